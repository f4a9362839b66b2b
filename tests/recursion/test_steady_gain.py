"""Steady states: fixed points to rounding, the best constant gain, and refusals."""

import contextlib

import generators
import numpy as np
import pytest
import scipy.linalg
import scipy.sparse.linalg

import luenberger as lb
from luenberger import kernels
from luenberger.papers.leondes_novak.derivation import gain_step, steady_gradient
from luenberger.recursion import best_constant_gain, excitation, steady_gain
from luenberger.recursion.settings import Setting, setting


def plants():
    rng = np.random.default_rng(11)
    shapes = [(2, 1), (3, 2), (5, 3), (9, 4), (16, 3)]
    for n, p in shapes:
        yield generators.plant(rng, n, p)
        yield generators.plant(rng, n, p, radius=1.3, cross=False)


CASES = [
    pytest.param(plant, m1, id=f"n={plant.n} m1={m1} plant {k}")
    for k, plant in enumerate(plants())
    for m1 in range(plant.p + 1)
]


@pytest.mark.parametrize("plant, m1", CASES)
def test_fixed_point_to_rounding(plant, m1):
    now = setting(plant, range(m1))
    observer = lb.reduced_order_filter(plant, m1)
    Sigma = lb.error_covariance(observer, plant)
    new = kernels.compiled(gain_step)(
        A=now.As, Q=now.Qs, C=now.C, R=now.R, Gamma=now.Gamma, Sigma=Sigma
    )
    gap = np.abs(new["Sigma_next"] - Sigma).max()
    assert gap <= 1e-12 * np.abs(new["Omega"]).max()
    assert (np.abs(observer.poles) < 1).all()


@pytest.mark.parametrize("plant", list(plants()), ids=lambda plant: f"n={plant.n}")
def test_kalman_filter_solves_the_riccati_equation_of_scipy(plant):
    Omega = scipy.linalg.solve_discrete_are(
        plant.A.T, plant.C.T, plant.Q, plant.R, s=plant.S
    )
    M = plant.C @ Omega @ plant.C.T + plant.R
    gain = Omega @ plant.C.T @ np.linalg.inv(M)
    np.testing.assert_allclose(lb.kalman_filter(plant).V, gain, rtol=1e-7, atol=1e-9)


def test_the_filter_over_steps_settles_on_it():
    plant = generators.plant(np.random.default_rng(3), 4, 3)
    for m1 in range(4):
        settled = lb.reduced_order_filter(plant, m1, steps=400).V[-1]
        np.testing.assert_allclose(
            lb.reduced_order_filter(plant, m1).V, settled, rtol=1e-9, atol=1e-11
        )


def test_large_plant_takes_the_iterative_path():
    n = steady_gain.DENSE_LIMIT + 4
    plant = generators.plant(np.random.default_rng(4), n, 3, cross=False)
    observer = lb.reduced_order_filter(plant, 2)
    now = setting(plant, [0, 1])
    Sigma = lb.error_covariance(observer, plant)
    new = steady_gain.step_from(now, Sigma)
    gap = np.abs(new["Sigma_next"] - Sigma).max()
    assert gap <= 1e-12 * np.abs(new["Omega"]).max()


def springs(n, p):
    """Masses and springs with little damping: every mode forgets slowly."""
    m = n // 2
    K = 2 * np.eye(m) - np.eye(m, k=1) - np.eye(m, k=-1)
    A = np.block([[np.zeros((m, m)), np.eye(m)], [-K, -0.02 * np.eye(m)]])
    C = np.eye(n)[np.linspace(0, n - 1, p).astype(int)]
    A = scipy.linalg.expm(0.3 * A)
    return lb.Plant(A, None, C, dt=1.0, Q=0.1 * np.eye(n), R=0.01 * np.eye(p))


@pytest.mark.parametrize("m1", [0, 2])
def test_large_slow_plant_takes_few_steps(monkeypatch, m1):
    """Few iterations of Newton's equation, and no search where all is driven."""
    plant, count = springs(steady_gain.DENSE_LIMIT + 4, 3), dict(moves=0, values=0)

    gmres = scipy.sparse.linalg.gmres

    def counted_gmres(*args, **options):
        def count_one(_):
            count["moves"] += 1

        return gmres(*args, callback=count_one, callback_type="pr_norm", **options)

    def counted_values(*args, **options):
        count["values"] += 1
        return np.linalg.svd(*args, **options, compute_uv=False)

    monkeypatch.setattr(scipy.sparse.linalg, "gmres", counted_gmres)
    monkeypatch.setattr(scipy.linalg, "svdvals", counted_values)
    observer = lb.reduced_order_filter(plant, m1)
    assert 0 < count["moves"] <= (20 if m1 else 4)
    assert 0 < count["values"] <= plant.n / 2  # one for each pair of poles at most
    if m1 == 0:
        Omega = scipy.linalg.solve_discrete_are(plant.A.T, plant.C.T, plant.Q, plant.R)
        gain = Omega @ plant.C.T @ np.linalg.inv(plant.C @ Omega @ plant.C.T + plant.R)
        np.testing.assert_allclose(observer.V, gain, rtol=1e-7, atol=1e-9)


def greedy_case():
    """A plant on which the step-wise gain is far from the best constant one."""
    A = [[0.5, 1.1, 0.0], [-0.9, 0.3, 0.8], [0.2, -0.6, 0.9]]
    Q = np.diag([0.1, 0.02, 0.01])
    return lb.Plant(A, None, [[1, 0, 0], [0, 1, 0]], dt=1.0, Q=Q, R=np.diag([2.0, 3.0]))


def steady_trace(plant, observer, weight=None):
    Sigma = lb.error_covariance(observer, plant)
    return np.trace(Sigma if weight is None else weight @ Sigma)


@pytest.mark.parametrize("weight", [None, np.diag([1.0, 5.0, 0.1])], ids=["I", "W"])
def test_best_constant_gain_is_lower_and_nothing_near_is_lower_still(weight):
    plant = greedy_case()
    step = lb.reduced_order_filter(plant, 1, weight=weight)
    best = lb.reduced_order_filter(plant, 1, weight=weight, horizon="steady")
    least = steady_trace(plant, best, weight)
    assert least < 0.98 * steady_trace(plant, step, weight)
    now = setting(plant, [0], weight)
    rng = np.random.default_rng(1)
    for size in (1e-4, 1e-2, 1e-1):
        for _ in range(20):
            K = best.V + size * now.Phat @ rng.normal(size=(2, 2))
            cost, _ = steady_gain.steady_cost(
                now, K, np.eye(3) if weight is None else weight
            )
            assert cost > least


def test_gradient_of_the_steady_trace_by_finite_differences():
    now = setting(greedy_case(), [0])
    W = np.diag([1.0, 2.0, 0.5])
    K = steady_gain.steady_gain(now, (0,)) + 0.05 * now.Phat @ np.ones((2, 2))
    _, (Sigma, Phi) = steady_gain.steady_cost(now, K, W)
    Lambda = scipy.linalg.solve_discrete_lyapunov(Phi.T, W)
    Omega = now.As @ Sigma @ now.As.T + now.Qs
    M = now.C @ Omega @ now.C.T + now.R
    have = dict(K=K, M=M, Omega=Omega, C=now.C, Lambda=Lambda)
    gradient = kernels.run(steady_gradient, have)
    rng = np.random.default_rng(0)
    for _ in range(5):
        d = now.Phat @ rng.normal(size=(2, 2))
        h = 1e-5
        slope = (
            steady_gain.steady_cost(now, K + h * d, W)[0]
            - steady_gain.steady_cost(now, K - h * d, W)[0]
        )
        slope /= 2 * h
        np.testing.assert_allclose(np.sum(gradient["Gradient"] * d), slope, rtol=1e-6)


def test_stationary_gain_is_the_stepwise_gain_with_weight_lambda():
    plant = greedy_case()
    best = lb.reduced_order_filter(plant, 1, horizon="steady")
    now = setting(plant, [0])
    Phi = (np.eye(3) - best.V @ now.C) @ now.As
    Lambda = scipy.linalg.solve_discrete_lyapunov(Phi.T, np.eye(3))
    again = lb.reduced_order_filter(plant, 1, weight=Lambda)
    np.testing.assert_allclose(again.V, best.V, rtol=1e-8, atol=1e-12)


def test_horizon_makes_no_difference_to_the_kalman_filter_and_perfect_outputs():
    rng = np.random.default_rng(7)
    plant = generators.plant(rng, 4, 2, cross=False)
    perfect = lb.Plant(
        plant.A, None, plant.C, dt=1.0, Q=plant.Q, R=np.diag([0, plant.R[1, 1]])
    )
    for which, m1 in ((plant, 0), (perfect, 1)):
        one = lb.reduced_order_filter(which, m1)
        two = lb.reduced_order_filter(which, m1, horizon="steady")
        np.testing.assert_allclose(one.V, two.V, rtol=1e-8, atol=1e-10)


DOUBLE = [[1.0, 1.0], [0.0, 1.0]]
CONSTANT_ACCELERATION = [[0.25, 0.5], [0.5, 1.0]]


@pytest.mark.parametrize(
    "plant, m1, message",
    [
        (
            lb.Plant(DOUBLE, None, [[0, 1]], dt=1.0, Q=np.eye(2), R=[[1]]),
            0,
            "not detectable: the plant mode at 1 ",
        ),
        (
            lb.Plant(np.diag([1.2, 0.5]), None, [[0, 1]], dt=1.0, Q=np.eye(2), R=[[1]]),
            1,
            r"not detectable: the plant mode at 1\.2 ",
        ),
        (
            lb.Plant(DOUBLE, None, [[1, 0]], dt=1.0, Q=CONSTANT_ACCELERATION, R=[[0]]),
            0,
            "no steady filter: a motion at -1,",
        ),
        (
            lb.Plant(DOUBLE, None, [[1, 0]], dt=1.0, Q=CONSTANT_ACCELERATION, R=[[0]]),
            1,
            "no steady filter: a motion at -1,",
        ),
        (
            lb.Plant(DOUBLE, None, [[1, 0]], dt=1.0, Q=np.zeros((2, 2)), R=[[1]]),
            0,
            "no steady filter: a motion at 1,",
        ),
        (
            lb.Plant(
                [[np.cos(1), -np.sin(1)], [np.sin(1), np.cos(1)]],
                None,
                [[1, 0]],
                dt=1.0,
                Q=np.zeros((2, 2)),
                R=[[1]],
            ),
            0,
            r"no steady filter: a motion at 0\.540302 \+- 0\.841471j",
        ),
    ],
    ids=[
        "undetectable at 1",
        "undetectable and unstable",
        "exact position, order 2",
        "exact position, order 1",
        "no process noise",
        "undriven oscillator",
    ],
)
def test_no_steady_state_is_refused_with_its_mode(plant, m1, message):
    with pytest.raises(lb.DesignError, match=message):
        lb.reduced_order_filter(plant, m1)


def test_slow_but_forgetting_filter_is_not_refused():
    """Tracking index 1e-6: poles at 0.9995, next to the unit circle but inside."""
    plant = lb.Plant(
        DOUBLE,
        None,
        [[1, 0]],
        dt=1.0,
        Q=1e-12 * np.array(CONSTANT_ACCELERATION),
        R=[[1]],
    )
    observer = lb.kalman_filter(plant)
    index = 1e-6
    r = (4 + index - np.sqrt(8 * index + index**2)) / 4
    np.testing.assert_allclose(observer.V[0, 0], 1 - r**2, rtol=1e-6)


@pytest.mark.parametrize("unit", [1e-12, 1.0, 1e12])
@pytest.mark.parametrize("noise", [0.0, 1e-6], ids=["lost", "slow"])
def test_units_of_an_output_play_no_part_in_what_is_lost(noise, unit):
    """x+ = x + w and y = unit x + v: without w the filter's pole is on the circle."""
    plant = lb.Plant([[1]], None, [[unit]], dt=1.0, Q=[[noise]], R=[[unit**2]])
    now, K = setting(plant), np.array([[0.001 / unit]])
    if noise:
        assert excitation.require_excited(now, K) is None
    else:
        with pytest.raises(lb.DesignError, match="motion at 1, on the unit circle"):
            excitation.require_excited(now, K)


@pytest.mark.parametrize(("off", "steps"), [(0.0, 1), (1e-3, 6)])
def test_the_recursion_stops_where_it_has_settled(monkeypatch, off, steps):
    """Sigma = 1/2 Omega, Omega = 1/4 Sigma + 7/16: an error shrinks to 1/16."""
    plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[0.4375]], R=[[0.5]])
    taken, step = [], Setting.step
    monkeypatch.setattr(Setting, "step", lambda *given: taken.append(1) or step(*given))
    Sigma = steady_gain._recur(setting(plant), np.eye(1) * (0.25 + off), 99)
    assert Sigma[0, 0] == pytest.approx(0.25, rel=1e-9) and len(taken) <= steps + 1


def test_no_singular_value_of_the_pencil_is_steeper_than_its_slope():
    A = np.diag([10.0, 0.5])
    plant = lb.Plant(A, None, [[1, 1]], dt=1.0, Q=np.eye(2), R=[[1]])
    pencil, slope = excitation._pencil(setting(plant))
    one, other = (np.linalg.svd(pencil(a), compute_uv=False) for a in (0.7, 0.7001))
    assert slope == 0.1 and (np.abs(one - other) <= slope * 0.0001).all()


def test_unstable_noise_free_mode_is_stabilised():
    """x+ = 2 x without process noise: the steady pole is 1/2, not the plant's 2."""
    plant = lb.Plant([[2]], None, [[1]], dt=1.0, Q=[[0]], R=[[1]])
    np.testing.assert_allclose(lb.kalman_filter(plant).poles, [0.5], rtol=1e-12)


@pytest.mark.parametrize("noisy", [0.0, 1.0], ids=["quiet", "driven"])
def test_a_constant_gain_that_gives_a_mode_up_is_refused(noisy):
    """The best constant gain leaves the undriven mode 1 - 1e-12 to itself."""
    plant = lb.Plant(
        [[1 - 1e-12, 0, 0], [1, 0.5, 0], [0, 0.3, 0.2]],
        None,
        [[1, 1, 1]],
        dt=1.0,
        Q=np.diag([0, noisy, 1.0]),
        R=[[1.0]],
    )
    for design in (
        lambda: lb.kalman_filter(plant),
        lambda: lb.reduced_order_filter(plant, 1, horizon="steady"),
    ):
        with pytest.raises(lb.DesignError, match="motion at 1, on the unit circle"):
            design()
    table = lb.compare(plant)
    assert max(one.worst_pole for one in table.designs) < 1 - 1e-9


@pytest.mark.parametrize(
    ("start", "found", "searched"),
    [(0.26, 0.3, True), (0.34, 0.3, True), (0.36, None, False), (-0.3, None, False)],
)
def test_where_the_pencil_loses_rank_is_found_within_reach(start, found, searched):
    """A pencil that does at 0.3 rad, looked for 0.05 rad to either side."""
    seen = []

    def pencil(angle):
        seen.append(angle)
        return np.array([[1 - np.exp(1j * (angle - 0.3))]])

    angle = excitation._loss(pencil, 1.0, start)
    assert angle == found or angle == pytest.approx(found, abs=1e-9)
    assert (len(seen) > 1) == searched


@pytest.mark.filterwarnings("ignore:invalid value")
def test_an_overflow_is_blamed_on_a_mode_that_grows():
    A, noise = [[1e200, 0.1], [0, 0.3]], dict(Q=np.eye(2), R=[[1.0]])
    plant = lb.Plant(A, None, [[1, 1]], dt=1.0, **noise)
    why = "grow 1e[+]200 times in a step. Sample faster"
    with pytest.raises(lb.CertificateError, match=f"overflows.*{why}"):
        lb.kalman_filter(plant)


@pytest.mark.filterwarnings("ignore:overflow", "ignore:invalid value")
@pytest.mark.parametrize("told", [True, False], ids=["told", "not told"])
def test_an_overflow_is_blamed_on_large_entries(told, monkeypatch):
    """In the user's units, which natural ones make up for; not every BLAS tells."""
    if not told:
        monkeypatch.setattr(np, "errstate", lambda **_: contextlib.nullcontext())
    A, noise = [[0.5, 0.1], [0, 0.3]], dict(Q=np.eye(2), R=[[1.0]])
    plant = lb.Plant(A, None, [[1e200, 1]], dt=1.0, **noise)
    assert lb.kalman_filter(plant).order == 2
    monkeypatch.setattr(steady_gain, "natural", lambda now: (np.ones(2), np.ones(1)))
    why = "entries too large.*Scale the states and"
    with pytest.raises(lb.CertificateError, match=f"overflows.*{why}"):
        lb.kalman_filter(plant)


@pytest.mark.filterwarnings("ignore:overflow", "ignore:invalid value")
def test_a_residual_that_overflows_ends_the_search(monkeypatch):
    noise = dict(Q=1e300 * np.eye(2), R=[[1e300]])
    plant = lb.Plant([[0.5, 0.1], [0, 0.6]], None, [[1, 0]], dt=1.0, **noise)
    assert lb.reduced_order_filter(plant, 1, horizon="steady").order == 1
    for name in ("natural", "_units"):
        monkeypatch.setattr(
            best_constant_gain, name, lambda *_: (np.ones(2), np.ones(1))
        )
    with pytest.raises(lb.CertificateError, match="best constant gain was not reached"):
        lb.reduced_order_filter(plant, 1, horizon="steady")


@pytest.mark.parametrize("Q", [np.zeros((2, 2)), np.diag([0, 1.0]), np.ones((2, 2))])
@pytest.mark.parametrize("C", [np.eye(2), [[1, 2], [3, 4]]], ids=["C = I", "C"])
@pytest.mark.parametrize("unit", [1.0, 1e9])
@pytest.mark.parametrize("noisy", [False, True], ids=["all exact", "a noisy one too"])
def test_the_state_is_read_off_exact_outputs(Q, C, unit, noisy, monkeypatch):
    """x = C^-1 y, though no noise tells that gain from others that are not stable.

    The recursion, whose M is singular there, is not asked: it has other fixed points.
    """
    monkeypatch.setattr(steady_gain, "_fixed_point", None)
    d = np.array([1.0, unit])
    A, C, R = np.array([[1.5, 0.2], [0.1, 2.0]]), np.array(C, float), np.zeros((2, 2))
    if noisy:
        C, R = np.vstack([C, [[1.0, 1.0]]]), np.diag([0, 0, 1.0])
    A, C, Q = A * d[:, None] / d, C / d, Q * d[:, None] * d
    plant = lb.Plant(A, None, C, dt=1.0, Q=Q, R=R, P0=np.diag(d * d))
    for observer in (lb.kalman_filter(plant), lb.reduced_order_filter(plant, 1)):
        assert lb.certify(observer, plant).stable
        np.testing.assert_allclose(
            observer.V @ C * d / d[:, None], np.eye(2), atol=1e-9
        )
        X = lb.error_covariance(observer, plant) / d / d[:, None]
        np.testing.assert_allclose(X, 0, atol=1e-20)
    run = lb.simulate(plant, lb.kalman_filter(plant), 3, x0=d, seed=None)
    np.testing.assert_allclose(run.error / d, 0, atol=1e-9)


def test_too_few_exact_outputs_leave_the_gain_open():
    A, C = np.diag([1.5, 2.0, 1.2]), np.array([[1.0, 1, 0], [0, 1, 1]])
    plant = lb.Plant(A, None, C, dt=1.0, Q=np.zeros((3, 3)), R=np.zeros((2, 2)))
    with pytest.raises(lb.DesignError, match="more noise-free outputs than noise"):
        lb.kalman_filter(plant)


def test_a_noisy_output_taken_as_accurate_beside_exact_ones():
    C = np.vstack([[[1.0, 1.0]], np.eye(2)])
    A, R = [[1.5, 0.2], [0.1, 2.0]], np.diag([0.25, 0, 0])
    plant = lb.Plant(A, None, C, dt=1.0, Q=np.zeros((2, 2)), R=R)
    observer = lb.reduced_order_filter(plant, 1)
    np.testing.assert_allclose(C[:1] @ observer.V, [[1, 0, 0]], atol=1e-12)
    np.testing.assert_allclose(
        lb.error_covariance(observer, plant), np.full((2, 2), 0.0625), atol=1e-12
    )


def test_a_variance_that_rounding_makes_negative_is_no_crash():
    """SciPy says -1e-24 for variances of a resonance without noise."""
    rng, turn = np.random.default_rng(0), np.array([[0.6, -0.8], [0.8, 0.6]])
    A = np.zeros((6, 6))
    A[:4, :4] = np.kron(np.eye(2), turn) + np.eye(4, k=2)
    A[4:, 4:], A[4:, :4] = rng.uniform(-0.6, 0.6, (2, 2)), rng.standard_normal((2, 4))
    noise = np.concatenate([np.zeros((4, 1)), rng.standard_normal((2, 1))])
    plant = lb.Plant(A, None, np.eye(6), dt=1.0, Q=noise @ noise.T, R=np.eye(6))
    with pytest.raises(lb.DesignError, match=r"no steady filter: a motion at 0\.6"):
        lb.kalman_filter(plant)
