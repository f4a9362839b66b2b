"""Accurate outputs that have noise, while C changes: rows of compiled code."""

import generators
import numpy as np
import pytest
from every_pair import every_pair
from generators import holes
from in_full import in_full

import luenberger as lb
from luenberger.numeric.linalg import complete
from luenberger.recursion.pushes import pushes
from luenberger.recursion.settings import Settings

WEIGHTS = {"none": None, "given": np.diag([1.0, 2, 3, 4]), "canonical": "canonical"}


def filtered(plant, y, u, **options):
    return [
        in_full(plant, y, u, backend=backend, **options)
        for backend in ("numba", "numpy")
    ]


def agree(found, wanted, tol=1e-11):
    for name in ("x", "std", "P", "K"):
        a, b = getattr(found, name), getattr(wanted, name)
        assert generators.relative(a, b) < tol, name


def changed(plant, **matrices):
    names = "A", "B", "C", "E", "Q", "R", "P0", "x0"
    return lb.Plant(**{k: getattr(plant, k) for k in names} | matrices, dt=1.0)


@pytest.fixture
def made(monkeypatch):
    """The instants at which a setting is made, from now on."""
    instants, make = [], Settings._make
    monkeypatch.setattr(
        Settings,
        "_make",
        lambda self, i, seen: instants.append(i) or make(self, i, seen),
    )
    return instants


@every_pair(weight=[*WEIGHTS], m1=[1, [0, 2], 3], gaps=[False, True])
def test_rows_are_those_of_numpy(gaps, m1, weight, plain, made):
    rng, N = np.random.default_rng(7), 60
    plant = generators.varying(rng, 4, 3, N, m=1, cross=False)
    y, u, u0 = generators.record(rng, plant, N)
    y = holes(rng, y, 0.05) if gaps else y
    given = dict(m1=m1, u0=u0, weight=WEIGHTS[weight])
    found, wanted = filtered(plant, y, u, **given)
    agree(found, wanted)
    made.clear()
    in_full(plant, y, u, backend="numba", **given)
    assert len(made) < 20  # a few kinds of rows, not each


@pytest.mark.parametrize("rank", [0, 1, 2])
def test_singular_process_noise(rank, plain):
    rng, N = np.random.default_rng(rank), 40
    plant = generators.varying(rng, 4, 3, N, m=1, cross=False)
    H = rng.normal(size=(4, rank))
    plant = changed(plant, Q=H @ H.T)
    y, u, _ = generators.record(rng, plant, N)
    agree(*filtered(plant, holes(rng, y), u, m1=[0, 2]), 1e-9)


def test_rows_do_not_hang_on_the_chunks(plain):
    rng, N = np.random.default_rng(2), 60
    plant = generators.varying(rng, 4, 3, N, m=1, cross=False)
    y, u, _ = generators.record(rng, plant, N)
    y = holes(rng, y)
    whole, _ = filtered(plant, y, u, m1=2)
    parts = in_full(plant, y, u, m1=2, backend="numba", parts=[*range(9, 60, 9)])
    np.testing.assert_allclose(parts.x, whole.x, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_units_of_states_and_outputs(unit, plain):
    rng, N = np.random.default_rng(3), 30
    plant = generators.varying(rng, 4, 3, N, m=1, cross=False)
    y, u, _ = generators.record(rng, plant, N)
    states = unit ** np.array([1.0, 0, 0.5, 1])
    outputs = unit ** np.array([0.0, 1, 1])
    T, S = np.diag(states), np.diag(outputs)
    other = lb.Plant(
        T @ plant.A / states, T @ plant.B, S @ plant.C / states, S @ plant.E, dt=1.0,
        Q=T @ plant.Q @ T, R=S @ plant.R @ S, P0=T @ plant.P0 @ T, x0=T @ plant.x0,
    )  # fmt: skip
    weight = np.diag(1 / states**2)  # the same observer in other units
    found, wanted = filtered(other, y * outputs, u, m1=2, weight=weight)
    agree(found, wanted, 1e-9)
    plainly, _ = filtered(plant, y, u, m1=2)
    np.testing.assert_allclose(found.std / states, plainly.std, rtol=1e-9)


def test_outputs_that_depend_on_each_other_at_one_instant(plain):
    """It is refused, unless one of them did not arrive there."""
    rng, N = np.random.default_rng(4), 30
    plant = generators.varying(rng, 4, 3, N, m=1, cross=False)
    C = plant.C.copy()
    C[12, 1] = 2 * C[12, 0]
    plant = changed(plant, C=C)
    y, u, _ = generators.record(rng, plant, N)
    for backend in ("numpy", "numba"):
        with pytest.raises(lb.DesignError, match="dependent"):
            in_full(plant, y, u, m1=2, backend=backend)
    y[11, 1] = np.nan
    agree(*filtered(plant, y, u, m1=2))


def test_outputs_that_all_but_depend_on_each_other(made):
    """Their push is that of one instant by itself."""
    rng = np.random.default_rng(5)
    plant = generators.varying(rng, 4, 3, 9, m=0, cross=False)
    C = plant.C.copy()
    C[6, 1] = C[6, 0] * (1 + 1e-8 * np.arange(4))
    settings = Settings(changed(plant, C=C), 2)
    instants = np.arange(3, 9)
    found = pushes(settings, C[instants], np.ones(3, dtype=bool), instants)
    assert made == [6]
    for gamma, one in zip(found, C[instants]):
        wanted = complete(one[:2])[1]
        np.testing.assert_allclose(
            gamma[:, :2], wanted, rtol=0, atol=1e-13 * np.abs(wanted).max() ** 2
        )
        assert not gamma[:, 2].any()
