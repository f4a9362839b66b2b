"""The normalised error of right and wrong claims where covariances are singular."""

import dataclasses

import numpy as np
import pytest
from exact_filter import problem, run, solve, zeros

import luenberger as lb
from luenberger.numeric.factors import square_root

DRIFT = [[1, 1], [0, 1]]  # position and velocity; the position is measured
STEPS, RUNS, SURE = 5, 200, 1 - 1e-7


def drift(R=0.0, Q=(0.1, 0.3), P0=(0.1, 0.3), A=DRIFT):
    Q, P0 = (np.outer(X, X) if np.ndim(X) == 1 else X for X in (Q, P0))
    return lb.Plant(A, None, [[1, 0]], dt=1.0, Q=Q, R=[[R]], P0=P0)


def ensemble(plant, model=None, steps=STEPS, **options):
    """Of a filter made for `model`, which it claims to be right for."""
    observer = lb.kalman_filter(plant if model is None else model, steps=steps)
    if model is not None:
        options["claimed"] = lb.error_covariance(observer, model, steps=steps)
    return lb.monte_carlo(plant, observer, runs=RUNS, steps=steps, seed=1, **options)


def assert_consistent(found, dof):
    assert found.dof.tolist() == dof
    low, high = found.nees_bounds(SURE)
    assert (low - 1e-9 <= found.nees).all() and (found.nees <= high + 1e-9).all()


CERTAIN = np.zeros((2, 2))
RIGHT = {
    "a perfect sensor": (
        drift(Q=np.diag([0, 0.1]), P0=np.diag([1.0, 0])), [1, 1, 1, 1, 1, 1]
    ),
    "noise in one direction": (drift(), [1, 1, 1, 1, 1, 1]),
    "one direction, a noisy sensor": (drift(1.0), [1, 2, 2, 2, 2, 2]),
    "a known start, a perfect sensor": (drift(P0=CERTAIN), [0, 0, 0, 0, 0, 0]),
    "a known start": (drift(1.0, P0=CERTAIN), [0, 1, 2, 2, 2, 2]),
    "a nearly perfect sensor": (drift(1e-20), [1, 2, 2, 2, 2, 2]),
    "an uncertain direction that stays": (
        drift(1.0, Q=CERTAIN, A=[[0.5, 0.2], [0.1, 0.7]]), [1, 1, 1, 1, 1, 1]
    ),
    "and is seen": (
        drift(Q=CERTAIN, A=[[0.5, 0.2], [0.1, 0.7]]), [1, 0, 0, 0, 0, 0]
    ),
    "noise that comes and goes": (
        drift(Q=np.stack([np.outer(g, g) for g in [[0.1, 0.3], [0, 0]] * 3])),
        [1, 1, 0, 0, 0, 0],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", RIGHT)
def test_a_right_claim_is_consistent(name):
    plant, dof = RIGHT[name]
    found = ensemble(plant)
    assert_consistent(found, dof)
    given = ensemble(plant, plant)
    assert_consistent(given, dof)
    np.testing.assert_allclose(given.nees, found.nees, rtol=1e-4)


@pytest.mark.parametrize("seed", range(12))
def test_rank_and_figures_are_those_of_exact_fractions(seed):
    one = problem(seed)
    plant, n, p = one.plant, one.plant.n, one.plant.p
    covariances = [one.model.P0, *run(one.model, zeros(STEPS, p), None).P]
    dof = [n - solve(P, zeros(0, n))[1].shape[1] for P in covariances]
    observer = lb.kalman_filter(plant, steps=STEPS)
    options = dict(runs=RUNS, steps=STEPS, seed=seed)
    found = lb.monte_carlo(plant, observer, **options)
    assert_consistent(found, dof)
    claimed = np.array(covariances).astype(float)
    given = lb.monte_carlo(plant, observer, claimed=claimed, **options)
    assert given.dof.tolist() == dof
    np.testing.assert_allclose(given.nees, found.nees, rtol=1e-3, atol=1e-9)


@pytest.mark.parametrize(
    "plant, model",
    [
        (drift(1e-16), drift()),
        (drift(1.0), drift()),
        (drift(), drift(Q=CERTAIN)),
    ],
    ids=["a little noise", "a sensor taken for perfect", "process noise left out"],
)
def test_what_a_claim_rules_out_is_infinite(plant, model):
    found = ensemble(plant, model)
    assert np.isfinite(found.nees[0]) and np.isinf(found.nees[1:]).all()


def test_a_start_taken_for_known_is_infinite_at_once():
    for P0 in (CERTAIN, 1e-30 * np.eye(2)):
        found = ensemble(drift(), drift(P0=P0))
        assert np.isinf(found.nees[0]) and found.dof[0] == 0


@pytest.mark.parametrize("scale", [1e-4, 0.5, 2, 1e4])
def test_a_claim_that_is_too_small_or_too_large_shows_by_as_much(scale):
    plant = drift(1e-16, Q=CERTAIN, P0=np.eye(2), A=[[0.9, 0.2], [0.1, 0.8]])
    observer = lb.kalman_filter(plant, steps=STEPS)
    X = lb.error_covariance(observer, plant, steps=STEPS)
    options = dict(runs=RUNS, steps=STEPS, seed=1)
    right, wrong = (
        lb.monte_carlo(plant, observer, claimed=c * X, **options) for c in (1, scale)
    )
    np.testing.assert_allclose(wrong.nees * scale, right.nees, rtol=1e-6)
    assert_consistent(right, [2, 2, 2, 2, 2, 2])


def test_a_claimed_direction_without_error_lowers_the_figure():
    found = ensemble(drift(), drift(P0=np.eye(2)))
    assert found.dof[0] == 2 and found.nees[0] < 0.2


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e12])
def test_units_of_a_state_decide_nothing(unit):
    plant, scale = drift(), np.array([1.0, unit])
    A, Q, P0 = (X * scale[:, None] for X in (plant.A / scale, plant.Q, plant.P0))
    plant = dataclasses.replace(plant, A=A, Q=Q * scale, P0=P0 * scale)
    assert_consistent(ensemble(plant), [1, 1, 1, 1, 1, 1])


@pytest.mark.parametrize("x0, dof", [(1e4, 2), (1e8, 1)])
def test_the_mean_of_the_state_sets_what_is_rounding(x0, dof):
    """Errors of 1e-5 are 1e-13 of 1e8: the rounding of the two that differ by them."""
    plant = drift(1e-12, Q=CERTAIN, P0=1e-10 * np.eye(2), A=np.eye(2))
    far = dataclasses.replace(plant, x0=[x0, 0])
    assert_consistent(ensemble(far), 6 * [dof])


@pytest.mark.parametrize("R, seen", [(1e-26, False), (1e-20, True)])
def test_noise_below_rounding_is_not_ruled_out(R, seen):
    found = ensemble(drift(R), drift())
    if seen:
        assert (found.nees[1:] > 1e6).all()
    else:
        assert_consistent(found, [1, 1, 1, 1, 1, 1])


@pytest.mark.parametrize("spread", [0, 6, 12])
@pytest.mark.parametrize("rank", [0, 1, 2, 4])
def test_random_numbers_have_the_covariance_in_any_units(rank, spread):
    """Rounding of a large variance beside a small one would be noise of its own."""
    for seed in range(20):
        rng = np.random.default_rng(seed)
        unit = 10.0 ** rng.uniform(-spread, spread, 4)
        G = rng.normal(size=(4, rank)) * (rng.random((4, 1)) < 0.8)
        X = unit[:, None] * (G @ G.T) * unit
        X = (X + X.T) / 2
        H = square_root(X)
        scale = np.sqrt(np.where(X.diagonal() > 0, X.diagonal(), 1))
        off = (H @ H.T - X) / scale[:, None] / scale
        assert H.shape == (4, 4) and np.abs(off).max() < 3e-12
        assert not H[X.diagonal() == 0].any()
        values = np.linalg.svd(H / scale[:, None], compute_uv=False)
        assert (values > 1e-10).sum() == (values > 1e-14).sum() <= rank
