"""Moore's functional observers: ground truth, second methods, published numbers."""

import warnings
from fractions import Fraction

import numpy as np
import pytest
import scipy.linalg
from pairs import with_stairs

import luenberger as lb
from luenberger.papers.moore import companion_chain
from luenberger.papers.moore.driven import driven
from luenberger.papers.moore.orthonormal import orthonormal
from luenberger.papers.moore.recurrences import Admissible, recurrences

half = Fraction(1, 2)


def truth(rng, n, poles, dt, p=1, gaps=(1,)):
    """A random plant, and a k that an observer with these poles can have.

    k = sum c (A - pole I)^-power, with one c C for each; `gaps` are the powers.
    """
    A = rng.standard_normal((n, n))
    A *= (0.9 if dt else 1.7) / np.abs(np.linalg.eigvals(A)).max()
    C = rng.standard_normal((p, n))
    k = np.zeros(n, complex)
    for pole in poles:
        for power in gaps:
            c = rng.standard_normal(p) + 1j * rng.standard_normal(p) * (pole.imag != 0)
            there = np.linalg.matrix_power(A - pole * np.eye(n), power)
            k += np.linalg.solve(there.T, c @ C) * (2 if pole.imag else 1)
    B, E = rng.standard_normal((n, 2)), rng.standard_normal((p, 2))
    return lb.Plant(A, B, C, E, dt=dt, x0=rng.standard_normal(n)), k.real


def with_conjugates(poles):
    return np.sort_complex([*poles, *(p.conjugate() for p in poles if p.imag)])


def transfer(observer, s):
    """From [u, y] to w^ at s."""
    o = observer
    inside = np.linalg.solve(s * np.eye(o.order) - o.F, np.hstack([o.G, o.D]))
    return o.P @ inside


GIVEN = {  # the poles of positive imaginary part and the real ones
    "one": ([-1.5], [0.5]),
    "two": ([-1.5, -4], [0.5, -0.3]),
    "a pair": ([-1 + 2j], [0.4 + 0.5j]),
    "three": ([-1 + 2j, -3], [0.4 + 0.5j, -0.6]),
    "four": ([-1 + 2j, -3 + 1j], [0.4 + 0.5j, -0.6 + 0.1j]),
    "five": ([-1 + 2j, -3 + 1j, -2], [0.4 + 0.5j, -0.6 + 0.1j, 0.1]),
}


@pytest.mark.parametrize("dt", [0.0, 0.1], ids=["continuous", "discrete"])
@pytest.mark.parametrize("poles", GIVEN)
@pytest.mark.parametrize("n", [6, 12])
def test_least_order_and_poles_are_found(n, poles, dt):
    rng = np.random.default_rng([n, len(poles)])
    poles = [complex(p) for p in GIVEN[poles][dt > 0]]
    plant, k = truth(rng, n, poles, dt)
    wanted = with_conjugates(poles)
    r = len(wanted)
    unique = n - r >= r  # as many equations as unknowns, at least
    orders = recurrences(plant, k, orders=range(1, r + 1))
    if unique:
        assert [found.dimension for found in orders] == [None] * (r - 1) + [0]
        assert np.abs(orders[-1].poles - wanted).max() < 1e-5
        observer = lb.functional_observer(plant, k)
        assert observer.order == r
        assert np.abs(np.sort_complex(observer.poles) - wanted).max() < 1e-5
        assert lb.certify(observer, plant).worst < 1e-10
        for lower in range(1, r):
            with pytest.raises(lb.DesignError, match=f"order {lower}.*no polynomial"):
                lb.functional_observer(plant, k, order=lower)
    given = lb.functional_observer(plant, k, poles=wanted)
    assert np.abs(np.sort_complex(given.poles) - wanted).max() < 1e-13
    assert lb.certify(given, plant).worst < 1e-10
    higher = lb.functional_observer(plant, k, order=r + 1)
    assert higher.order == r + 1 and lb.certify(higher, plant).worst < 1e-10


@pytest.mark.parametrize("dt", [0.0, 1.0], ids=["continuous", "discrete"])
def test_repeated_poles_are_found(dt):
    pole = complex(0.3 if dt else -1.2)
    plant, k = truth(np.random.default_rng(2), 9, [pole], dt, gaps=(1, 2, 3))
    observer = lb.functional_observer(plant, k)
    assert observer.order == 3
    assert np.abs(np.poly(observer.poles) - np.poly([pole] * 3)).max() < 1e-8
    given = lb.functional_observer(plant, k, poles=[pole.real] * 3)
    assert (given.poles == pole.real).all()
    assert lb.certify(given, plant).worst < 1e-12


@pytest.mark.parametrize("dt", [0.0, 1.0], ids=["continuous", "discrete"])
@pytest.mark.parametrize("p", [2, 3])
def test_several_outputs(p, dt):
    """With p outputs r (n - p r) equations are not too few for r unknowns."""
    rng = np.random.default_rng(p)
    poles = [complex(x) for x in GIVEN["two"][dt > 0]]
    plant, k = truth(rng, 10, poles, dt, p)
    observer = lb.functional_observer(plant, k)
    assert observer.order == 2
    assert np.abs(np.sort_complex(observer.poles) - np.sort(poles)).max() < 1e-8
    assert lb.certify(observer, plant).worst < 1e-12
    with pytest.raises(lb.DesignError, match="order 1 .*least order found is 2"):
        lb.functional_observer(plant, k, order=1)
    with pytest.raises(lb.DesignError, match="not a combination of the rows.*is left"):
        lb.functional_observer(plant, k, poles=[-0.1, -0.2])


def test_several_outputs_admit_any_poles_from_the_observability_index_on():
    A, C = with_stairs((1, 2, 2), np.random.default_rng(3))
    plant = lb.Plant(A, None, C)
    k = np.ones(5)
    assert [r.dimension for r in recurrences(plant, k)] == [None, 1, 3, 4, 5]
    assert lb.functional_observer(plant, k, poles=[-1, -2, -3]).order == 3
    with pytest.raises(lb.DesignError, match="from order 3 on"):
        lb.functional_observer(plant, k, poles=[-1, -2])


def test_a_redundant_output_changes_nothing():
    plant, k = truth(np.random.default_rng(2), 8, [-1.0 + 0j, -2.0 + 0j], 0.0)
    C = np.vstack([plant.C, -3 * plant.C])
    observer = lb.functional_observer(lb.Plant(plant.A, None, C), k)
    assert observer.order == 2
    assert np.abs(observer.poles - [-2, -1]).max() < 1e-9


# -- published ----------------------------------------------------------------------


def test_first_order_observer_in_rationals():
    """k = C (A - I/10)^-1: z+ = z/10 + y and w^ = z up to scale (our case list)."""
    A = [[half, 1, 0], [0, Fraction(1, 3), 1], [Fraction(1, 4), 0, Fraction(-1, 5)]]
    k = [Fraction(-35, 111), Fraction(50, 37), Fraction(500, 111)]
    plant = lb.Plant(A, [[1], [0], [2]], [[1, 0, 0]], dt=1.0)
    for poles in (None, [Fraction(1, 10)]):
        exact = lb.functional_observer(plant, k, poles=poles).exact
        assert exact["F"].tolist() == [[Fraction(1, 10)]]
        assert (exact["P"] @ exact["D"]).tolist() == [[1]]
        assert exact["T"].tolist() == [k]
        assert exact["G"].tolist() == [[k[0] + 2 * k[2]]]
    floats = lb.functional_observer(lb.Plant(plant.A, None, plant.C, dt=1.0), k)
    assert floats.exact is None and abs(floats.poles[0] - 0.1) < 1e-15


def test_moore_by_hand():
    """A triple integrator, n = 3 and r = 2: one equation beta_0 = 3 beta_1 + 2."""
    plant = lb.Plant([[0, 1, 0], [0, 0, 1], [0, 0, 0]], [[0], [0], [1]], [[1, 0, 0]])
    k = [2, 3, -1]  # kappa = (-1, 3, 2): -beta_0 + 3 beta_1 + 2 = 0
    assert [r.dimension for r in recurrences(plant, k)] == [None, 1, 3]
    exact = lb.functional_observer(plant, k).exact
    beta_1, beta_0 = -exact["F"][:, 0]
    assert beta_0 == 3 * beta_1 + 2
    # k beta(A) = D_1 C A + D_2 C: coefficients of C A^0 and C A
    assert exact["D"].T.tolist() == [[2 * beta_1 + 3 * beta_0, 2 * beta_0]]
    admitted = lb.functional_observer(plant, k, poles=[-4, -14])  # 56 = 3 * 18 + 2
    assert admitted.exact["F"].tolist() == [[-4, 1], [0, -14]]
    with pytest.raises(lb.DesignError, match="row 0 comes to 0.0046 of its terms"):
        lb.functional_observer(plant, k, poles=[-4, -13.5])  # 54 and 54.5
    near = -14 - Fraction(1, 10**15)  # rounding would not tell
    with pytest.raises(lb.DesignError, match="row 0 comes to"):
        lb.functional_observer(plant, k, poles=[-4, near])


# -- second methods -----------------------------------------------------------------


@pytest.mark.parametrize("dt", [0.0, 0.1], ids=["continuous", "discrete"])
@pytest.mark.parametrize("p", [1, 2])
def test_the_error_decays_as_the_poles_say(dt, p):
    """The composite system of x and z under a feedback of the state, by expm."""
    rng = np.random.default_rng(11)
    poles = [complex(x) for x in GIVEN["three"][dt > 0]]
    plant, k = truth(rng, 8, poles, dt, p)
    observer = lb.functional_observer(plant, k)
    A, B, C, E, o = plant.A, plant.B, plant.C, plant.E, observer
    K = rng.standard_normal((2, 8)) * 0.1  # u = K x, an input like any other
    whole = np.block([
        [A + B @ K, np.zeros((8, o.order))],
        [(o.D @ C) + (o.G + o.D @ E) @ K, o.F],
    ])  # fmt: skip
    start = np.r_[rng.standard_normal(8), np.zeros(o.order)]
    seen = np.r_[-k, o.P[0]]
    first = -o.T @ start[:8]
    for t in (1, 4, 9):
        move = np.linalg.matrix_power(whole, t) if dt else scipy.linalg.expm(whole * t)
        own = np.linalg.matrix_power(o.F, t) if dt else scipy.linalg.expm(o.F * t)
        error, wanted = seen @ move @ start, (o.P @ own @ first)[0]
        assert abs(error - wanted) < 1e-9 * max(np.abs(move @ start).max(), 1)


@pytest.mark.parametrize("dt", [0.0, 0.1], ids=["continuous", "discrete"])
def test_a_feedback_law_through_the_observer_has_the_poles_of_both(dt):
    rng = np.random.default_rng(12)
    plant, _ = truth(rng, 6, [], dt)
    B = plant.B[:, :1]
    wanted = np.linspace(0.2, 0.6, 6) if dt else -np.linspace(1, 3, 6)
    K = scipy.signal.place_poles(plant.A, B, wanted).gain_matrix
    single = lb.Plant(plant.A, B, plant.C, dt=dt)
    o = lb.functional_observer(single, K)
    loop = np.block([
        [plant.A, -B @ o.P],
        [o.D @ plant.C, o.F - o.G @ o.P],
    ])  # fmt: skip
    both = np.r_[wanted, o.poles]
    found, asked = np.poly(np.linalg.eigvals(loop)), np.poly(both)
    assert np.abs(found - asked.real).max() < 1e-6 * np.abs(asked).max()


def test_coordinates_and_units_change_nothing_the_user_sees():
    rng = np.random.default_rng(5)
    plant, k = truth(rng, 7, [-1 + 2j, -3 + 0j], 0.0)
    first = lb.functional_observer(plant, k)
    turn = scipy.linalg.qr(rng.standard_normal((7, 7)))[0]
    units = 10.0 ** rng.integers(-3, 4, 7)
    M, back = units[:, None] * turn, turn.T / units
    turned = lb.Plant(
        M @ plant.A @ back, M @ plant.B, 1e3 * plant.C @ back, 1e3 * plant.E
    )
    second = lb.functional_observer(turned, 1e-4 * k @ back)
    assert second.order == first.order == 3
    for s in (0.1j, 1j, 5j):
        a, b = transfer(first, s), transfer(second, s) * 1e4
        b[:, -1] *= 1e3
        assert np.abs(a - b).max() < 1e-6 * np.abs(a).max()


def test_noise_passes_only_through_the_states():
    plant = lb.Plant([[1, 0.1], [0, 0.95]], [[0], [0.1]], [[1, 0]], dt=0.1,
                     Q=np.eye(2) * 1e-4, R=[[1]])  # fmt: skip
    observer = lb.functional_observer(plant, [1, 2], poles=[0.6, 0.7])
    o, found = observer, lb.error_covariance(observer, plant)
    assert found.shape == (1, 1)
    assert (o.V == 0).all() and (o.W == 0).all()
    noise = o.D @ plant.R @ o.D.T + o.T @ plant.Q @ o.T.T
    steady = scipy.linalg.solve_discrete_lyapunov(o.F, noise)
    assert np.allclose(found, o.P @ steady @ o.P.T)


# -- the chain, the rows driven to zero and the orthonormal rows --------------------


@pytest.mark.parametrize("p", [1, 2])
def test_a_chain_of_one_factor_or_many_and_other_rows_are_the_same_observer(p):
    rng = np.random.default_rng(21)
    poles = np.array([-1 + 2j, -1 - 2j, -3, -0.5 + 0.1j, -0.5 - 0.1j])
    plant, k = truth(rng, 12, [p for p in poles if p.imag >= 0], 0.0, p)
    A, C = plant.A, plant.C
    single = companion_chain.chain(A, C, k, [np.poly(poles).real[:0:-1]])
    many = companion_chain.chain(A, C, k, [[5, 2], [3], [0.26, 1]])
    steps = driven(A, C, k, poles)
    other = orthonormal(A, C, k, many, poles)
    values = []
    for one in (single, many, steps, other):
        assert np.abs(one.T @ A - one.F @ one.T - one.D @ C).max() < 1e-8
        assert np.abs(one.P @ one.T - k).max() < 1e-10
        assert np.allclose(np.poly(one.F), np.poly(poles).real, rtol=1e-9)
        values.append(one.P @ np.linalg.solve(0.7j * np.eye(5) - one.F, one.D))
    assert np.allclose(np.linalg.norm(steps.T, axis=1), 1, atol=1e-12)
    assert np.allclose(other.T @ other.T.T, np.eye(5), atol=1e-12)
    assert np.allclose(values, values[0], rtol=1e-7)
    for one in (steps, other):
        assert (one.F.diagonal() == poles.real).all()


def test_digits_that_cancel_in_the_chain_are_kept_by_orthonormal_rows():
    """Ten equal poles: what the state drives into the estimate at rest."""
    rng = np.random.default_rng(1)
    A = rng.standard_normal((10, 10))
    A /= np.abs(np.linalg.eigvals(A)).max()
    plant, k = lb.Plant(A, None, rng.standard_normal((1, 10))), rng.standard_normal(10)

    def error(o):
        dynamics = o.T @ A - o.F @ o.T - o.D @ plant.C
        return np.abs(o.P @ (np.linalg.solve(-o.F, dynamics) + o.T) - k).max()

    chain = companion_chain.chain(A, plant.C, k, [[1.0]] * 10)
    observer = lb.functional_observer(plant, k, poles=[-1] * 10)
    assert error(chain) > 1e-9 > 1e-11 > error(observer)
    assert (observer.poles == -1).all()


def large(n, p, dt, seed=1):
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n)) / np.sqrt(n) - (0 if dt else 1.2) * np.eye(n)
    plant = lb.Plant(A, None, rng.standard_normal((p, n)), dt=dt)
    return plant, rng.standard_normal(n)


def test_digits_that_high_powers_of_the_plant_cancel_are_kept_step_by_step():
    plant, k = large(80, 2, 0.0)
    poles = np.full(40, -1 + 0j)
    chain = companion_chain.chain(plant.A, plant.C, k, [[1.0]] * 40)
    steps = driven(plant.A, plant.C, k, poles)

    def error(o):
        dynamics = o.T @ plant.A - o.F @ o.T - o.D @ plant.C
        there = o.P @ (np.linalg.solve(-o.F, dynamics) + o.T) - k
        return np.linalg.norm(there) / np.linalg.norm(k)

    assert error(chain) > 3e-8 > 3e-9 > error(steps)
    assert not np.tril(steps.F, -1).any() and (steps.F.diagonal() == -1).all()


def test_two_hundred_states_take_seconds():
    """Fewer than n / p states would give 200 equations too few unknowns; see it run."""
    plant, k = large(200, 5, 1.0)
    observer = lb.functional_observer(plant, k)
    assert observer.order == 34  # the least r with r (p + 1) >= n
    lb.certify(observer, plant).require(1e-9)
    x, z = np.random.default_rng(2).standard_normal(200), np.zeros(34)
    for _ in range(400):
        x, z = plant.A @ x, observer.F @ z + observer.D @ (plant.C @ x)
    found = observer.P @ z
    assert abs(found - k @ x) < 1e-6 * np.linalg.norm(k) * np.linalg.norm(x)


def test_where_rounding_spoils_order_after_order_few_are_tried(monkeypatch):
    tried, answer = [], Admissible.answer
    monkeypatch.setattr(
        Admissible, "answer", lambda self, r: tried.append(r) or answer(self, r)
    )
    plant, k = large(52, 2, 0.0)
    observer = lb.functional_observer(plant, k)
    lb.certify(observer, plant).require(1e-9)
    assert observer.order == 26 == tried[-1]  # any poles: r p >= n
    assert len(tried) < 22 and tried == sorted(tried)


# -- several functionals, none, hidden modes ----------------------------------------


def test_rows_of_k_get_observers_side_by_side():
    plant, k1 = truth(np.random.default_rng(2), 6, [-1.0 + 0j], 0.0)
    k2 = plant.C[0]
    observer = lb.functional_observer(plant, [k1, np.zeros(6), k2])
    alone = [lb.functional_observer(plant, k) for k in (k1, k2)]
    r1, r2 = (one.order for one in alone)
    assert observer.order == r1 + r2 and r1 == 1
    assert np.array_equal(observer.F[:r1, :r1], alone[0].F)
    assert np.array_equal(observer.F[r1:, r1:], alone[1].F)
    assert not observer.F[:r1, r1:].any() and not observer.F[r1:, :r1].any()
    assert not observer.P[1].any() and np.array_equal(observer.L[2], k2)
    assert np.array_equal(observer.z0, observer.T @ plant.x0) and observer.z0.any()
    exact = lb.Plant([[0, 1], [0, 0]], None, [[1, 0]])
    assert lb.functional_observer(exact, [[1, 2], [0, 1]]).exact["F"].shape == (4, 4)


def test_zero_needs_no_state():
    plant = lb.Plant([[0, 1], [0, 0]], [[0], [1]], [[1, 0]])
    for k in ([0, 0], [0.0, 0.0]):
        assert lb.functional_observer(plant, k).order == 0
        assert lb.functional_observer(plant, k, poles=[-3]).poles == [-3]
    assert lb.functional_observer(plant, [0, 0], order=2).order == 2


def test_an_output_itself_needs_states_here():
    """k = C: V y would give it at once, but V = 0, and (13) asks for r = n."""
    plant = lb.Plant([[0, 1], [-1, -1]], None, [[1, 0]])
    assert lb.functional_observer(plant, [1, 0]).order == 2


@pytest.mark.parametrize("kind", [int, float], ids=["exact", "floats"])
def test_stable_hidden_modes_that_k_sees_are_among_the_poles(kind):
    A = np.array([[-5, 0, 0], [0, 0, 1], [0, -2, -3]], dtype=kind)
    plant = lb.Plant(A, None, np.array([[0, 1, 0]], dtype=kind))
    k = np.array([1, 1, 2], dtype=kind)
    orders = recurrences(plant, k)
    assert [r.dimension for r in orders] == [None, 1, 2]
    observer = lb.functional_observer(plant, k, poles=np.array([-5, -7, -8], kind))
    assert np.allclose(np.sort(observer.poles), [-8, -7, -5])
    with pytest.raises(lb.DesignError, match="No order admits any poles"):
        lb.functional_observer(plant, k, poles=[-6, -7, -8])
    blind = np.array([0, 1, 2], dtype=kind)  # does not see it
    assert lb.functional_observer(plant, blind, poles=[-6, -7]).order == 2
    A[0, 0] = 5
    with pytest.raises(lb.DesignError, match=r"mode\(s\) 5 do not decay.*k sees them"):
        lb.functional_observer(lb.Plant(A, None, plant.C), k)


def integrator_within(seed):
    """A mode at 0 that no output shows, among integers that hide it from floats."""
    rng = np.random.default_rng(seed)
    A = np.zeros((4, 4), int)
    A[:2, :2] = rng.integers(-3, 4, (2, 1)) @ rng.integers(-3, 4, (1, 2))
    A[:2, 2:], A[2:, 2:] = 1, [[-1, 1], [0, -2]]
    return lb.Plant(A.tolist(), None, [[0, 0, 1, 0]])


@pytest.mark.parametrize("seed", [34, 90, 114])
def test_a_mode_that_rounding_takes_for_decaying_is_named(seed):
    plant = integrator_within(seed)
    message = (
        r"mode\(s\) (-?[\d.e-]+, )*-?(0|\d[\d.]*e-1\d)(, -?[\d.e-]+)* do not decay"
    )
    with pytest.raises(lb.DesignError, match=message):
        lb.functional_observer(plant, [1, 1, 1, 1])
    with pytest.raises(lb.DesignError, match=r"Stable among them: (none|-\d+)\."):
        lb.reduced_order_observer(plant, [-1, -1, -1])


@pytest.mark.parametrize("seed", [169, 319, 369])
def test_rows_that_become_dependent_are_no_bare_traceback(seed):
    """Without outputs the chain is the plant's own, and loses digits."""
    rng = np.random.default_rng(seed)
    n, p = int(rng.integers(2, 9)), int(rng.integers(1, 3))
    A = rng.normal(size=(n, n)) - 5 * np.eye(n)
    rng.normal(size=(p, n)), rng.integers(0, 2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plant = lb.Plant(A, None, np.zeros((p, n)))
        assert lb.functional_observer(plant, rng.normal(size=n)).order <= n


def test_more_than_twenty_states_are_designed_in_floats():
    A = np.eye(21, k=1, dtype=int)
    plant = lb.Plant(A, None, np.eye(21, dtype=int)[:1], dt=1.0)
    k = np.zeros(21, int)
    k[:2] = 1
    assert lb.functional_observer(plant, k, order=21).exact is None


# -- what is said of each order -----------------------------------------------------


def test_reasons_and_margins():
    plant = lb.Plant([[0, 1, 0], [0, 0, 1], [0, 0, 0]], None, [[1, 0, 0]])
    table = recurrences(plant, [2, 3, -1])
    assert [r.decided for r in table] == ["exact"] * 3
    assert table[0].reason == "no polynomial is admissible" and not table[0].stable
    assert table[1].reason == "the admissible polynomials have 1 free number"
    assert table[2].poles.tolist() == [-1, -1, -1] and table[2].margin == 1
    plant = lb.Plant(np.diag([0.5, 0.2]), None, [[1, 1]], dt=1.0)
    single = recurrences(plant, [0.8, 0.8 / 0.7])[0]  # c C (A - I)^-1 ... pole 0.9
    assert single.dimension in (0, 1)
    unstable = recurrences(plant, [1 / (0.5 - 2), 1 / (0.2 - 2)], orders=[1])
    assert unstable[0].poles is not None


def test_the_margin_is_the_largest_of_second_order():
    """One equation, n = 3: against every point of the line of polynomials."""
    rng = np.random.default_rng(13)
    for dt in (0.0, 1.0) * 4:
        plant, _ = truth(rng, 3, [], dt)
        k = rng.standard_normal(3)
        found = recurrences(plant, k, orders=[2])[0]
        A, C = plant.A, plant.C
        g = np.linalg.solve(np.vstack([C, C @ A, C @ A @ A]), [0, 0, 1])
        kappa = np.array([k @ g, k @ A @ g, k @ A @ A @ g])
        best = np.inf
        for b1 in np.tan(np.linspace(-1.57, 1.57, 1001)) * 3:
            b0 = -(kappa[2] + b1 * kappa[1]) / kappa[0]
            roots = np.roots([1, b1, b0])
            size = np.abs(roots) if dt else np.abs((1 + roots) / (1 - roots))
            best = min(best, size.max())
        assert found.stable == (best < 1)
        if found.stable and dt:
            assert abs(1 - found.margin - best) < 0.02


@pytest.mark.parametrize("discrete", [False, True], ids=["continuous", "discrete"])
def test_one_sign_is_no_obstacle_in_discrete_time(discrete):
    """A = shift, so kappa = k reversed: (2, 1) obeys beta = -1/2: a Schur polynomial,
    not a Hurwitz one."""
    plant = lb.Plant([[0, 1], [0, 0]], None, [[1, 0]], dt=float(discrete))
    if discrete:
        assert lb.functional_observer(plant, [1, 2]).poles == [0.5]
    else:
        with pytest.raises(lb.DesignError, match="one sign.*all n = 2 states"):
            lb.functional_observer(plant, [1, 2], order=1)


def test_the_remark_is_not_made_in_discrete_time():
    plant = lb.Plant(np.eye(3, k=1), None, [[1, 0, 0]], dt=1.0)
    with pytest.raises(lb.DesignError, match="order 1 .*no polynomial") as refusal:
        lb.functional_observer(plant, [5, 1, 1], order=1)
    assert "one sign" not in str(refusal.value)


# -- refusals -----------------------------------------------------------------------

SERVO = dict(A=[[0, 1, 0], [0, 0, 1], [-6.0, -11, -6]], C=[[1, 0, 0]])


def servo(**changes):
    parts = SERVO | changes
    return lb.Plant(parts.pop("A"), parts.pop("B", None), parts.pop("C"), **parts)


@pytest.mark.parametrize(
    ("k", "options", "error", "message"),
    [
        ([1, 2, np.nan], {}, ValueError, "not finite"),
        ([1, 2], {}, ValueError, r"k must have shape \(3,\)"),
        ([[1, 2]], {}, ValueError, "k must be 1 x 3"),
        ([1, 2, 3j], {}, ValueError, "k must be an array of real numbers"),
        (5, {}, ValueError, "k must be a vector of 3 numbers"),
        (np.zeros((0, 3)), {}, ValueError, "no rows"),
        ([1, 2, 3], dict(order=0), lb.DesignError, "1 to n = 3 states, got order 0"),
        ([1, 2, 3], dict(order=4), lb.DesignError, "got order 4"),
        ([1, 2, 3], dict(order=2.0), ValueError, "order must be an integer"),
        ([1, 2, 3], dict(order=True), ValueError, "order must be an integer"),
        ([1, 2, 3], dict(poles=[]), lb.DesignError, "got order 0"),
        ([1, 2, 3], dict(poles=[-1] * 4), lb.DesignError, "got order 4"),
        ([1, 2, 3], dict(poles=-5), ValueError, "list of finite numbers"),
        ([1, 2, 3], dict(poles=[-5, np.inf]), ValueError, "list of finite numbers"),
        ([1, 2, 3], dict(poles=["x"]), ValueError, "list of numbers"),
        ([1, 2, 3], dict(order=2, poles=[-1]), ValueError, "order is 2, but 1 poles"),
        (
            [1, 2, 3],
            dict(poles=[-5, -6 + 1j, -2]),
            lb.DesignError,
            r"pole -6\+1j needs its conjugate -6-1j",
        ),
        (
            [1, 2, 3],
            dict(poles=[-5, -6, 1]),
            lb.CertificateError,
            "not stable: poles",
        ),
        (
            [1, 2, 3],
            dict(poles=[-5]),
            lb.DesignError,
            "poles -5: the recurrence.*row 0 comes to 0.03.*row 1.*from order 3 on",
        ),
        (
            [1, 0, 0],
            dict(order=2),
            lb.DesignError,
            "In Moore's coordinates all entries of k have one sign.*order found is 3",
        ),
    ],
)
def test_refusals(k, options, error, message):
    with pytest.raises(error, match=message):
        lb.functional_observer(servo(), k, **options)


def test_the_only_admissible_poles_are_named():
    plant, k = truth(np.random.default_rng(4), 6, [-1.0 + 0j, -2.5 + 0j], 0.0)
    with pytest.raises(lb.DesignError, match="order 2 the only poles are -2.5, -1"):
        lb.functional_observer(plant, k, poles=[-1, -2.4999])
    plant, k = truth(np.random.default_rng(4), 6, [-1.0 + 0j, 2.5 + 0j], 0.0)
    with pytest.raises(lb.DesignError, match="not stable, its poles are -1, 2.5"):
        lb.functional_observer(plant, k, order=2)


@pytest.mark.parametrize(
    ("plant", "message"),
    [
        (lb.Plant([[1j]], None, [[1]]), "is for real matrices"),
        (lb.Plant([[[0.5]]] * 3, None, [[1]], dt=1.0), "constant plant.*3 steps"),
        (lb.Plant([[2]], None, [[0]], dt=1.0), r"mode\(s\) 2 do not decay"),
        (lb.Plant([[0.0]], None, [[0]]), r"mode\(s\) 0 do not decay"),
        (lb.Plant([[3]], None, np.zeros((0, 1))), r"mode\(s\) 3 do not decay"),
    ],
)
def test_plants_that_cannot_be(plant, message):
    with pytest.raises(lb.DesignError, match=message):
        lb.functional_observer(plant, [1])


def test_a_plant_without_outputs_that_decays():
    plant = lb.Plant([[-3]], None, np.zeros((0, 1)))
    assert lb.functional_observer(plant, [1]).poles == [-3]


def test_rounding_that_leaves_no_digit_is_refused():
    """Sixteen poles a hundred times as fast as the plant."""
    rng = np.random.default_rng(3)
    A = rng.standard_normal((16, 16))
    A /= np.abs(np.linalg.eigvals(A)).max()
    plant = lb.Plant(A, None, rng.standard_normal((1, 16)))
    with pytest.raises(lb.DesignError, match="rounding would put an error of"):
        lb.functional_observer(plant, np.ones(16), poles=-np.linspace(50, 100, 16))


def test_an_exact_observer_that_rounding_spoils_is_refused_too():
    """Deadbeat for a plant that grows eightfold a step; its certificate is 1e-17."""
    rng = np.random.default_rng(0)
    parts = [rng.integers(-3, 4, shape) for shape in ((16, 16), (1, 16), 16)]
    plant = lb.Plant(parts[0], None, parts[1], dt=1.0)
    with pytest.raises(lb.DesignError, match="rounding would put an error of"):
        lb.functional_observer(plant, parts[2], poles=[0] * 16)
    with pytest.raises(lb.DesignError, match="rounding would put an error of"):
        lb.functional_observer(plant, parts[2], order=16)


# -- exact observers ----------------------------------------------------------------


def test_an_observer_keeps_its_rationals(tmp_path):
    parts = dict(F=[[half]], G=[[1]], D=[[2]], P=[[1]], V=[[0]], T=[[1, 2]])
    observer = lb.Observer(**parts, L=[[1, 2]])
    assert observer.exact["F"][0, 0] == half and observer.F[0, 0] == 0.5
    assert observer.exact["W"].tolist() == [[0]]
    assert all(type(x) is Fraction for X in observer.exact.values() for x in X.flat)
    observer.exact.clear()
    assert sorted(observer.exact) == sorted("FGDPVWTL")
    for name in "FGDPVT":
        floats = parts | {name: np.array(parts[name], float)}
        assert lb.Observer(**floats, L=[[1, 2]]).exact is None
    assert lb.Observer(**parts, L=[[1.0, 2]]).exact is None
    assert lb.Observer(**parts, L=[[1, 2]], W=[[0.0]]).exact is None
    observer.to_json(tmp_path / "observer.json")
    again = lb.Observer.from_json(tmp_path / "observer.json")
    assert again.F.tolist() == [[0.5]] and again.exact is None
    stacks = {name: [X, X] for name, X in parts.items()}
    stacks |= dict(T0=parts["T"], G0=parts["G"], L=[[1, 2]])
    assert lb.Observer(**stacks).exact is None


@pytest.mark.parametrize(
    ("k", "poles", "exactly"),
    [
        ([1, 2, 3], [-1, -2, Fraction(-7, 3)], True),
        ([1, 2, 3], [-1.0, -2, -3], False),
        ([1, 2, 3], None, True),
        ([1.0, 2, 3], None, False),
        ([1, 2, 3], [-1, -2 + 1j, -2 - 1j], False),
    ],
)
def test_rational_in_rational_out(k, poles, exactly):
    plant = lb.Plant([[0, 1, 0], [0, 0, 1], [-6, -11, -6]], [[0], [0], [1]],
                     [[1, 0, 0]], [[half]])  # fmt: skip
    observer = lb.functional_observer(plant, k, poles=poles)
    assert (observer.exact is not None) == exactly
    if poles is not None:
        wanted = np.sort_complex(np.array(poles, complex))
        assert np.abs(np.sort_complex(observer.poles) - wanted).max() < 1e-15
