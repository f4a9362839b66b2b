"""Loops over rows: what they ask memory for ahead, and what they write in place."""

from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
import sympy as sp
from own_stages import own

from luenberger.kernels import Recursion, numba, stack
from luenberger.kernels.in_place import in_place
from luenberger.kernels.inputs import arguments
from luenberger.recursion.filter_stacks import FILTER
from luenberger.symbolic import Stage

SIZES = dict(n=9, p=2, m=0)
ROWS = 4
ABSENT = "B", "E", "Gamma", "J"  # of a plant without inputs and S


def asked(recursion, changing=(), keep=True):
    """Lines that a run in plain Python asks for: (array, row, entry), in order."""
    loop = recursion.lowered(ABSENT)
    arrays, rng = {}, np.random.default_rng(1)
    for name, kind in arguments(loop).items():
        wide = widths(loop).get(name, 0)
        if kind == "f8[:,::1]":
            arrays[name] = 0.1 * rng.normal(size=(ROWS + 1, wide))
        elif kind == "f8[::1]":
            arrays[name] = np.zeros(wide)
    unit = np.eye(SIZES["n"]).ravel()
    arrays |= {name: np.tile(unit, (ROWS + 1, 1)) for name in ("Q",) if name in arrays}
    if "R" in arrays:
        arrays["R"][:] = np.eye(SIZES["p"]).ravel()
    if "Sigma" in arrays:
        arrays["Sigma"][...] = unit
    names = {id(X): name for name, X in arrays.items()}
    start = dict(start=0, stop=ROWS, last=ROWS - 1, keep=keep, now=None, before=None)
    start["good"] = np.ones(ROWS, dtype=bool)
    lines = []
    space = stack.plain() | dict(
        fetch=lambda X, row, k: lines.append((names[id(X)], row, k))
    )
    exec(numba.source(loop, SIZES, frozenset(changing), None), space)
    given = {**start, **arrays}
    done = space["run"](*(given[name] for name in arguments(loop)))
    assert done == ROWS
    return lines


def widths(loop):
    """How many numbers a row of each array has."""
    found = {}
    for name in loop.matrices:
        found[name] = np.prod(loop.program.shape(name, SIZES))
    for name, (array, _) in loop.rows.items():
        if name in loop.program.given:
            found[array] = np.prod(loop.program.shape(name, SIZES))
    for name in loop.carried.values():
        found[name] = np.prod(loop.program.shape(name, SIZES))
    for array, result, kind in loop.recursion.written:
        rows, cols = loop.program.shape(loop.program.results[result].name, SIZES)
        found[array] = rows if kind == "diagonal" else rows * cols
    return found


def lines_of(loop, array, row):
    return [(array, row, k) for k in range(0, widths(loop)[array], stack.LINE)]


def test_what_is_kept_of_a_row_is_asked_for_once_in_the_row_before():
    loop = FILTER.lowered(ABSENT)
    arrays = [array for array, _, kind in FILTER.written if kind == "matrix"]
    wanted = [
        line
        for row in range(ROWS)
        for array in arrays
        for line in lines_of(loop, array, row + 1)
    ]
    assert Counter(asked(FILTER)) == Counter(wanted)
    assert asked(FILTER, keep=False) == []


def test_lines_are_asked_for_a_few_at_a_time():
    """As many behind each step, in the text as it is printed."""
    text = numba.source(FILTER.lowered(ABSENT), dict(n=30, p=8, m=0), frozenset(), None)
    counts, here = [], 0
    for before, line in pairwise(text.splitlines()):
        if "product(" in line and here:
            counts.append(here)
            here = 0
        if "fetch(" in line:
            here += int(before.partition("range(")[2].partition(")")[0])
    assert len(counts) > 5 and max(counts) < 60


def test_a_row_hands_on_in_place():
    found = in_place(FILTER.lowered(ABSENT))
    assert found == {"Sigma_next": "Sigma", "x_next": "x"}


def recursion(*stages, **more):
    n = sp.Symbol("n", integer=True)
    X, A, Y, Z = (sp.MatrixSymbol(k, n, n) for k in "XAYZ")
    named = dict(X=X, A=A, Y=Y, Z=Z)
    made = [Stage(named[k], sp.sympify(text, named)) for k, text in stages]
    derivation = own((X, A), *made)
    return Recursion(lambda: derivation, (("Y", "X"),), (), **more)


@pytest.mark.parametrize(
    "found",
    [
        recursion(("Y", "A*X"), written=()),
        recursion(("Y", "2*A"), ("Z", "Y*X"), written=(("out", "Z", "matrix"),)),
        recursion(
            ("Z", "A*X"), ("Y", "A*Z"), written=(), bounds=(("Z", "X", "above", 1.0),)
        ),
        recursion(("Z", "A*X"), ("Y", "A*Z"), written=(("out", "X", "matrix"),)),
    ],
    ids=["in its own step", "behind it", "in a bound", "where it is written"],
)
def test_what_is_read_later_keeps_its_place(found):
    assert in_place(found.lowered()) == {}


def test_what_is_read_before_gives_its_place():
    found = recursion(("Z", "A*X"), ("Y", "A*Z"), written=())
    assert in_place(found.lowered()) == {"Y": "X"}
