"""A recursion that runs over a record: a stage list, and what goes round.

It adds to a stage list what a loop over time needs to know: what one row hands to the
next, what is read from the record's rows, what is written down.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

from ..stage_list import StageList
from .program import Factor, Guard, Operand, Program


@dataclass(frozen=True)
class Recursion:
    """A stage list that is run once for each row of a record.

    Attributes
    ----------
    stages : StageList
    carried : tuple of (str, str)
        Results, and the given matrix that each is at the next row; one that nothing
        reads then is left out.
    rows : tuple of (str, str, int)
        Given vectors, and matrices that are copied, with the array of the record and
        the row in it, k or k + 1.
    written : tuple of (str, str, str)
        Output array, result, and "vector", "diagonal", "matrix" or "sum"; matrices are
        written only where a history is kept, and a sum is added to row 0 of its array.
        What is carried may be written as well, as the row began with it.
    before : tuple of str
        Given matrices that belong to the instant before.
    symmetric : tuple of str
        Given matrices that are symmetric.
    definite : tuple of Factor
        Of results that must be positive definite, or the loop gives up.
    bounds : tuple of (str, str, str, float)
        A result, a given matrix, and what holds of each two entries of their
        diagonals, or the loop gives up: "above", the first is more than the bound
        times the other; "product", their product is at most the bound; "square", the
        square of the first is at most the bound times the other.  Vectors are
        diagonals, and of a square the other may be a result.
    replaces : tuple of (str, str)
        Output arrays that are the place of a given matrix too.  Where the loop gives
        up, rows that it takes back have what was given.
    same : tuple of (str, str, str)
        Given matrices that are the same as another one where a third vanishes.
    backward : bool
        From the last row to the first; a matrix that changes has one for each row.
    fresh : bool
        Some rows begin anew, from what was carried into the first.
    zero : tuple of str
        Given matrices that vanish in all rows.  A result that vanishes with them is
        neither handed on nor written.
    sizes : tuple of Guard
        Squares and variances that stages judge rounding by.
    each : bool
        Each row is tested for definiteness where matrices change.
    """

    stages: StageList
    carried: tuple[tuple[str, str], ...]
    rows: tuple[tuple[str, str, int], ...]
    written: tuple[tuple[str, str, str], ...]
    before: tuple[str, ...] = ()
    symmetric: tuple[str, ...] = ()
    definite: tuple[Factor, ...] = ()
    bounds: tuple[tuple[str, str, str, float], ...] = ()
    replaces: tuple[tuple[str, str], ...] = ()
    same: tuple[tuple[str, str, str], ...] = ()
    backward: bool = False
    fresh: bool = False
    zero: tuple[str, ...] = ()
    sizes: tuple[Guard, ...] = ()
    each: bool = False

    def lowered(self, zero: Collection[str] = ()) -> Loop:
        """The `Loop` where the matrices named in `zero` vanish."""
        from .lowering import lower

        zero = {*zero, *self.zero}
        same = [(one, other) for one, other, third in self.same if third in zero]
        left = dict(self.carried)
        while True:
            carried = left
            begun = {name: Operand(name) for name in carried.values()}
            known = carried.keys() | begun.keys()
            found = [name for _, name, _ in self.written]
            found += [name for name, *_ in self.bounds]
            found += [one.beside for one in self.definite if one.beside and self.sizes]
            found += [one for _, one, kind, _ in self.bounds if kind == "square"]
            written = [name for name in found if name not in known]
            program = lower(
                self.stages(),
                [*carried, *written],
                zero=zero,
                symmetric=self.symmetric,
                definite=self.definite,
                same=same,
                guards=self.sizes,
            )
            left = {k: name for k, name in carried.items() if name in program.given}
            if left == carried:
                program = replace(program, results=program.results | begun)
                return Loop(self.without(program), program, carried)

    def strict(self, wanted: bool) -> Recursion:
        """The recursion that passes over nothing that is known exactly, if `wanted`."""
        if not wanted:
            return self
        tests = tuple(replace(one, known=False) for one in self.definite)
        return replace(self, definite=tests)

    def without(self, program: Program) -> Recursion:
        """The recursion that does not write what vanishes with `zero`."""
        if not self.zero:
            return self
        there = {name for name, op in program.results.items() if op is not None}
        return replace(self, written=tuple(w for w in self.written if w[1] in there))


@dataclass(frozen=True)
class Loop:
    """A recursion as a lowered program; `carried` is a dict of what is handed on."""

    recursion: Recursion
    program: Program
    carried: dict[str, str]

    @property
    def name(self) -> str:
        """What it is, for the head of generated code."""
        return self.recursion.stages.where.rpartition(".")[2]

    @property
    def rows(self) -> dict[str, tuple[str, int]]:
        """What is read of the record, with its array, and 0 or 1 rows ahead."""
        return {name: (array, ahead) for name, array, ahead in self.recursion.rows}

    @property
    def matrices(self) -> tuple[str, ...]:
        """Given matrices that are neither carried nor read from the record."""
        known = {*self.carried.values(), *self.rows}
        return tuple(name for name in self.program.given if name not in known)
