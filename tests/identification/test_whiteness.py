"""Whether innovations are white and of variance one."""

import numpy as np
import pytest
from statsmodels.stats.diagnostic import acorr_ljungbox

import luenberger as lb

RNG = np.random.default_rng(11)


def test_white_noise_is_believed_as_often_as_it_should_be():
    found = [lb.whiteness(RNG.normal(size=(400, 2))) for _ in range(400)]
    assert 0.02 < np.mean([not one.white for one in found]) < 0.09
    assert 0.02 < np.mean([not one.sized for one in found]) < 0.15  # of two outputs
    assert np.mean([one.statistic for one in found]) == pytest.approx(80, rel=0.04)


def test_it_is_box_and_pierces_statistic():
    e = RNG.normal(size=3000)
    found = lb.whiteness(e[:, None], lags=10)
    same = acorr_ljungbox(e - 0, lags=[10], boxpierce=True)
    assert found.statistic == pytest.approx(same["bp_stat"].iloc[0], rel=0.05)
    assert found.p_value == pytest.approx(same["bp_pvalue"].iloc[0], abs=0.05)


def test_what_is_not_white_or_too_large_is_said():
    e = np.random.default_rng(12).normal(size=1001)
    dragged = lb.whiteness((e[1:] + 0.3 * e[:-1])[:, None])
    assert not dragged.white
    assert dragged.autocorrelation[0, 0, 0] == pytest.approx(0.3 / 1.09, abs=0.07)
    assert dragged.sentences[0].startswith("The normalised innovations are not white")
    large = lb.whiteness(1.5 * e[:, None])
    assert large.white and not large.sized
    assert "and should be 1" in large.sentences[1]
    assert "as it should be" in lb.whiteness(e[:, None]).sentences[1]


def test_gaps_are_left_out():
    e = RNG.normal(size=(2000, 2))
    e[RNG.random(e.shape) < 0.3] = np.nan
    found = lb.whiteness(e)
    assert found.white and found.sized
    e[:, 1] = np.nan
    assert lb.whiteness(e).dof == 20


def test_an_echo_in_the_other_output_is_seen():
    e = RNG.normal(size=(1000, 2))
    e[3:, 1] = 0.8 * e[3:, 1] + 0.6 * e[:-3, 0]
    found = lb.whiteness(e)
    assert not found.white
    assert found.autocorrelation[2, 1, 0] == pytest.approx(0.6, abs=0.1)
    assert abs(found.autocorrelation[2, 0, 1]) < 0.1
