"""Errors and runs of plants with multiplicative noise, against plain recursions."""

import dataclasses

import generators
import numpy as np
import pytest

import luenberger as lb
from luenberger.analysis import mean_square


def noisy(seed, n=3, p=2, *, m=0, noises=2, strength=0.3, **options):
    """A random mean-square stable plant; its noises act on A and C together."""
    rng = np.random.default_rng(seed)
    given = generators.plant(rng, n, p, m=m, radius=0.85, **options)
    pairs = [
        (strength * rng.normal(size=(n, n)) / n, strength * rng.normal(size=(p, n)))
        for _ in range(noises)
    ]
    return dataclasses.replace(given, multiplicative=pairs)


def quiet(plant):
    return dataclasses.replace(plant, multiplicative=())


def unfit(seed, plant, order=2):
    """A stable observer whose T is wrong, as that of a filter of fixed order is."""
    rng, n, p = np.random.default_rng(seed), plant.n, plant.p
    T, D, V = (rng.normal(size=shape) for shape in ((order, n), (order, p), (n, p)))
    return lb.Observer(
        generators.dynamics(rng, order, 0.7),
        T @ plant.B - D @ plant.E,
        D,
        rng.normal(size=(n, order)),
        V,
        T,
        np.eye(n),
        -V @ plant.E,
        z0=T @ plant.x0,
        dt=plant.dt,
    )


def exact(plant, m1=1, **options):
    """Filters of the plant without its multiplicative noise: T fits all the same."""
    return lb.reduced_order_filter(quiet(plant), m1, **options)


def augmented(plant, i, F, D):
    """Atilde, the Atilde_j and Vtilde of s = [x; z]: Haddad and Bernstein (4.1)."""
    now, n, r = plant.at(i), plant.n, len(F)
    S = np.zeros((n, plant.p)) if now.S is None else now.S
    At = np.block([[now.A, np.zeros((n, r))], [D @ now.C, F]])
    Ats = [
        np.block([[A1, np.zeros((n, r))], [D @ C1, np.zeros((r, r))]])
        for A1, C1 in plant.multiplicative
    ]
    Vt = np.block([[now.Q, S @ D.T], [D @ S.T, D @ now.R @ D.T]])
    return At, Ats, Vt


def error_of(plant, i, P, V, L, X):
    """E[e e'] of e = P z + V y - L x where E[s s'] = X."""
    now, r = plant.at(i), P.shape[1]
    out = np.hstack([V @ now.C - L, P])
    Sigma = out @ X @ out.T + V @ now.R @ V.T
    for _, C1 in plant.multiplicative:
        wide = np.hstack([V @ C1, np.zeros((len(L), r))])
        Sigma = Sigma + wide @ X @ wide.T
    return Sigma


def steady(observer, plant):
    """The steady error from one Kronecker product of the augmented size."""
    At, Ats, Vt = augmented(plant, 0, observer.F, observer.D)
    N = len(At)
    move = np.kron(At, At) + sum(np.kron(M, M) for M in Ats)
    X = np.linalg.solve(np.eye(N * N) - move, Vt.ravel()).reshape(N, N)
    return error_of(plant, 0, observer.P, observer.V, observer.L, X)


def over(observer, plant, steps):
    """Rows of `error_covariance` by stepping E[s s'], with u = 0."""
    L, varying = observer.L, observer.steps is not None
    mean, X, rows = plant.x0, plant.P0 + np.outer(plant.x0, plant.x0), []
    if varying:
        rows.append(L @ plant.P0 @ L.T)
        if not plant.at_first:
            now = plant.at(0)
            mean = now.A @ mean
            noise = sum(A1 @ X @ A1.T for A1, _ in plant.multiplicative)
            X = now.A @ X @ now.A.T + now.Q + noise
    z, cross = observer.z0, np.outer(mean, observer.z0)
    X = np.block([[X, cross], [cross.T, np.outer(z, z)]])
    first = int(varying)
    for i in range(first, steps + 1):
        F, _, D, P, V, _ = observer.at(i - first)
        rows.append(error_of(plant, i, P, V, L, X))
        At, Ats, Vt = augmented(plant, i, F, D)
        X = At @ X @ At.T + sum(M @ X @ M.T for M in Ats) + Vt
    return np.array(rows)


OBSERVERS = {
    "a filter that fits": exact,
    "a Kalman filter": lambda plant: exact(plant, 0),
    "an observer of chosen poles": lambda plant: lb.reduced_order_observer(
        quiet(plant), [0.4] * (plant.n - plant.p)
    ),
    "a filter of fixed order": lambda plant: lb.fixed_order_filter(plant, 2, starts=1),
    "a filter that does not fit": lambda plant: unfit(1, plant),
}


@pytest.mark.parametrize("make", OBSERVERS.values(), ids=OBSERVERS)
@pytest.mark.parametrize("noises", [1, 2], ids=["one noise", "two noises"])
@pytest.mark.parametrize("cross", [False, True], ids=["S = 0", "S not 0"])
def test_steady_error_is_that_of_the_augmented_system(make, noises, cross):
    plant = noisy(noises, noises=noises, cross=cross)
    observer = make(plant)
    wanted = steady(observer, plant)
    found = lb.error_covariance(observer, plant)
    np.testing.assert_allclose(found, wanted, atol=1e-11 * np.abs(wanted).max())
    without = lb.error_covariance(observer, quiet(plant))
    assert np.trace(found) > 1.01 * np.trace(without)


@pytest.mark.parametrize("make", OBSERVERS.values(), ids=OBSERVERS)
@pytest.mark.parametrize("m", [0, 1], ids=["no input", "an input"])
@pytest.mark.parametrize("known", [False, True])
def test_error_of_constant_observers_over_steps(make, m, known):
    plant = noisy(3, m=m, at_first=known)
    observer = make(plant)
    observer = dataclasses.replace(observer, z0=observer.z0 + 1)
    wanted = over(observer, plant, 6)
    found = lb.error_covariance(observer, plant.with_input(0), steps=6)
    np.testing.assert_allclose(found, wanted, atol=1e-12 * np.abs(wanted).max())


@pytest.mark.parametrize("known", [False, True])
@pytest.mark.parametrize("fits", [True, False], ids=["that fit", "of a wrong plant"])
def test_error_of_filters_over_steps(known, fits):
    plant = noisy(4, at_first=known)
    believed = plant if fits else dataclasses.replace(plant, A=0.6 * plant.A)
    observer = exact(believed, steps=6)
    wanted = over(observer, plant, 6)
    found = lb.error_covariance(observer, plant, steps=6)
    np.testing.assert_allclose(found, wanted, atol=1e-12 * np.abs(wanted).max())


@pytest.mark.parametrize("fits", [True, False], ids=["that fit", "of a wrong plant"])
def test_error_of_filters_of_a_time_varying_plant(fits):
    rng = np.random.default_rng(6)
    plant = generators.varying(rng, 3, 2, 8, m=0)
    pairs = [(0.2 * rng.normal(size=(3, 3)), 0.3 * rng.normal(size=(2, 3)))]
    plant = dataclasses.replace(plant, multiplicative=pairs)
    believed = plant if fits else dataclasses.replace(plant, A=0.6 * plant.A)
    observer = exact(believed, steps=6)
    wanted = over(observer, plant, 6)
    found = lb.error_covariance(observer, plant, steps=6)
    np.testing.assert_allclose(found, wanted, atol=1e-12 * np.abs(wanted).max())


@pytest.mark.parametrize("make", OBSERVERS.values(), ids=OBSERVERS)
def test_error_over_many_steps_settles_at_the_steady_one(make):
    plant = noisy(5)
    observer = make(plant)
    last = lb.error_covariance(observer, plant, steps=400)[-1]
    wanted = lb.error_covariance(observer, plant)
    np.testing.assert_allclose(last, wanted, atol=1e-11 * np.abs(wanted).max())


@pytest.mark.parametrize("make", OBSERVERS.values(), ids=OBSERVERS)
def test_error_is_that_of_the_equivalent_plant(make):
    plant = noisy(7)
    _, Q, S, R = mean_square.equivalent_noise(plant)
    equivalent = dataclasses.replace(quiet(plant), Q=Q, S=S, R=R)
    observer = make(plant)
    found = lb.error_covariance(observer, plant)
    wanted = lb.error_covariance(observer, equivalent)
    np.testing.assert_allclose(found, wanted, atol=1e-12 * np.abs(wanted).max())


@pytest.mark.parametrize("m1", [0, 1, 2])
def test_filter_of_the_equivalent_plant_is_better(m1):
    """Its Kalman filter is the best linear one; the noise ignored costs accuracy."""
    plant = noisy(7, strength=0.4)
    _, Q, S, R = mean_square.equivalent_noise(plant)
    equivalent = dataclasses.replace(quiet(plant), Q=Q, S=S, R=R)
    best = lb.error_covariance(lb.kalman_filter(equivalent), plant).trace()
    assert best < 0.99 * lb.error_covariance(exact(plant, m1), plant).trace()


RUNS, STEPS = 3000, 6
RUNNERS = {
    "constant and fits": exact,
    "constant and does not fit": lambda plant: unfit(2, plant),
    "over steps": lambda plant: exact(plant, steps=STEPS),
    "over steps for a wrong plant": lambda plant: exact(
        dataclasses.replace(plant, A=0.5 * plant.A), steps=STEPS
    ),
}


@pytest.mark.parametrize("make", RUNNERS.values(), ids=RUNNERS)
def test_simulated_errors_agree_within_four_standard_errors(make):
    plant = noisy(9)
    observer = make(plant)
    found = lb.monte_carlo(plant, observer, runs=RUNS, steps=STEPS, seed=5)
    wanted = lb.error_covariance(observer, plant, steps=STEPS)
    limit = 4 * found.standard_error + 1e-12 * np.abs(wanted).max()
    assert (np.abs(found.covariance - wanted) <= limit).all()
    without = lb.error_covariance(observer, quiet(plant), steps=STEPS)
    assert (np.abs(found.covariance - without) > limit).any()


@pytest.mark.parametrize(
    "order, noises, feedthrough",
    [(1, 1, True), (1, 2, False), (2, 2, True), (4, 1, False), (4, 2, True)],
)
def test_simulation_confirms_the_cost_of_the_fixed_order_filter(
    order, noises, feedthrough
):
    """w = L x is a scalar, so that its mean square is the cost, with an error bar."""
    plant = noisy(16 + noises, n=4, noises=noises, strength=0.4)
    still = dict(x0=np.zeros(4), P0=mean_square.equivalent_noise(plant).X)
    plant = dataclasses.replace(plant, **still)  # so that only z has to settle
    options = dict(L=[[1, 0.5, -1, 0]], feedthrough=feedthrough, starts=2)
    observer = lb.fixed_order_filter(plant, order, **options)
    cost = lb.optimality(observer, plant).cost
    found = lb.monte_carlo(plant, observer, runs=6000, steps=30, seed=7)
    bar = found.standard_error[-1, 0, 0]
    assert abs(found.covariance[-1, 0, 0] - cost) <= 4 * bar
    ignored = lb.fixed_order_filter(quiet(plant), order, **options)
    promised = lb.optimality(ignored, quiet(plant)).cost
    assert found.covariance[-1, 0, 0] - promised > 4 * bar


def test_long_run_shows_the_steady_error():
    plant = noisy(10)
    observer = unfit(3, plant)
    run = lb.simulate(plant, observer, 20_000, seed=2)
    sample = run.error[200:].T @ run.error[200:] / len(run.error[200:])
    wanted = lb.error_covariance(observer, plant)
    np.testing.assert_allclose(sample, wanted, atol=0.08 * np.abs(wanted).max())
    X = run.x[200:].T @ run.x[200:] / len(run.x[200:])
    moment = mean_square.equivalent_noise(plant).X
    np.testing.assert_allclose(X, moment, atol=0.08 * np.abs(moment).max())


def test_one_noise_moves_a_and_c_together():
    """Without other noise, g is read off the state and must explain the outputs."""
    A, A1, C, C1 = (np.diag([a, b]) for a, b in ((0.9, 0.5), (0.3, 0), (1, 1), (0, 2)))
    plant = lb.Plant(
        A, None, C, dt=1.0, Q=np.zeros((2, 2)), R=np.zeros((2, 2)), x0=[4, 3],
        P0=np.zeros((2, 2)), multiplicative=[(A1, C1)],
    )  # fmt: skip
    run = lb.simulate(plant, unfit(4, plant), 400, seed=1)
    g = (run.x[1:, 0] - 0.9 * run.x[:-1, 0]) / (0.3 * run.x[:-1, 0])
    np.testing.assert_allclose(run.x[1:, 1], 0.5 * run.x[:-1, 1], rtol=1e-12)
    shown = (1 + 2 * g[:40]) * run.x[:40, 1]
    np.testing.assert_allclose(run.y[:40, 1], shown, rtol=1e-9)
    np.testing.assert_allclose(run.y[:, 0], run.x[:, 0], rtol=1e-12)
    assert abs(g.mean()) < 0.2 and abs(g.var() - 1) < 0.3
    assert abs(np.mean(g[1:] * g[:-1])) < 0.2


def test_two_noises_are_independent():
    zero, one = np.zeros((2, 2)), np.eye(2)
    plant = lb.Plant(
        0.9 * one, None, one, dt=1.0, Q=one, R=zero, P0=one,
        multiplicative=[(np.diag([0.1, 0]), zero), (np.diag([0, 0.1]), zero)],
    )  # fmt: skip
    noises = []
    for same in (plant, quiet(plant)):  # the other draws are the same: subtract
        noises.append(lb.simulate(same, unfit(5, plant), 3000, seed=6).x)
    loud, still = noises
    moved = np.diff(loud - still, axis=0) + 0.1 * (loud - still)[:-1]
    g = moved / (0.1 * loud[:-1])
    np.testing.assert_allclose(np.cov(g.T), one, atol=0.1)


def test_runs_without_multiplicative_noise_stay_what_they_were():
    """Numbers from before there was any: the g are drawn after everything else."""
    plant = lb.Plant(
        [[0.5, 1], [0, 0.8]], [[0], [1]], [[1, 0]], dt=1.0, Q=[[2, 0.5], [0.5, 1]],
        R=[[1]], S=[[0.25], [0.5]], P0=[[1, 0], [0, 4]], x0=[1, -1],
    )  # fmt: skip
    gain = np.array([[0.5], [0.25]])
    observer = lb.Observer(
        plant.A - gain @ plant.C, plant.B, gain, np.eye(2), np.zeros((2, 1)),
        np.eye(2), np.eye(2), dt=1.0,
    )  # fmt: skip
    silent = [(np.zeros((2, 2)), np.zeros((1, 2)))] * 2
    for same in (plant, dataclasses.replace(plant, multiplicative=silent)):
        run = lb.simulate(same, observer, 4, u=1.0, seed=11)
        last = [2.45109165, 2.2566319]
        np.testing.assert_allclose(run.x[-1], last, rtol=1e-8)
        shown = [1.34113435, 3.24643356, 1.06129568, 3.99959628, 2.2305479]
        np.testing.assert_allclose(run.y[:, 0], shown, rtol=1e-7)
        found = lb.monte_carlo(same, observer, runs=70, steps=2, seed=3).covariance
        wanted = [[6.01978097, 2.58376796], [2.58376796, 2.34776397]]
        np.testing.assert_allclose(found[-1], wanted, rtol=1e-8)


def test_simulation_without_a_seed_has_no_multiplicative_noise():
    plant = noisy(11, m=1)
    run = lb.simulate(plant, unfit(6, plant), 5, u=1.0)
    still = lb.simulate(quiet(plant), unfit(6, plant), 5, u=1.0)
    np.testing.assert_array_equal(run.x, still.x)
    np.testing.assert_array_equal(run.y, still.y)


def test_a_run_of_an_ensemble_does_not_depend_on_the_others():
    plant = noisy(12)
    observer = exact(plant)
    few, many = (
        lb.monte_carlo(plant, observer, runs=runs, steps=3, seed=4).mean * runs
        for runs in (1, 2)
    )
    seeds = [np.random.SeedSequence(4, spawn_key=(k,)) for k in range(2)]
    alone = [lb.simulate(plant, observer, 3, seed=seed).error for seed in seeds]
    np.testing.assert_allclose(few, alone[0], atol=1e-12)
    np.testing.assert_allclose(many, alone[0] + alone[1], atol=1e-12)


def too_noisy():
    plant = noisy(13, noises=1)
    (A1, C1), *_ = plant.multiplicative
    limit = mean_square.largest_scaling(plant.A, plant.multiplicative)
    return dataclasses.replace(plant, multiplicative=[(2 * limit * A1, C1)])


def test_no_steady_error_without_mean_square_stability():
    plant = too_noisy()
    At, (A1, *_), _ = augmented(plant, 0, np.zeros((0, 0)), np.zeros((0, plant.p)))
    found = np.abs(np.linalg.eigvals(np.kron(At, At) + np.kron(A1, A1))).max()
    wanted = f"spectral radius .* is {found:.6g}.*less than 0.5 times"
    for observer in (exact(plant), unfit(7, plant)):
        with pytest.raises(lb.DesignError, match=wanted):
            lb.error_covariance(observer, plant)
        rows = lb.error_covariance(observer, plant, steps=40)
        assert np.trace(rows[40]) > 100 * np.trace(rows[10])


FILTERS = {
    "kalman_filter": lambda plant: lb.kalman_filter(plant),
    "kalman_filter over steps": lambda plant: lb.kalman_filter(plant, steps=3),
    "reduced_order_filter": lambda plant: lb.reduced_order_filter(plant, 1),
    "Filter": lambda plant: lb.Filter(plant).run(np.zeros((3, 2))),
}


@pytest.mark.parametrize("design", FILTERS.values(), ids=FILTERS)
def test_filters_that_do_not_model_it_say_what_to_use(design):
    with pytest.raises(lb.DesignError, match="too small. Use fixed_order_filter"):
        design(noisy(14))


def test_observer_with_a_wrong_input_gain_is_still_refused():
    plant = noisy(15, m=1)
    observer = unfit(8, plant)
    assert lb.error_covariance(observer, plant.with_input(0)).shape == (3, 3)
    with pytest.raises(lb.DesignError, match="depends on the known input"):
        wrong = dataclasses.replace(observer, G=observer.G + 0.1)
        lb.error_covariance(wrong, plant)
    with pytest.raises(lb.DesignError, match="depends on the known input"):
        wrong = dataclasses.replace(observer, W=observer.W + 0.1)
        lb.error_covariance(wrong, plant)
