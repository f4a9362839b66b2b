"""Loops or scalars: what a pass through a program costs, and which is the better form.

Scalars do no work on zeros and ones that are known, loops do; but scalars are as many
lines as they are operations.
"""

import math

from . import guards
from . import loops as writing
from .program import GUARDS, Assign, Cost, Factor, Known, Program, Sizes, Step
from .scalars import Straight, unroll
from .writer import Writer

SHORT, LONG = 400, 3000  # operations: scalars up to SHORT; up to LONG if mostly zeros
SPARSE = 3  # that is, where loops would do this many times the work


def straight(
    program: Program, sizes: Sizes, known: Known | None = None
) -> Straight | None:
    """The pass as scalars if a device is better off with them, else None."""
    whole = loops(program, sizes).operations
    if whole > 100 * LONG:
        return None  # unrolling alone would take a while
    found = unroll(program, sizes, known)
    some = found.cost.operations
    return found if some <= (LONG if SPARSE * some < whole else SHORT) else None


def loops(program: Program, sizes: Sizes, known: Known | None = None) -> Cost:
    """The `Cost` of one pass as `loops` writes it; tables of the `known` matrices."""
    steps = (*program.steps, *program.definite)
    operations = sum(_operations(one, program, sizes) for one in steps)
    tables = set(known or ()) & set(program.given)
    constants = sum(math.prod(program.shape(name, sizes)) for name in tables)
    stack = sum(writing.arrays(program, sizes, Writer()).values())
    return Cost(operations, constants, stack, operations // 2)


def _operations(step: Step, program: Program, sizes: Sizes) -> int:
    if isinstance(step, Factor):
        size, _ = program.shape(step.matrix, sizes)
        pivots = size * (2 + bool(step.tol) + bool(step.beside))
        return pivots + size * (size - 1) * (2 * size + 5) // 6
    if isinstance(step, GUARDS):
        return guards.operations(step, *program.shape(step.matrix, sizes))
    rows, cols = program.shape(step.target, sizes)
    if not isinstance(step, Assign):
        return rows * cols * (2 * cols - 1)
    entries = rows * (rows + 1) // 2 if step.symmetric else rows * cols
    identities = sum(term.is_identity for term in step.terms)
    single = sum(len(term.factors) == 1 for term in step.terms) - identities
    one = max(single - 1, 0)  # operations of an entry: copies are added up
    for term in step.terms:
        scaled, width = abs(term.scale) != 1 and not term.is_identity, 0
        if len(term.factors) == 2:
            width = writing.inner_width(program, sizes, term)
            parts = writing.spans(width, cols)  # None: each product is scaled
            scaled *= width if parts == [None] else len(parts)
        one += 2 * width + scaled
    return entries * one + rows * identities
