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
    written : str
        The array that the result is written to.
    weighed : str
        A result of whose squared length the largest is kept.
    """

    stages: StageList
    carried: tuple[str, str]
    read: str
    written: str
    weighed: str

    @property
    def program(self) -> Program:
        """The stage list, lowered."""
        from .lowering import lower

        return lower(self.stages(), [self.carried[0], self.weighed])

    def matrices(self, program: Program) -> list[str]:
        """The given matrices that stay."""
        return [k for k in program.given if k not in (self.carried[1], self.read)]


def arguments(lanes: Lanes, program: Program) -> dict[str, str]:
    """Names of the arguments of `run`, in order, and the numba type of each."""
    types = dict.fromkeys(("begins", "shows", "ends"), "i8[::1]")
    types |= {name: "f8[::1]" for name in lanes.matrices(program)}
    types |= dict.fromkeys((lanes.carried[1], lanes.read, lanes.written), "f8[:,::1]")
    return types | {"largest": "f8[::1]"}


def source(lanes: Lanes, program: Program, sizes: Sizes, count: int) -> str:
    """The text of a module with the function `run`.

    ``run(begins, shows, ends, ...)`` runs lane l over the rows from ``begins[l]`` to
    ``ends[l]``, at least one, and writes results from row ``shows[l]`` on.  Lanes are
    run `count` at a time, and there are a multiple of these.  What is carried comes
    with a row for each lane, and is left as after its last row.  ``largest`` takes up
    the largest |entry| of what is written and of what is read there, and the largest
    squared length of what is weighed.
    """
    to = Python(0)
    to.line(f'"""{lanes.stages.where}, {count} lanes.  Generated: do not edit."""')
    names = arguments(lanes, program)
    to.line("")
    to.line("")
    to.line(f"def run({', '.join(f'{name}_' for name in names)}):")
    to.depth = 1
    _Body(lanes, program, sizes, count, to).write()
    return "\n".join(to.lines) + "\n"


class _Body:
    """Numbers of all lanes are kept entry by entry: one row of `count` an entry."""

    def __init__(
        self, lanes: Lanes, program: Program, sizes: Sizes, count: int, to: Python
    ) -> None:
        self.lanes, self.program, self.sizes = lanes, program, sizes
        self.count, self.to = count, to
        self.result, self.given = lanes.carried
        self.long = {
            name: int(program.shape(name, sizes)[0])
            for name in (self.given, lanes.read, self.result, lanes.weighed)
        }
        self.sums = {s.target: s for s in program.steps if isinstance(s, Assign)}

    def write(self) -> None:
        to, L, n = self.to, self.count, self.long[self.given]
        watched = n + self.long[self.lanes.read] + 1
        for name, length in self.long.items():
            to.let(name, f"array({max(length, 1) * L})")
        for name in (self.result, self.lanes.weighed):
            to.let(f"{name}_b", f"array({max(self.long[name], 1) * L})")
        to.let("most", f"array({watched * L})")
        to.fill("most[i]", "0.0", watched * L)
        to.loop("g", "0", f"begins_.shape[0], {L}")
        self.start()
        to.loop("t", 0, "steps")
        self.row()
        to.end()
        self.each_lane(f"{self.given}_[g + l, i]", f"{self.given}[i * {L} + l]", n)
        to.end()
        to.loop("i", 0, watched)
        to.loop("l", 0, L)
        to.set("largest_[i]", f"max(largest_[i], most[i * {L} + l])")
        to.end()
        to.end()

    def start(self) -> None:
        """The lanes of one go: what they carry, and when they all do the same."""
        to, n = self.to, self.long[self.given]
        here = f"{self.given}[i * {self.count} + l]"
        self.each_lane(here, f"{self.given}_[g + l, i]", n)
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
        to, L, n, read = self.to, self.count, self.long[self.given], self.lanes.read
        to.loop("l", 0, L)
        to.let("row", "min(begins_[g + l] + t, ends_[g + l] - 1)")
        to.fill(f"{read}[i * {L} + l]", f"{read}_[row, i]", self.long[read])
        to.end()
        self.assign(self.result)
        to.check("t >= quiet")
        self.assign(self.lanes.weighed)
        to.check("loud <= t < calm")
        to.loop("l", 0, L)
        self.weigh()
        to.end()
        for name, at, length in self.watched():
            most = f"most[i + {at * L}]"
            to.fill(most, f"max({most}, abs({name}[i]))", length * L)
        to.end()
        to.line("else:")
        to.depth += 1
        self.shown()
        self.weigh()
        for name, at, length in self.watched():
            most = f"most[(i + {at}) * {L} + l]"
            to.fill(most, f"max({most}, abs({name}[i * {L} + l]))", length)
        to.end()
        to.end()
        to.end()
        self.shown()
        to.fill(f"{self.lanes.written}_[row, i]", f"{self.result}[i * {L} + l]", n)
        to.end()
        to.end()
        to.end()
        self.carry()

    def watched(self) -> list[tuple[str, int, int]]:
        """Vectors of whose entries the largest are kept: name, place, length."""
        (n, k), read = (self.long[i] for i in (self.given, self.lanes.read)), self.lanes
        return [(self.result, 0, n), (read.read, n, k)]

    def shown(self) -> None:
        """Open a loop over the lanes whose row is written."""
        self.to.loop("l", 0, self.count)
        self.to.let("row", "begins_[g + l] + t")
        self.to.check("shows_[g + l] <= row < ends_[g + l]")

    def weigh(self) -> None:
        """The largest squared length, in lane l."""
        to, L, name = self.to, self.count, self.lanes.weighed
        at = (self.long[self.given] + self.long[self.lanes.read]) * L
        to.let("s", "0.0")
        for i in range(self.long[name]):
            to.let("w", f"{name}[{i * L} + l]")
            to.set("s", "w * w", "+=")
        to.set(f"most[{at} + l]", f"max(most[{at} + l], s)")

    def carry(self) -> None:
        """What the next row begins with: no change in lanes that have ended."""
        to, L, n = self.to, self.count, self.long[self.given]
        to.check("t < calm")
        to.fill(f"{self.given}[i]", f"{self.result}[i]", n * L)
        to.end()
        to.line("else:")
        to.depth += 1
        to.loop("l", 0, L)
        to.check("begins_[g + l] + t < ends_[g + l]")
        to.fill(f"{self.given}[i * {L} + l]", f"{self.result}[i * {L} + l]", n)
        to.end()
        to.end()
        to.end()

    def assign(self, target: str) -> None:
        """A sum of products, in tiles."""
        step, L = self.sums[target], self.count
        start, last = None, len(step.terms) - 1
        for number, term in enumerate(step.terms):
            matrix, vector = (factor.name for factor in term.factors)
            assert not term.factors[0].turned
            inner = self.long[vector]
            into = target if (last - number) % 2 == 0 else f"{target}_b"
            for first, end, height in runs(self.long[target], HEIGHT):
                at = f"{first * L}, {L}"
                given = [
                    f"{height}, {int(start is not None)}, {(end - first) // height}",
                    f"{L}, {inner}, 0, {float(term.scale)}",
                    f"{into}, {at}", f"{start or into}, {at}",
                    f"{matrix}_, {first * inner}, {inner}, 1", f"{vector}, 0, {L}",
                ]  # fmt: skip
                self.to.line(f"product({', '.join(given)})")
            start = into


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
