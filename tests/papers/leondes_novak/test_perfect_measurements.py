"""Perfect measurements and other singular plants: a right answer, or a clear refusal.

The oracle is `generators.exact`, the best estimate in rational arithmetic, which has
no tolerance and so no opinion on what is nearly singular.
"""

import warnings

import generators
import numpy as np
import pytest
from generators import integer_plant

import luenberger as lb

DOUBLE = [[1, 1], [0, 1]]
SMOOTH = [[1 / 3, 1 / 2], [1 / 2, 1]]  # continuous white acceleration over one step
JERKY = [[0.25, 0.5], [0.5, 1.0]]  # acceleration constant between samples


@pytest.fixture(autouse=True)
def no_warnings():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


@pytest.mark.parametrize("block", range(3))
def test_any_singular_noise_agrees_with_rational_arithmetic(block):
    """150 plants with joint noise of every rank, P0 of every rank, S and feedthrough.

    The error bound grows with the plant's own sensitivity over the six steps: some
    of these have noise-free modes that grow tenfold a step.
    """
    for seed in range(50 * block, 50 * block + 50):
        plant, y, u, u0 = integer_plant(seed)
        x, P = generators.exact(plant, y, u, u0)
        run = lb.Filter(plant).run(lb.Record(y, u, u0=u0))
        size = np.abs(P).max() + np.abs(plant.P0).max() + np.abs(plant.Q).max() + 1
        assert np.abs(run.x - x).max() < 1e-10 * (1 + np.abs(x).max()), seed
        assert np.abs(run.P - P).max() < 1e-10 * size, seed
        assert np.linalg.eigvalsh(run.P).min() > -1e-13 * size, seed


@pytest.mark.parametrize("seed", range(12))
def test_noise_free_outputs_lower_the_order_for_nothing(seed):
    """With R11 = 0, m1 of them treated as exact is the Kalman filter itself."""
    rng = np.random.default_rng(seed)
    n, p, m1 = 5, 3, 1 + seed % 2
    plant = generators.plant(rng, n, p, radius=[0.0, 0.9, 1.2][seed % 3])
    noisy = np.arange(p) >= m1
    plant = lb.Plant(
        plant.A, plant.B, plant.C, plant.E, dt=1.0, Q=plant.Q, P0=plant.P0,
        R=plant.R * np.outer(noisy, noisy), S=plant.S * noisy,
    )  # fmt: skip
    y, u, u0 = generators.record(rng, plant, 30)
    full = lb.Filter(plant).run(lb.Record(y, u, u0=u0))
    less = lb.Filter(plant, m1).run(lb.Record(y, u, u0=u0))
    np.testing.assert_allclose(less.P, full.P, atol=1e-12 * np.abs(full.P).max())
    np.testing.assert_allclose(less.x, full.x, atol=1e-10 * np.abs(full.x).max())
    steady = lb.reduced_order_filter(plant, m1)
    assert steady.order == n - m1
    kalman = lb.kalman_filter(plant)
    found, wanted = (lb.error_covariance(o, plant) for o in (steady, kalman))
    np.testing.assert_allclose(found, wanted, atol=1e-11 * np.abs(wanted).max())


@pytest.mark.parametrize("cross", [False, True], ids=["S = 0", "S"])
def test_as_R_tends_to_zero_the_filter_tends_to_the_perfect_one(cross):
    """FilterPy issues 214 and 172: R = 0 is a value like any other.

    The distance falls in proportion to R (with S, to sqrt R), down to rounding.
    """
    sizes = np.array([10.0**-k for k in range(2, 15)])
    w = np.array([[0.3], [0.5]])  # E[w v'] = w sqrt(R), inside the admissible cone

    def plant(r):
        S = w * np.sqrt(r) if cross else None
        return lb.Plant(DOUBLE, None, [[1, 0]], dt=1.0, Q=SMOOTH, R=[[r]], S=S)

    perfect = lb.kalman_filter(plant(0.0))
    P0 = lb.error_covariance(perfect, plant(0.0))
    power = sizes ** (0.5 if cross else 1.0)
    for m1 in (0, 1):
        for r, size in zip(sizes, power):
            observer = lb.reduced_order_filter(plant(r), m1)
            assert np.abs(observer.V - perfect.V).max() < 20 * size + 1e-11
            P = lb.error_covariance(observer, plant(r))
            assert np.abs(P - P0).max() < 20 * size + 1e-11
            assert P[0, 0] <= r * (1 + 1e-9)  # never worse than the output itself
    minimal = lb.reduced_order_filter(plant(0.0), 1)
    np.testing.assert_allclose(minimal.V, perfect.V, rtol=1e-12)


REDUNDANT = {
    "twice the first": [[1, 0, 0], [0, 1, 0], [2, 0, 0]],
    "sum of both": [[1, 0, 0], [0, 1, 0], [1, 1, 0]],
    "sum with rounding": [[0.1, 0.2, 0], [0.7, 0.1, 0], [0.1 + 0.7, 0.2 + 0.1, 0]],
}
CHAIN = np.eye(3) + np.eye(3, k=1) * 0.5


@pytest.mark.parametrize("C", REDUNDANT.values(), ids=REDUNDANT.keys())
@pytest.mark.parametrize("m1", [0, 1, 2])
def test_a_redundant_noise_free_output_changes_nothing(C, m1):
    given = dict(dt=1.0, Q=np.diag([1.0, 2, 3]), P0=np.eye(3))
    two = lb.Plant(CHAIN, None, C[:2], R=np.zeros((2, 2)), **given)
    three = lb.Plant(CHAIN, None, C, R=np.zeros((3, 3)), **given)
    y, _, _ = generators.record(np.random.default_rng(3), two, 20)
    extra = y @ np.linalg.lstsq(np.array(C[:2]).T, np.array(C[2]), rcond=None)[0]
    y3 = np.column_stack([y, extra])
    a = lb.Filter(two, m1).run(y)
    b = lb.Filter(three, m1).run(y3)
    np.testing.assert_allclose(a.x, b.x, rtol=0, atol=1e-12 * np.abs(a.x).max())
    np.testing.assert_allclose(a.P, b.P, rtol=0, atol=1e-12)
    P = lb.error_covariance(lb.reduced_order_filter(two, m1), two)
    P3 = lb.error_covariance(lb.reduced_order_filter(three, m1), three)
    np.testing.assert_allclose(P, P3, rtol=0, atol=1e-12)


@pytest.mark.parametrize("C", REDUNDANT.values(), ids=REDUNDANT.keys())
def test_redundant_outputs_cannot_all_be_accurate(C):
    plant = lb.Plant(
        CHAIN, None, C, dt=1.0, Q=np.eye(3), R=np.zeros((3, 3)), P0=np.eye(3),
        output_names=("port", "bow", "stern"),
    )  # fmt: skip
    message = "'port', 'bow', 'stern'.*linearly dependent"
    with pytest.raises(lb.DesignError, match=message):
        lb.reduced_order_filter(plant, 3)
    with pytest.raises(lb.DesignError, match=message):
        lb.Filter(plant, 3).run(np.zeros((1, 3)))


@pytest.mark.parametrize("m1", [0, [0]])
def test_contradicting_noise_free_outputs_are_named_with_the_instant(m1):
    """Two noise-free sensors of one state that disagree (IRIS-Toolbox issue 223)."""
    plant = lb.Plant(
        [[0.9]], None, [[1], [1], [1]], dt=1.0, Q=[[1]], R=np.diag([0, 1, 0]),
        P0=[[1]], output_names=("left", "noisy", "right"),
    )  # fmt: skip
    y = np.array([[1.0, 3, 1], [2, 0, 2], [3, 1, 3.001], [4, 4, 4]])
    with pytest.raises(lb.DesignError, match=r"instant 3 .*'left', 'right'"):
        lb.Filter(plant, m1).run(y)
    y[2] = [3, 1, 3 + 1e-9]  # rounding of the record is no contradiction
    assert np.isfinite(lb.Filter(plant, m1).run(y).x).all()
    y[2] = [3, 1, np.nan]
    assert np.isfinite(lb.Filter(plant, m1).run(y).x).all()


def test_a_noise_free_output_cannot_contradict_a_state_known_exactly():
    plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[0]], R=[[0]], P0=[[0]], x0=[8])
    run = lb.Filter(plant).run([[4], [2], [1]])
    np.testing.assert_array_equal(run.x[:, 0], [4, 2, 1])
    np.testing.assert_array_equal(run.std, 0)
    with pytest.raises(lb.DesignError, match="instant 2 .*y1.*known exactly"):
        lb.Filter(plant).run([[4], [3], [1]])


def test_zero_data_of_a_noise_free_output_is_not_a_contradiction():
    """y = 0 with C x = 0 up to rounding: compared with sizes, not with the data."""
    plant = lb.Plant(
        [[1, 0], [0.1, 0.7]], None, [[0.1, -0.3]], dt=1.0, Q=np.zeros((2, 2)),
        R=[[0]], P0=[[9, 3], [3, 1]], x0=[0.3, 0.1],
    )  # fmt: skip
    run = lb.Filter(plant).run(np.zeros((4, 1)))  # A x0 = x0 and C x0 = 0
    np.testing.assert_allclose(run.x, [[0.3, 0.1]] * 4, rtol=0, atol=1e-14)


@pytest.mark.parametrize("m1", [0, 1])
def test_nilpotent_plant(m1):
    """Drake issue 8034: the doubling iteration never returns for A = [0 1; 0 0]."""
    for C, R in (([[1, 0]], [[0]]), ([[0, 1]], [[1]]), ([[1, 1]], [[0]])):
        plant = lb.Plant(
            [[0, 1], [0, 0]], None, C, dt=1.0, Q=np.eye(2), R=R, P0=np.eye(2)
        )
        steady = lb.reduced_order_filter(plant, m1)
        P = lb.error_covariance(steady, plant)
        over = lb.error_covariance(
            lb.reduced_order_filter(plant, m1, steps=40), plant, steps=40
        )
        np.testing.assert_allclose(over[-1], P, rtol=0, atol=1e-12)
        assert lb.certify(steady, plant).stable


@pytest.mark.parametrize("m1", [0, 1, 2])
@pytest.mark.parametrize("cross", [False, True], ids=["S = 0", "S"])
def test_plant_that_forgets_everything(m1, cross):
    """A = 0: nothing is carried over but what S says; residuals are rounding."""
    plant = generators.plant(np.random.default_rng(4), 3, 2, cross=cross, radius=0.0)
    assert not plant.A.any()
    observer = lb.reduced_order_filter(plant, m1)
    over = lb.reduced_order_filter(plant, m1, steps=60)
    assert lb.certify(observer, plant).stable
    settled = lb.error_covariance(over, plant, steps=60)[-1]
    P = lb.error_covariance(observer, plant)
    np.testing.assert_allclose(settled, P, rtol=0, atol=1e-9 * np.abs(P).max())


@pytest.mark.parametrize("m1", [0, 1])
@pytest.mark.parametrize("growth", [1.01, 1.5, 4.0])
def test_unstable_plant_with_exact_output(m1, growth):
    plant = lb.Plant(
        [[growth, 1, 0], [0, growth, 1], [0, 0, 0.3]], None, [[1, 0, 0]],
        dt=1.0, Q=np.diag([0.1, 0.2, 0.3]), R=[[0]], P0=np.eye(3),
    )  # fmt: skip
    observer = lb.reduced_order_filter(plant, m1)
    assert lb.certify(observer, plant).stable
    P = lb.error_covariance(observer, plant)
    over = lb.Filter(plant, m1).run(np.zeros((200, 1))).P
    np.testing.assert_allclose(over[-1], P, rtol=0, atol=1e-11 * np.abs(P).max())
    assert np.abs(P[0]).max() < 1e-12


@pytest.mark.parametrize("m1", [0, 1])
def test_no_noise_at_all_finds_the_state_in_n_steps(m1):
    """Q = R = 0: after n samples of an observable plant the error is zero for ever."""
    A = np.array([[1.1, 0.4, 0], [0, 0.8, 0.5], [0.2, 0, 0.9]])
    plant = lb.Plant(
        A, None, [[1, 0, 0]], dt=1.0, Q=np.zeros((3, 3)), R=[[0]], P0=np.eye(3)
    )
    x = np.array([1.0, -2, 3])
    states = []
    for _ in range(60):
        x = A @ x
        states.append(x)
    run = lb.Filter(plant, m1).run(np.array(states)[:, :1])
    np.testing.assert_allclose(run.x[2:], states[2:], rtol=1e-9)
    assert np.abs(run.P[2:]).max() < 1e-12
    assert np.linalg.eigvalsh(run.P).min() > -1e-15


@pytest.mark.parametrize("m1", [0, 1])
def test_certainty_of_an_unstable_mode_does_not_run_away(m1):
    """P0 = 0 and no noise on an unstable mode: zero variance is a point of balance.

    Rounding leaves it to either side.  On the negative side the covariance used to
    run away to 1e140; on the positive side the filter settles on the stable solution.
    """
    for seed in range(12):
        rng = np.random.default_rng(seed)
        basis = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        drive = basis[:, 1:] @ rng.normal(size=(2, 2))
        plant = lb.Plant(
            basis @ np.diag([1.6, 0.5, 0.9]) @ basis.T, None, rng.normal(size=(2, 3)),
            dt=1.0, Q=drive @ drive.T, R=np.eye(2), P0=np.zeros((3, 3)),
        )  # fmt: skip
        P = lb.Filter(plant, m1).run(np.zeros((300, 2))).P
        assert np.linalg.eigvalsh(P).min() > -1e-14 and np.abs(P).max() < 1e3, seed


@pytest.mark.parametrize("m1", [0, 1, 2])
def test_state_known_at_the_start(m1):
    """P0 = 0: K = 0 until noise enters, and the filter is that of the same plant."""
    rng = np.random.default_rng(9)
    for R in (np.zeros((2, 2)), np.diag([0.0, 1])):
        plant = lb.Plant(
            generators.dynamics(rng, 4, 0.9), None, rng.normal(size=(2, 4)), dt=1.0,
            Q=np.diag([0, 0, 1, 1.0]), R=R, P0=np.zeros((4, 4)), x0=np.ones(4),
        )  # fmt: skip
        y, u, u0 = generators.record(rng, plant, 5)
        x, P = generators.exact(plant, y)
        run = lb.Filter(plant, m1).run(y)
        if R[1, 1] == 0 or m1 < 2:  # treating a noisy output as exact costs accuracy
            np.testing.assert_allclose(run.P, P, rtol=0, atol=1e-12)
            np.testing.assert_allclose(run.x, x, rtol=0, atol=1e-11)
        assert (np.trace(run.P, axis1=1, axis2=2) > np.trace(P.T) - 1e-12).all()


@pytest.mark.parametrize("m1", [0, 1])
def test_double_integrator_with_jerky_noise_has_no_steady_filter(m1):
    """Position exact, acceleration constant between samples: the pole sits at -1.

    The noise input has a zero at -1, so the steady minimal-order observer would have
    its pole there and never forget its start; over a number of steps it is fine.
    """
    plant = lb.Plant(DOUBLE, None, [[1, 0]], dt=1.0, Q=JERKY, R=[[0]], P0=np.eye(2))
    with pytest.raises(lb.DesignError, match=r"no steady filter: a motion at -1,"):
        lb.reduced_order_filter(plant, m1)
    P = lb.error_covariance(
        lb.reduced_order_filter(plant, m1, steps=50), plant, steps=50
    )
    wanted = generators.exact(plant, np.zeros((50, 1)))[1]
    np.testing.assert_allclose(P[1:], wanted, rtol=0, atol=1e-12)


@pytest.mark.parametrize("R", [0.0, 1.0])
@pytest.mark.parametrize("m1", [0, 1])
def test_modes_that_cannot_be_seen_are_named(R, m1):
    plant = lb.Plant(
        np.diag([0.5, 1.25, -1.0]), None, [[1, 0, 0]], dt=1.0, Q=np.eye(3), R=[[R]]
    )
    with pytest.raises(lb.DesignError, match=r"not detectable.*-1, 1\.25"):
        lb.reduced_order_filter(plant, m1)
    turn = 1.1 * np.array([[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 0]])
    plant = lb.Plant(turn, None, [[0, 0, 1]], dt=1.0, Q=np.eye(3), R=[[R]])
    with pytest.raises(lb.DesignError, match=r"0\.66 \+- 0\.88j"):
        lb.reduced_order_filter(plant, m1)


def test_more_noise_free_outputs_than_noise_sources():
    """One source of noise, two exact outputs: right where stable, else refused.

    In the steady state one output is a function of the past of both, so the gain is
    not determined by the noise; the refusal names the outputs and the ways out.
    """
    given = dict(dt=1.0, Q=JERKY, R=np.zeros((2, 2)), P0=np.eye(2))
    plant = lb.Plant(DOUBLE, None, np.eye(2), **given)
    for m1 in (0, 1, 2):
        if m1 == 1:  # keeps y1 only, whose noise has its zero at -1
            continue
        observer = lb.reduced_order_filter(plant, m1)
        assert lb.certify(observer, plant).stable
        assert np.abs(lb.error_covariance(observer, plant)).max() < 1e-14
    growing = lb.Plant(
        np.diag([2.0, 3.0, 0.5]), None, np.eye(3)[:2], dt=1.0, Q=np.diag([0, 0, 1.0]),
        R=np.zeros((2, 2)), P0=np.eye(3),
    )  # fmt: skip
    message = r"more noise-free outputs than noise sources.*outputs \[0, 1\]"
    with pytest.raises(lb.DesignError, match=message):
        lb.kalman_filter(growing)
    both = lb.reduced_order_filter(growing, 2)
    assert both.order == 1 and lb.certify(both, growing).stable


@pytest.mark.parametrize("m1", [0, 1])
def test_zero_process_noise(m1):
    """Q = 0 and R > 0: a stable plant is left alone, an unstable one is mirrored."""
    calm = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[0]], R=[[1]], P0=[[1]])
    observer = lb.reduced_order_filter(calm, m1)
    assert lb.error_covariance(observer, calm)[0, 0] == pytest.approx(m1, abs=1e-12)
    wild = lb.Plant([[2]], None, [[1]], dt=1.0, Q=[[0]], R=[[1]])
    if m1 == 0:  # 1/P+ = 1/(4 P) + 1 has P = 3/4, pole 1/2
        observer = lb.kalman_filter(wild)
        assert observer.poles[0] == pytest.approx(0.5, abs=1e-12)
        assert lb.error_covariance(observer, wild)[0, 0] == pytest.approx(0.75)
    constant = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[1]], P0=[[1]])
    if m1 == 0:
        with pytest.raises(lb.DesignError, match="motion at 1, on the unit circle"):
            lb.kalman_filter(constant)


SCALES = [1e-8, 1e-4, 1e4, 1e8]


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("m1", [0, 1, 2])
@pytest.mark.parametrize("perfect", [False, True], ids=["noisy", "first exact"])
def test_units_of_an_output_do_not_matter(scale, m1, perfect):
    """One output in other units, with its noise: the same states and covariances."""
    rng = np.random.default_rng(5)
    plant = generators.plant(rng, 4, 2, m=0, cross=False)
    R = plant.R * np.outer([0, 1], [0, 1]) if perfect else plant.R
    units = np.diag([scale, 1.0])

    def made(unit):
        return lb.Plant(
            plant.A, None, unit @ plant.C, dt=1.0, Q=plant.Q, P0=plant.P0,
            R=unit @ R @ unit,
        )  # fmt: skip

    y, _, _ = generators.record(rng, made(np.eye(2)), 50)
    a = lb.Filter(made(np.eye(2)), m1).run(y)
    b = lb.Filter(made(units), m1).run(y @ units)
    np.testing.assert_allclose(b.x, a.x, rtol=0, atol=1e-10 * np.abs(a.x).max())
    np.testing.assert_allclose(b.P, a.P, rtol=0, atol=1e-10 * np.abs(a.P).max())
    wanted = lb.reduced_order_filter(made(np.eye(2)), m1).V
    found = lb.reduced_order_filter(made(units), m1).V @ units
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-10 * np.abs(wanted).max())


def test_without_process_noise_the_gain_is_found_though_nothing_stays_uncertain():
    """Every covariance goes to zero, so only the measurements give a scale."""
    plant = lb.Plant(
        [[0.5, 1], [0, 0.3]], None, np.eye(2), dt=1.0, Q=np.zeros((2, 2)),
        R=np.diag([0, 1]),
    )  # fmt: skip
    observer = lb.kalman_filter(plant)
    assert np.abs(np.linalg.eigvals(observer.F)).max() < 1
    np.testing.assert_allclose(lb.error_covariance(observer, plant), 0, atol=1e-12)


@pytest.mark.parametrize("scale", SCALES)
def test_units_of_a_state_do_not_matter(scale):
    """A state in other units: the Kalman filter is the same in those units."""
    rng = np.random.default_rng(6)
    plant = generators.plant(rng, 4, 2, m=0)
    Z = np.diag([scale, 1, 1, 1 / scale])
    other = lb.Plant(
        Z @ plant.A @ np.linalg.inv(Z), None, plant.C @ np.linalg.inv(Z), dt=1.0,
        Q=Z @ plant.Q @ Z, R=plant.R, S=Z @ plant.S, P0=Z @ plant.P0 @ Z,
        x0=Z @ plant.x0,
    )  # fmt: skip
    y, _, _ = generators.record(rng, plant, 40)
    a, b = lb.Filter(plant).run(y), lb.Filter(other).run(y)
    np.testing.assert_allclose(b.x / Z.diagonal(), a.x, rtol=0, atol=1e-9)
    np.testing.assert_allclose(b.std / Z.diagonal(), a.std, rtol=1e-9)


@pytest.mark.parametrize("r", [1e-4, 1e-8, 1e-11])
def test_almost_redundant_outputs_are_both_used(r):
    """A good sensor and a fair one of one state: weighed, they beat the good one."""
    plant = lb.Plant(
        DOUBLE, None, [[1, 0], [1, 0]], dt=1.0, Q=SMOOTH, P0=np.eye(2),
        R=r * np.diag([1.0, 4]),
    )  # fmt: skip
    y = np.array([[1.0, 1], [2, 2], [3, 3]])
    x, P = generators.exact(plant, y)
    run = lb.Filter(plant).run(y)
    np.testing.assert_allclose(run.P[:, 0, 0], P[:, 0, 0], rtol=1e-3)
    np.testing.assert_allclose(run.P[:, 0, 0], 0.8 * r, rtol=1e-3)
    np.testing.assert_allclose(run.x, x, rtol=0, atol=1e-9)
