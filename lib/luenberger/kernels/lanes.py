"""Print one row of a record as loops over lanes: many parts of the record at once.

A row is a few products of matrices that stay with vectors that change.  A lane is a
part of the record with a vector of its own; what one lane does is the same in whichever
lane, so the result does not depend on how a record is divided among them.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

from ..stage_list import StageList
from .products import HEIGHT
from .program import Assign, Program, Sizes
from .python import Python
from .tiles import runs
from .turning import SIDE


@dataclass(frozen=True)
class Lanes:
    """A stage list whose rows are run in lanes.

    Attributes
    ----------
    stages : StageList
    carried : (str, str)
        A result, and the given vector that it is at the next row.
    read : str
        The given vector that is read from the record.
    weighed : str
        A result of whose squared length the largest is kept.
    """

    stages: StageList
    carried: tuple[str, str]
    read: str
    weighed: str

    @property
    def program(self) -> Program:
        """The stage list, lowered."""
        from .lowering import lower

        return lower(self.stages(), [self.carried[0], self.weighed])

    @property
    def vectors(self) -> tuple[str, str, str, str]:
        """What is carried on and weighed, what was carried and is read."""
        return self.carried[0], self.weighed, self.carried[1], self.read


def arguments(lanes: Lanes, program: Program) -> dict[str, str]:
    """Names of the arguments of `run`, in order, and the numba type of each."""
    types = dict.fromkeys(("begins", "shows", "ends"), "i8[::1]")
    _, _, carried, read = lanes.vectors
    matrices = [name for name in program.given if name not in (carried, read)]
    types |= dict.fromkeys((*matrices, carried, read, "written"), "f8[:,::1]")
    return types | {"largest": "f8[::1]"}


def source(lanes: Lanes, program: Program, sizes: Sizes, count: int) -> str:
    """The text of a module with the function `run`.

    ``run(begins, shows, ends, ...)`` runs lane l over the rows from ``begins[l]`` to
    ``ends[l]``, at least one, and writes results from row ``shows[l]`` on.  Lanes are
    run `count` at a time, and there are a multiple of these.  What is carried comes as
    a row for each lane, and is left as after its last row.  ``largest`` takes up the
    largest |entry| of what is written and of what is read there, and the largest
    squared length of what is weighed.
    """
    to = Python(0)
    to.line(f'"""{lanes.stages.where}, {count} lanes.  Generated: do not edit."""')
    to.line("import numpy as np\n\n")
    names = arguments(lanes, program)
    to.line(f"def run({', '.join(f'{name}_' for name in names)}):")
    to.depth = 1
    _Body(lanes, program, sizes, count, to).write()
    return "\n".join(to.lines) + "\n"


class _Body:
    """Numbers of all lanes are kept entry by entry: one row of `count` an entry."""

    def __init__(
        self, lanes: Lanes, program: Program, sizes: Sizes, count: int, to: Python
    ) -> None:
        self.lanes, self.program = lanes, program
        self.count, self.to = count, to
        self.long = {name: int(program.shape(name, sizes)[0]) for name in lanes.vectors}
        _, self.j, n, k = self.long.values()
        self.n, self.k = n, k
        # of what is kept of each row: where it is, and its place in `largest`
        self.watched = ("new", 0, 0, n), ("old", n, n, k)

    def write(self) -> None:
        to, L, n, k = self.to, self.count, self.n, self.k
        to.let("old", f"array({(n + k) * L})")
        to.let("new", f"array({(n + self.j) * L})")
        to.let("most", f"array({(n + k + 1) * L})")
        to.fill("most[i]", "0.0", (n + k + 1) * L)
        to.let("rows", f"np.empty({L}, np.int64)")
        self.stack()
        to.loop("g", "0", f"begins_.shape[0], {L}")
        self.start()
        to.loop("t", 0, "steps")
        self.row()
        to.end()
        self.each_lane(self.carried, self.at("old"), n)
        to.end()
        to.loop("i", 0, n + k + 1)
        to.loop("l", 0, L)
        to.set("largest_[i]", f"max(largest_[i], most[i * {L} + l])")
        to.end()
        to.end()
        to.line("return 0")

    def stack(self) -> None:
        """One matrix, by columns: new from old."""
        to, rows = self.to, self.n + self.j
        result, weighed, carried, read = self.lanes.vectors
        to.let("step", f"np.zeros({(self.n + self.k) * rows})")  # large for a stack
        for step in self.program.steps:
            assert isinstance(step, Assign)
            first = {result: 0, weighed: self.n}[step.target]
            for term in step.terms:
                matrix, vector = (factor.name for factor in term.factors)
                assert term.scale == 1 and not term.factors[0].turned
                column = {carried: 0, read: self.n}[vector]
                to.loop("c", 0, self.long[vector])
                place = f"step[(c + {column}) * {rows} + i + {first}]"
                to.fill(place, f"{matrix}_[i, c]", self.long[step.target], "+=")
                to.end()

    @property
    def carried(self) -> str:
        """Entry i of lane l as it comes and goes."""
        return f"{self.lanes.carried[1]}_[g + l, i]"

    def at(self, name: str, first: int = 0) -> str:
        """Entry `first` + i of lane l."""
        entry = f"(i + {first})" if first else "i"
        return f"{name}[{entry} * {self.count} + l]"

    def start(self) -> None:
        """The lanes of one go: what they carry, and when they all do the same."""
        to = self.to
        self.each_lane(self.at("old"), self.carried, self.n)
        for name, end, of in (
            ("quiet", "shows", "min"), ("loud", "shows", "max"),
            ("calm", "ends", "min"), ("steps", "ends", "max"),
        ):  # fmt: skip
            to.let(name, f"{end}_[g] - begins_[g]")
            to.loop("l", 1, self.count)
            to.let(name, f"{of}({name}, {end}_[g + l] - begins_[g + l])")
            to.end()

    def each_lane(self, target: str, text: str, length: int) -> None:
        """target = text for each lane l and each i."""
        self.to.loop("l", 0, self.count)
        self.to.fill(target, text, length)
        self.to.end()

    def row(self) -> None:
        """One row of every lane; lanes that have ended read their last one again."""
        to = self.to
        to.loop("l", 0, self.count)
        to.let("row", "min(begins_[g + l] + t, ends_[g + l] - 1)")
        to.fill(self.at("old", self.n), f"{self.lanes.read}_[row, i]", self.k)
        to.end()
        self.product()
        to.check("t >= quiet")
        to.check("loud <= t < calm")
        self.keep()
        self.put()
        to.end()
        to.line("else:")
        to.depth += 1
        self.shown()
        self.keep_one()
        to.fill("written_[row, i]", self.at("new"), self.n)
        to.end()
        to.end()
        to.end()
        to.end()
        self.carry()

    def put(self) -> None:
        """Write the row of every lane."""
        to, L, n = self.to, self.count, self.n
        if n < SIDE:
            to.loop("l", 0, L)
            to.let("row", "begins_[g + l] + t")
            to.fill("written_[row, i]", self.at("new"), n)
            to.end()
            return
        to.fill("rows[i]", "begins_[g + i] + t", L)
        to.loop("l", "0", f"{L}, {SIDE}")
        for first in (*range(0, n - SIDE, SIDE), n - SIDE):  # some perhaps twice
            given = f"l, {first}, new, {first * L} + l, {L}"
            to.line(f"to_rows(written_, rows, {given})")
        to.end()

    def product(self) -> None:
        """new = step old, in tiles."""
        L, rows, inner = self.count, self.n + self.j, self.n + self.k
        for first, end, height in runs(rows, HEIGHT):
            given = [
                f"{height}, 0, {(end - first) // height}, {L}, {inner}, 0, 1.0",
                *[f"new, {first * L}, {L}"] * 2,
                f"step, {first}, 1, {rows}, old, 0, {L}",
            ]
            self.to.line(f"product({', '.join(given)})")

    def keep(self) -> None:
        """What is largest, of all lanes."""
        to, L = self.to, self.count
        for name, at, place, length in self.watched:
            most = f"most[i + {place * L}]" if place else "most[i]"
            entry = f"{name}[i + {at * L}]" if at else f"{name}[i]"
            to.fill(most, f"max({most}, abs({entry}))", length * L)
        to.loop("l", 0, L)
        self.weigh()
        to.end()

    def keep_one(self) -> None:
        """The same of lane l."""
        for name, at, place, length in self.watched:
            most = self.at("most", place)
            self.to.fill(most, f"max({most}, abs({self.at(name, at)}))", length)
        self.weigh()

    def weigh(self) -> None:
        """The largest squared length, in lane l."""
        to, L = self.to, self.count
        most = f"most[{(self.n + self.k) * L} + l]"
        to.let("s", "0.0")
        for i in range(self.n, self.n + self.j):
            to.set("s", f"new[{i * L} + l] * new[{i * L} + l]", "+=")
        to.set(most, f"max({most}, s)")

    def shown(self) -> None:
        """Open a loop over the lanes whose row is written."""
        self.to.loop("l", 0, self.count)
        self.to.let("row", "begins_[g + l] + t")
        self.to.check("shows_[g + l] <= row < ends_[g + l]")

    def carry(self) -> None:
        """What the next row begins with: no change in lanes that have ended."""
        to = self.to
        to.check("t < calm")
        to.fill("old[i]", "new[i]", self.n * self.count)
        to.end()
        to.line("else:")
        to.depth += 1
        to.loop("l", 0, self.count)
        to.check("begins_[g + l] + t < ends_[g + l]")
        to.fill(self.at("old"), self.at("new"), self.n)
        to.end()
        to.end()
        to.end()


@cache
def in_lanes(lanes: Lanes, sizes: tuple[tuple[str, int], ...], count: int) -> Any:
    """``run(**arrays)``, compiled by numba; see `source`."""
    from . import cache as kept

    def make() -> tuple[str, dict[str, str]]:
        program = lanes.program
        text = source(lanes, program, dict(sizes), count)
        return text, arguments(lanes, program)

    text, types = kept.derived(("lanes", lanes, sizes, count), make)
    run = kept.compiled(text, tuple(types.values()))

    def over(**arrays: Any) -> None:
        run(*(arrays[name] for name in types))

    return over
