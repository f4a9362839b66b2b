"""Against statsmodels: records with gaps, plants that vary in time."""

import exact_oracles as exact
import generators
import numpy as np
import pytest
from statsmodels.tsa.statespace.kalman_smoother import KalmanSmoother

import luenberger as lb

NEARLY_EXACT = 1e-12  # of an estimate or a covariance, relative to the largest


def theirs(plant, y, u, u0):
    """Filtered and smoothed results of statsmodels; time comes last there."""
    n, N = plant.n, len(y)
    model = KalmanSmoother(k_endog=plant.p, k_states=n, k_posdef=n, tolerance=0)
    model.bind(np.array(y.T, order="F"))
    now = [plant.at(i + 1) for i in range(N if plant.steps else 1)]

    def over_time(name):
        return np.stack([getattr(instant, name) for instant in now], axis=-1)

    model["design"], model["transition"] = over_time("C"), over_time("A")
    model["state_cov"], model["obs_cov"] = over_time("Q"), over_time("R")
    model["selection"] = np.eye(n)[..., None]
    drive, heard = over_time("B"), over_time("E")
    model["state_intercept"] = (drive * u.T).sum(axis=1)
    model["obs_intercept"] = (heard * u.T).sum(axis=1)
    A, B, Q = plant.first_step()
    model.initialize_known(A @ plant.x0 + B @ u0, A @ plant.P0 @ A.T + Q)
    return model.smooth()


@pytest.fixture(
    params=[
        (n, p, varying, share, kind)
        for n, p in ((1, 1), (3, 2), (6, 4))
        for varying in (False, True)
        for share, kind in ((0.0, "prior"), (0.4, "posterior"))
    ],
    ids=lambda p: (
        f"n={p[0]} {'varying' if p[2] else 'constant'} {p[4]} {p[3]:.0%} gone"
    ),
)
def case(request):
    n, p, varying, share, kind = request.param
    rng = np.random.default_rng(n)
    options = dict(m=1, cross=False, at_first=kind == "prior")
    plant = (
        generators.varying(rng, n, p, 80, **options)
        if varying
        else generators.plant(rng, n, p, radius=1.02, **options)
    )
    y, u, u0 = generators.record(rng, plant, 80)
    y[rng.random(y.shape) < share] = np.nan
    if share:
        y[[0, 20, 21, 79]] = np.nan  # the first row, the last, and two together
    return plant, y, u, u0


def test_filtered_states_and_covariances(case):
    plant, y, u, u0 = case
    run = lb.Filter(plant).run(lb.Record(y, u, u0=u0))
    found = theirs(plant, y, u, u0)
    assert generators.relative(run.x, found.filtered_state.T) < NEARLY_EXACT
    for k in range(len(y)):
        P, before = found.filtered_state_cov[..., k], found.predicted_state_cov[..., k]
        # theirs is a difference of two covariances of the size before the sample
        assert np.abs(run.P[k] - P).max() < NEARLY_EXACT * np.abs(before).max()
        assert generators.relative(run.std[k] ** 2, run.P[k].diagonal()) < NEARLY_EXACT


def test_a_filter_over_steps_is_theirs_without_gaps(case):
    plant, y, u, u0 = case
    if np.isnan(y).any():
        observer = lb.kalman_filter(plant, steps=80)
        with pytest.raises(ValueError, match="a Filter takes NaN"):
            lb.estimate(observer, lb.Record(y, u, u0=u0))
        return
    found = theirs(plant, y, u, u0)
    estimates = lb.estimate(lb.kalman_filter(plant, steps=80), lb.Record(y, u, u0=u0))
    assert generators.relative(estimates, found.filtered_state.T) < NEARLY_EXACT


@pytest.mark.parametrize("varying", [False, True])
def test_the_exact_smoother_is_theirs(varying):
    """So that the oracle of the next smoother has been seen to be right."""
    rng = np.random.default_rng(4)
    make = generators.varying if varying else generators.plant
    plant = make(rng, 2, 1, *([5] * varying), m=1, cross=False)
    y, u, u0 = generators.record(rng, plant, 5)
    y[2] = np.nan
    means, covariances = exact.smoothed(plant, y, u, u0)
    found = theirs(plant, y, u, u0)
    for k in range(5):
        assert exact.off(found.smoothed_state[:, k], means[k]) < NEARLY_EXACT
        assert exact.off(found.smoothed_state_cov[:, :, k], covariances[k]) < 1e-11
