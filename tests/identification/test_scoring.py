"""Scoring, with which a fit begins where there are gaps, and its compiled rows."""

import dataclasses
from contextlib import nullcontext

import generators
import numpy as np
import pytest
from as_python import as_python

import luenberger as lb
from luenberger.identification import records, scoring, stretch
from luenberger.identification.forms import form_of
from luenberger.identification.objective import per_reading, readings
from luenberger.identification.parameters import parameters_of
from luenberger.identification.unknowns import Unknowns

FORMS = ("full", "diagonal", [[1, 0], [0, 1], [1, 1]], "function", "scaled")


def unknowns(plant, Q, R="full", begin=(1.0, 1.0)):
    """All that is unknown, in units of size one."""
    if isinstance(Q, str) and Q == "function":
        Q = lambda q: np.diag([q[0], q[0] + q[1], q[1]])  # noqa: E731
    forms = [
        form_of("Q", Q, plant.n, plant.Q, np.array(begin), np.ones(plant.n)),
        form_of("R", R, plant.p, plant.R, None, np.ones(plant.p)),
    ]
    return Unknowns(*forms, None, parameters_of(plant, None))


def case(seed=3, rows=120, n=3, p=2):
    """A plant without a start, and its record with a twentieth missing."""
    rng = np.random.default_rng(seed)
    plant = generators.plant(rng, n, p, m=0, radius=0.9)
    y = generators.record(rng, plant, rows)[0]
    y[rng.random(y.shape) < 0.05] = np.nan
    return dataclasses.replace(plant, P0=None), [(y, np.zeros((rows, 0)))]


@pytest.mark.parametrize("Q", FORMS, ids=str)
def test_a_step_is_one_of_the_covariance_itself(Q):
    """Linear in the step, until it would leave what is semi-definite."""
    plant, _ = case()
    what = unknowns(plant, Q)
    rng = np.random.default_rng(0)
    theta, step = rng.normal(size=what.count) / 2, 0.1 * rng.normal(size=what.count)
    q = what.Q.count
    for form, at in ((what.Q, slice(0, q)), (what.R, slice(q, None))):
        X = form.matrix(theta[at])
        wanted = X + np.tensordot(step[at], form.slopes(theta[at]), 1)
        found = form.matrix(scoring.moved(what, theta, step)[at])
        np.testing.assert_allclose(found, wanted, rtol=1e-8, atol=1e-9)
    far = what.Q.matrix(scoring.moved(what, theta, -9 + 0 * step)[:q])
    assert np.linalg.eigvalsh(far).min() > -1e-15


def test_a_variance_that_is_far_too_small_is_left_in_one_step():
    plant, data = case(rows=200)
    what = unknowns(plant, "diagonal")
    likely = per_reading(what, data)
    calls = []

    def counted(theta):
        calls.append(theta)
        return likely(theta)

    theta = np.array([-7.0, 0, 0, 0, 0, -7.0])
    found, inverse = scoring.scored(what, counted, theta, data)
    assert len(calls) < 12
    from_far = lb.fit_noise(plant, data[0][0], Q="diagonal")
    assert -likely(found)[0] * readings(data) == pytest.approx(
        from_far.log_likelihood, abs=1e-2
    )


@pytest.mark.parametrize("seed, rows", [(0, 40), (1, 120), (2, 40)])
def test_a_fit_with_gaps_is_as_likely_as_one_without_scoring(seed, rows, monkeypatch):
    """Some of these are most likely at a bound."""
    plant, data = case(seed, rows=rows, n=2, p=1 + seed % 2)
    options = dict(Q="diagonal", R="diagonal" if seed % 3 else "full")
    fit = lb.fit_noise(plant, data[0][0], **options)
    monkeypatch.setattr(records, "has_gaps", lambda data: False)
    other = lb.fit_noise(plant, data[0][0], **options)
    assert fit.log_likelihood > other.log_likelihood - 1e-5


def test_scoring_leaves_what_it_has_no_information_of(monkeypatch):
    """The first rows do not determine the start, so the search goes on without."""
    plant, data = case(rows=100)
    data[0][0][:60] = np.nan
    monkeypatch.setattr(scoring, "ROWS", 50)
    what = unknowns(plant, "diagonal")
    theta = np.zeros(what.count)
    found, inverse = scoring.scored(what, per_reading(what, data), theta, data)
    assert inverse is None and (found == theta).all()


def test_steps_that_gain_nothing_are_not_taken():
    """The slope promises a gain, and no step along it, however short, has one."""
    plant, data = case(rows=40)
    what = unknowns(plant, "diagonal")
    theta, steep = np.zeros(what.count), (1.0, np.ones(what.count))
    found, inverse = scoring.scored(what, lambda theta: steep, theta, data)
    assert inverse is not None and (found == theta).all()


def test_a_step_to_what_is_no_covariance_is_halved(monkeypatch):
    """R is nearly singular, and so the step too long for the digits of its factor."""
    plant, data = case(rows=40, n=2)
    what, slope, steps = unknowns(plant, "diagonal"), np.eye(5)[4], []
    theta, step_to = np.array([0, 0, -0.3, -0.7, -18.0]), scoring.moved

    def moved(what, theta, step):
        steps.append(step)
        return step_to(what, theta, step if len(steps) < 3 else 1e-30 * step)

    monkeypatch.setattr(scoring, "moved", moved)
    falls = lambda at: (1.0, slope) if (at == theta).all() else (0.0, 0 * slope)  # noqa: E731
    found, inverse = scoring.scored(what, falls, theta, data)
    with pytest.raises(np.linalg.LinAlgError):
        step_to(what, theta, steps[1])
    np.testing.assert_array_equal(steps[2], steps[0] / 4)
    np.testing.assert_array_equal(found, step_to(what, theta, 1e-30 * steps[2]))
    assert inverse is not None


@pytest.mark.parametrize("varying", [False, True])
@pytest.mark.parametrize("start", [False, True])
def test_compiled_rows_hold_the_same_information(varying, start, monkeypatch):
    monkeypatch.setattr(stretch, "ENOUGH", 100)
    rng = np.random.default_rng(7)
    plant = generators.plant(rng, 2, 2, m=1, cross=True, radius=0.9)
    y, u, u0 = generators.record(rng, plant, 200)
    y[rng.random(y.shape) < 0.2] = np.nan
    if varying:
        plant = dataclasses.replace(plant, A=plant.A * rng.uniform(0.8, 1, (201, 1, 1)))
    if not start:
        plant = dataclasses.replace(plant, P0=None)
    along = [
        {"A": rng.normal(size=(2, 2)), "C": rng.normal(size=(2, 2))},
        {"B": rng.normal(size=(2, 1)), "S": rng.normal(size=(2, 2)) / 9},
        {"Q": np.eye(2), "R": np.eye(2)},
    ]
    with nullcontext() if start and not varying else as_python():
        found, wanted = (
            lb.information(plant, y, u, u0=u0, along=along, backend=backend)
            for backend in ("numba", "numpy")
        )
    size = np.sqrt(wanted.diagonal())
    assert np.abs((found - wanted) / size / size[:, None]).max() < 1e-11


def test_a_step_to_a_bound_takes_the_others_along():
    """By hand: the first stops at its bound, and the second is least there."""
    H, slope = np.array([[2.0, 1], [1, 2]]), np.array([10.0, 0])
    found = scoring._step(H, slope, np.array([True, True]))
    np.testing.assert_allclose(found, [-0.495, 0.2475])
    free = scoring._step(H, slope, np.array([False, False]))
    np.testing.assert_allclose(free, -np.linalg.solve(H, slope))
