"""Error covariances against simulated ensembles, optimal gains and wrong ones."""

import concurrent.futures
import dataclasses

import generators
import numpy as np
import pytest

import luenberger as lb

RUNS, STEPS = 4000, 8
NAN = float("nan")


def plant_of(seed, **options):
    return generators.plant(np.random.default_rng(seed), 3, 2, m=0, **options)


def disturbed(observer, plant):
    """The same structure with gains a fifth too large: exact, but not optimal."""
    if observer.steps is None:
        other = lb.reduced_order_filter(plant, 1, weight=np.diag([1.0, 30.0, 0.05]))
    else:
        loud = dataclasses.replace(plant, R=25 * plant.R, S=5 * plant.S)
        other = lb.reduced_order_filter(loud, 1, steps=observer.steps)
    assert np.abs(other.V - observer.V).max() > 0.02
    return other


def within_four_standard_errors(plant, observer):
    found = lb.monte_carlo(plant, observer, runs=RUNS, steps=STEPS, seed=5)
    wanted = lb.error_covariance(observer, plant, steps=STEPS)
    assert found.covariance.shape == wanted.shape == (STEPS + 1, 3, 3)
    # an exactly known entry has no spread, so rounding is allowed for
    limit = 4 * found.standard_error + 1e-12 * np.abs(wanted).max()
    assert (np.abs(found.covariance - wanted) <= limit).all()


@pytest.mark.parametrize("steps", [None, STEPS], ids=["steady gain", "over steps"])
@pytest.mark.parametrize("m1", [0, 1, 2])
@pytest.mark.parametrize("cross", [False, True], ids=["S = 0", "S not 0"])
def test_optimal_gains(steps, m1, cross):
    plant = plant_of(1, cross=cross)
    within_four_standard_errors(plant, lb.reduced_order_filter(plant, m1, steps=steps))


@pytest.mark.parametrize("steps", [None, STEPS], ids=["steady gain", "over steps"])
def test_wrong_gains(steps):
    plant = plant_of(2)
    right = lb.reduced_order_filter(plant, 1, steps=steps)
    wrong = disturbed(right, plant)
    within_four_standard_errors(plant, wrong)
    covariances = [
        lb.error_covariance(one, plant, steps=STEPS)[2] for one in (right, wrong)
    ]
    assert np.abs(covariances[0] - covariances[1]).max() > 1e-3


@pytest.mark.parametrize("steps", ["3", 2.5, True, -1, [3], NAN, np.timedelta64(3)])
def test_steps_that_are_no_number_of_steps(steps):
    plant = plant_of(1)
    with pytest.raises(ValueError, match="steps must be a whole number >= 0, got"):
        lb.error_covariance(lb.kalman_filter(plant), plant, steps=steps)


def test_a_steady_variance_is_not_negative():
    """What the gain lets through of redundant outputs is rounding: it was -5e-16."""
    R = np.array([[49, 28, 56], [28, 16, 32], [56, 32, 64]]) / 9
    plant = lb.Plant([[0.0]], None, [[-1], [-1], [5 / 3]], dt=1.0, Q=[[0]], R=R)
    assert 0 <= lb.error_covariance(lb.kalman_filter(plant), plant)[0, 0] < 1e-28


def test_prior_start_and_biased_start():
    plant = plant_of(3, at_first=True)
    within_four_standard_errors(plant, lb.reduced_order_filter(plant, 1, steps=STEPS))
    observer = lb.reduced_order_filter(plant, 1)
    biased = dataclasses.replace(observer, z0=observer.z0 + 2)
    within_four_standard_errors(plant, biased)


def test_filter_of_a_wrong_plant():
    plant = plant_of(4)
    believed = dataclasses.replace(plant, A=0.6 * plant.A)
    within_four_standard_errors(plant, lb.reduced_order_filter(believed, 1))
    within_four_standard_errors(
        plant, lb.reduced_order_filter(believed, 1, steps=STEPS)
    )


def test_time_varying_plant():
    plant = generators.varying(np.random.default_rng(6), 3, 2, STEPS + 1, m=0)
    within_four_standard_errors(plant, lb.reduced_order_filter(plant, 1, steps=STEPS))


def test_ensemble_is_bit_identical_for_any_executor():
    plant = plant_of(7)
    observer = lb.reduced_order_filter(plant, 1, steps=5)
    here = lb.monte_carlo(plant, observer, runs=150, steps=5, seed=9)
    with concurrent.futures.ThreadPoolExecutor(3) as threads:
        there = lb.monte_carlo(
            plant, observer, runs=150, steps=5, seed=9, executor=threads
        )
    for name in ("mean", "covariance", "standard_error"):
        assert getattr(here, name).tobytes() == getattr(there, name).tobytes()


def test_standard_errors_shrink_as_runs_grow():
    plant = plant_of(8)
    observer = lb.kalman_filter(plant, steps=3)
    few, many = (
        lb.monte_carlo(plant, observer, runs=runs, steps=3, seed=1)
        for runs in (250, 4000)
    )
    ratio = few.standard_error[1:] / many.standard_error[1:]
    assert (2.5 < ratio).all() and (ratio < 6).all()


def test_simulated_noise_has_the_plants_covariance():
    plant = plant_of(9)
    observer = lb.kalman_filter(plant)
    run = lb.simulate(plant, observer, 20_000, seed=4)
    w = run.x[1:] - run.x[:-1] @ plant.A.T
    v = run.y - run.x @ plant.C.T
    sample = np.cov(np.hstack([w, v[:-1]]).T)
    wanted = np.block([[plant.Q, plant.S], [plant.S.T, plant.R]])
    np.testing.assert_allclose(sample, wanted, atol=0.05 * np.abs(wanted).max())


def test_simulation_without_a_seed_is_free_of_noise():
    plant = plant_of(10)
    run = lb.simulate(plant, lb.kalman_filter(plant), 5)
    np.testing.assert_allclose(run.x[1:], run.x[:-1] @ plant.A.T, rtol=1e-12)
    assert lb.simulate(plant, lb.kalman_filter(plant), 5, seed=0).y.std() > 0


@pytest.mark.parametrize("steps", [None, 6], ids=["constant", "over steps"])
def test_error_of_a_run_follows_the_error_equation(steps):
    """(11) and (26) stepped with the noises read off the run, not with simulate."""
    plant = generators.plant(np.random.default_rng(12), 4, 2, m=2)
    observer = lb.reduced_order_filter(plant, 1, steps=steps)
    run = lb.simulate(plant, observer, 6, u=np.ones(2), u0=None, seed=3)
    v = run.y - run.x @ plant.C.T - run.u @ plant.E.T
    w = run.x[1:] - run.x[:-1] @ plant.A.T - run.u[:-1] @ plant.B.T
    T = observer.T if steps else [observer.T] * 8
    eps = run.z[0] - T[0] @ run.x[0]
    for k in range(len(w)):
        F, _, D, P, V, _ = observer.at(k)
        np.testing.assert_allclose(run.error[k], P @ eps + V @ v[k], atol=1e-10)
        eps = F @ eps + D @ v[k] - T[k + 1] @ w[k]


def test_continuous_error_decays_as_the_poles_say():
    plant = lb.Plant([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]])
    observer = lb.Observer(
        [[-5]], [[1]], [[-12]], [[0], [1]], [[1], [2]], T=[[-2, 1]], L=np.eye(2)
    )
    t = np.linspace(0, 2, 201)
    run = lb.simulate(plant, observer, t, u=1.0, x0=[1, 0], z0=[1.0])
    start = 1.0 - observer.T @ [1, 0]
    np.testing.assert_allclose(run.error[:, 1], np.exp(-5 * t) * start[0], atol=1e-12)


@pytest.mark.parametrize("at_first", [True, False])
def test_an_observer_of_nothing_errs_as_the_state_beside_it_says(at_first):
    """Its T is anything: the moments of x and z together need none."""
    rng = np.random.default_rng(4)
    n, p, r, q, N = 3, 2, 2, 2, 4
    A, C, L = rng.normal(size=(n, n)), rng.normal(size=(p, n)), rng.normal(size=(q, n))
    half, start = rng.normal(size=(n + p, n + p)), rng.normal(size=(n, n))
    noise, P0, x0, z0 = (
        half @ half.T,
        start @ start.T,
        np.arange(3.0),
        np.array([2, -1]),
    )
    plant = lb.Plant(
        A, None, C, dt=1.0, x0=x0, P0=P0, at_first=at_first,
        Q=noise[:n, :n], S=noise[:n, n:], R=noise[n:, n:],
    )  # fmt: skip
    sizes = dict(F=(r, r), G=(r, 0), D=(r, p), P=(q, r), V=(q, p), T=(r, n))
    given = {name: rng.normal(size=(N, *size)) for name, size in sizes.items()}
    observer = lb.Observer(
        **given, L=L, z0=z0, dt=1.0, T0=np.zeros((r, n)), G0=np.zeros((r, 0))
    )
    found = lb.error_covariance(observer, plant, steps=N)
    moved = not at_first
    s = np.concatenate([A @ x0 if moved else x0, z0])
    M = np.outer(s, s)
    M[:n, :n] += A @ P0 @ A.T + plant.Q if moved else P0
    np.testing.assert_allclose(found[0], L @ P0 @ L.T)
    for k in range(N):
        F, D, P, V = (given[name][k] for name in "FDPV")
        shows = np.hstack([V @ C - L, P])
        wanted = shows @ M @ shows.T + V @ plant.R @ V.T
        np.testing.assert_allclose(found[k + 1], wanted, rtol=1e-9)
        moves = np.block([[A, np.zeros((n, r))], [D @ C, F]])
        drives = np.block([[np.eye(n), np.zeros((n, p))], [np.zeros((r, n)), D]])
        M = moves @ M @ moves.T + drives @ noise @ drives.T
