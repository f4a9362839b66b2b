"""Certificates, error covariances and gains against rational arithmetic."""

from dataclasses import replace
from fractions import Fraction

import exact_oracles as exact
import generators
import numpy as np
import pytest

import luenberger as lb
from luenberger.analysis import mean_square

QUARTER, EIGHTH = 0.25, 0.125  # dyadic, so that sums and products do not round


def dyadic(rng, *shape, unit=QUARTER, most=4):
    """A random matrix of multiples of `unit`."""
    return unit * rng.integers(-most, most + 1, size=shape)


def covariances(rng, n, p, rank):
    """Q, R, S of one dyadic joint covariance of at most the given rank."""
    H = dyadic(rng, n + p, rank, most=3)
    joint = H @ H.T
    return dict(Q=joint[:n, :n], R=joint[n:, n:], S=joint[:n, n:])


def plant(rng, n=2, p=1, m=1, rank=None, stable=True, **options):
    """A random plant in multiples of 1/4, its noise as singular as `rank` says."""
    while True:
        A = dyadic(rng, n, n)
        if not stable or np.abs(np.linalg.eigvals(A)).max() < 0.95:
            break
    half = dyadic(rng, n, 1)
    given = covariances(rng, n, p, n + p if rank is None else rank)
    given |= dict(P0=half @ half.T, x0=dyadic(rng, n), dt=1.0)
    B, C, E = dyadic(rng, n, m), dyadic(rng, p, n, unit=1.0, most=2), dyadic(rng, p, m)
    return lb.Plant(A, B, C, E, **(given | options))


def luenberger(rng, plant):
    """x^+ = A x^ + B u + K (y+ - C ..) with a dyadic K: exact in floats, and stable."""
    n, p = plant.n, plant.p
    for _ in range(1000):
        K = dyadic(rng, n, p, unit=EIGHTH, most=16)
        left = np.eye(n) - K @ plant.C
        T, F = left, left @ plant.A
        if np.abs(np.linalg.eigvals(F)).max() < 0.95:
            break
    else:
        pytest.fail("no dyadic gain makes this plant's observer stable")
    D = F @ K
    G = T @ plant.B - D @ plant.E
    W = -K @ plant.E
    return lb.Observer(
        F, G, D, np.eye(n), K, T, np.eye(n), W, T @ plant.x0, dt=1.0
    )  # fmt: skip


def arbitrary(rng, plant, r=2, q=2):
    """A stable system that tracks nothing in particular."""
    F = dyadic(rng, r, r, unit=EIGHTH)
    F = F / max(1.0, 2.0 ** np.ceil(np.log2(np.abs(F).sum(1).max() + EIGHTH)))
    return lb.Observer(
        F, np.zeros((r, plant.m)), dyadic(rng, r, plant.p), dyadic(rng, q, r),
        dyadic(rng, q, plant.p), dyadic(rng, r, plant.n), dyadic(rng, q, plant.n),
        dt=1.0, z0=dyadic(rng, r),
    )  # fmt: skip


# -- certificates ---------------------------------------------------------------------

DESIGNS = {
    "Kalman": lb.kalman_filter,
    "Kalman over steps": lambda plant: lb.kalman_filter(plant, steps=4),
    "one accurate": lambda plant: lb.reduced_order_filter(plant, 1),
    "all accurate, over steps": lambda p: lb.reduced_order_filter(p, p.p, steps=4),
    "best constant gain": lambda p: lb.reduced_order_filter(p, 1, horizon="steady"),
    "chosen poles": lambda p: lb.reduced_order_observer(p, [0.5, 0.25][: p.n - p.p]),
    "deadbeat": lb.deadbeat_observer,
    "functional": lambda plant: lb.functional_observer(plant, np.ones(plant.n)),
}


@pytest.mark.parametrize("design", DESIGNS.values(), ids=DESIGNS.keys())
@pytest.mark.parametrize("seed", range(4))
def test_certificate_is_the_exact_one(design, seed):
    """To the rounding of the certificate itself, and all of it is rounding."""
    rng = np.random.default_rng(seed)
    given = plant(rng, 3, 1 + seed % 2, m=2, stable=seed < 2)
    try:
        observer = design(given)
    except lb.DesignError as refusal:
        assert "observ" in str(refusal) or "detect" in str(refusal)
        return
    found, wanted = lb.certify(observer, given), exact.certificate(observer, given)
    assert max(wanted) < 1e-13
    for name, value in wanted._asdict().items():
        assert abs(getattr(found, name) - value) < 2e-15, name


@pytest.mark.parametrize("name", "FGDPVTWL")
def test_certificate_of_a_damaged_observer_is_the_exact_one(name):
    rng = np.random.default_rng(3)
    given = plant(rng, 3, 1)
    observer = luenberger(rng, given)
    assert max(exact.certificate(observer, given)) == 0.0
    assert lb.certify(observer, given).worst == 0.0
    part = getattr(observer, name).copy()
    part[-1, 0] += 1 / 3
    broken = replace(observer, **{name: part})
    found, wanted = lb.certify(broken, given), exact.certificate(broken, given)
    assert max(wanted) > 0.01
    for which, value in wanted._asdict().items():
        assert getattr(found, which) == pytest.approx(value, rel=1e-14), which


# -- error covariances ----------------------------------------------------------------

RANKS = [0, 1, 3]


@pytest.mark.parametrize("rank", RANKS)
@pytest.mark.parametrize("seed", range(4))
def test_steady_error_of_an_observer(seed, rank):
    """Two exact ways agree exactly, and floats with them to rounding."""
    rng = np.random.default_rng(seed)
    given = plant(rng, 2, 1, rank=rank)
    observer = luenberger(rng, given)
    wanted = exact.steady_error(observer, given)
    assert (wanted == exact.steady_error_alone(observer, given)).all()
    assert exact.off(lb.error_covariance(observer, given), wanted) < 1e-14


@pytest.mark.parametrize("rank", RANKS)
@pytest.mark.parametrize("seed", range(4))
def test_steady_error_on_a_plant_that_is_not_stable(seed, rank):
    rng = np.random.default_rng(seed)
    A = [[1.25, 0.5], [QUARTER * seed, 1.0]]
    given = replace(plant(rng, 2, 1, rank=rank), A=A, C=[[1.0, 0.0]])
    observer = luenberger(rng, given)
    wanted = exact.steady_error_alone(observer, given)
    assert exact.off(lb.error_covariance(observer, given), wanted) < 1e-14


@pytest.mark.parametrize("noises", [0, 1, 2])
@pytest.mark.parametrize("seed", range(3))
def test_steady_error_of_any_system(seed, noises):
    """The state drives the error too, and multiplicative noise does."""
    rng = np.random.default_rng(seed)
    pairs = [
        (dyadic(rng, 2, 2, unit=1 / 16), dyadic(rng, 1, 2, unit=1 / 16))
        for _ in range(noises)
    ]
    given = plant(rng, 2, 1, m=0, multiplicative=pairs)
    observer = arbitrary(rng, given)
    wanted = exact.steady_error(observer, given)
    assert exact.off(lb.error_covariance(observer, given), wanted) < 1e-13
    cost = lb.optimality(observer, given).cost
    assert cost == pytest.approx(float(wanted.trace()), rel=1e-13)


@pytest.mark.parametrize("units", [1e-9, 1e9])
def test_steady_error_whatever_the_units(units):
    """A state in other units, in powers of two: each entry beside its own sigmas."""
    rng = np.random.default_rng(5)
    given = plant(rng, 3, 1, m=0)
    observer = luenberger(rng, given)
    z = np.array([1.0, 2.0 ** np.round(np.log2(units)), 1.0])
    other = replace(
        given, A=given.A * z[:, None] / z, B=None, C=given.C / z, E=None, x0=None,
        Q=given.Q * np.outer(z, z), S=given.S * z[:, None], P0=None,
    )  # fmt: skip
    moved = lb.Observer(
        observer.F * z[:, None] / z, np.zeros((3, 0)), observer.D * z[:, None],
        np.eye(3), observer.V * z[:, None], observer.T * z[:, None] / z, np.eye(3),
        dt=1.0,
    )  # fmt: skip
    wanted = exact.steady_error_alone(moved, other)
    assert exact.off_units(lb.error_covariance(moved, other), wanted) < 1e-14


@pytest.mark.parametrize("kind", [False, True])
@pytest.mark.parametrize("noises", [0, 1])
@pytest.mark.parametrize("design", ["constant", "over steps", "any system"])
def test_error_from_the_start_on(design, noises, kind):
    rng = np.random.default_rng(8)
    pairs = [(dyadic(rng, 2, 2, unit=1 / 16), dyadic(rng, 1, 2))] * noises
    given = plant(rng, 2, 1, m=0, at_first=kind, multiplicative=pairs)
    observer = {
        "constant": luenberger,
        "over steps": lambda rng, p: lb.kalman_filter(
            replace(p, multiplicative=()), steps=5
        ),
        "any system": arbitrary,
    }[design](rng, given)
    found = lb.error_covariance(observer, given, steps=5)
    wanted = exact.error_over(observer, given, 5)
    assert len(found) == len(wanted) == 6
    for one, other in zip(found, wanted):
        assert exact.off(one, other) < 1e-13


def in_units(given, observer, x, y, z, w):
    """Plant and observer whose x, y, z, w^ are these powers of two times as large."""
    over = lambda X, left, right: X * left[:, None] / right  # noqa: E731
    plant = replace(
        given, A=over(given.A, x, x), B=None, C=over(given.C, y, x), E=None,
        Q=over(given.Q, x, 1 / x), R=over(given.R, y, 1 / y),
        S=over(given.S, x, 1 / y), P0=over(given.P0, x, 1 / x), x0=x * given.x0,
    )  # fmt: skip
    o = observer
    moved = lb.Observer(
        over(o.F, z, z), np.zeros((o.order, 0)), over(o.D, z, y), over(o.P, w, z),
        over(o.V, w, y), over(o.T, z, x), over(o.L, w, x), z0=z * o.z0, dt=1.0,
    )  # fmt: skip
    return plant, moved


@pytest.mark.parametrize("seed", range(12))
def test_a_state_in_light_years_hides_no_error_behind_it(seed):
    """The error was taken to be free of the state by residuals in users' units."""
    rng = np.random.default_rng(seed)
    given = plant(rng, 2, 2, m=0)
    observer = arbitrary(rng, given)
    units = [2.0 ** rng.integers(-30, 31, 2) for _ in "xyzw"]
    other, moved = in_units(given, observer, *units)
    found = lb.error_covariance(moved, other)
    assert exact.off_units(found, exact.steady_error(moved, other)) < 1e-12
    found, wanted = (
        lb.error_covariance(moved, other, steps=3),
        exact.error_over(moved, other, 3),
    )
    for one, true in zip(found, wanted):
        assert exact.off_units(one, true) < 1e-12


def test_a_sensor_that_shows_nothing_hides_no_error_either():
    """Its gain is large beside the rest in any unit of it."""
    given = lb.Plant(
        [[0.75, -0.5], [0.125, 0]], None, [[-2, 2], [0, 0]], dt=1.0,
        Q=np.zeros((2, 2)), R=np.zeros((2, 2)), P0=[[0.25, 0], [0, 0]],
    )  # fmt: skip
    observer = lb.Observer(
        [[0.375, 0], [-0.375, -0.375]], np.zeros((2, 0)), [[0, 0], [-0.5, 1e30]],
        [[-1, 0.5], [1, 1]], [[0, -1e30], [0, 0]], [[0.5, 1], [1, -0.5]],
        [[0, 2], [1, 1]], dt=1.0,
    )  # fmt: skip
    found = lb.error_covariance(observer, given, steps=2)
    for one, true in zip(found, exact.error_over(observer, given, 2)):
        assert exact.off(one, true) < 1e-14


# -- moments of a plant with multiplicative noise -------------------------------------


def test_the_limit_of_mean_square_stability_lies_where_it_is_said():
    """Just below it the exact second moment is one, just above it is none."""
    for seed in range(4):
        rng = np.random.default_rng(seed)
        A = plant(rng, 3, 1).A
        pairs = [(dyadic(rng, 3, 3), np.zeros((1, 3))) for _ in range(2)]
        limit = mean_square.largest_scaling(A, pairs)
        for inside in (True, False):
            s = generators.rational([limit * (1 + (-1e-9 if inside else 1e-9))])[0]
            maps = [generators.rational(A)]
            maps += [s * generators.rational(A1) for A1, _ in pairs]
            X = exact.stein(maps, exact.eye(3))
            assert exact.is_semidefinite(X) is inside


def test_equivalent_noise_is_exact_to_rounding():
    rng = np.random.default_rng(2)
    pairs = [(dyadic(rng, 3, 3, unit=1 / 64), dyadic(rng, 2, 3)) for _ in range(2)]
    given = plant(rng, 3, 2, m=0, multiplicative=pairs)
    R = generators.rational
    X = exact.stein([R(given.A), *(R(A1) for A1, _ in pairs)], R(given.Q))
    found = mean_square.equivalent_noise(given)
    assert exact.off(found.X, X) < 1e-14
    for name, left, right in (("Q", 0, 0), ("S", 0, 1), ("R", 1, 1)):
        more = sum(R(pair[left]) @ X @ R(pair[right]).T for pair in pairs)
        assert exact.off(getattr(found, name), R(getattr(given, name)) + more) < 1e-14


# -- gains ----------------------------------------------------------------------------


@pytest.mark.parametrize("accurate", [(), (0,), (1,), (0, 1)])
@pytest.mark.parametrize("weight", [None, np.diag([1.0, 4.0, 0.25])])
def test_a_steady_gain_is_the_best_after_its_own_covariance(accurate, weight):
    """The fixed point, judged with the exact error of the floats that came back."""
    rng = np.random.default_rng(4)
    given = plant(rng, 3, 2, m=0)
    given = replace(given, Q=given.Q + np.eye(3), R=given.R + np.eye(2))
    observer = lb.reduced_order_filter(given, list(accurate), weight=weight)
    Sigma = exact.steady_error(observer, given)
    gain = exact.best_gain(given, Sigma, accurate, weight)
    assert exact.off(observer.V, gain) < 1e-13
    others = exact.best_gain(given, Sigma, accurate, np.diag([1.0, 9.0, 1.0]))
    assert (exact.off(observer.V, others) > 1e-3) is bool(accurate)


def test_a_fixed_order_filter_leaves_no_direction_that_is_better():
    """The exact cost along every entry of F, D, P, V: flat, and no lower nearby."""
    rng = np.random.default_rng(6)
    given = plant(rng, 3, 1, m=0)
    observer = lb.fixed_order_filter(given, 1)
    cost = exact.steady_error(observer, given).trace()
    assert lb.optimality(observer, given).cost == pytest.approx(float(cost), rel=1e-12)
    step = Fraction(1, 2**12)
    for name in "FDPV":
        part = getattr(observer, name)
        for place in np.ndindex(part.shape):
            sides = []
            for sign in (1, -1):
                moved = part.copy()
                moved[place] += sign * float(step)
                other = replace(observer, **{name: moved})
                sides.append(exact.steady_error(other, given).trace())
            up, down = sides
            slope, bend = (up - down) / (2 * step), (up - 2 * cost + down) / step**2
            assert bend > 0 and abs(float(slope)) < 1e-4 * float(bend), (name, place)


# -- smoothing ------------------------------------------------------------------------


def record(rng, given, N, holes=True):
    """A dyadic record that the plant can have made, and its inputs."""
    y, u, u0 = generators.record(rng, given, N)
    y = np.round(y * 64) / 64
    if holes:
        y[rng.random(y.shape) < 0.3] = np.nan
    return y, u, u0


@pytest.mark.parametrize("kind", [False, True])
@pytest.mark.parametrize("varying", [False, True])
def test_the_smoother_ends_as_the_filter_does(kind, varying):
    """Its last row uses what the filter uses; of every shorter record too."""
    rng = np.random.default_rng(7)
    make = (lambda *a, **k: generators.varying(*a, 6, **k)) if varying else (
        generators.plant
    )  # fmt: skip
    given = make(rng, 2, 2, at_first=kind)
    y, u, u0 = record(rng, given, 5)
    x, P = generators.exact(given, y, u, u0)
    for N in (1, 3, 5):
        means, covariances = exact.smoothed(given, y[:N], u[:N], u0)
        np.testing.assert_allclose(means[-1].astype(float), x[N - 1], rtol=1e-14)
        np.testing.assert_array_equal(covariances[-1].astype(float), P[N - 1])


def test_the_smoother_is_least_squares():
    """Without S and with all covariances invertible: the normal equations."""
    rng = np.random.default_rng(1)
    R = generators.rational
    given = plant(rng, 2, 1, m=0, at_first=True, P0=np.eye(2), S=None)
    given = replace(given, Q=given.Q + np.eye(2), R=given.R + 1)
    y = dyadic(rng, 4, 1)
    A, C = R(given.A), R(given.C)
    weigh = {name: exact.solve(R(getattr(given, name)), exact.eye(k))
             for name, k in (("P0", 2), ("Q", 2), ("R", 1))}  # fmt: skip
    normal, right = exact.zeros(8, 8), exact.zeros(8)

    def term(matrix, where, of, weight):
        row = exact.zeros(len(matrix[0]), 8)
        for X, k in zip(matrix, where):
            row[:, 2 * k : 2 * k + 2] = X
        normal[...] = normal + row.T @ weight @ row
        right[...] = right + row.T @ weight @ of

    term([exact.eye(2)], [0], R(given.x0), weigh["P0"])
    for k in range(4):
        term([C], [k], R(y[k]), weigh["R"])
    for k in range(3):
        term([-A, exact.eye(2)], [k, k + 1], exact.zeros(2), weigh["Q"])
    inverse = exact.solve(normal, exact.eye(8))
    means, covariances = exact.smoothed(given, y)
    assert (means.ravel() == inverse @ right).all()
    for k in range(4):
        here = slice(2 * k, 2 * k + 2)
        assert (covariances[k] == inverse[here, here]).all()


def test_the_smoother_takes_singular_noise_and_finds_a_contradiction():
    """A known start, an exact sensor, no process noise: all states follow."""
    given = lb.Plant(
        [[1, 1], [0, 1]], None, [[1, 0]], dt=1.0, Q=np.zeros((2, 2)), R=[[0]],
        P0=[[0, 0], [0, 1]], at_first=True,
    )  # fmt: skip
    means, covariances = exact.smoothed(given, np.array([[np.nan], [3.0], [np.nan]]))
    np.testing.assert_array_equal(means.astype(float), [[0, 3], [3, 3], [6, 3]])
    assert not covariances.any()
    with pytest.raises(AssertionError, match="contradicts"):
        exact.smoothed(given, np.array([[0.0], [3.0], [7.0]]))
