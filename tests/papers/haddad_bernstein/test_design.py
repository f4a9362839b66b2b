"""The fixed-order filter: published and exact cases, its parts, and its refusals."""

from dataclasses import replace

import generators
import numpy as np
import pytest
import scipy.linalg
from fixed_order_plants import STABLE, made, noisy

import luenberger as lb
from luenberger.papers.haddad_bernstein import descent, design
from luenberger.papers.haddad_bernstein import search as search_module
from luenberger.papers.haddad_bernstein.design import fixed_order_search
from luenberger.papers.haddad_bernstein.stein import Schur
from luenberger.papers.haddad_bernstein.target import prediction, target

DE_KONING = dict(
    A=[[0.5319, 0.226275], [0.13605, 0.714375]],
    C=[[0.3088, 0.5735]],
    Q=[[0.5627, 0], [0, 0.7357]],
    R=[[0.2588]],
)
SIMON = dict(A=[[0.9, 0.1], [0.2, 0.7]], C=[[0, 1]], Q=[[0.1, 0], [0, 0]], R=[[1]])


# Published numbers and closed forms


@pytest.mark.parametrize(
    "feedthrough, F, PD, V, cost",
    [
        (True, 0.83028995, 0.16717869, 0.1983684, 0.48593771387104884),
        (False, 0.83268688, 0.19261781, 0, 0.5304946532579838),
    ],
)
def test_one_state_of_simons_plant(feedthrough, F, PD, V, cost):
    """Simon, Optimal State Estimation, the plant of section 10.3; brute force optima.

    His own one-state filter has 0.5272, the best with its pole 0.5139.
    """
    plant = made(**SIMON)
    options = dict(L=[[1, 0]], feedthrough=feedthrough)
    found = fixed_order_search(plant, 1, starts=8, **options)
    o = found.best.observer
    assert found.best.cost == pytest.approx(cost, abs=1e-12)
    assert o.F[0, 0] == pytest.approx(F, abs=1e-7)
    assert (o.P @ o.D)[0, 0] == pytest.approx(PD, abs=1e-7)
    assert o.V[0, 0] == pytest.approx(V, abs=1e-7)
    assert len(found.minima) == 1 and found.best.optimality.worst < 1e-12


@pytest.mark.parametrize(
    "order, feedthrough, cost, F",
    [
        (1, True, 1.1024980912035076, 0.36945849363846495),
        (1, False, 1.6848688827732154, 0.3248719262650812),
        (2, True, 1.1000814327179174, None),
        (2, False, 1.6821083851091923, None),
    ],
)
def test_de_konings_plant(order, feedthrough, cost, F):
    """De Koning 1992, A scaled by 3/4 to be stable; optima by brute force."""
    options = dict(feedthrough=feedthrough, starts=8)
    found = fixed_order_search(made(**DE_KONING), order, **options)
    assert found.best.cost == pytest.approx(cost, abs=1e-12)
    if F is not None:
        assert found.best.observer.F[0, 0] == pytest.approx(F, abs=1e-7)


def test_scalar_plant_with_multiplicative_noise_in_closed_form():
    """x+ = (1/2 + g/4) x + w, y = (1 + h/2) x + v, with variances 1 and 1/2."""
    pairs = [([[0.25]], [[0]]), ([[0]], [[0.5]])]
    plant = made([[0.5]], [[1]], Q=[[1]], R=[[0.5]], multiplicative=pairs)
    P = (39 + np.sqrt(30705)) / 176
    K = (np.sqrt(30705) - 153) / 76
    ahead = fixed_order_search(plant, 1, feedthrough=False).best
    assert ahead.cost == pytest.approx(P, rel=1e-13)
    assert ahead.observer.D[0, 0] == pytest.approx(K, rel=1e-12)
    now = lb.fixed_order_filter(plant, 1)
    assert now.V[0, 0] == pytest.approx(2 * K, rel=1e-12)
    assert now.F[0, 0] == pytest.approx(0.5 - K, rel=1e-12)


@pytest.mark.parametrize("a", [10.0, 100.0, 1000.0])
def test_model_reduction_of_zigic_and_others(a):
    """Zigic, Watson, Collins and Bernstein 1992, example 2: a trap for poor starts.

    Continuous H2 reduction is this problem for C = 0 and noise in y that drives x,
    after s = a (z - 1) / (z + 1), which leaves the Gramians as they are.
    """
    A, B = np.array([[-0.05, -0.99], [-0.99, -5000.0]]), np.array([[1], [100.0]])
    eye = np.eye(2)
    back = np.linalg.inv(eye - A / a)
    Ad, Bd = back @ (eye + A / a), np.sqrt(2 / a) * back @ B
    plant = made(Ad, np.zeros((1, 2)), Q=Bd @ Bd.T, R=[[1]], S=Bd)
    found = fixed_order_search(plant, 1, L=B.T, feedthrough=False)
    o = found.best.observer
    F = o.F[0, 0]
    assert found.best.cost == pytest.approx(9.26679949733, rel=1e-9)
    assert a * (F - 1) / (F + 1) == pytest.approx(-4998.0787, abs=1e-3)
    gain = o.P[0, 0] * o.D[0, 0] * np.sqrt(a / 2) * 2 / (F + 1)
    assert np.sqrt(gain) == pytest.approx(100.000194, abs=1e-5)
    worse = found.minima[1:]
    assert all(one.cost == pytest.approx(9999.01898, rel=1e-8) for one in worse)
    assert worse or a > 100, "the bad minimum is listed too"


# Order n


@pytest.mark.parametrize("feedthrough", [True, False], ids=["filter", "predictor"])
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"A": np.diag(np.ones(4), 1)},
        {"R": np.zeros((2, 2)), "S": np.zeros((5, 2))},
        {"S": np.zeros((5, 2))},
    ],
    ids=["with S", "A nilpotent", "no measurement noise", "S = 0"],
)
def test_order_n_is_the_kalman_filter(changes, feedthrough):
    plant = generators.plant(np.random.default_rng(1), 5, 2)
    plant = replace(plant, **changes)
    found = fixed_order_search(plant, 5, feedthrough=feedthrough).best
    o, kalman = found.observer, lb.kalman_filter(plant)
    assert lb.certify(o, plant).worst < 1e-12  # exact for known inputs too
    wanted = lb.error_covariance(kalman, plant)
    if feedthrough:
        assert np.abs(o.V - kalman.V).max() < 1e-10
    else:  # from the filter at i to the prediction of i + 1; J v is what S tells of w
        J = plant.S @ np.linalg.pinv(plant.R)
        As = plant.A - J @ plant.C
        wanted = As @ wanted @ As.T + plant.Q - J @ plant.R @ J.T
        assert not o.V.any()
    assert found.cost == pytest.approx(np.trace(wanted), rel=1e-10)
    ours = lb.error_covariance(o, plant)
    assert np.abs(ours - wanted).max() < 1e-10 * np.abs(wanted).max()
    ours, theirs = np.poly(o.F), np.poly(kalman.F)
    assert np.abs(ours - theirs).max() < 1e-10


@pytest.mark.parametrize("noises", [1, 2])
@pytest.mark.parametrize("feedthrough", [True, False])
def test_order_n_with_multiplicative_noise_solves_corollary_31(noises, feedthrough):
    """(3.21)-(3.27), coded here as printed."""
    plant = noisy(noises, 4, 2, noises=noises)
    found = fixed_order_search(plant, 4, feedthrough=feedthrough).best
    o, (A, C), (V1, V2, V12) = (
        found.observer,
        (plant.A, plant.C),
        (plant.Q, plant.R, plant.S),
    )
    Q, Qh = found.optimality.Q, found.optimality.Qh
    pairs = plant.multiplicative
    V2s = V2 + C @ Q @ C.T + sum(Ci @ (Q + Qh) @ Ci.T for _, Ci in pairs)
    Qs = A @ Q @ C.T + V12 + sum(Ai @ (Q + Qh) @ Ci.T for Ai, Ci in pairs)
    K = Qs @ np.linalg.inv(V2s)
    spread = K @ Qs.T
    right = A @ Q @ A.T + sum(Ai @ (Q + Qh) @ Ai.T for Ai, _ in pairs) + V1 - spread
    size = np.abs(Q + Qh).max()
    assert np.abs(right - Q).max() < 1e-11 * size  # (3.25)
    assert np.abs(A @ Qh @ A.T + spread - Qh).max() < 1e-11 * size  # (3.26)
    assert np.abs(o.F - (A - K @ C)).max() < 1e-11
    assert np.abs(o.D - K).max() < 1e-11
    De = Q @ C.T @ np.linalg.inv(V2s) if feedthrough else np.zeros((4, 2))
    assert np.abs(o.V - De).max() < 1e-11
    assert found.cost == pytest.approx(np.trace(Q - De @ V2s @ De.T), rel=1e-12)


# What is returned


def test_known_inputs_enter_as_in_the_observer_form():
    """(3.19): with the input known, z follows Gam x as if u were not there."""
    plant = generators.plant(np.random.default_rng(4), 5, 2, m=2, radius=0.8)
    o = lb.fixed_order_filter(plant, 2, starts=3)
    assert np.abs(o.G - (o.T @ plant.B - o.D @ plant.E)).max() < 1e-14
    assert np.abs(o.W + o.V @ plant.E).max() < 1e-14
    assert np.abs(o.z0 - o.T @ plant.x0).max() < 1e-14
    assert lb.certify(o, plant).input < 1e-14
    still = replace(plant, B=None, E=None, input_names=None)
    without = lb.fixed_order_filter(still, 2, starts=3)
    for name in "FDPVT":
        assert (getattr(o, name) == getattr(without, name)).all()


def test_same_numbers_every_time_and_balanced_coordinates():
    plant = noisy(3, 5, 2)
    one, two = (lb.fixed_order_filter(plant, 2, seed=5, starts=6) for _ in range(2))
    for name in "FDPVT":
        assert (getattr(one, name) == getattr(two, name)).all()
    # other starts, the same minimum
    other = lb.fixed_order_filter(plant, 2, seed=6, starts=6)
    for name in "FDPVT":
        assert np.abs(getattr(one, name) - getattr(other, name)).max() < 1e-8
    reach = equivalent_reach(one, plant)
    seen = scipy.linalg.solve_discrete_lyapunov(one.F.T, one.P.T @ one.P)
    assert np.abs(reach - seen).max() < 1e-10 * seen.max()
    assert np.abs(seen - np.diag(np.diag(seen))).max() < 1e-10 * seen.max()
    assert seen[0, 0] > seen[1, 1]


@pytest.mark.parametrize("seed", range(4))
def test_rows_of_t_point_the_same_way_on_every_machine(seed):
    plant = generators.plant(np.random.default_rng(seed), 4, 2, m=0)
    T = lb.fixed_order_filter(plant, 3, starts=2).T
    assert (T[np.arange(3), np.abs(T).argmax(axis=1)] > 0).all()


def equivalent_reach(observer, plant):
    """E[z z'] by the long way: a Kronecker system of plant and observer."""
    n, r = plant.n, observer.order
    A = np.block([[plant.A, np.zeros((n, r))], [observer.D @ plant.C, observer.F]])
    pairs = [
        np.block([[A1, np.zeros((n, r))], [observer.D @ C1, np.zeros((r, r))]])
        for A1, C1 in plant.multiplicative
    ]
    H = scipy.linalg.block_diag(np.eye(n), observer.D)
    V = H @ np.block([[plant.Q, plant.S], [plant.S.T, plant.R]]) @ H.T
    whole = np.eye((n + r) ** 2) - sum(np.kron(M, M) for M in (A, *pairs))
    return np.linalg.solve(whole, V.ravel()).reshape(n + r, n + r)[n:, n:]


@pytest.mark.parametrize("feedthrough", [True, False])
def test_excess_is_the_difference_to_the_kalman_filter(feedthrough):
    plant = noisy(6, 5, 2)
    found = fixed_order_search(plant, 2, feedthrough=feedthrough, starts=8)
    full = fixed_order_search(plant, 5, feedthrough=feedthrough)
    assert found.least_cost == full.best.cost == full.least_cost
    for one in found.minima:
        assert one.excess > 0
        assert one.optimality.cost == pytest.approx(one.cost, rel=1e-12)
        assert one.cost - full.best.cost == pytest.approx(one.excess, rel=1e-9)


def test_search_lists_the_minima_and_their_starts():
    plant = made(np.diag([0.9, -0.8]), [[1, 1]], Q=np.eye(2), R=[[1]])
    found = fixed_order_search(plant, 1, L=[[1, 1]], starts=10, seed=3)
    assert [round(one.excess, 4) for one in found.minima] == [0.049, 0.0909]
    assert found.best is found.minima[0] and found.enough == 2
    names = [name for one in found.minima for name in one.starts]
    failed = [name for name, _ in found.failed]
    assert len(names + failed) == 10 == len(set(names + failed))
    assert {"directions 1", "directions 2", "random 1"} <= set(names + failed)
    for one in found.minima:
        assert one.optimality.worst < 1e-12


def test_a_saddle_is_left():
    """The weaker of two unconnected states alone is stationary, but no minimum."""
    A, Q = np.diag([0.9, 0.5]), np.diag([1, 2])
    plant = made(A, np.eye(2), Q=Q, R=np.eye(2))
    found = fixed_order_search(plant, 1, feedthrough=False)
    assert len(found.minima) == 1 and "directions 2" in found.best.starts


def test_minima_that_form_a_continuum_are_one():
    """Two copies of a plant: any mixture of their best estimates is as good."""
    twice = np.eye(2)
    parts = {k: np.kron(twice, v) for k, v in DE_KONING.items()}
    found = fixed_order_search(made(**parts), 1, starts=12)
    alone = fixed_order_search(made(**DE_KONING), 1, starts=4)
    assert len(found.minima) == 1 and len(found.best.starts) == 12
    static = fixed_order_search(made(**DE_KONING), 2)
    assert found.best.excess > alone.best.excess > static.best.excess == 0


def test_order_that_is_enough_loses_nothing():
    """One of two unconnected plants is of no interest."""
    one = generators.plant(np.random.default_rng(5), 4, 1, m=0)
    other = generators.plant(np.random.default_rng(6), 3, 1, m=0)
    parts = {
        k: scipy.linalg.block_diag(getattr(one, k), getattr(other, k)) for k in "ACQRS"
    }
    turn = np.linalg.qr(np.random.default_rng(7).normal(size=(7, 7)))[0]
    A, C, Q, R, S = parts.values()
    plant = made(turn @ A @ turn.T, C @ turn.T, Q=turn @ Q @ turn.T, R=R, S=turn @ S)
    L = turn.T[:1]
    full = fixed_order_search(plant, 7, L=L)
    found = fixed_order_search(plant, 4, L=L)
    assert found.enough == 4 and found.best.excess == 0
    assert found.best.optimality.worst < 1e-10 and full.best.optimality.worst < 1e-10
    assert found.best.optimality.cost == pytest.approx(full.best.cost, rel=1e-12)
    assert np.abs((found.best.observer.T @ turn)[:, 4:]).max() < 1e-10
    three = fixed_order_search(plant, 3, L=L, starts=4).best
    assert three.excess > 0
    with pytest.raises(lb.DesignError, match="needs only 4 states.*Order 4 loses"):
        lb.fixed_order_filter(plant, 5, L=L)


@pytest.mark.parametrize("size", [1e-6, 1e6])
def test_units_play_no_part(size):
    """States, outputs and estimates in other units: the same filter."""
    plant = noisy(8, 4, 2)
    X = np.diag([1, size, 1 / size, 1])
    Y, back = np.diag([size, 1]), np.diag([1, 1 / size, size, 1])
    scaled = made(
        X @ plant.A @ back,
        Y @ plant.C @ back,
        Q=X @ plant.Q @ X,
        R=Y @ plant.R @ Y,
        S=X @ plant.S @ Y,
        multiplicative=[
            (X @ A1 @ back, Y @ C1 @ back) for A1, C1 in plant.multiplicative
        ],
    )
    one = lb.fixed_order_filter(plant, 2, starts=6)
    two = lb.fixed_order_filter(scaled, 2, L=back, starts=6)
    assert lb.optimality(two, scaled).worst < 1e-12
    for wanted, found in (
        (one.F, two.F),
        (one.D, two.D @ Y),
        (one.P, two.P),
        (one.V, two.V @ Y),
    ):
        assert (
            np.abs(np.abs(wanted) - np.abs(found)).max() < 1e-7 * np.abs(wanted).max()
        )


@pytest.mark.parametrize("size", [1e-12, 1e12])
def test_strength_of_all_noise_plays_no_part(size):
    plant = replace(noisy(8, 4, 2), multiplicative=())
    scaled = replace(plant, Q=size * plant.Q, R=size * plant.R, S=size * plant.S)
    one, two = (fixed_order_search(p, 2, starts=6) for p in (plant, scaled))
    assert len(two.minima) == len(one.minima) and not two.failed
    assert two.best.cost == pytest.approx(size * one.best.cost, rel=1e-10)
    assert two.best.optimality.worst < 1e-12
    assert np.abs(two.best.observer.V - one.best.observer.V).max() < 1e-8


def test_a_weight_may_have_any_units():
    plant, units = noisy(4, 3, 1), np.array([1, 1e-9, 1e9])
    weight = np.array([[2, 1, 0], [1, 2, 1], [0, 1, 2]]) * np.outer(units, units)
    one = fixed_order_search(plant, 1, weight=weight, starts=4).best
    two = fixed_order_search(
        plant, 1, L=np.diag(units), weight=weight / np.outer(units, units), starts=4
    ).best
    assert one.cost == pytest.approx(two.cost, rel=1e-12)
    assert one.optimality.worst < 1e-10


@pytest.mark.parametrize("feedthrough", [True, False])
def test_measurements_without_noise(feedthrough):
    """R = 0 is a limit that exists as long as every output brings something new."""
    plant = replace(generators.plant(np.random.default_rng(2), 5, 2), S=None)
    least, near = (
        fixed_order_search(
            replace(plant, R=size * plant.R), 2, feedthrough=feedthrough, starts=6
        )
        for size in (0, 1e-12)
    )
    assert least.best.cost == pytest.approx(near.best.cost, rel=1e-9)
    assert least.best.optimality.worst < 1e-12


# Refusals

TWICE = dict(C=[[1, 0], [2, 0]], R=np.zeros((2, 2)))


@pytest.mark.parametrize(
    "changes, options, message",
    [
        ({"A": [[1.1, 0], [0, 0.5]]}, {}, r"A has the mode 1\.1 on or outside.*kalman"),
        ({"A": [[1 - 1e-15, 0.1], [0, 0.5]]}, {}, "A has the mode 1 on or outside"),
        (
            {"multiplicative": [(1.2 * np.eye(2), [[0, 0]])]},
            {},
            r"radius of A\(x\)A \+ sum A_i\(x\)A_i is 1\.69.*0\.7216",
        ),
        ({}, {"order": 0}, "order must be a whole number from 1 to n = 2, got 0"),
        ({}, {"order": 3}, "from 1 to n = 2, got 3"),
        ({}, {"order": 1.0}, "got 1.0"),
        ({}, {"order": True}, "got True"),
        ({}, {"starts": 0}, "starts must be a whole number from 1 up"),
        *(
            ({}, {"seed": seed}, "seed must be a whole number from 0 up")
            for seed in (None, -1, 0.5, "1", True)
        ),
        ({}, {"feedthrough": 1}, "feedthrough must be True or False"),
        ({}, {"L": np.zeros((0, 2))}, "L has no rows"),
        ({}, {"L": [[1, 2, 3]]}, "L must be 1 x 2"),
        ({}, {"weight": np.diag([1, 0])}, "weight must be positive definite"),
        ({}, {"weight": [[1]]}, "weight must be 2 x 2"),
        ({"dt": 0.0}, {}, "discrete time but the plant has dt = 0"),
        ({"Q": None}, {}, "no Q, the covariance of the process noise"),
        ({"R": None}, {}, "no R"),
        ({"A": np.stack([np.eye(2)] * 3)}, {}, "for a constant plant"),
        ({"A": [[0.5, 0.1j], [0, 0.2]]}, {}, "the plant is complex"),
        (TWICE, {}, r"V2s of \(3\.10\) is singular.*outputs y1, y2 .*noise in R"),
        ({"Q": np.zeros((2, 2))}, {}, "no filter state is of use"),
        ({"C": [[0, 0]]}, {}, "no filter state is of use"),
    ],
)
def test_refusals(changes, options, message):
    given = {"dt": 1.0} | STABLE | changes
    plant = lb.Plant(given.pop("A"), None, given.pop("C"), **given)
    options = {"order": 1} | options
    with pytest.raises(ValueError, match=f"(?s){message}"):
        lb.fixed_order_filter(plant, **options)


def test_order_n_is_not_refused_where_less_would_be():
    nothing = {"A": [[0.95, 0.1], [0, -0.4]], "Q": np.zeros((2, 2))}
    for changes in (TWICE, nothing, {"C": [[0, 0]]}):
        plant = made(**(STABLE | changes))
        found = fixed_order_search(plant, 2).best
        assert found.optimality.worst < 1e-12
        assert lb.certify(found.observer, plant).worst < 1e-12


def test_a_filter_that_misses_a_condition_is_refused(monkeypatch):
    def spoilt(*args, **options):
        return replace(lb.optimality(*args, **options), riccati=1e-7)

    monkeypatch.setattr(design, "optimality", spoilt)
    plant = made(**SIMON)
    assert fixed_order_search(plant, 1, starts=2).best.optimality.worst == 1e-7
    with pytest.raises(lb.CertificateError, match=r"\(3\.14\) is missed by 1.0e-07"):
        lb.fixed_order_filter(plant, 1, starts=2)


def test_start_that_fails_says_why():
    plant = made(**SIMON)
    whole = target(prediction(plant, np.eye(2), np.eye(2), True))
    for Ae, Be, reason in (
        (np.diag([0.5, 0.5]), [[1], [1]], "fewer states than its order"),
        (np.diag([1.5, 0.5]), [[1], [1]], "limit of stability"),
    ):
        with pytest.raises(lb.CertificateError, match=reason):
            descent.descend(whole, Ae, np.array(Be, float))


# The parts


@pytest.mark.parametrize("stack", [(), (4,)], ids=["one", "four at once"])
def test_stein_equations(stack):
    rng = np.random.default_rng(0)
    A, F = generators.dynamics(rng, 6, 0.95), generators.dynamics(rng, 3, 0.9)
    N = rng.normal(size=(*stack, 6, 3))
    X = Schur(A).forward(Schur(F), N)
    assert np.abs(A @ X @ F.T + N - X).max() < 1e-12
    X = Schur(A).backward(Schur(F), N)
    assert np.abs(A.T @ X @ F + N - X).max() < 1e-12


@pytest.mark.parametrize("feedthrough", [True, False])
@pytest.mark.parametrize("balanced", [True, False])
def test_gradient_and_hessian_against_differences(feedthrough, balanced):
    rng = np.random.default_rng(7)
    plant = noisy(7, 5, 2, noises=2)
    L = rng.normal(size=(3, 5))
    sought = target(prediction(plant, L, np.diag([1.0, 2, 3]), feedthrough))
    Ae, Be = 0.3 * rng.normal(size=(2, 2)), rng.normal(size=(2, 2))
    frame = descent.Frame(sought, Ae, Be, balanced=balanced)

    def cost(step):
        return descent.evaluate(sought, *frame.moved(step)).cost

    h, eye = 1e-4, np.eye(4)
    slope = [(cost(h * e) - cost(-h * e)) / (2 * h) for e in eye]
    np.testing.assert_allclose(slope, frame.slope, atol=1e-6 * sought.scale)
    plus, minus = (
        [
            [cost(h * (a + sign * b)) + cost(-h * (a + sign * b)) for a in eye]
            for b in eye
        ]
        for sign in (1, -1)
    )
    hessian = (np.array(plus) - np.array(minus)) / (4 * h * h)
    np.testing.assert_allclose(hessian, np.diag(frame.values), atol=1e-5 * sought.scale)


def test_steps_of_the_trust_region():
    """Full where the model allows, else to the edge; downhill from a saddle."""
    sought = target(prediction(made(**SIMON), np.eye(2), np.eye(2), True))
    frame = descent.Frame(sought, np.array([[0.2]]), np.array([[1.0]]))
    for values, slope, reach, length in (
        ([2.0], [1.0], 1.0, 0.5),
        ([2.0], [1.0], 0.1, 0.1),
        ([-2.0, 1.0], [0.0, 0.0], 0.3, 0.3),
        ([-2.0, 1.0], [1e-3, 1.0], 0.3, 0.3),
    ):
        frame.values, frame.slope = np.array(values), np.array(slope)
        step = frame.step(reach)
        assert np.linalg.norm(step) == pytest.approx(length, rel=1e-6)
        assert frame.model(step) > 0
        other = np.random.default_rng(0).normal(size=(200, len(step)))
        other *= length / np.linalg.norm(other, axis=1, keepdims=True)
        assert frame.model(step) >= max(frame.model(one) for one in other) - 1e-9


def test_directions_diagonalise_both_gramians():
    plant = noisy(2, 5, 2)
    sought = target(prediction(plant, np.eye(5), np.eye(5), True))
    found = search_module.directions(sought)
    A, C, L, Q1 = (sought.matrices[k] for k in ("A", "C", "L", "Q1"))
    F = A - sought.Kq @ C
    Ph = scipy.linalg.solve_discrete_lyapunov(F.T, L.T @ L)
    assert np.abs(found.read @ found.lift - np.eye(5)).max() < 1e-10
    assert (
        np.abs(found.lift.T @ Ph @ found.lift - np.diag(found.strength)).max() < 1e-10
    )
    assert (
        np.abs(found.read @ Q1 @ found.read.T - np.diag(found.strength)).max() < 1e-10
    )
    assert (np.diff(found.strength) <= 0).all()


def test_gramian_roots_keep_weak_directions():
    """Values down to 1e-14 of the largest, which a square root of H H' would lose."""
    A = np.diag([0.9, 0.5, 0.1])
    B = np.diag([1.0, 1e-5, 1e-14])
    H = search_module.gramian_root(A, B)
    wanted = B.diagonal() / np.sqrt(1 - A.diagonal() ** 2)
    found = np.sort(np.linalg.svd(H, compute_uv=False))[::-1]
    np.testing.assert_allclose(found, wanted, rtol=1e-3)


def test_a_better_start_among_bad_ones_is_enough(monkeypatch):
    """When every start fails, the message says why; when one does not, it is used."""
    plant, descend = made(**SIMON), search_module.descend

    def fussy(sought, Ae, Be):
        if Ae[0, 0] != fussy.first:
            raise lb.CertificateError("of a bad mood")
        return descend(sought, Ae, Be)

    sought = target(prediction(plant, np.eye(2), np.eye(2), True))
    found = search_module.directions(sought)
    fussy.first = next(search_module.starts(sought, found, 1, 24, 0))[1][0, 0]
    monkeypatch.setattr(search_module, "descend", fussy)
    search = fixed_order_search(plant, 1)
    assert len(search.failed) == 23 and search.best.starts == ("directions 1",)
    assert search.failed[0] == ("directions 2", "of a bad mood")
    fussy.first = np.inf
    with pytest.raises(lb.CertificateError, match="of a bad mood.*more starts"):
        lb.fixed_order_filter(plant, 1)


def test_outputs_that_say_the_same_are_named():
    plant = lb.Plant(
        [[0.6, 0.1], [0, 0.3]],
        None,
        [[1, 0], [0, 1], [1, 0]],
        dt=1.0,
        Q=np.eye(2),
        R=np.zeros((3, 3)),
        output_names=["radar", "speed", "sonar"],
    )
    with pytest.raises(lb.DesignError, match="of the outputs radar, sonar follows"):
        lb.fixed_order_filter(plant, 1)


@pytest.mark.parametrize(
    "A, C", [([[0.5]], [[1], [2]]), (np.diag([0.5, 0.7]), [[1, 2], [3, 4]])]
)
def test_what_exact_outputs_tell_is_optimal(A, C):
    """Of an error that is zero every condition is met, however it was rounded."""
    n, p = len(A), len(C)
    plant = lb.Plant(A, None, C, dt=1.0, Q=np.eye(n), R=np.zeros((p, p)))
    observer = lb.fixed_order_filter(plant, n)
    np.testing.assert_allclose(observer.V @ C, np.eye(n), atol=1e-12)
    found = lb.optimality(observer, plant)
    assert found.worst < 1e-12 and abs(found.cost) < 1e-12
    off = replace(observer, V=0.9 * observer.V)
    assert lb.optimality(off, plant).worst > 1e-2
    off = replace(observer, P=1e-6 * np.ones((n, n)))
    assert lb.optimality(off, plant).worst > 1e-2


def test_no_filter_state_is_of_use_beside_exact_outputs():
    plant = lb.Plant(
        [[0.5, 0.2], [0.1, 0.7]], None, [[1, 2], [3, 4]], dt=1.0, Q=np.eye(2),
        R=np.zeros((2, 2)),
    )  # fmt: skip
    with pytest.raises(lb.DesignError, match="no filter state is of use: the static"):
        lb.fixed_order_filter(plant, 1)
