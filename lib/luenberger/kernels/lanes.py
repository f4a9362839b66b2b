"""Print one row of a record as loops over lanes: many parts of the record at once.

A row is a few products of matrices that stay with vectors that change.  A lane is a
part of the record with a vector of its own; what one lane does is the same in whichever
lane, so the result does not depend on how a record is divided among them.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

from ..stage_list import StageList
from .program import Assign, Program, Sizes
from .python import Python

HIGH, DEEP = 4, 4  # rows and products that are written out together


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
    types = {"rows": "i8", "write": "b1", "first": "i8[::1]"}
    types |= {name: "f8[:,::1]" for name in lanes.matrices(program)}
    types |= {lanes.carried[1]: "f8[::1]", lanes.read: "f8[:,::1]"}
    return types | {lanes.written: "f8[:,::1]", "largest": "f8[::1]"}


def source(lanes: Lanes, program: Program, sizes: Sizes, count: int) -> str:
    """The text of a module with the function `run`.

    ``run(rows, write, first, ...)`` works on `rows` rows in each of `count` lanes, lane
    l from row ``first[l]`` on.  What is carried comes as entries of all lanes one after
    the other, and is left as after the last row.  Results are written if `write`.
    ``largest`` takes up the largest |entry| of what is carried and of what is read, and
    the largest squared length of what is weighed: again entry by entry, all lanes.
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
    def __init__(
        self, lanes: Lanes, program: Program, sizes: Sizes, count: int, to: Python
    ) -> None:
        self.lanes, self.program, self.sizes = lanes, program, sizes
        self.count, self.to = count, to
        self.result, self.given = lanes.carried
        self.long = {
            name: program.shape(name, sizes)[0]
            for name in (self.given, lanes.read, self.result, lanes.weighed)
        }

    def write(self) -> None:
        to, L, long = self.to, self.count, self.long
        n, k = long[self.given], long[self.lanes.read]
        for name, length in long.items():
            to.let(name, f"array({max(length, 1) * L})")
        to.let("sums", f"array({HIGH * L})")
        to.let("most", f"array({(n + k + 1) * L})")
        to.fill(f"{self.given}[i]", f"{self.given}_[i]", n * L)
        to.fill("most[i]", "largest_[i]", (n + k + 1) * L)
        to.loop("t", 0, "rows_")
        self.read(k)
        for step in self.program.steps:
            assert isinstance(step, Assign)
            self.assign(step)
        to.fill(f"{self.given}[i]", f"{self.result}[i]", n * L)
        self.keep(n, k)
        to.line("if write_:")
        to.depth += 1
        to.loop("l", 0, L)
        to.let("row", "first_[l] + t")
        for_all = f"{self.lanes.written}_[row, i]", f"{self.given}[i * {L} + l]"
        to.fill(*for_all, n)
        to.end()
        to.end()
        to.end()
        to.fill(f"{self.given}_[i]", f"{self.given}[i]", n * L)
        to.fill("largest_[i]", "most[i]", (n + k + 1) * L)

    def read(self, k: int) -> None:
        to, name = self.to, self.lanes.read
        to.loop("l", 0, self.count)
        to.let("row", "first_[l] + t")
        to.fill(f"{name}[i * {self.count} + l]", f"{name}_[row, i]", k)
        to.end()

    def keep(self, n: int, k: int) -> None:
        """The largest entries, and the largest squared length."""
        to, L = self.to, self.count
        for name, begin, length in ((self.given, 0, n), (self.lanes.read, n, k)):
            at = f"most[i + {begin * L}]" if begin else "most[i]"
            to.fill(at, f"max({at}, abs({name}[i]))", length * L)
        to.loop("l", 0, L)
        to.let("s", "0.0")
        for i in range(self.long[self.lanes.weighed]):
            to.let("w", f"{self.lanes.weighed}[{i * L} + l]")
            to.set("s", "w * w", "+=")
        to.set(f"most[{(n + k) * L} + l]", f"max(most[{(n + k) * L} + l], s)")
        to.end()

    def assign(self, step: Assign) -> None:
        """A target, some rows at a time."""
        to, rows = self.to, self.program.shape(step.target, self.sizes)[0]
        whole = rows // HIGH * HIGH
        if whole:
            to.loop("i", "0", f"{whole}, {HIGH}")
            self.block(step, "i", HIGH)
            to.end()
        if rows % HIGH:
            self.block(step, str(whole), rows % HIGH)

    def block(self, step: Assign, first: str, high: int) -> None:
        to, L = self.to, self.count
        to.loop("l", 0, L)
        for r in range(high):
            to.set(f"sums[{r * L} + l]", "0.0")
        to.end()
        for term in step.terms:
            assert term.scale == 1 and not term.factors[0].turned
            matrix, vector = (factor.name for factor in term.factors)
            for loop, columns in _parts(self.long[vector]):
                if loop:
                    to.loop("k", *loop)
                self.products(matrix, vector, first, high, columns)
                if loop:
                    to.end()
        to.loop("l", 0, L)
        for r in range(high):
            to.set(f"{step.target}[({first} + {r}) * {L} + l]", f"sums[{r * L} + l]")
        to.end()

    def products(
        self, matrix: str, vector: str, first: str, high: int, columns: list[str]
    ) -> None:
        to, L = self.to, self.count
        for r in range(high):
            for c, column in enumerate(columns):
                to.let(f"a{r}_{c}", f"{matrix}_[{first} + {r}, {column}]")
        to.loop("l", 0, L)
        for c, column in enumerate(columns):
            to.let(f"b{c}", f"{vector}[({column}) * {L} + l]")
        for r in range(high):
            found = " + ".join(f"a{r}_{c} * b{c}" for c in range(len(columns)))
            to.set(f"sums[{r * L} + l]", found, "+=")
        to.end()


def _parts(length: int) -> Iterator[tuple[Any, list[str]]]:
    """The columns of a product: those of a loop over `k`, and the rest."""
    whole = length // DEEP * DEEP
    if whole:
        yield ("0", f"{whole}, {DEEP}"), [f"k + {c}" for c in range(DEEP)]
    if length % DEEP:
        yield None, [str(c) for c in range(whole, length)]


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
