"""The expected information, against whole records in rationals and against chance."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from exact_likelihood import (
    direction,
    exact_moments,
    free_moments,
    inverse,
    rational_plant,
)

import luenberger as lb
from luenberger.identification import few_rows

nan = float("nan")
ALONG = {
    "S": ("A", "C", "S", "P0"),
    "prior": ("B", "E", "R", "x0", "P0"),
    "singular A": ("A", "Q", "x0"),
    "gaps": ("B", "C", "E", "R"),
    "one perfect": ("C", "Q"),
    "determined": ("A", "Q", "x0"),
}


def way(plant, name):
    """A direction in one matrix."""
    D = direction(plant, name)
    return {name: D + (not D.any())}


def same(found, wanted, within):
    """Whether informations are the same, as parts of what they are on the diagonal."""
    size = np.sqrt(np.diagonal(wanted))
    return (np.abs(found - wanted) <= within * size * size[:, None]).all()


def gaussian(changes, W):
    """1/2 tr(W dV W dV) and dmean' W dmean, of all pairs; W is the inverse of V."""
    both = [(W @ dV, W @ dd, dd) for dV, dd in changes]
    found = [
        [(a[0] * b[0].T).sum() / 2 + (a[2].T @ b[1])[0, 0] for b in both] for a in both
    ]
    return np.array(found, dtype=float)


@pytest.mark.parametrize(("kind", "names"), ALONG.items(), ids=list(ALONG))
def test_it_is_that_of_the_whole_record(kind, names):
    """Of its covariance and mean, entry by entry, in rational arithmetic."""
    plant, y, u, u0 = rational_plant(kind)
    changes = []
    for name in names:
        moments = exact_moments(plant, y, u, u0, way(plant, name))
        V, d = free_moments(*moments)
        changes.append((V.dX, d.dX))
    wanted = gaussian(changes, inverse(V.X)[0])
    along = [way(plant, name) for name in names]
    found = lb.information(plant, y, u, u0=u0, along=along)
    assert same(found, wanted, 1e-11) and wanted.diagonal().all()


# -- a start that is not known ---------------------------------------------------------


def whole(plant, u, seen):
    """Mean, covariance and columns of the start of all that was read, from x[1] = 0."""
    n, p = plant.n, plant.p
    noise = np.block([[plant.Q, plant.S], [plant.S.T, plant.R]])
    size = len(seen) * (n + p)
    start, shift, moved = np.eye(n), np.zeros(n), np.zeros((n, size))
    rows, means, columns = [], [], []
    for k, here in enumerate(seen):
        w = np.eye(size)[k * (n + p) : (k + 1) * (n + p)]
        rows.append((plant.C @ moved + w[n:])[here])
        means.append((plant.C @ shift + plant.E @ u[k])[here])
        columns.append((plant.C @ start)[here])
        moved, start = plant.A @ moved + w[:n], plant.A @ start
        shift = plant.A @ shift + plant.B @ u[k]
    Y = np.vstack(rows)
    return (
        np.concatenate(means),
        Y @ np.kron(np.eye(len(seen)), noise) @ Y.T,
        np.vstack(columns),
    )


@pytest.mark.parametrize("seed", range(4))
def test_without_a_start_it_is_that_of_the_contrasts(seed):
    """1/2 tr(P dV P dV) + dm' P dm, with P that is blind to the start.

    That is the restricted likelihood's.  The first rows may have more readings than
    the state, and what an input does to those counts.
    """
    plant, y, u = unknown_start(seed)
    seen = ~np.isnan(y)
    along = [way(plant, name) for name in "BEQRS"]
    _, V, X = whole(plant, u, seen)
    W = np.linalg.inv(V)
    P = W - W @ X @ np.linalg.solve(X.T @ W @ X, X.T @ W)
    none = {name: 0 * getattr(plant, name) for name in "BEQRS"}
    moves = [whole(changed(plant, **none | one), u, seen)[:2] for one in along]
    wanted = [
        [0.5 * np.trace(P @ dV @ P @ dW) + dm @ P @ dn for dn, dW in moves]
        for dm, dV in moves
    ]
    assert same(lb.information(plant, y, u, along=along), wanted, 1e-9)


def changed(plant, **matrices):
    """A plant with other matrices, which need not be covariances."""
    return SimpleNamespace(**{k: getattr(plant, k) for k in "ABCEQRSnp"} | matrices)


def unknown_start(seed):
    """A plant without P0, and a record, with gaps for odd seeds."""
    rng = np.random.default_rng(seed)
    n, p, m, N = 2, (1, 1, 3, 3)[seed], 1, 8
    A, B, C, E = (rng.normal(size=s) for s in ((n, n), (n, m), (p, n), (p, m)))
    J = rng.normal(size=(n + p, n + p))
    J = J @ J.T + 0.1 * np.eye(n + p)
    plant = lb.Plant(A, B, C, E, dt=1.0, Q=J[:n, :n], R=J[n:, n:], S=J[:n, n:])
    y, u = rng.normal(size=(N, p)), rng.normal(size=(N, m))
    if seed % 2:
        y[1, 0] = y[4] = nan
    return plant, y, u


def test_without_a_start_moving_outputs_are_conditional_on_the_first_readings():
    """Readings 1 and 2 determine the state; the others, given those, by differences."""
    plant, y, u = unknown_start(0)
    n, seen = plant.n, ~np.isnan(y)

    def given(one, t):
        moved = {name: getattr(plant, name) + t * X for name, X in one.items()}
        mean, V, X = whole(changed(plant, **moved), u, seen)
        L = X[n:] @ np.linalg.inv(X[:n])
        H = np.hstack([-L, np.eye(len(y) - n)])
        return mean[n:] + L @ (y[:n, 0] - mean[:n]), H @ V @ H.T

    along = [way(plant, name) for name in "ABCEQRS"]
    h = 1e-6
    pairs = [zip(given(one, h), given(one, -h)) for one in along]
    changes = [[(a - b) / (2 * h) for a, b in pair] for pair in pairs]
    changes = [(dV, dm[:, None]) for dm, dV in changes]
    wanted = gaussian(changes, np.linalg.inv(given({}, 0)[1]))
    assert same(lb.information(plant, y, u, along=along), wanted, 1e-6)


def test_slopes_of_records_have_it_as_their_covariance():
    """The mean of their products over 100 records, within four of its errors."""
    rng = np.random.default_rng(4)
    plant = lb.Plant([[0.8]], None, [[1]], dt=1.0, Q=[[1.0]], R=[[0.5]])
    gaps = np.ones((40, 1))
    gaps[4:9] = nan
    slopes = []
    for _ in range(100):
        x, y = rng.normal(), np.empty((40, 1))
        for k in range(40):
            y[k] = x + np.sqrt(0.5) * rng.normal()
            x = 0.8 * x + rng.normal()
        _, slope = lb.log_likelihood(plant, y * gaps, gradient=True)
        slopes.append([slope["Q"][0, 0], slope["R"][0, 0]])
    products = np.array([np.outer(s, s) for s in slopes])
    error = products.std(axis=0) / np.sqrt(len(slopes))
    found = lb.information(plant, gaps, along=[{"Q": [[1]]}, {"R": [[1]]}])
    assert (np.abs(products.mean(axis=0) - found) < 4 * error).all()
    assert (error < 0.3 * found).all()


# -- long records ----------------------------------------------------------------------


@pytest.mark.parametrize("start", ["known", "unknown"])
def test_rows_of_a_settled_filter_are_counted(start, monkeypatch):
    """As many as there are; row by row they give the same."""
    rng = np.random.default_rng(1)
    A, C = np.array([[0.97, 0.2], [0, 0.7]]), np.array([[1.0, 0.5]])
    P0 = dict(P0=np.eye(2)) if start == "known" else {}
    plant = lb.Plant(A, np.ones((2, 1)), C, dt=1.0, Q=np.eye(2), R=[[1.0]], **P0)
    y, u = rng.normal(size=(2500, 1)), rng.normal(size=(2500, 1))
    along = [way(plant, name) for name in "ABCQR"]
    found = lb.information(plant, y, u, along=along)
    monkeypatch.setattr(few_rows, "STILL", -1.0)
    wanted = lb.information(plant, y, u, along=along)
    assert same(found, wanted, 1e-10) and wanted.diagonal().all()


def test_plants_that_vary_are_followed():
    """A constant plant written over time has the same information."""
    plant, y, u = unknown_start(3)
    long = {k: np.repeat(getattr(plant, k)[None], 9, axis=0) for k in "ABCEQR"}
    varying = dataclasses.replace(plant, **long)
    along = [way(plant, name) for name in "ABCEQRS"]
    wanted = lb.information(plant, y, u, along=along)
    np.testing.assert_allclose(
        lb.information(varying, y, u, along=along), wanted, rtol=1e-9
    )
    R, each = way(plant, "R")["R"], np.eye(9)[1:, :, None, None]
    found = lb.information(varying, y, u, along=[{"R": one * R} for one in each])
    assert found.sum() == pytest.approx(wanted[5, 5]) and found[-1, -1] > 0


@pytest.mark.parametrize("power", [-40, 40])
def test_units_only_scale_it(power):
    plant, y, u = unknown_start(2)
    unit = np.array([2.0**power, 1, 1])
    other = dataclasses.replace(
        plant, C=plant.C * unit[:, None], E=plant.E * unit[:, None],
        R=plant.R * unit * unit[:, None], S=plant.S * unit,
    )  # fmt: skip
    R = np.diag([1.0, 0, 0])
    Q = {"Q": np.eye(2)}
    found = lb.information(other, y * unit, u, along=[{"R": R * unit[0] ** 2}, Q])
    wanted = lb.information(plant, y, u, along=[{"R": R}, Q])
    np.testing.assert_allclose(found, wanted, rtol=1e-9)


def test_records_add_up_and_no_direction_is_nothing():
    plant, y, u = unknown_start(2)
    along = [{"Q": np.eye(2)}]
    one, other = (lb.information(plant, y[:k], u[:k], along=along) for k in (8, 5))
    both = lb.information(plant, [y, y[:5]], [u, u[:5]], along=along)
    np.testing.assert_allclose(both, one + other, rtol=1e-12)
    assert lb.information(plant, y, u, along=[]).shape == (0, 0)


@pytest.mark.parametrize(
    ("along", "message"),
    [
        ([{"T": 1}], "must be a dict of changes.*number 0"),
        ([{}, {"Q": [[1.0]]}], r"change of Q in direction 1.*shape \(1, 1\)"),
        ([{"Q": [[0, 1.0], [0, 0]]}], "not symmetric.*mirror image"),
        ([{"A": [[nan, 1], [0, 0]]}], "not finite"),
        ([{"P0": np.eye(2)}], "has no P0"),
    ],
)
def test_a_direction_that_is_none_is_refused(along, message):
    plant, y, u = unknown_start(0)
    with pytest.raises(ValueError, match=message):
        lb.information(plant, y, u, along=along)
