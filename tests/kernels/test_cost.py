"""What a program is said to cost is what it does, counted while it runs."""

import re
from operator import add, mul, sub, truediv

import numpy as np
import pytest

from luenberger.kernels import cost, numba, scalars
from luenberger.kernels.loops import arrays, write, write_definite
from luenberger.kernels.lowering import lower
from luenberger.kernels.program import Cost, Factor
from luenberger.papers.leondes_novak.derivation import (
    arrived,
    filter_step,
    observer_matrices,
    steady_gradient,
    step_differential,
)

SIZES = {"n": 4, "p": 2, "m": 1, "r": 3}
LARGE = SIZES | {"n": 20, "p": 8}  # whose factors and rows are not written out
LISTS = {
    "filter step": (filter_step, dict(symmetric=("Q", "R", "Sigma"))),
    "beside": (filter_step, dict(definite=[Factor("Sigma_next", 1e-9, "Omega")])),
    "definite": (filter_step, dict(definite=[Factor("Sigma_next", 0.0)])),
    "observer": (observer_matrices, {}),
    "differential": (step_differential, {}),
    "gradient": (steady_gradient, {}),  # a product with a factor of 2
    "arrived": (arrived, {}),
}
NUMBER = re.compile(r"(?<![\w.+-])\d|(?<!e)-\d")


class Counted:
    """A number that counts what is done with it."""

    done = 0

    def __init__(self, value):
        self.value = value

    def __neg__(self):
        return Counted(-self.value)

    def __gt__(self, other):
        Counted.done += 1
        return self.value > getattr(other, "value", other)


def counting(operation, swapped):
    def method(self, other):
        Counted.done += 1
        two = self.value, getattr(other, "value", other)
        return Counted(operation(*two[:: -1 if swapped else 1]))

    return method


for name, operation in dict(add=add, sub=sub, mul=mul, truediv=truediv).items():
    setattr(Counted, f"__{name}__", counting(operation, False))
    setattr(Counted, f"__r{name}__", counting(operation, True))


def given(program, sizes):
    """Matrices of counted numbers; those that are symmetric are definite."""
    rng, out = np.random.default_rng(5), {}
    for name in program.given:
        X = rng.normal(size=program.shape(name, sizes))
        if name in ("Q", "R", "Sigma", "M", "R_all", "Q_all", "Inverse", "Seen"):
            X = X @ X.T + np.eye(len(X))
        out[name] = np.vectorize(Counted, otypes=[object])(X)
    return out


@pytest.mark.parametrize("sizes", [SIZES, LARGE], ids=["small", "large"])
@pytest.mark.parametrize(("stages", "options"), LISTS.values(), ids=LISTS)
def test_operations_of_loops_are_those_that_are_done(stages, options, sizes):
    program = lower(stages(), **options)
    matrices, to = given(program, sizes), numba.Python(1)
    to.turns = to.has_blas = False  # as in C
    lengths = arrays(program, sizes, to)
    for name, length in lengths.items():
        to.let(name, f"np.zeros({length}, dtype=object)")
    to.let("ok", "True")
    write(program, sizes, to)
    write_definite(program, sizes, to)
    space = {"np": np}
    exec("\n".join([f"def step({', '.join(matrices)}):", *to.lines]), space)
    Counted.done = 0
    space["step"](**{k: X.ravel() for k, X in matrices.items()})
    found = cost.loops(program, sizes, {name: None for name in program.given[:2]})
    assert found.operations == Counted.done
    assert found.stack == sum(lengths.values())
    assert found.constants == sum(matrices[name].size for name in program.given[:2])


@pytest.mark.parametrize(("stages", "options"), LISTS.values(), ids=LISTS)
def test_operations_of_scalars_are_those_that_are_done(stages, options):
    program = lower(stages(), **options)
    matrices = given(program, SIZES)
    known = {"C": (np.arange(8.0).reshape(2, 4) - 3).tolist()}  # a 0 and ones, too
    straight = scalars.unroll(program, SIZES, known)
    space = {
        entry: matrices[name][i, j]
        for name, entries in straight.given.items()
        for i, j, entry in entries
    }
    Counted.done = 0
    for one in straight.statements:
        value = eval(one.text, {}, space)
        assert one.reads <= set(space), one.text
        if isinstance(one, scalars.Let):
            space[one.name] = value
    assert straight.cost.operations == Counted.done
    texts = " ".join(one.text for one in straight.statements)
    assert straight.cost.constants == len(NUMBER.findall(texts))
    assert straight.cost.stack == len(straight.used & set(space))


def test_a_device_gets_the_form_that_does_less_work():
    """Scalars while they are few, or where loops would mostly multiply zeros."""
    program = lower(observer_matrices(), ["F"])
    dense = program.cost({"r": 6, "n": 6})
    assert dense == cost.loops(program, {"r": 6, "n": 6})
    shift = {"As": np.eye(6, k=1).tolist(), "Phat": np.eye(6).tolist()}
    assert program.cost({"r": 6, "n": 6}, shift) == Cost(stack=30)  # T_next, moved
    sizes, dense = {"r": 11, "n": 11}, np.random.default_rng(1).random((11, 11))
    for half, loops in ((dense, True), (np.triu(dense), False)):
        known = {"As": (0.5 * np.eye(11)).tolist(), "Phat": half.tolist()}
        found = program.cost(sizes, known)
        assert found.operations > cost.SHORT
        assert (found == cost.loops(program, sizes, known)) == loops
    few = program.cost({"r": 2, "n": 2})
    assert few.operations == 2 * 2 * 3 * 2 and few.terms == 2 * 2 * 2 * 2
