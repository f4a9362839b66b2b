"""Likelihoods from the settled filter, held against the filter row by row."""

import dataclasses

import generators
import numpy as np
import pytest

import luenberger as lb
from luenberger.identification import settled
from luenberger.identification.score import names
from luenberger.identification.settled_record import Evaluator, carried, doubled


def case(seed, n=3, p=2, cross=False, **more):
    """A plant, some of them unstable, and a record far from zero."""
    rng = np.random.default_rng(seed)
    radius = 1.05 if seed % 2 else 0.8
    plant = generators.plant(rng, n, p, m=1, cross=cross, radius=radius, **more)
    y, u = 100 + 3 * rng.normal(size=(600, p)), rng.normal(size=(600, 1))
    return plant, (y, u, rng.normal(size=1))


def settled_score(plant, records, fast=False):
    start = None if plant.P0 is None else plant
    return Evaluator(records, fast)(plant.at(0), start, names(plant))


def same(plant, records, fast=False, rel=1e-12):
    """Both ways, to the rounding of their terms."""
    y, u, u0 = (list(part) for part in zip(*records))
    wanted, slopes = lb.log_likelihood(
        plant, y, u, u0=u0, gradient=True, backend="numpy"
    )
    found, others = settled_score(plant, records, fast)
    assert found == pytest.approx(wanted, rel=rel)
    assert set(others) == set(slopes)
    for name, X in slopes.items():
        np.testing.assert_allclose(
            others[name], X, rtol=0, atol=100 * rel * abs(X).max()
        )


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("start", [None, False, True])
def test_it_is_the_likelihood_of_the_filter_row_by_row(seed, start):
    plant, record = case(seed, cross=seed // 2)
    more = {} if start is None else {"at_first": start, "x0": [1, -2, 3]}
    P0 = None if start is None else np.diag([4.0, 0, 1e6])
    plant = dataclasses.replace(plant, P0=P0, **more)
    # P0 of 1e6 costs covariances some digits, with a state that is known or without
    same(plant, [record], fast=bool(seed % 2), rel=1e-12 if start is None else 1e-11)


def test_several_records():
    plant, (y, u, u0) = case(5)
    same(plant, [(y, u, u0), (y[::-1][:560], u[:560], u0)])


@pytest.mark.parametrize("singular", [[0, 0], [1, 0]])
def test_perfect_outputs(singular):
    """An innovation needs a covariance, not its sensor."""
    plant, record = case(2)
    same(dataclasses.replace(plant, R=np.diag(singular), P0=None), [record])


@pytest.mark.parametrize("power", [-40, 40])
def test_units(power):
    plant, (y, u, u0) = case(1, P0=None)
    x, z = np.array([2.0**power, 1, 2.0 ** (power // 2)]), np.array([2.0**-power, 1])
    other = dataclasses.replace(
        plant, A=plant.A / x[:, None] * x, B=plant.B / x[:, None],
        C=plant.C / z[:, None] * x, E=plant.E / z[:, None],
        Q=plant.Q / x / x[:, None], R=plant.R / z / z[:, None],
    )  # fmt: skip
    one, slopes = settled_score(plant, [(y, u, u0)])
    two, others = settled_score(other, [(y / z, u, u0)])
    # the unknown start counts in the units of the state
    shift = 600 * np.log(z).sum() - np.log(x).sum()
    assert two - shift == pytest.approx(one, rel=1e-12)
    np.testing.assert_allclose(others["Q"] / x / x[:, None], slopes["Q"], rtol=1e-9)


def test_a_record_must_be_as_long_as_a_start_is_felt():
    """There both ways agree; with a row less nothing is said."""
    plant, (y, u, u0) = case(0, P0=None)
    rows = settled.settle(plant.at(0)).least
    same(plant, [(y[:rows], u[:rows], u0)])
    assert settled_score(plant, [(y[: rows - 1], u[: rows - 1], u0)]) is None


def test_what_does_not_settle_is_left_to_the_rows():
    plant, (y, u, u0) = case(0, P0=None)
    gap = y.copy()
    gap[7, 0] = np.nan
    assert settled_score(plant, [(gap, u, u0)]) is None
    walk = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[1]])
    none = np.zeros((600, 0))
    assert settled_score(walk, [(y[:, :1], none, u0[:0])]) is None
    twice = lb.Plant([[0.5]], None, [[1], [1]], dt=1.0, Q=[[1]], R=np.zeros((2, 2)))
    assert settled_score(twice, [(y, none, u0[:0])]) is None
    assert settled.settle(twice.at(0), np.array([[0.4, 0.1]])) is None
    sure = lb.Plant(
        [[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[0]], P0=[[0]], at_first=True
    )  # the first reading is known before
    assert settled_score(sure, [(y[:, :1], none, u0[:0])]) is None
    unseen = lb.Plant(np.diag([0.5, 0.4]), None, [[1, 0]], dt=1.0, Q=np.eye(2), R=[[1]])
    assert settled_score(unseen, [(y[:, :1], none, u0[:0])]) is None
    same(dataclasses.replace(unseen, P0=np.eye(2)), [(y[:, :1], none, u0[:0])])


def test_a_gain_to_begin_from_does_not_matter():
    plant, _ = case(1)
    first = settled.settle(plant.at(0))
    other = dataclasses.replace(plant, Q=9 * plant.Q)
    again = settled.settle(plant.at(0), settled.settle(other.at(0)).G)
    np.testing.assert_allclose(again.Omega, first.Omega, rtol=1e-13)
    assert settled.settle(plant.at(0), np.zeros((3, 2))) is None  # it is not stable


def test_rows_are_carried_on():
    """In whole numbers, with a matrix whose powers end and one whose do not."""
    rng = np.random.default_rng(0)
    for f in (np.array([[0, 2, 0], [0, 0, 1], [0, 0, 0.0]]), np.eye(3)):
        g, z = rng.integers(-9, 9, (20, 3)).astype(float), np.array([1.0, 2, 3])
        rows = [z]
        for one in g:
            rows.append(f @ rows[-1] + one)
        np.testing.assert_array_equal(carried(f, g, z, True), rows)
        np.testing.assert_array_equal(doubled(f, np.vstack([z, g])), rows)
