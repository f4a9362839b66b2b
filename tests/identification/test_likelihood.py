"""The likelihood of a record, against statsmodels, exact rationals and batches."""

import dataclasses
from contextlib import nullcontext

import generators
import numpy as np
import pytest
from as_python import as_python
from exact_likelihood import (
    KINDS,
    SCORED,
    beside_noises,
    density,
    direction,
    exact_moments,
    nile,
    rational_plant,
)

import luenberger as lb
from luenberger.identification import score

nan = float("nan")
BACKENDS = ("numpy", "numba")


@pytest.mark.parametrize("backend", BACKENDS)
def test_nile_with_a_wide_start(backend):
    """The local level with a prior variance of 10^7, the first year included."""
    plant = lb.Plant(
        [[1]], None, [[1]], dt=1.0, Q=[[1469.1]], R=[[15099.0]], P0=[[1e7]],
        at_first=True,
    )  # fmt: skip
    found = lb.log_likelihood(plant, nile(), backend=backend)
    assert round(found, 2) == -641.59
    first = lb.log_likelihood(plant, nile()[:1])
    assert round(found - first, 2) == -632.54  # the years after the first, given it


# -- against statsmodels ---------------------------------------------------------------


def statsmodels(plant, y):
    model, (mean, P) = beside_noises(plant, y)
    mean[: plant.n] = plant.A @ plant.x0
    P[: plant.n, : plant.n] = plant.A @ plant.P0 @ plant.A.T + plant.Q
    model.ssm.initialize_known(mean, P)
    return model.ssm.loglike()


def case(seed):
    """A random plant and its record, with gaps in two of three cases."""
    rng = np.random.default_rng(seed)
    n, p = rng.integers(1, 6), rng.integers(1, 4)
    plant = generators.plant(rng, n, p, m=0, cross=seed % 2, radius=rng.uniform(0.2, 1))
    y = generators.record(rng, plant, 40)[0]
    if seed % 3:
        y[rng.random(y.shape) < 0.25] = nan
    return plant, y


@pytest.mark.parametrize("seed", range(200))
def test_statsmodels_has_the_same_likelihood(seed):
    plant, y = case(seed)
    wanted = statsmodels(plant, y)
    assert lb.log_likelihood(plant, y) == pytest.approx(wanted, rel=1e-10)


@pytest.mark.parametrize("seed", range(3))
def test_compiled_code_has_the_same_likelihood_and_score(seed):
    plant, y = case(seed)
    wanted, slope = lb.log_likelihood(plant, y, gradient=True, backend="numpy")
    with as_python():
        found, other = lb.log_likelihood(plant, y, gradient=True, backend="numba")
        assert lb.log_likelihood(plant, y, backend="numba") == found
    assert found == pytest.approx(wanted, rel=1e-12)
    for name, X in slope.items():
        np.testing.assert_allclose(other[name], X, rtol=1e-9, atol=1e-9 * abs(X).max())


@pytest.mark.parametrize("n", [2, 8])
@pytest.mark.parametrize("start", [True, False])
def test_gradients_of_many_rows_with_gaps_are_added_up(n, start, monkeypatch):
    """More rows than compiled code adds up at a time, as scalars and as loops."""
    monkeypatch.setattr(score, "TOGETHER", 64)
    rng = np.random.default_rng(n)
    plant = generators.plant(rng, n, 2, m=1, cross=True, radius=0.9)
    y, u, u0 = generators.record(rng, plant, score.TOGETHER + 40)
    if not start:
        plant = dataclasses.replace(plant, P0=None)
    y[rng.random(y.shape) < 0.1] = nan
    options = dict(u0=u0, gradient=True)
    wanted, slopes = lb.log_likelihood(plant, y, u, backend="numpy", **options)
    with nullcontext() if n == 2 else as_python():
        found, others = lb.log_likelihood(plant, y, u, backend="numba", **options)
    assert found == pytest.approx(wanted, rel=1e-12)
    assert slopes.keys() == others.keys()
    for name, X in slopes.items():
        np.testing.assert_allclose(others[name], X, rtol=0, atol=1e-10 * abs(X).max())


# -- exactly ---------------------------------------------------------------------------


def exact(plant, y, u, u0, move=None):
    """The density of a whole record, with rationals, and its slope along `move`."""
    return density(*exact_moments(plant, y, u, u0, move))


@pytest.mark.parametrize("kind", KINDS)
def test_the_likelihood_is_the_density_of_the_record(kind):
    plant, *record = rational_plant(kind)
    y, u, u0 = record
    wanted, _ = exact(plant, *record)
    assert lb.log_likelihood(plant, y, u, u0=u0) == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize(("kind", "name"), SCORED)
def test_the_gradient_is_that_of_the_density(kind, name):
    plant, *record = rational_plant(kind)
    y, u, u0 = record
    D = direction(plant, name)
    _, wanted = exact(plant, *record, move={name: D})
    _, slope = lb.log_likelihood(plant, y, u, u0=u0, gradient=True)
    size = np.abs(slope[name] * D).sum()
    assert np.sum(slope[name] * D) == pytest.approx(wanted, abs=1e-11 * size)


@pytest.mark.parametrize("kind", ["perfect", "one perfect"])
def test_the_gradient_in_the_noise_of_a_perfect_output(kind):
    """It is that from the one side where it is not perfect."""
    plant, *record = rational_plant(kind)
    D = np.zeros((plant.p, plant.p))
    D[0, 0] = 1
    _, wanted = exact(plant, *record, move={"R": D})
    _, slope = lb.log_likelihood(plant, *record[:2], u0=record[2], gradient=True)
    assert slope["R"][0, 0] == pytest.approx(wanted, rel=1e-11)


def test_a_varying_plant_has_a_gradient_at_each_instant():
    rng = np.random.default_rng(5)
    plant = generators.varying(rng, 2, 1, 3, m=1)
    plant = dataclasses.replace(
        plant, **{k: np.round(getattr(plant, k), 2) for k in ("A", "B", "C", "E")}
    )
    y, u, u0 = generators.record(rng, plant, 3)
    with as_python():
        numpy, numba = (
            lb.log_likelihood(plant, y, u, u0=u0, gradient=True, backend=backend)[1]
            for backend in BACKENDS
        )
    for name in ("A", "B", "C", "E", "Q", "R", "S"):
        shape = getattr(plant, name).shape
        D = rng.integers(-2, 3, shape).astype(float)
        D = D + D.mT if name in "QR" else D
        _, wanted = exact(plant, y, u, u0, {name: D})
        for slope in (numpy[name], numba[name]):
            assert slope.shape == shape
            size = np.abs(slope * D).sum()
            assert np.sum(slope * D) == pytest.approx(wanted, abs=1e-9 * size)


# -- records ---------------------------------------------------------------------------


def test_records_of_one_plant_multiply():
    plant, y, u, u0 = rational_plant("two")
    one = lb.log_likelihood(plant, y, u, u0=u0, gradient=True)
    other = lb.log_likelihood(plant, y[:2], u[:2], gradient=True)
    both, slope = lb.log_likelihood(
        plant, [y, y[:2]], [u, u[:2]], u0=[u0, [0]], gradient=True
    )
    assert both == pytest.approx(one[0] + other[0], rel=1e-14)
    for name, X in slope.items():
        np.testing.assert_allclose(X, one[1][name] + other[1][name], rtol=1e-12)


def test_what_is_not_measured_says_nothing():
    plant, y, u, u0 = rational_plant("two")
    value, slope = lb.log_likelihood(plant, np.full_like(y, nan), u, gradient=True)
    assert value == 0 and all(not X.any() for X in slope.values())
    assert lb.log_likelihood(plant, y[:0], u[:0]) == 0


def test_names_of_columns():
    import pandas as pd

    plant, y, u, _ = rational_plant("two")
    table = pd.DataFrame({"u1": u[:, 0], "y2": y[:, 1], "y1": y[:, 0]})
    assert lb.log_likelihood(plant, table) == lb.log_likelihood(plant, y, u)
    assert lb.log_likelihood(plant, [table]) == lb.log_likelihood(plant, y, u)


def test_accurate_outputs_are_those_without_noise():
    plant, y, u, _ = rational_plant("one perfect")
    assert lb.log_likelihood(plant, y, u, m1=1) == lb.log_likelihood(plant, y, u)
    with pytest.raises(lb.DesignError, match="'y2' is noisy.*not white"):
        lb.log_likelihood(plant, y, u, m1=2)


def test_an_impossible_record_is_refused():
    plant, y, u, _ = rational_plant("determined")
    y = y.copy()
    y[2, 1] += 1
    with pytest.raises(lb.DesignError, match="instant 3"):
        lb.log_likelihood(plant, y, u)


def test_a_list_of_records_needs_a_list_of_inputs():
    plant, y, u, _ = rational_plant("two")
    with pytest.raises(ValueError, match="u must be a list as long"):
        lb.log_likelihood(plant, [y, y], u)


@pytest.mark.parametrize("power", [-40, 40])
@pytest.mark.parametrize("kind", ["two", "one perfect"])
def test_units_of_outputs_only_add_a_constant(kind, power):
    plant, y, u, u0 = rational_plant(kind)
    wanted = lb.log_likelihood(plant, y, u, u0=u0)
    unit = np.array([2.0**power, 1])
    other = dataclasses.replace(
        plant, C=plant.C * unit[:, None], E=plant.E * unit[:, None],
        R=plant.R * unit * unit[:, None],
        S=None if plant.S is None else plant.S * unit,
    )  # fmt: skip
    found = lb.log_likelihood(other, y * unit, u, u0=u0)
    assert found + 4 * power * np.log(2) == pytest.approx(wanted, rel=1e-12)


# -- many records ----------------------------------------------------------------------


@pytest.fixture(params=["numpy", "python"])
def backend(request):
    """NumPy, or generated code as Python."""
    with as_python() if request.param == "python" else nullcontext():
        yield "numpy" if request.param == "numpy" else "numba"


@pytest.fixture(scope="module")
def fleet():
    rng = np.random.default_rng(8)
    plant = generators.plant(rng, 3, 2, m=1)
    y, u = rng.standard_normal((5, 30, 2)), rng.standard_normal((5, 30, 1))
    y[1, 3:6, 0] = y[2, 15:] = y[3] = np.nan  # a gap; ends earlier; never measured
    return plant, y, u


def test_an_array_of_records_is_a_list_of_them(fleet, backend):
    plant, y, u = fleet
    one, slope = lb.log_likelihood(plant, y, u, gradient=True, backend=backend)
    two, same = lb.log_likelihood(
        plant, list(y), list(u), gradient=True, backend=backend
    )
    assert one == two
    for name in slope:
        np.testing.assert_array_equal(slope[name], same[name])
    shared = lb.log_likelihood(plant, y, u[0], backend=backend)
    assert shared == lb.log_likelihood(plant, list(y), [u[0]] * 5, backend=backend)


@pytest.mark.parametrize("unknown", [False, True])
def test_each_record_has_its_value(fleet, unknown):
    plant, y, u = fleet
    if unknown:
        plant, y, u = dataclasses.replace(plant, P0=None), y[:3], u[:3]
    values, slopes = lb.log_likelihood(plant, y, u, each=True, gradient=True)
    assert values.shape == (len(y),)
    for k in range(len(y)):
        wanted, slope = lb.log_likelihood(plant, y[k], u[k], gradient=True)
        np.testing.assert_allclose(values[k], wanted, rtol=1e-12)
        for name in slope:
            np.testing.assert_allclose(slopes[name][k], slope[name], rtol=1e-9, atol=0)
    whole = lb.log_likelihood(plant, y, u)
    np.testing.assert_allclose(values.sum(), whole, rtol=1e-12)
    np.testing.assert_array_equal(lb.log_likelihood(plant, y, u, each=True), values)
    assert unknown or values[3] == 0
    assert lb.log_likelihood(plant, y[0], u[0], each=True).shape == (1,)


def test_a_record_that_is_refused_is_named(fleet):
    plant, y, u = fleet
    bad = np.array(y)
    bad[4, 2, 1] = np.inf
    with pytest.raises(ValueError, match="record 4: y is infinite in row 2"):
        lb.log_likelihood(plant, bad, u)
    with pytest.raises(ValueError, match=r"u must be \(5, 30, m\), or \(30, m\)"):
        lb.log_likelihood(plant, y, u[:, :3])
    exact = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[0]], P0=[[1]])
    said = "record 1: .*instant 2"
    for how in ({}, {"each": True}):
        with pytest.raises(lb.DesignError, match=said):
            lb.log_likelihood(exact, np.array([[[1.0], [1]], [[1], [2]]]), **how)
