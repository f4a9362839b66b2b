"""Rows of a state that is known exactly, beside rational arithmetic and NumPy."""

import dataclasses

import generators
import numpy as np
import pytest
from in_full import in_full

import luenberger as lb
from luenberger.recursion import filter_pass
from luenberger.recursion.known import Known, repeated
from luenberger.recursion.settings import Settings
from luenberger.recursion.state import start

pytest.importorskip("numba", reason="numba is an optional extra")

nan = float("nan")
KINDS = ["rank one", "silent", "rank one, one noisy"]


def problem(kind, rows=40, seed=5, last=0.5):
    """A plant whose state is told again and again, and a record with a gap.

    Readings are exact in floats, so that none contradicts the others.
    """
    rng = np.random.default_rng(seed)
    G = np.array([[5], [-3], [6]]) / 4 * (kind != "silent")
    A, (B, E) = np.eye(3, k=1), rng.integers(-4, 5, (2, 3, 1))
    A[2, 0] = last
    C, R = rng.integers(-4, 5, (2, 3)), np.zeros((2, 2))
    if kind == "rank one, one noisy":
        C, R = rng.integers(-4, 5, (3, 3)), np.diag([0, 0, 0.25])
    plant = lb.Plant(A, B, C, E[: len(C)], dt=1.0, Q=G @ G.T, R=R, P0=np.eye(3))
    x, u = rng.integers(-4, 5, 3) / 4, rng.integers(-8, 9, (rows + 1, 1)) / 8
    y = np.empty((rows, len(C)))
    for k in range(rows):
        x = A @ x + B @ u[k] + G[:, 0] * rng.integers(-8, 9) / 4
        noise = 2 * R.diagonal() * rng.integers(-4, 5) / 4
        y[k] = C @ x + plant.E @ u[k + 1] + noise
    y[20, 0] = nan
    return plant, y, u[1:], u[0]


def run(plant, y, u=None, backend="numba", **more):
    return in_full(plant, y, u, backend=backend, **more)


@pytest.mark.parametrize("kind", KINDS)
def test_rows_are_those_of_rationals(kind, form, by_hand):
    plant, y, u, u0 = problem(kind)
    x, P = generators.exact(plant, y, u, u0)
    found = run(plant, y, u, u0=u0)
    assert 20 in by_hand and len(by_hand) < 10
    assert generators.relative(found.x, x) < 1e-12
    np.testing.assert_allclose(found.P, P.astype(float), atol=1e-20)
    np.testing.assert_allclose(found.std[-5:], 0, atol=1e-13)


@pytest.mark.parametrize("kind", KINDS)
def test_gains_are_those_of_numpy(kind, plain):
    """As far as they can be told: by what they do to noise."""
    plant, y, u, u0 = problem(kind)
    found, wanted = (run(plant, y, u, one, u0=u0) for one in ("numba", "numpy"))
    shown = plant.C @ plant.Q
    np.testing.assert_allclose(found.K @ shown, wanted.K @ shown, atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_units_of_states_and_outputs_cost_no_digits(kind, plain, by_hand):
    plant, y, u, u0 = problem(kind)
    x, z = np.array([2.0**20, 1, 2.0**-20]), 2.0 ** np.array([-20, 20, 3])[: plant.p]
    other = dataclasses.replace(
        plant, A=plant.A / x[:, None] * x, B=plant.B / x[:, None],
        C=plant.C / z[:, None] * x, E=plant.E / z[:, None],
        Q=plant.Q / x / x[:, None], R=plant.R / z / z[:, None],
        P0=plant.P0 / x / x[:, None],
    )  # fmt: skip
    found, wanted = run(other, y / z, u, u0=u0), run(plant, y, u, u0=u0)
    assert len(by_hand) < 20
    assert generators.relative(found.x * x, wanted.x) < 1e-12


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("off", [1e-3, 1e-9])
def test_a_contradiction_is_numpys(kind, off, form):
    """With row and output; what is within the rounding of readings is none."""
    plant, y, u, u0 = problem(kind)
    y[31, 1] += off
    if off < 1e-6:
        found, wanted = (run(plant, y, u, one, u0=u0) for one in ("numba", "numpy"))
        np.testing.assert_allclose(found.x, wanted.x, atol=1e-12)
        return
    for backend in ("numpy", "numba"):
        with pytest.raises(lb.DesignError, match="at instant 32 the noise-free .*'y2'"):
            run(plant, y, u, backend, u0=u0)


@pytest.mark.parametrize("kind", KINDS)
def test_readings_of_zero(kind, plain, by_hand):
    plant, y, u, _ = problem(kind)
    found = run(plant, 0 * y[:20], 0 * u[:20])
    assert len(by_hand) < 6
    np.testing.assert_array_equal(found.x, np.zeros((20, 3)))


@pytest.mark.parametrize("kind", KINDS)
def test_chunks_change_no_bit(kind, plain):
    plant, y, u, u0 = problem(kind)
    whole = run(plant, y, u, u0=u0)
    for ends in ([1], [7, 8, 30], list(range(1, 40))):
        found = run(plant, y, u, u0=u0, parts=ends)
        for name in ("x", "std", "P", "K"):
            np.testing.assert_array_equal(getattr(found, name), getattr(whole, name))


def test_with_accurate_outputs(plain, by_hand):
    plant, y, u, u0 = problem("rank one")
    wanted = run(plant, y, u, "numpy", u0=u0)
    by_hand.clear()
    found = run(plant, y, u, u0=u0, m1=2)
    assert len(by_hand) < 10
    assert generators.relative(found.x, wanted.x) < 1e-12


def test_a_missing_output_is_noticed_where_nothing_is_known_before(form, by_hand):
    """No combination of outputs has to agree, so no other test sees it."""
    plant = lb.Plant(
        [[0.5, 0.25, 1], [0, 0.5, 1], [0, 0, 0]], None, np.eye(2, 3), dt=1.0,
        Q=np.diag([1.0, 1, 0]), R=np.zeros((2, 2)), P0=np.eye(3),
    )  # fmt: skip
    assert Known(Settings(plant, 0)).fixed.U.size == 0
    y = np.random.default_rng(0).normal(size=(12, 2))
    y[7, 1] = nan
    found, wanted = run(plant, y), run(plant, y, backend="numpy")
    assert 7 in by_hand
    np.testing.assert_allclose(found.x, wanted.x, atol=1e-13)
    np.testing.assert_allclose(found.P, wanted.P, atol=1e-13)


def test_rounding_that_would_grow_is_numpys(plain, by_hand):
    """The state is known, and rounding of it is not corrected by what is known."""
    plant, y, u, u0 = problem("silent", last=1.5)
    assert Known(Settings(plant, 0)).fixed is None
    run(plant, y, u, u0=u0)
    assert len(by_hand) > 30


def test_a_constant_that_is_known_stays(plain, by_hand):
    """No mode fades, and none grows."""
    plant = lb.Plant(
        np.eye(2), None, [[1, 1], [1, -1]], dt=1.0, Q=np.zeros((2, 2)),
        R=np.zeros((2, 2)), P0=np.eye(2),
    )  # fmt: skip
    found = run(plant, np.tile([[5.0, 1.0]], (30, 1)))
    assert len(by_hand) < 4
    np.testing.assert_allclose(found.x, np.tile([[3.0, 2.0]], (30, 1)), rtol=1e-15)


@pytest.mark.parametrize("kind", KINDS)
def test_behind_such_rows_a_state_is_that_of_numpy(kind, plain):
    """And the rounding that it has is at least as large, of the largest numbers met."""
    plant, y, u, u0 = problem(kind)
    way = filter_pass.Pass(Settings(plant, 0))
    begin = start(way.settings, plant.x0, u0)
    found, wanted = (way.over(begin, y[:19], u[:19], one)[0] for one in (True, False))
    assert found.instant == wanted.instant == 19
    for name in ("x", "u", "rho"):
        a, b = getattr(found, name), getattr(wanted, name)
        np.testing.assert_allclose(a, b, atol=1e-12)
    less, more = wanted.rounding.diagonal(), found.rounding.diagonal()
    assert (0.99 * less <= more).all() and (more <= 1e4 * less + 1e-40).all()


def test_steps_are_taken_two_by_two():
    rng = np.random.default_rng(0)
    A, Q, X = rng.normal(size=(3, 3, 3)) / 3
    for rows in range(9):
        wanted = X
        for _ in range(rows):
            wanted = A @ wanted @ A.T + Q
        np.testing.assert_allclose(repeated(A, Q, X, rows), wanted, rtol=1e-12)
