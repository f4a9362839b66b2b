"""Kernels compute the formulas they were compiled from, and refuse false ones."""

import numpy as np
import pytest
import sympy as sp
from exact_stages import exact_inputs, exact_step, kernel
from own_stages import own
from worlds import STAGE_LISTS

from luenberger.kernels.text import numpy_source
from luenberger.papers.leondes_novak import derivation as recursions
from matrixproof import Derivation, Stage


@pytest.mark.parametrize("flat", [False, True], ids=["stacks", "flat"])
@pytest.mark.parametrize("name", STAGE_LISTS)
def test_kernel_agrees_with_exact_arithmetic(name, flat):
    derivation = getattr(recursions, name)()
    values = exact_inputs(derivation, np.random.default_rng(8))
    step = kernel(derivation, flat=flat)
    found = step(
        **{key: np.array(values[key].tolist(), dtype=float) for key in step.given}
    )
    wanted = exact_step(derivation, values)
    assert set(found) == set(wanted)
    for target, value in wanted.items():
        value = np.array(value.tolist(), dtype=float)
        scale = np.abs(value).max()
        np.testing.assert_allclose(
            found[target], value, rtol=0, atol=1e-12 * scale, err_msg=target
        )


@pytest.mark.parametrize("name", STAGE_LISTS)
def test_leading_axes_broadcast(name):
    derivation = getattr(recursions, name)()
    rng = np.random.default_rng(3)
    step = kernel(derivation)
    one, two = (
        {k: np.array(v.tolist(), dtype=float) for k, v in given.items()}
        for given in (exact_inputs(derivation, rng), exact_inputs(derivation, rng))
    )
    both = step(**{k: np.stack([one[k], two[k]]) for k in step.given})
    for k, given in enumerate((one, two)):
        alone = step(**{key: given[key] for key in step.given})
        for target, value in alone.items():
            np.testing.assert_allclose(both[target][k], value, rtol=1e-12, atol=1e-12)


def test_only_the_stages_that_are_asked_for_are_kept():
    derivation = recursions.gain_step()
    given, source = numpy_source(derivation, ("M",))
    assert "Kmv" not in source and "Gamma" not in given
    with pytest.raises(KeyError, match="no stage assigns"):
        numpy_source(derivation, ("Psi",))


def false_derivation(steps):
    X = sp.MatrixSymbol("X", 2, 2)
    Y = sp.MatrixSymbol("Y", 2, 2)
    return Derivation((X,), (Stage(Y, 2 * X),), steps=steps, source="nowhere")


@pytest.mark.parametrize(
    "steps", [{}, {"2 X = 3 X": sp.Matrix([[1]])}], ids=["no steps", "a false step"]
)
def test_kernel_refuses_what_is_not_proved(steps):
    with pytest.raises(AssertionError, match="unproved derivation: nowhere"):
        kernel(false_derivation(steps))


def test_an_inverse_has_no_numpy_form():
    X = sp.MatrixSymbol("X", 2, 2)
    bad = own((X,), Stage(sp.MatrixSymbol("Y", 2, 2), X.I))
    with pytest.raises(TypeError, match="write an inverse as Solve"):
        numpy_source(bad)


@pytest.mark.parametrize("name", STAGE_LISTS)
def test_symmetric_stages_come_out_symmetric_to_the_last_bit(name):
    derivation = getattr(recursions, name)()
    given = exact_inputs(derivation, np.random.default_rng(5))
    step = kernel(derivation)
    found = step(**{k: np.array(given[k].tolist(), dtype=float) for k in step.given})
    for stage in derivation.stages:
        if stage.symmetric:
            value = found[stage.target.name]
            np.testing.assert_array_equal(value, value.T, err_msg=stage.target.name)
