"""When a loop over rows gives up, and what it then takes back.

Whether a matrix is definite is tested every few rows, because the test takes as long
as half a row.  Where it fails, all rows since the last one that passed are taken back.
"""

from collections.abc import Iterable, Sequence
from typing import Any

from .python import Python
from .recursion import Loop

TEST_EVERY = 8  # rows; the test costs as much as half a row
BACK = 32  # the same of a recursion that runs backward: all its rows have bounds


class TakingBack:
    """Writes tests of rows, and what is done where one of them fails."""

    loop: Loop
    to: Python
    changing: Any  # names of matrices whose index changes
    count: str  # what a turn of the loop is called
    shape: Any  # that of a matrix, as numbers

    def length(self, name: str) -> int:
        """How many entries a matrix has."""
        rows, cols = self.shape(name)
        return rows * cols

    @property
    def every(self) -> int:
        """How many rows there are to a test of definiteness.

        What is singular in one row may be none in the next where matrices change.
        """
        if self.changing and self.loop.recursion.each:
            return 1
        return BACK if self.loop.recursion.backward else TEST_EVERY

    def room(self) -> None:
        """Arrays for rows whose results take the place of what was given."""
        for _, name in self.loop.recursion.replaces:
            self.to.let(f"{name}_held", f"np.empty(({BACK}, {self.length(name)}))")

    def hold(self) -> None:
        """Keep what the results of this row will take the place of."""
        for _, name in self.loop.recursion.replaces:
            place = f"{name}_held[{self.count} % {BACK}, i]"
            self.to.fill(place, f"{name}[i]", self.length(name))

    def keep(self, row: str) -> None:
        """Keep what is carried: all rows before this one are safe."""
        self.to.let("safe", row)
        for name in self.loop.carried.values():
            self.to.fill(f"{name}_kept[i]", f"{name}[i]", self.length(name))

    def give_up(self) -> None:
        """Take back the rows that are not safe, and leave the loop."""
        to = self.to
        to.depth += 1
        to.let("done", "safe")
        for name in self.loop.carried.values():
            to.fill(f"{name}[i]", f"{name}_kept[i]", self.length(name))
        for array, name in self.loop.recursion.replaces:
            to.loop("back", "safe", self.count)
            held = f"{name}_held[back % {BACK}, i]"
            to.fill(f"{array}_[last_ - back, i]", held, self.length(name))
            to.end()
        to.line("break")
        to.depth -= 1

    def bounds(self) -> None:
        """Test each entry of the diagonals that have a bound."""
        names = {name for name, *_ in bounded(self.loop)}
        for name in sorted(names):
            rows, cols = self.shape(name)
            self.to.loop("i", 0, rows)
            at = f"i * {cols + 1}" if cols > 1 else "i"
            for one, unit, kind, bound in bounded(self.loop):
                if one == name:
                    entries = f"{name}[{at}]", f"{unit}[{at}]"
                    self.to.need(f"({condition(kind, bound, entries)})")
            self.to.end()


def bounded(loop: Loop) -> Iterable[tuple[str, str, str, float]]:
    """Matrices whose diagonals have a bound: beside which one, the kind, the bound."""
    for name, beside, kind, bound in loop.recursion.bounds:
        operand = loop.program.results[name]
        if operand is not None:
            yield operand.name, beside, kind, bound


def condition(kind: str, bound: float, entries: Sequence[object]) -> str:
    """What has to hold of an entry and of the one beside it; a NaN fails.

    An entry is above one that is zero, too, if it is zero itself: both are known.
    """
    one, beside = entries
    if kind == "above":
        return f"({one} > {bound!r} * {beside} or {one} == {beside} == 0.0)"
    if kind == "square":
        return f"{one} * {one} <= {bound!r} * {beside}"
    return f"{one} * {beside} <= {bound!r}"
