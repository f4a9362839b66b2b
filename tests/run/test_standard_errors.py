"""Standard errors of a mean over so few runs that they are counted on one hand."""

import numpy as np
import pytest

import luenberger as lb

PLANT = lb.Plant([[0.5, 0.2], [0, 0.7]], None, [[1, 0.3]], dt=1.0,
                 Q=[[1, 0.2], [0.2, 0.4]], R=[[0.5]], P0=np.eye(2))  # fmt: skip


def ensemble(runs):
    observer = lb.kalman_filter(PLANT)
    return lb.monte_carlo(PLANT, observer, runs=runs, steps=3, seed=4)


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
