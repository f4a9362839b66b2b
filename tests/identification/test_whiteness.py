"""Whether innovations are white and of variance one."""

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import brentq
from statsmodels.stats.diagnostic import acorr_ljungbox

import luenberger as lb
from luenberger.identification.whiteness import whiteness

RNG = np.random.default_rng(11)


def test_white_noise_is_believed_as_often_as_it_should_be():
    found = [whiteness(RNG.normal(size=(400, 2))) for _ in range(400)]
    assert 0.02 < np.mean([not one.white for one in found]) < 0.09
    assert 0.02 < np.mean([not one.sized for one in found]) < 0.15  # of two outputs
    assert np.mean([one.statistic for one in found]) == pytest.approx(80, rel=0.04)


@pytest.mark.parametrize(
    ("rows", "outputs", "lags", "gaps"),
    [
        (20, 1, None, 0),
        (50, 1, 20, 0),
        (100, 1, None, 0),
        (100, 3, None, 0.3),
        (700, 1, None, 0),
    ],
)
def test_a_small_probability_is_as_rare_as_it_says(rows, outputs, lags, gaps):
    rng = np.random.default_rng(rows + outputs)
    seen = rng.random((rows, outputs)) >= gaps
    many = 4000
    found = np.array(
        [
            whiteness(np.where(seen, e, np.nan), lags=lags).p_value
            for e in rng.normal(size=(many, rows, outputs))
        ]
    )
    for level, slack in ((0.05, 0.15), (0.01, 0.15)):
        rare = (found < level).mean()
        assert abs(rare - level) < slack * level + 3 * np.sqrt(level / many)
    assert (found < 0.001).mean() < 0.0035  # by chi-square 0.006 at 100 rows


def excess(rows, statistic=45.0):
    """How much more probable a sum of 20 squares is than by chi-square, as a log."""
    e = np.random.default_rng(rows).normal(size=rows + 1)

    def found(echo):
        return whiteness((e[1:] + echo * e[:-1])[:, None])

    echo = brentq(lambda x: found(x).statistic - statistic, 0, 1, xtol=1e-12)
    return np.log(found(echo).p_value / stats.chi2.sf(statistic, 20))


def test_the_excess_of_long_records_is_in_proportion_to_that_of_500_rows():
    known = excess(500)
    assert known > 0.1
    assert excess(501) == pytest.approx(known, rel=0.03)
    assert excess(1000) == pytest.approx(known / 2, rel=0.1)
    assert excess(4000) == pytest.approx(known / 8, rel=0.15)


@pytest.mark.parametrize("gaps", [0, 0.4])
@pytest.mark.parametrize("rows", [32, 60])
def test_the_mean_is_the_number_of_entries(rows, gaps):
    """The variances are exact: with gaps, at all lags, of one output and of two."""
    rng = np.random.default_rng(rows)
    seen = rng.random((rows, 2)) >= gaps
    kept = [
        whiteness(np.where(seen, e, np.nan), lags=6).statistic
        for e in rng.normal(size=(5000, rows, 2))
    ]
    error = np.std(kept) / np.sqrt(len(kept))
    assert np.mean(kept) == pytest.approx(24, abs=3.5 * error)


def test_it_is_ljung_and_boxes_statistic_about_a_known_mean():
    e = RNG.normal(size=80)
    e = np.concatenate([e, -e[::-1]])  # of mean zero, as statsmodels takes it off
    found = whiteness(e[:, None], lags=10)
    same = acorr_ljungbox(e, lags=[10])
    assert found.statistic == pytest.approx(same["lb_stat"].iloc[0], rel=1e-12)
    e = RNG.normal(size=20_000)
    found = whiteness(e[:, None], lags=10)
    same = acorr_ljungbox(e - 0, lags=[10])
    assert found.p_value == pytest.approx(same["lb_pvalue"].iloc[0], abs=0.02)


def test_what_was_fitted_counts_as_it_does_in_chi_square():
    """Of a long record: one degree of freedom less for each number."""
    e = RNG.normal(size=(50_000, 1))
    for fitted in (0, 3, 12):
        found = whiteness(e, fitted)
        assert found.dof == 20 - fitted
        same = stats.chi2.sf(found.statistic, 20 - fitted)
        assert found.p_value == pytest.approx(same, rel=0.05)


def test_a_fit_takes_off_what_it_fitted_beyond_the_covariance_of_the_innovation():
    """Q and R of two states and an output are two numbers; one is the innovation's."""
    plant = lb.Plant([[1, 1], [0, 0.5]], None, [[1, 0]], dt=1.0)
    true = lb.Plant(
        plant.A, None, plant.C, dt=1.0, Q=np.diag([0.3, 1.0]), R=[[2.0]], P0=np.eye(2)
    )
    y = lb.simulate(true, lb.kalman_filter(true), 200, seed=3).y
    diagonal = lb.fit_noise(plant, y, Q="diagonal")
    assert diagonal.whiteness.dof == 20 - 2
    same = whiteness(diagonal.innovations, 2)
    assert diagonal.whiteness.p_value == same.p_value
    assert lb.fit_noise(true, y, Q="scaled", R="scaled").whiteness.dof == 20 - 1
    assert lb.fit_noise(true, y, Q="scaled", R=None).whiteness.dof == 20


def test_short_records_are_warned_of_and_lags_beyond_one_refused():
    with pytest.warns(UserWarning, match="whiteness of 19 rows with a reading"):
        whiteness(RNG.normal(size=(19, 1)))
    thin = np.full((100, 2), np.nan)
    thin[::6, 1] = 1.0
    with pytest.warns(UserWarning, match="whiteness of 17 rows"):
        whiteness(thin)
    for lags in (0, 30, 2.5):
        with pytest.raises(ValueError, match="lags must be"):
            whiteness(RNG.normal(size=(30, 1)), lags=lags)


def test_what_is_not_white_or_too_large_is_said():
    e = np.random.default_rng(12).normal(size=1001)
    dragged = whiteness((e[1:] + 0.3 * e[:-1])[:, None])
    assert not dragged.white
    assert dragged.autocorrelation[0, 0, 0] == pytest.approx(0.3 / 1.09, abs=0.07)
    assert dragged.sentences[0].startswith("The normalised innovations are not white")
    large = whiteness(1.5 * e[:, None])
    assert large.white and not large.sized
    assert "and should be 1" in large.sentences[1]
    assert "as it should be" in whiteness(e[:, None]).sentences[1]


def test_an_echo_in_the_other_output_is_seen():
    e = RNG.normal(size=(1000, 2))
    e[3:, 1] = 0.8 * e[3:, 1] + 0.6 * e[:-3, 0]
    found = whiteness(e)
    assert not found.white
    assert found.autocorrelation[2, 1, 0] == pytest.approx(0.6, abs=0.1)
    assert abs(found.autocorrelation[2, 0, 1]) < 0.1
