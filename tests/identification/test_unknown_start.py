"""The likelihood of a record whose start is not known."""

import dataclasses

import generators
import mpmath as mp
import numpy as np
import pytest
from exact_likelihood import (
    KINDS,
    SCORED,
    beside_noises,
    direction,
    exact_moments,
    free_moments,
    inverse,
    nile,
    rational_plant,
)
from exact_smoother import product
from statsmodels.tsa.statespace.initialization import Initialization

import luenberger as lb
from luenberger.filtering import unknown as start

nan = float("nan")


def unknown(plant):
    """The same plant, of whose start nothing is known."""
    return dataclasses.replace(plant, P0=None)


def test_nile():
    """Durbin and Koopman (2012), section 2.10, give -632.54.

    Exactly it is -632.5456; -632.5442 has a prior variance of 10^7.  statsmodels has
    -633.4646, which counts one more factor (2 pi)^(-1/2).
    """
    plant = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[1469.1]], R=[[15099.0]])
    found = lb.Filter(plant).log_likelihood(nile())
    assert round(found, 4) == -632.5456
    assert round(found - np.log(2 * np.pi) / 2, 4) == -633.4646


# -- statsmodels, and many digits where it has too few ---------------------------------


def with_many_digits(plant, y):
    """The limit, from a start of variance 10^25 and 80 digits."""
    with mp.workdps(80):
        size, n = mp.mpf(10) ** 25, plant.n
        A, C, Q, R, S = (
            mp.matrix(X.tolist())
            for X in (plant.A, plant.C, *plant.at(0).covariances())
        )
        x, P, total = mp.zeros(n, 1), mp.eye(n) * size, mp.mpf(0)
        for row in y:
            seen = [k for k in range(plant.p) if not np.isnan(row[k])]
            G = mp.zeros(n, 1)
            nu, M = mp.zeros(1, 1), mp.eye(1)
            if seen:
                here = mp.matrix([[C[k, j] for j in range(n)] for k in seen])
                M = here * P * here.T
                M += mp.matrix([[R[j, k] for k in seen] for j in seen])
                nu = mp.matrix([row[k] for k in seen]) - here * x
                cross = mp.matrix([[S[j, k] for k in seen] for j in range(n)])
                G = (A * P * here.T + cross) * M**-1
                total -= (nu.T * M**-1 * nu)[0] / 2
                total -= (len(seen) * mp.log(2 * mp.pi) + mp.log(mp.det(M))) / 2
            x, P = A * x + G * nu, A * P * A.T + Q - G * M * G.T
        return float(total + n * mp.log(2 * mp.pi * size) / 2)


def case(seed):
    """A random plant, some of them unstable, and a record, most of them with gaps."""
    rng = np.random.default_rng(seed)
    n, p = rng.integers(1, 5), rng.integers(1, 4)
    plant = generators.plant(
        rng, n, p, m=0, cross=seed % 2, radius=rng.uniform(0.3, 1.1), P0=None
    )
    y = 3 * rng.normal(size=(30, p))
    if seed % 3:
        y[rng.random(y.shape) < 0.2] = nan
    return plant, y


def statsmodels(plant, y):
    model, (mean, P) = beside_noises(plant, y)
    n = plant.n
    start = Initialization(len(mean))
    start.set((0, n), "diffuse")
    start.set((n, len(mean)), "known", constant=mean[n:], stationary_cov=P[n:, n:])
    model.ssm.initialize(start)
    return model.ssm.loglike() + n * np.log(2 * np.pi) / 2


def test_statsmodels_has_the_same_likelihood():
    """Where it has not, 80 digits decide: its rank decisions lose a state at times."""
    apart = []
    for seed in range(200):
        plant, y = case(seed)
        found, wanted = lb.Filter(plant).log_likelihood(y), statsmodels(plant, y)
        if found != pytest.approx(wanted, rel=1e-10):
            apart.append(seed)
            wanted = with_many_digits(plant, y)
            assert found == pytest.approx(wanted, rel=1e-10), seed
    assert len(apart) < 15


# -- exactly ---------------------------------------------------------------------------


def exact(plant, y, u, u0, move=None):
    """The density integrated over the first state, with rationals; and its slope."""
    n = plant.n
    any_start = dataclasses.replace(plant, P0=np.eye(n), at_first=True)
    moments = exact_moments(any_start, y, u, u0, move, start=True)
    (V, dV), (d, dd) = free_moments(*moments)
    (d, D), (dd, dD) = ((X[:, :1], -X[:, 1:]) for X in (d, dd))
    W, det = inverse(V)
    WD = product(W, D)
    spread, determined = inverse(product(D.T, WD))
    best = product(spread, D.T, W, d)
    rest = d - product(D, best)
    e = product(W, rest)
    value = -((len(d) - n) * np.log(2 * np.pi) + np.log(float(det))) / 2
    value -= (np.log(float(determined)) + float(product(rest.T, e)[0, 0])) / 2
    moved = product(dD.T, WD) + product(WD.T, dD) - product(WD.T, dV, WD)
    slope = product(e.T, dV, e)[0, 0] / 2
    slope -= product(e.T, dd - product(dD, best))[0, 0]
    slope -= ((W * dV.T).sum() + (spread * moved.T).sum()) / 2
    return value, float(slope)


@pytest.mark.parametrize("kind", [k for k in KINDS if k != "prior"])
def test_the_likelihood_is_the_integral_of_the_density(kind):
    plant, *record = rational_plant(kind)
    wanted, _ = exact(plant, *record)
    y, u, u0 = record
    found = lb.Filter(unknown(plant)).log_likelihood(lb.Record(y, u, u0=u0))
    assert found == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize(
    ("kind", "name"), [x for x in SCORED if x[1] in "QRS" and x[0] != "prior"]
)
def test_the_score_is_that_of_the_integral(kind, name):
    plant, *record = rational_plant(kind)
    y, u, u0 = record
    D = direction(plant, name)
    _, wanted = exact(plant, *record, move={name: D})
    slope = getattr(lb.Filter(unknown(plant)).score(lb.Record(y, u, u0=u0)), name)
    size = np.abs(slope * D).sum()
    assert np.sum(slope * D) == pytest.approx(wanted, abs=1e-11 * size)


def test_a_varying_plant_is_scored_at_the_right_instant():
    """Rows after the first ones, too, have the matrices of their own instants."""
    rng = np.random.default_rng(5)
    plant = generators.varying(rng, 1, 1, 4, m=1, P0=None)
    parts = {k: np.round(getattr(plant, k), 2) for k in ("A", "B", "C", "E")}
    plant = dataclasses.replace(plant, **parts)
    y, u, u0 = (np.round(rng.normal(size=size), 2) for size in ((4, 1), (4, 1), 1))
    found = lb.Filter(plant).score(lb.Record(y, u, u0=u0))
    for name in "QRS":
        D = np.ones(getattr(plant, name).shape)
        _, wanted = exact(plant, y, u, u0, {name: D})
        assert getattr(found, name).sum() == pytest.approx(wanted, rel=1e-9)


# -- what must not matter --------------------------------------------------------------


@pytest.mark.parametrize("power", [-60, 60])
def test_units_only_add_a_constant(power):
    """Those of a state do not enter at all."""
    for seed in range(60):
        plant, y = case(seed)
        wanted, unit = lb.Filter(plant).log_likelihood(y), np.ones(plant.n)
        unit[0] = 2.0**power
        other = dataclasses.replace(
            plant, A=plant.A * unit / unit[:, None], C=plant.C * unit,
            Q=plant.Q / unit / unit[:, None],
            S=None if plant.S is None else plant.S / unit[:, None],
        )  # fmt: skip
        found = lb.Filter(other).log_likelihood(y) + np.log(unit[0])
        assert found == pytest.approx(wanted, rel=1e-10)


@pytest.mark.parametrize("away", [1e3, 1e6])
def test_a_record_may_begin_anywhere(away):
    """Only what the record shows beside its start counts."""
    plant = lb.Plant(
        [[1, 1], [0, 1]], None, [[1, 0]], dt=1.0, Q=[[0.25, 0.5], [0.5, 1]], R=[[1]]
    )
    y = np.array([[1.0], [3], [2], [nan], [5], [4]])
    run = lb.Filter(plant)
    wanted = run.log_likelihood(y)
    found = run.log_likelihood(y + away + away * np.arange(6)[:, None])
    assert found == pytest.approx(wanted, rel=1e-15 * away * 100)


def test_as_few_rows_as_determine_the_state():
    """Kawazoe's count: three outputs of one sensor, two rows of two sensors."""
    A = [[1, 1, 0], [0, 1, 1], [0, 0, 1]]
    for C, rows in (([[1, 0, 0]], 3), ([[1, 0, 0], [0, 0, 1]], 2)):
        plant = lb.Plant(A, None, C, dt=1.0, Q=np.eye(3), R=np.eye(len(C)))
        passed = lb.Filter(plant).passed(lb.Record(np.ones((6, len(C)))), "values")
        assert [len(one.x) for one in passed] == [rows, 6 - rows]
        assert (passed[0].variances[-1] < start.LARGE).all()


def test_many_rows_may_pass_before_the_state_is_determined():
    """A likelihood does not change when nothing is measured after one reading."""
    plant = lb.Plant([[1.0]], None, [[1], [1]], dt=1.0, Q=[[0]], R=np.eye(2))
    two = lb.Plant(np.eye(2), None, np.eye(2), dt=1.0, Q=np.zeros((2, 2)), R=np.eye(2))
    y = np.full((200, 2), nan)
    y[0, 0], y[-2:, 1], y[-1, 0] = 1.0, [3.0, 2.0], 4.0
    short = y[[0, -2, -1]]
    for one in map(lb.Filter, (plant, two)):
        assert one.log_likelihood(y) == pytest.approx(one.log_likelihood(short), 1e-12)
        np.testing.assert_allclose(one.score(y).R, one.score(short).R, atol=1e-12)


def test_an_estimate_is_the_limit_of_wide_starts():
    """Until the record determines a state its error has no bound."""
    A, C = [[1, 1], [0, 1]], [[1, 0]]
    given = dict(dt=1.0, Q=np.eye(2) / 4, R=[[1]])
    y = np.array([[1.0], [nan], [3], [2], [4]])
    found = lb.Filter(lb.Plant(A, None, C, **given)).run(y)
    wide = lb.Plant(A, None, C, P0=1e8 * np.eye(2), at_first=True, **given)
    wanted = lb.Filter(wide).run(y)
    np.testing.assert_allclose(found.x[2:], wanted.x[2:], rtol=1e-6)
    np.testing.assert_allclose(found.std[2:], wanted.std[2:], rtol=1e-6)
    np.testing.assert_allclose(found.P[2:], wanted.P[2:], rtol=1e-6)
    assert found.std[0, 0] == pytest.approx(1) and np.isinf(found.std[[0, 1], 1]).all()
    rest = lb.Filter(lb.Plant(A, None, C, **given)).run(y[:2])
    again = lb.Filter(lb.Plant(A, None, C, **given)).run(y[2:], start=rest.end)
    np.testing.assert_array_equal(again.x, found.x[2:])


def test_innovations_begin_where_the_state_is_known():
    plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0, Q=np.eye(2), R=[[1]])
    found = lb.Filter(plant).innovations(np.arange(4.0) ** 2)
    assert np.isnan(found[:2]).all() and np.isfinite(found[2:]).all()


def test_a_record_that_does_not_determine_the_state_is_refused():
    plant = lb.Plant(
        [[1, 1], [0, 1]], None, [[1, 0]], dt=1.0, Q=np.eye(2), R=[[1]],
        state_names=("place", "speed"),
    )  # fmt: skip
    for y in ([[1.0]], [[1.0], [nan], [nan]], np.zeros((0, 1))):
        with pytest.raises(lb.DesignError, match="no P0.*does not determine"):
            lb.Filter(plant).log_likelihood(y)
    blind = dataclasses.replace(plant, C=[[0, 1]])
    with pytest.raises(lb.DesignError, match="combination of place is not seen"):
        lb.Filter(blind).log_likelihood(np.ones((9, 1)))
    lost = dataclasses.replace(plant, A=[[0, 0], [0, 1]], C=[[0, 1]])
    with pytest.raises(lb.DesignError, match="combination of place is not seen"):
        lb.Filter(lost).log_likelihood(np.ones((9, 1)))
