"""Memory that a loop over rows asks for while it works on the row before.

All lines of a row at once are more than a processor can wait for, and the steps of the
row wait as well.  So a few are asked for behind each step.
"""

from collections.abc import Iterator
from fractions import Fraction
from itertools import groupby
from typing import Any

from .python import Python
from .recursion import Loop
from .stack import LINE


class AskingAhead:
    """Writes what is asked for behind the steps of a row."""

    loop: Loop
    to: Python
    changing: Any  # names of matrices whose index changes
    backward: bool
    asked = 0  # lines so far
    shape: Any  # that of a matrix, as numbers

    def ask(self, written: Fraction) -> None:
        """Ask for what the next row reads and writes, up to a part of its lines."""
        lines = list(self.lines())
        first, self.asked = self.asked, int(len(lines) * written)
        here = lines[first : self.asked]
        if here and not self.backward:
            self.to.check("keep_")
        for array, those in groupby(here, key=lambda line: line[0]):
            starts = [start for _, start in those]
            self.to.loop("i", 0, len(starts))
            row = "row - 1" if self.backward else "row + 1"
            self.to.line(f"fetch({array}_, {row}, {starts[0]} + {LINE} * i)")
            self.to.end()
        if here and not self.backward:
            self.to.end()

    def lines(self) -> Iterator[tuple[str, int]]:
        """Arrays, and the entry with which each line of a row begins."""
        for array, name in (self.back if self.backward else self.forth)().items():
            high, wide = self.shape(name)
            yield from ((array, start) for start in range(0, high * wide, LINE))

    def forth(self) -> dict[str, str]:
        """Matrices that are written: what is read forward a processor asks for."""
        return self.found("matrix")

    def back(self) -> dict[str, str]:
        """All of a row but what it leaves in the place of what it read."""
        given, in_place = self.loop.program.given, dict(self.loop.recursion.replaces)
        rows = {one: name for name, (one, _) in self.loop.rows.items() if name in given}
        rows |= {name: name for name in self.loop.matrices if name in self.changing}
        written = self.found("vector") | self.found("matrix")
        return rows | {one: X for one, X in written.items() if one not in in_place}

    def found(self, kind: str) -> dict[str, str]:
        """Arrays that are written, each with its result."""
        results = self.loop.program.results
        every = {
            one: results[name]
            for one, name, k in self.loop.recursion.written
            if k == kind
        }
        return {one: X.name for one, X in every.items() if X}
