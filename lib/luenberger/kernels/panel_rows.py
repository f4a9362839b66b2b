"""The function that runs records in panels, line by line; see `panels`."""

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

from .fused import joined
from .panel_copies import HIGH, LANES, copy_in, copy_out, lane
from .panel_stays import Stays
from .panel_watch import Watch
from .program import Sizes
from .python import Python
from .recursion import Loop
from .scalars import Entry, Inverse, Let, Need, Straight
from .taking_back import bounded, condition

if TYPE_CHECKING:
    from .panels import Panels


def source(
    panels: "Panels",
    loop: Loop,
    sizes: Sizes,
    changing: Collection[str],
    straight: Straight,
    names: Sequence[str],
) -> str:
    """The text of a module with the function `run`.

    ``run(who, rows, y, which_y, ..., A, ..., Omega, ..., xs, ...)`` works on the first
    `rows` rows of the records `who`, which are rows of every array that is written.
    Record s reads row ``which_y[s]`` of y, and so on; NaN is what did not arrive.
    Matrices come as stacks (S, rows * cols), of which row k uses index k if the matrix
    is `changing`, else 0.  What is carried comes flat, and is the same for all at the
    first row.  A recursion that runs backward begins with the last row.

    A lane in which a pivot or a bound fails goes on with numbers that mean nothing, and
    has failed.
    """
    to = Python(0)
    shown = ", ".join(f"{name} = {value}" for name, value in sorted(sizes.items()))
    to.line(f'"""{loop.name}, {shown}, in panels.  Generated: do not edit."""')
    to.line("import numpy as np\n\n")
    to.line(f"def run({', '.join(f'{name}_' for name in names)}):")
    to.depth = 1
    _Panel(panels, loop, sizes, changing, straight, to).write()
    return "\n".join(to.lines) + "\n"


class _Panel:
    """Scalars in a loop over lanes, around it loops over rows and records.

    A number of a lane that is needed outside that loop is kept in a local array: entry
    by entry, all lanes.
    """

    def __init__(
        self,
        panels: "Panels",
        loop: Loop,
        sizes: Sizes,
        changing: Collection[str],
        straight: Straight,
        to: Python,
    ) -> None:
        self.panels, self.loop, self.program = panels, loop, loop.program
        self.sizes, self.changing, self.to = sizes, changing, to
        self.straight = straight
        self.marks, self.marked = panels.marks or ("", "")
        self.level = self.levels()
        self.carried = {name: self.given(name) for name in loop.carried.values()}
        self.stays = Stays(panels, self.program, sizes)
        self.read = {
            array: self.program.shape(name, sizes)[0]
            for name, (array, _) in loop.rows.items()
            if self.given(name) and name not in self.stays.read
        }
        self.written = {
            array: (kind, self.flat(result, kind))
            for array, result, kind in loop.recursion.written
            if array not in self.stays.written
        }
        self.whole = dict(self.read)  # vectors of which some rows are kept
        for array, (kind, flat) in self.written.items():
            if kind != "matrix":
                self.whole[array] = len(flat)
        covariance = self.table(panels.watched) if panels.watched else []
        variances = [
            array
            for array, result, kind in loop.recursion.written
            if (result, kind) == (panels.watched, "diagonal") and array in self.whole
        ]
        self.watch = Watch(panels.tests, covariance, *variances)

    def given(self, name: str) -> list[tuple[int, int, str]]:
        """The entries of a given matrix that are not known."""
        return self.straight.given.get(name, [])

    def levels(self) -> dict[Entry, int]:
        """Of each name: 0 if it stays, 1 if rows have their own, 2 if lanes have."""
        lanes = {*self.loop.carried.values(), *self.loop.rows, self.marks}
        level: dict[Entry, int] = {}
        for name, entries in self.straight.given.items():
            of = 2 if name in lanes else int(name in self.changing)
            level |= {entry: of for *_, entry in entries}
        for one in self.straight.statements:
            if isinstance(one, Let):
                level[one.name] = max((level[k] for k in one.reads), default=0)
        return level

    def flat(self, result: str, kind: str) -> list[Entry]:
        """The entries of a result, or of its diagonal."""
        table = self.table(result)
        if kind == "diagonal":
            return [row[i] for i, row in enumerate(table)]
        return [entry for row in table for entry in row]

    def table(self, result: str) -> list[list[Entry]]:
        operand = self.program.results[result]
        if operand is None:
            rows, cols = self.program.shape(result, self.sizes)
            return [[0.0] * cols] * rows
        table = self.straight.entries[operand.name]
        return [list(row) for row in zip(*table)] if operand.turned else table

    def write(self) -> None:
        to = self.to
        self.rooms()
        self.uniform(0)
        to.loop("begin", "0", f"who_.shape[0], {LANES}")
        to.let("here", f"min({LANES}, who_.shape[0] - begin)")
        self.start()
        to.loop("first", "0", f"rows_, {HIGH}")
        to.let("high", f"min({HIGH}, rows_ - first)")
        back = self.loop.recursion.backward
        to.let("base", "rows_ - first - high" if back else "first")
        for array, long in self.read.items():
            copy_in(to, array, long)
        to.loop("turn", 0, "high")
        to.let("t", "high - 1 - turn" if back else "turn")
        to.let("row", "base + t")
        self.stays.fetch(to)
        self.uniform(1)
        for (
            array,
            long,
        ) in self.whole.items():  # with less in an index loops are vectors
            many = long * LANES
            rows = f"t * {many}:(t + 1) * {many}"
            to.let(f"{array}_lanes", f"{array}_high[{rows}]")
        self.in_lanes()
        self.stays.put(to)
        for array, (kind, flat) in self.written.items():
            if kind == "matrix":
                self.put(array, flat)
        to.end()
        self.watch.rows(to)
        for array, (kind, flat) in self.written.items():
            if kind != "matrix":
                copy_out(to, array, len(flat))
        to.end()
        self.watch.leave(to)
        to.end()
        to.line("return 0")

    def rooms(self) -> None:
        """The local arrays."""
        rooms = {f"{name}_lanes": len(of) for name, of in self.carried.items()}
        for array, (kind, flat) in self.written.items():
            if kind == "matrix":
                rooms[f"{array}_lanes"] = len(set(flat))
        rooms |= {f"{array}_high": HIGH * long for array, long in self.whole.items()}
        for array in self.read:
            self.to.let(f"{array}_of", f"np.empty({LANES}, np.int64)")
        self.to.let("written", f"np.empty({LANES}, np.int64)")
        rooms |= self.watch.rooms | self.stays.rooms
        for name, length in rooms.items():
            self.to.let(name, f"array({max(length, 1) * LANES})")

    def uniform(self, level: int) -> None:
        """What is the same in all lanes, for good or in a row."""
        row = "row" if level else "0"
        for name in self.loop.matrices:
            _, cols = self.program.shape(name, self.sizes)
            for i, j, entry in self.given(name):
                if self.level[entry] == level and name != self.marks:
                    self.to.let(entry, f"{name}_[{row}, {i * cols + j}]")
        self.statements(level)

    def statements(self, level: int) -> None:
        """Those of a level; a condition that does not hold is noted."""
        for one in self.straight.statements:
            if isinstance(one, Need):
                if level == 2:
                    self.fail(one.text, one.unless)
            elif self.level[one.name] == level:
                text = joined(one.terms, one.number) or one.text
                if isinstance(one, Inverse):
                    text = self.to.inverse(one.pivot)
                self.to.let(one.name, text)

    def fail(self, condition: str, unless: Sequence[str] = ()) -> None:
        """Note in a lane that a condition does not hold."""
        zero = " and ".join(f"{name} == 0.0" for name in unless)
        if zero:
            condition = f"({condition}) or ({zero})"
        self.to.let("bad_", f"bad_ if {condition} else 1.0")

    def bound(
        self, one: list[list[Entry]], beside: str, kind: str, bound: float
    ) -> None:
        """The entries of a diagonal that has a bound."""
        other = self.straight.entries[beside]
        for i in range(len(one)):
            self.fail(condition(kind, bound, (one[i][i], other[i][i])))

    def start(self) -> None:
        """Every lane at what all records begin with."""
        to = self.to
        to.loop("l", 0, LANES)
        to.let("s", "who_[begin + min(l, here - 1)]")
        to.set("written[l]", "s")
        for array in self.read:
            to.set(f"{array}_of[l]", f"which_{array}_[s]")
        for name, of in self.carried.items():
            _, cols = self.program.shape(name, self.sizes)
            for k, (i, j, _) in enumerate(of):
                to.set(lane(f"{name}_lanes", k), f"{name}_[{i * cols + j}]")
        self.watch.start(to)
        to.end()

    def in_lanes(self) -> None:
        """One row of every lane."""
        to = self.to
        to.loop("l", 0, LANES)
        for name, of in self.carried.items():
            for k, (*_, entry) in enumerate(of):
                to.let(entry, lane(f"{name}_lanes", k))
        for name, (array, _) in self.loop.rows.items():
            if name in self.stays.read:
                self.stays.load(to, name, self.given(name))
            else:
                self.load(name, array)
        if self.panels.tests:
            to.let("bad_", "bad[l]")
        self.statements(2)
        for one, beside, kind, bound in bounded(self.loop):
            self.bound(self.straight.entries[one], beside, kind, bound)
        self.stays.keep(to, self.table)
        for array, (kind, flat) in self.written.items():
            self.keep(array, kind, flat)
        self.watch.row(to)
        for result, name in self.loop.carried.items():
            table = self.table(result)
            for k, (i, j, _) in enumerate(self.carried[name]):
                to.set(lane(f"{name}_lanes", k), table[i][j])
        to.end()

    def load(self, name: str, array: str) -> None:
        """A vector of the record: zero where it did not arrive, and marks of that."""
        to, marks = self.to, {i: entry for i, _, entry in self.given(self.marks)}
        for i, _, entry in self.given(name):
            to.let(entry, lane(f"{array}_lanes", i))
            if name == self.marked:
                to.let(marks[i], f"1.0 if {entry} == {entry} else 0.0")
            to.let(entry, f"{entry} if {entry} == {entry} else 0.0")

    def keep(self, array: str, kind: str, flat: list[Entry]) -> None:
        """What is written later: some rows at once, or a matrix after its row."""
        to = self.to
        for k, entry in enumerate(dict.fromkeys(flat) if kind == "matrix" else flat):
            to.set(lane(f"{array}_lanes", k), entry)

    def put(self, array: str, flat: list[Entry]) -> None:
        """A matrix of every lane."""
        to, places = self.to, {entry: k for k, entry in enumerate(dict.fromkeys(flat))}
        to.loop("l", 0, "here")
        to.let("s", "who_[begin + l]")
        for i, entry in enumerate(flat):
            place = f"{array}_[s, row * {len(flat)} + {i}]"
            to.set(place, lane(f"{array}_lanes", places[entry]))
        to.end()
