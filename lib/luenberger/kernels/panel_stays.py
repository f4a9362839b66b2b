"""Arrays that stay in lanes between two recursions; see `panel_rows`.

One recursion writes them and another reads them.  A row of an array has all entries of
a matrix, of a symmetric one those of its upper half, each in all lanes.  A panel of
records has its rows one after the other, and one more behind them.
"""

from typing import TYPE_CHECKING, Any

from .panel_copies import LANES, lane
from .program import Program, Sizes
from .python import Python

if TYPE_CHECKING:
    from .panels import Panels

PLACE = f"begin // {LANES} * (rows_ + 1) + row"


def places(program: Program, name: str, sizes: Sizes) -> dict[tuple[int, int], int]:
    """Which entries of a matrix there are, and the number of each."""
    operand = program.results.get(name)
    name = operand.name if operand else name
    half = name in program.symmetric
    rows, cols = program.shape(name, sizes)
    if operand and operand.turned:
        rows, cols = cols, rows
    every = [(i, j) for i in range(rows) for j in range(i if half else 0, cols)]
    return {at: k for k, at in enumerate(every)}


class Stays:
    """What one recursion reads and writes of them, line by line."""

    def __init__(self, panels: "Panels", program: Program, sizes: Sizes) -> None:
        rows, written = panels.recursion.rows, panels.recursion.written
        self.read = {
            name: (array, ahead, places(program, name, sizes))
            for name, array, ahead in rows
            if array in panels.stays and name in program.given
        }
        self.written = {
            array: (result, places(program, result, sizes))
            for array, result, _ in written
            if array in panels.stays
        }

    @property
    def rooms(self) -> dict[str, int]:
        """The local arrays, and how many numbers a lane has in each."""
        found = {f"{name}_here": len(at) for name, (*_, at) in self.read.items()}
        return found | {f"{k}_here": len(at) for k, (_, at) in self.written.items()}

    def fetch(self, to: Python) -> None:
        """Copy what a row reads: the loop over lanes has arrays of its own only."""
        if self.read or self.written:
            to.let("place", PLACE)
        for name, (array, ahead, at) in self.read.items():
            row = f"place + {ahead}" if ahead else "place"
            to.fill(f"{name}_here[i]", f"{array}_[{row}, i]", len(at) * LANES)

    def load(self, to: Python, name: str, given: list[tuple[int, int, str]]) -> None:
        """The entries of a matrix in lane l."""
        *_, at = self.read[name]
        for i, j, entry in given:
            to.let(entry, lane(f"{name}_here", at[i, j]))

    def keep(self, to: Python, table: Any) -> None:
        """Results in lane l, which ``table(name)`` has."""
        for array, (result, at) in self.written.items():
            entries = table(result)
            for (i, j), k in at.items():
                to.set(lane(f"{array}_here", k), entries[i][j])

    def put(self, to: Python) -> None:
        """Copy what a row has written."""
        for array, (_, at) in self.written.items():
            to.fill(f"{array}_[place, i]", f"{array}_here[i]", len(at) * LANES)
