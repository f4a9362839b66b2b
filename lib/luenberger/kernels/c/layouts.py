"""Which matrices are kept as their transposes, so that loops run along rows.

A product is added up along the rows of its right factor.  Where that is a transpose,
its rows are columns in memory, unless the transpose is what is kept; and a step may as
well compute the transpose of its target, whose right factor is then the left one.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import combinations

from ..program import (
    Assign,
    Magnitudes,
    Operand,
    Program,
    Sizes,
    Step,
    Substitute,
    Term,
)

ANOTHER = 1  # cost of a second table of constants, in entries that are copied


@dataclass(frozen=True)
class Layouts:
    """How the matrices of a program are kept.

    Attributes
    ----------
    program : Program
    sizes : dict of str to int
    constants : frozenset of str
        Given matrices that never change, which are kept either way, or both.
    turned : frozenset of str
        Targets of which the transpose is computed, and kept unless they are symmetric.
    """

    program: Program
    sizes: Sizes
    constants: frozenset[str]
    turned: frozenset[str] = frozenset()

    def shape(self, operand: Operand) -> tuple[int, int]:
        rows, cols = self.program.shape(operand.name, self.sizes)
        return (cols, rows) if operand.turned else (rows, cols)

    def in_rows(self, operand: Operand) -> bool:
        """Whether the rows of an operand are rows, or one column, in memory."""
        turned = operand.name in self.turned
        return self.either_way(operand) or turned == operand.turned

    def either_way(self, operand: Operand) -> bool:
        """Whether they are, whatever is turned."""
        return operand.name in self.program.symmetric or 1 in self.shape(operand)

    def kept(self, name: str) -> Operand:
        """What is kept of a target: itself or its transpose."""
        return Operand(name, name in self.turned and name not in self.program.symmetric)

    def terms(self, step: Assign) -> tuple[Term, ...]:
        """The terms of a target, or of its transpose if that is computed."""
        if step.target not in self.turned:
            return step.terms
        flipped = (
            tuple(factor.T for factor in reversed(term.factors)) for term in step.terms
        )
        return tuple(replace(t, factors=f) for t, f in zip(step.terms, flipped))

    def wanted(self, step: Step) -> Iterator[Operand]:
        """The operands whose rows a step runs along."""
        if isinstance(step, Substitute):
            yield step.right.T
        elif isinstance(step, Assign):
            products = False
            for term in self.terms(step):
                products |= len(term.factors) == 2
                yield from term.factors[1:]
            for term in self.terms(step) if products else ():
                if len(term.factors) == 1 and not term.is_identity:
                    yield term.factors[0]

    def copied(self) -> int:
        """Entries that are copied because rows are columns; they are to be few."""
        return Copied(self)(self.turned)

    def copies(self, step: Step) -> dict[tuple[str, bool], int]:
        """What a step wants that may be columns, and the entries to copy if it is."""
        return {
            (operand.name, operand.turned): self.entries(operand)
            for operand in self.wanted(step)
            if not self.either_way(operand)
        }

    def entries(self, operand: Operand) -> int:
        """Entries that are copied where the rows of an operand are columns."""
        if operand.name in self.constants:
            return ANOTHER
        rows, cols = self.shape(operand)
        return rows * cols


def chosen(program: Program, sizes: Sizes, constants: Iterable[str]) -> Layouts:
    """Layouts for which one or two changes do not save copies."""
    free, fixed = [], set()
    for step in program.steps:
        if isinstance(step, Substitute):
            fixed.add(step.target)
        elif isinstance(step, Magnitudes) and step.matrix in fixed:
            fixed.add(step.target)
        elif isinstance(step, Assign):
            rows, cols = program.shape(step.target, sizes)
            if rows > 1 and cols > 1:
                free.append(step.target)
            elif rows > 1:
                fixed.add(step.target)
    found = Layouts(program, sizes, frozenset(constants), frozenset(fixed))
    copied = Copied(found)
    changes = [{one} for one in free] + [set(two) for two in combinations(free, 2)]
    while True:
        others = [found.turned ^ change for change in changes]
        best = min(others, key=copied, default=found.turned)
        if copied(best) >= copied(found.turned):
            return found
        found = replace(found, turned=best)


class Copied:
    """`Layouts.copied`, called with what is turned, for many choices of one program."""

    def __init__(self, layouts: Layouts) -> None:
        """What a step wants hangs on its own target alone: it is found once."""
        steps = [X for X in layouts.program.steps if isinstance(X, Assign | Substitute)]
        all_ = frozenset(step.target for step in steps)
        plain, flipped = (replace(layouts, turned=X) for X in (all_ - all_, all_))
        self.steps = [(X.target, plain.copies(X), flipped.copies(X)) for X in steps]

    def __call__(self, turned: frozenset[str]) -> int:
        wrong: dict[tuple[str, bool], int] = {}
        for target, plain, flipped in self.steps:
            for operand, entries in (flipped if target in turned else plain).items():
                if (operand[0] in turned) != operand[1]:
                    wrong[operand] = entries
        return sum(wrong.values())
