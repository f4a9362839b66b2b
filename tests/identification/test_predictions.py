"""Likelihoods of exact outputs in compiled code, held against exact rows in NumPy."""

import dataclasses

import generators
import numpy as np
import pytest
from as_python import as_python
from exact_likelihood import density, exact_moments, rational_plant

import luenberger as lb
from luenberger.recursion import filter_pass
from luenberger.recursion.state import step

nan = float("nan")


def case(seed, rows=120, R=(0, 1), cross=False, varying=False):
    """A plant with an exact output, and its record with gaps."""
    rng = np.random.default_rng(seed)
    plant = generators.plant(
        rng, 3, 2, m=1, cross=False, radius=1.02 if seed % 2 else 0.9
    )
    plant = dataclasses.replace(plant, R=np.diag(R))
    if cross:
        S = np.zeros((3, 2))
        S[:, 1] = [0.1, -0.2, 0.1]
        plant = dataclasses.replace(plant, S=S)
    y, u, u0 = generators.record(rng, plant, rows)
    y[rng.random(y.shape) < 0.2] = nan
    if varying:
        A = plant.A * rng.uniform(0.9, 1, (rows + 1, 1, 1))
        C = plant.C * rng.uniform(0.9, 1.1, (rows + 1, 1, 1))
        R = plant.R * rng.integers(0, 3, (rows + 1, 1, 1))
        plant = dataclasses.replace(plant, A=A, C=C, R=R, S=None)
    return plant, y, u, u0


@pytest.fixture
def python():
    """What is generated runs as Python."""
    with as_python():
        yield


def same(plant, y, u, u0, by_hand=None, within=1e-10):
    """Value and gradients, of generated code and in NumPy."""
    options = dict(u0=u0, gradient=True)
    wanted, slopes = lb.log_likelihood(plant, y, u, backend="numpy", **options)
    if by_hand is not None:
        by_hand.clear()  # what follows counts
    found, others = lb.log_likelihood(plant, y, u, backend="numba", **options)
    assert found == pytest.approx(wanted, rel=1e-12)
    for name, X in slopes.items():
        atol = within * max(abs(X).max(), 1e-300)
        np.testing.assert_allclose(others[name], X, rtol=0, atol=atol)


@pytest.fixture
def by_hand(monkeypatch):
    """How many rows NumPy did."""
    rows = []

    def counted(*args):
        rows.append(args)
        return step(*args)

    monkeypatch.setattr(filter_pass, "step", counted)
    return rows


@pytest.mark.usefixtures("python")
@pytest.mark.parametrize("varying", [False, True])
@pytest.mark.parametrize("start", [False, True, None])
@pytest.mark.parametrize(("R", "cross"), [((0, 0), False), ((0, 1), True)])
def test_exact_outputs_with_gaps(varying, start, R, cross, by_hand):
    plant, *record = case(1, R=R, cross=cross, varying=varying)
    more = {} if start is None else {"at_first": start}
    P0 = None if start is None else np.diag([4.0, 1, 9])
    same(dataclasses.replace(plant, P0=P0, **more), *record, by_hand)
    assert len(by_hand) < 5


def test_compiled_code_does_the_same():
    plant, *record = case(1, R=(0, 1), cross=True)
    same(plant, *record)


@pytest.mark.usefixtures("python")
def test_the_rows_are_those_of_rationals():
    """The density of the whole record, from its exact covariance."""
    for kind in ("perfect", "one perfect"):
        plant, y, u, u0 = rational_plant(kind)
        wanted, _ = density(*exact_moments(plant, y, u, u0))
        found = lb.log_likelihood(plant, y, u, u0=u0, backend="numba")
        assert found == pytest.approx(wanted, rel=1e-11)


@pytest.mark.usefixtures("python")
def test_rows_in_which_nothing_is_new_are_left_to_numpy(by_hand):
    """One sensor is read twice in some rows; compiled code goes on after them."""
    plant, y, u, u0 = case(2, R=(0, 0))
    C = np.broadcast_to(plant.C, (len(y) + 1, 2, 3)).copy()
    C[31::30, 1] = C[31::30, 0]
    plant = dataclasses.replace(plant, C=C, E=np.zeros((2, 1)))
    y[30::30, 1] = y[30::30, 0]
    same(plant, y, u, u0, by_hand)
    assert 3 <= len(by_hand) < 40


@pytest.mark.usefixtures("python")
def test_a_state_that_is_known_exactly_is_left_to_numpy(by_hand):
    """No noise drives one state for a while, and an exact reading tells it."""
    plant, y, u, u0 = case(4, R=(0, 0))
    plant = dataclasses.replace(plant, A=np.diag([0.9, 0.5, 0.8]), C=np.eye(3)[:2])
    Q = np.broadcast_to(np.eye(3), (len(y) + 1, 3, 3)).copy()
    Q[20:24, 0, 0] = 0
    plant = dataclasses.replace(plant, Q=Q)
    y, u, u0 = generators.record(np.random.default_rng(0), plant, len(y))
    y[::7, 1] = nan
    same(plant, y, u, u0, by_hand)
    assert 3 <= len(by_hand) < 60


@pytest.mark.usefixtures("python")
def test_a_contradiction_is_refused():
    plant, y, u, u0 = case(2, R=(0, 0))
    C = np.array([[1.0, 0, 1], [1, 0, 1]])
    plant = dataclasses.replace(plant, C=C, E=np.zeros((2, 1)))
    y[:, 1] = y[:, 0]
    y[50] = [1, 2]
    with pytest.raises(lb.DesignError, match="instant 51"):
        lb.log_likelihood(plant, y, u, u0=u0, backend="numba")


@pytest.mark.usefixtures("python")
@pytest.mark.parametrize("power", [-40, 40])
def test_units_only_add_a_constant(power):
    plant, y, u, u0 = case(3, R=(0, 1))
    x, z = np.array([2.0**power, 1, 2.0 ** (power // 2)]), np.array([2.0**-power, 1])
    other = dataclasses.replace(
        plant, A=plant.A / x[:, None] * x, B=plant.B / x[:, None],
        C=plant.C / z[:, None] * x, E=plant.E / z[:, None],
        Q=plant.Q / x / x[:, None], R=plant.R / z / z[:, None],
        P0=plant.P0 / x / x[:, None], x0=plant.x0 / x,
    )  # fmt: skip
    one = lb.log_likelihood(plant, y, u, u0=u0, backend="numba")
    two = lb.log_likelihood(other, y / z, u, u0=u0, backend="numba")
    shift = (~np.isnan(y) * np.log(z)).sum()
    assert two - shift == pytest.approx(one, rel=1e-12)


@pytest.mark.usefixtures("python")
def test_zero_readings_and_rows_without_any():
    plant, y, u, u0 = case(2, R=(0, 0))
    y[~np.isnan(y)] = 0
    y[40:60] = nan
    same(plant, y, 0 * u, u0)
    y[:] = nan
    assert lb.log_likelihood(plant, y, u, u0=u0, backend="numba") == 0


@pytest.mark.usefixtures("python")
def test_innovations_and_information_are_the_same():
    plant, y, u, u0 = case(1, rows=400, R=(0, 1))
    for run in (
        lambda backend: lb.innovations(plant, y, u, backend=backend),
        lambda backend: lb.information(
            plant, y, u, along=[{"Q": np.eye(3)}, {"A": np.eye(3)}], backend=backend
        ),
    ):
        found, wanted = run("numba"), run("numpy")
        np.testing.assert_allclose(found, wanted, rtol=1e-8, atol=1e-10)


@pytest.mark.usefixtures("python")
@pytest.mark.parametrize("backend", ["numpy", "numba"])
def test_growth_in_a_gap_is_refused(backend):
    """By compiled code as by NumPy, and a shorter gap by neither."""
    A = [[2.0, 0.3], [0.5, 1.5]]
    plant = lb.Plant(
        A, None, np.eye(2), dt=1.0, Q=np.eye(2), R=np.zeros((2, 2)), P0=np.eye(2)
    )
    y = np.random.default_rng(0).normal(size=(80, 2))
    y[10:18] = nan
    assert np.isfinite(lb.log_likelihood(plant, y, backend=backend))
    y[10:60] = nan
    with pytest.raises(lb.DesignError, match="too few digits"):
        lb.log_likelihood(plant, y, backend=backend)


@pytest.mark.usefixtures("python")
def test_sensors_that_are_nearly_the_same_are_left_to_numpy(by_hand):
    """What the second adds has few digits left in a covariance of both."""
    plant, y, u, u0 = case(2, rows=40, R=(0, 0))
    C = np.array([[1.0, 0, 1], [1, 3e-5, 1]])
    plant = dataclasses.replace(plant, C=C)
    y, u, u0 = generators.record(np.random.default_rng(0), plant, 40)
    y[5:9, 0] = nan
    wanted = lb.log_likelihood(plant, y, u, u0=u0, backend="numpy")
    by_hand.clear()
    found = lb.log_likelihood(plant, y, u, u0=u0, backend="numba")
    assert found == pytest.approx(wanted, rel=1e-12)
    assert len(by_hand) > 20
