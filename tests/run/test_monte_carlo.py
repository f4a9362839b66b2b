"""Many runs: the same bits from any executor, workers that die, and consistency."""

import concurrent.futures
import dataclasses
import functools
import logging
import multiprocessing
import os
import signal
import sys
import time

import generators
import numpy as np
import pytest
import scipy.stats

import luenberger as lb
from luenberger.run import monte_carlo
from luenberger.run.executor import in_order
from luenberger.run.monte_carlo import Ensemble

RUNS, STEPS, SEED = 900, 5, 9  # 15 blocks, the last one of 4 runs
FIELDS = [one.name for one in dataclasses.fields(Ensemble) if one.name != "note"]


def plant_of(seed, n=3, p=2, **options):
    return generators.plant(np.random.default_rng(seed), n, p, m=0, **options)


def bits(ensemble):
    return {name: np.asarray(getattr(ensemble, name)).tobytes() for name in FIELDS}


@functools.cache
def problem():
    plant = plant_of(7)
    return plant, lb.reduced_order_filter(plant, 1, steps=STEPS)


def runs_of_the_problem(**options):
    return lb.monte_carlo(*problem(), runs=RUNS, steps=STEPS, seed=SEED, **options)


@pytest.fixture(scope="module", autouse=True)
def own_cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LUENBERGER_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="module")
def here():
    return runs_of_the_problem()


def processes(workers=2):
    spawn = multiprocessing.get_context("spawn")
    return concurrent.futures.ProcessPoolExecutor(workers, mp_context=spawn)


@pytest.fixture(scope="module")
def pool():
    with processes() as executor:
        yield executor


@pytest.fixture(scope="module")
def threads():
    with concurrent.futures.ThreadPoolExecutor(3) as executor:
        yield executor


# the same bits everywhere


@pytest.mark.parametrize("chunk", [None, 1, 65, 200, 321, 5000])
@pytest.mark.parametrize("where", ["pool", "threads"])
def test_same_bits_from_any_executor(where, chunk, here, request):
    executor = request.getfixturevalue(where)
    there = runs_of_the_problem(executor=executor, chunk=chunk)
    assert bits(there) == bits(here)


def test_same_bits_though_a_worker_of_a_dask_cluster_is_killed():
    import distributed

    plant, _ = problem()
    problem_ = plant, lb.kalman_filter(plant)
    options, killed = dict(runs=2000, steps=400, seed=SEED), []
    quiet = dict(silence_logs=logging.CRITICAL, dashboard_address=None)
    where = dict(host="127.0.0.1", n_workers=2, threads_per_worker=1, processes=True)
    with distributed.LocalCluster(**where, **quiet) as cluster:
        with distributed.Client(cluster) as client:
            workers = client.run(os.getpid)

            def kill_one(done, runs):
                if not killed:
                    tasks = client.processing()
                    busy = max(workers, key=lambda worker: len(tasks[worker]))
                    assert tasks[busy], "all is done: give the cluster more to do"
                    killed.append(workers[busy])
                    os.kill(workers[busy], signal.SIGKILL)

            there = lb.monte_carlo(
                *problem_, **options,
                executor=client.get_executor(), chunk=64, progress=kill_one,
            )  # fmt: skip
            client.wait_for_workers(2)
            alive = client.run(os.getpid).values()
    assert len(workers) == 2 and killed and killed[0] not in alive
    assert bits(there) == bits(lb.monte_carlo(*problem_, **options))


def test_same_bits_for_any_number_of_threads_of_blas(pool, monkeypatch):
    """n = 130 is a size at which BLAS shares a product out, and rounds otherwise.

    Workers of the pool have one thread, as all these tests; see tests/conftest.py.
    """
    n = 130
    plant = plant_of(1, n, 2)
    observer = lb.Observer(
        plant.A / 2, np.zeros((n, 0)), np.ones((n, 2)), np.eye(n), np.ones((n, 2)),
        T=np.eye(n), L=np.eye(n), dt=1.0,
    )  # fmt: skip
    options = dict(runs=70, steps=2, seed=1, claimed=np.eye(n))
    one = lb.monte_carlo(plant, observer, executor=pool, **options)
    for library in ("OMP", "OPENBLAS", "MKL"):
        monkeypatch.setenv(f"{library}_NUM_THREADS", "2")
    with processes(1) as executor:
        two = lb.monte_carlo(plant, observer, executor=executor, **options)
    assert bits(one) == bits(two)


def test_a_run_depends_on_seed_and_number_only():
    plant, observer = problem()
    errors = [
        lb.simulate(
            plant,
            observer,
            STEPS,
            seed=np.random.SeedSequence(SEED, spawn_key=(run,)),
        ).error
        for run in range(70)  # beyond the first block
    ]
    found = lb.monte_carlo(plant, observer, runs=70, steps=STEPS, seed=SEED)
    np.testing.assert_allclose(found.mean[1:], np.mean(errors, axis=0), atol=1e-13)
    second = np.einsum("rki,rkj->kij", errors, errors) / 70
    np.testing.assert_allclose(found.covariance[1:], second, rtol=1e-12)


class Written:
    """A number that remembers how it was added up."""

    def __init__(self, text):
        self.text = text

    def __add__(self, other):
        return Written(f"({self.text}+{other.text})")


@pytest.mark.parametrize("blocks", [1, 2, 3, 7, 8, 21, 100])
def test_sums_are_a_binary_tree_however_the_blocks_are_shared_out(blocks):
    def tree(a, b):  # the largest power of two that fits goes to the left
        if b - a == 1:
            return str(a)
        half = 2 ** ((b - a - 1).bit_length() - 1)
        return f"({tree(a, a + half)}+{tree(a + half, b)})"

    rng = np.random.default_rng(blocks)
    for cuts in range(6):
        edges = np.sort(rng.integers(0, blocks + 1, cuts)).tolist()
        nodes = []
        for a, b in zip([0, *edges], [*edges, blocks]):
            nodes += monte_carlo.join([(k, 0, (Written(str(k)),)) for k in range(a, b)])
        (found,) = monte_carlo.total(nodes)
        assert found.text == tree(0, blocks)


@pytest.mark.parametrize("q", [1, monte_carlo.FEW, monte_carlo.FEW + 1, 65])
def test_products_of_few_outputs_and_of_many_are_the_same_sums(q):
    e = np.random.default_rng(q).normal(size=(3, q, 9))
    wanted = np.einsum("kir,kjr->kij", e, e)
    np.testing.assert_allclose(monte_carlo._products(e), wanted, rtol=1e-12, atol=1e-13)


# workers that die, functions that fail


class Stalling(concurrent.futures.Executor):
    """An executor that is busy with something else from the fourth job on."""

    def __init__(self, executor):
        self.executor, self.jobs = executor, 0

    def submit(self, function, job):
        self.jobs += 1
        if self.jobs > 3:
            return self.executor.submit(time.sleep, 60)
        return self.executor.submit(function, job)


def test_a_broken_pool_is_named_and_counts_nothing(here, pool):
    before, seen = {child.pid for child in multiprocessing.active_children()}, []

    def kill_all(done, runs):
        seen.append(done)
        for child in multiprocessing.active_children():
            if child.pid not in before:
                child.kill()

    with processes(1) as executor:
        with pytest.raises(concurrent.futures.BrokenExecutor, match="nothing was coun"):
            runs_of_the_problem(
                executor=Stalling(executor), chunk=64, progress=kill_all
            )
    assert seen and seen[-1] < RUNS
    # as the message says: again, with another pool
    assert bits(runs_of_the_problem(executor=pool)) == bits(here)


def test_a_failure_calls_off_the_rest():
    done = []

    def fail_at_once(job):
        done.append(job)
        time.sleep(0.002)
        if job == 0:
            raise ZeroDivisionError

    with concurrent.futures.ThreadPoolExecutor(1) as executor:
        with pytest.raises(ZeroDivisionError):
            list(in_order(fail_at_once, range(500), executor))
    assert len(done) < 500


def test_an_interruption_calls_off_the_rest():
    started = []

    class Counting(concurrent.futures.ThreadPoolExecutor):
        def submit(self, function, job):
            return super().submit(self.late, function, job)

        def late(self, function, job):
            started.append(job)
            time.sleep(0.01)
            return function(job)

    def interrupt(done, total):
        raise KeyboardInterrupt

    with Counting(1) as executor:
        options = dict(executor=executor, progress=interrupt)
        with pytest.raises(KeyboardInterrupt) as caught:  # it holds on to the frames
            lb.monte_carlo(*problem(), runs=6400, steps=2, seed=1, **options)
    assert caught.value and len(started) < 40


def test_results_keep_the_order_of_the_jobs(threads):
    jobs = [0.03, 0.0, 0.02, 0.01]

    def wait(seconds):
        time.sleep(seconds)
        return seconds

    assert list(in_order(wait, jobs, threads)) == jobs


# consistency


@functools.cache
def steady(runs=2000, believed=1.0, **options):
    """A Kalman filter made for `believed` times the plant's Q, and its ensemble."""
    plant = plant_of(2, cross=False)
    model = dataclasses.replace(plant, Q=believed * plant.Q)
    observer = lb.kalman_filter(model, steps=20)
    claimed = lb.error_covariance(observer, model, steps=20)
    found = lb.monte_carlo(
        plant, observer, runs=runs, steps=20, seed=3, claimed=claimed, **options
    )
    return found, claimed, lb.error_covariance(observer, plant, steps=20)


def test_a_right_model_is_consistent():
    found, claimed, actual = steady()
    np.testing.assert_allclose(claimed, actual, rtol=1e-9, atol=1e-12)
    assert (found.dof == 3).all()
    assert (np.abs(found.nees - 3) < 4 * found.nees_standard_error).all()
    low, high = found.nees_bounds(0.9999)
    assert ((low < found.nees) & (found.nees < high)).all()


@pytest.mark.parametrize("believed", [0.05, 20.0], ids=["too little", "too much"])
def test_a_wrong_model_is_found_out(believed):
    found, claimed, actual = steady(believed=believed)
    wanted = [np.trace(np.linalg.solve(X, Y)) for X, Y in zip(claimed, actual)]
    assert (np.abs(found.nees - wanted) < 5 * found.nees_standard_error).all()
    low, high = found.nees_bounds()
    outside = found.nees > high if believed < 1 else found.nees < low
    assert outside[1:].all()


def test_one_covariance_serves_all_instants():
    plant = plant_of(5)
    observer = lb.kalman_filter(plant)
    options = dict(runs=100, steps=3, seed=1)
    X = lb.error_covariance(observer, plant)
    once = lb.monte_carlo(plant, observer, claimed=X, **options)
    four = lb.monte_carlo(plant, observer, claimed=np.stack([X] * 4), **options)
    twice = lb.monte_carlo(plant, observer, claimed=2 * X, **options)
    np.testing.assert_allclose(once.nees, four.nees, rtol=1e-12)
    np.testing.assert_allclose(once.nees, 2 * twice.nees, rtol=1e-12)
    assert once.dof.shape == (4,)


@pytest.mark.parametrize("confidence", [0.5, 0.95, 0.999])
def test_bounds_are_those_of_chi_square(confidence):
    found, *_ = steady(runs=70)
    tails = [[(1 - confidence) / 2], [(1 + confidence) / 2]]
    wanted = scipy.stats.chi2.ppf(tails, 70 * found.dof) / 70
    np.testing.assert_allclose(found.nees_bounds(confidence), wanted, rtol=1e-9)


def test_bounds_hold_as_often_as_they_say():
    plant, observer = problem()
    inside = []
    for seed in range(40):
        found = lb.monte_carlo(plant, observer, runs=64, steps=STEPS, seed=seed)
        low, high = found.nees_bounds(0.8)
        inside += list((low < found.nees) & (found.nees < high))
    # 240 instants, in part correlated: 0.8 within four of its standard errors
    assert abs(np.mean(inside) - 0.8) < 4 * np.sqrt(0.16 / 240 * 2)


def test_outputs_without_noise_leave_fewer_degrees_of_freedom():
    plant = lb.Plant(
        [[1, 1], [0, 0.9]], None, [[1, 1]], dt=1.0, Q=np.eye(2), R=[[0]], P0=np.eye(2)
    )
    observer = lb.reduced_order_filter(plant, 1, steps=6)
    found = lb.monte_carlo(plant, observer, runs=2000, steps=6, seed=2)
    assert found.dof.tolist() == [2] + 6 * [1]
    assert (np.abs(found.nees - found.dof) < 4 * found.nees_standard_error).all()
    noisy = dataclasses.replace(plant, R=[[1e-6]])  # the claim rules this noise out
    claimed = lb.error_covariance(observer, plant, steps=6)
    wrong = lb.monte_carlo(noisy, observer, runs=90, steps=6, seed=2, claimed=claimed)
    assert np.isfinite(wrong.nees[0]) and np.isinf(wrong.nees[1:]).all()
    assert np.isinf(wrong.nees_standard_error[1:]).all()


def test_an_observer_that_heeds_the_input_makes_no_claim():
    plant = generators.plant(np.random.default_rng(4), 3, 2, m=1)
    observer = lb.kalman_filter(plant)
    leaking = dataclasses.replace(observer, G=observer.G + 1)
    found = lb.monte_carlo(plant, leaking, runs=10, steps=2, seed=1)
    assert found.nees is None and found.dof is None and found.covariance.any()
    with pytest.raises(lb.DesignError, match="as claimed"):
        found.nees_bounds()
    X = lb.error_covariance(observer, plant)
    claimed = lb.monte_carlo(plant, leaking, runs=10, steps=2, seed=1, claimed=X)
    assert (claimed.nees > 0).all()


# standard errors, of so few runs that they are counted on one hand


@functools.cache
def ensemble(runs):
    plant = plant_of(2)
    return lb.monte_carlo(plant, lb.kalman_filter(plant), runs=runs, steps=3, seed=4)


def each(runs, of):
    """A figure of every run by itself: run k depends on the seed and k only."""
    means = [k * of(ensemble(k)) for k in range(1, runs + 1)]
    return np.diff([0 * means[0], *means], axis=0)


FIGURES = {
    "mean": ("mean_standard_error", lambda found: found.mean),
    "covariance": ("standard_error", lambda found: found.covariance),
    "nees": ("nees_standard_error", lambda found: found.nees),
}


@pytest.mark.parametrize("runs", [2, 3, 5])
@pytest.mark.parametrize("figure", FIGURES)
def test_standard_error_is_that_of_a_sample_of_unknown_variance(figure, runs):
    """s / sqrt(N) with s^2 = sum (x - mean)^2 / (N - 1), as NumPy has it with ddof=1.

    Of two runs it is half their distance.
    """
    name, of = FIGURES[figure]
    values = each(runs, of)
    wanted = values.std(axis=0, ddof=1) / np.sqrt(runs)
    found = ensemble(runs)
    np.testing.assert_allclose(getattr(found, name), wanted, rtol=1e-6, atol=1e-9)
    if runs == 2:
        np.testing.assert_allclose(wanted, np.abs(values[0] - values[1]) / 2)


def test_one_run_does_not_say_how_far_it_is_off():
    found = ensemble(1)
    for name, _ in FIGURES.values():
        assert np.isinf(getattr(found, name)).all()


# progress


def test_progress_is_told_in_order(threads):
    told = []
    runs_of_the_problem(progress=lambda *now: told.append(now))
    assert told == [(min(64 * k, RUNS), RUNS) for k in range(1, 16)]
    told.clear()
    options = dict(executor=threads, chunk=128)
    runs_of_the_problem(progress=lambda *now: told.append(now), **options)
    assert told == [(min(128 * k, RUNS), RUNS) for k in range(1, 9)]


def test_a_bar_shows_progress(capsys):
    runs_of_the_problem(progress=True)
    assert f"{RUNS}/{RUNS}" in capsys.readouterr().err


def test_a_bar_needs_tqdm(monkeypatch):
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    with pytest.raises(ImportError, match=r"pip install 'luenberger\[cluster\]'"):
        runs_of_the_problem(progress=True)


# refusals


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (dict(executor=3), "executor must be a concurrent.futures.Executor"),
        (dict(chunk=0), "chunk must be at least 1, got 0"),
        (dict(chunk=2.5), "chunk must be a whole number"),
        (dict(progress="yes"), "progress must be True, False or a function"),
        (dict(claimed=np.eye(2)), r"claimed must be"),
        (dict(claimed=np.eye(3)[None]), r"\(3, 3\) or \(6, 3, 3\), got \(1, 3, 3\)"),
        (dict(claimed=-np.eye(3)), "claimed"),
    ],
)
def test_refusals(options, message):
    with pytest.raises(ValueError, match=message):
        runs_of_the_problem(**options)


@pytest.mark.parametrize("seed", [None, -1, 0.5, True])
def test_seed_is_a_number_so_that_the_runs_can_be_made_again(seed):
    with pytest.raises(ValueError, match="seed must be"):
        lb.monte_carlo(*problem(), runs=2, steps=2, seed=seed)


@pytest.mark.parametrize("confidence", [0, 1, 95, np.nan])
def test_confidence_is_a_probability(confidence, here):
    with pytest.raises(ValueError, match="confidence must be between 0 and 1"):
        here.nees_bounds(confidence)
