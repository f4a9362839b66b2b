"""Print a recursion, its loop over time included, as Python that numba compiles."""

from collections.abc import Collection, Iterable
from typing import Any

from .asking_ahead import AskingAhead
from .in_place import in_place
from .inputs import arguments
from .loops import arrays, write, write_definite, write_turned
from .program import Sizes
from .python import Python, Tiled
from .recursion import Loop
from .scalars import Inverse, Let, Straight
from .taking_back import TakingBack, bounded, condition

PLACES = {"sum": ("0", "+=")}  # the row of an array, and how it is set
ON_STACK = 16_000  # numbers at most, 128 kB; more go to the heap


def source(
    loop: Loop,
    sizes: Sizes,
    changing: Collection[str],
    unrolled: Straight | None,
) -> str:
    """The text of a module with the function `run`.

    ``run(start, stop, now, before, good, keep, ...)`` works on rows start to stop
    and returns the row at which it gave up, or stop.  Matrices come as stacks
    (S, rows * cols), of which row k uses index ``now[k]``, or ``before[k]`` for those
    of the instant before; a matrix that is not `changing` uses index 0, and if none
    is, `now`, `before` and `good` are not read.  What is carried comes flat and is
    left as after the last row that was done.

    A recursion that runs backward has ``run(last, start, stop, keep, ...)``: rows are
    counted from the row `last` down, and a matrix that changes has one for each row.

    Where a recursion has `fresh`, row k begins with what was carried into the first
    row if ``fresh[k]``.

    Parameters
    ----------
    loop : Loop
    sizes : dict of str to int
    changing : set of str
        Matrices whose index changes from row to row.
    unrolled : Straight or None
        Scalar code, or None for loops.
    """
    form = "loops" if unrolled is None else "scalars"
    to = Tiled(0)
    shown = ", ".join(f"{name} = {value}" for name, value in sorted(sizes.items()))
    to.line(f'"""{loop.name}, {shown}, as {form}.  Generated: do not edit."""')
    to.line("import numpy as np\n\n")
    to.line(f"def run({', '.join(f'{name}_' for name in arguments(loop))}):")
    to.depth = 1
    body = _Scalars if unrolled else _LoopBody
    body(loop, sizes, changing, unrolled, to).write()
    return "\n".join(to.lines) + "\n"


class _Body:
    """The function's body around the steps; arguments end in an underscore."""

    prepare: Any  # what scalars and loops do in ways of their own
    begin: Any
    read: Any
    turn: Any
    steps: Any
    put: Any
    carry: Any
    leave: Any

    def __init__(
        self,
        loop: Loop,
        sizes: Sizes,
        changing: Collection[str],
        unrolled: Straight | None,
        to: Python,
    ) -> None:
        self.loop, self.recursion, self.to = loop, loop.recursion, to
        self.sizes, self.changing, self.unrolled = sizes, changing, unrolled
        self.program = loop.program
        self.backward = loop.recursion.backward
        self.count = "turn" if self.backward else "row"
        self.goods = bool(self.changing) and not self.backward

    def write(self) -> None:
        to, all_ = self.to, self.loop.matrices
        to.let("done", "stop_")
        self.prepare()
        self.read([name for name in all_ if name not in self.changing])
        self.turn()
        to.loop(self.count, "start_", "stop_")
        before = len(to.lines)
        if self.backward:
            to.let("row", "last_ - turn")
        if self.goods:
            to.line("if not good_[row]:")
            self.give_up()
        if self.recursion.fresh:
            to.line("if fresh_[row]:")
            to.depth += 1
            self.begin()
            to.end()
        self.read([name for name in all_ if name in self.changing])
        self.steps()
        for array, result, kind in self.recursion.written:
            self.put(array, self.program.results[result], result, kind)
        self.carry()
        if len(to.lines) == before:  # all that it finds vanishes
            to.line("pass")
        to.end()
        self.leave()
        to.line("return done")

    def give_up(self) -> None:
        self.to.line(f"    done = {self.count}")
        self.to.line("    break")

    def index(self, name: str) -> str:
        if name not in self.changing:
            return "0"
        if self.backward:
            return "row"
        return "before_[row]" if name in self.recursion.before else "now_[row]"

    def shape(self, name: str) -> tuple[int, int]:
        return self.program.shape(name, self.sizes)


class _Scalars(_Body):
    def turn(self) -> None:
        pass

    def prepare(self) -> None:
        self.begin()

    def begin(self) -> None:
        for name in self.loop.carried.values():
            _, cols = self.shape(name)
            for i, j, entry in self.unrolled.given.get(name, ()):
                self.to.let(entry, f"{name}_[{i * cols + j}]")

    def read(self, names: Iterable[str]) -> None:
        for name in names:
            _, cols = self.shape(name)
            for i, j, entry in self.unrolled.given[name]:
                self.to.let(entry, f"{name}_[{self.index(name)}, {i * cols + j}]")

    def steps(self) -> None:
        to = self.to
        for name, (array, ahead) in self.loop.rows.items():
            row = f"row + {ahead}" if ahead else "row"
            cols = self.shape(name)[1] if name in self.program.given else 1
            for i, j, entry in self.unrolled.given.get(name, ()):
                to.let(entry, f"{array}_[{row}, {i * cols + j}]")
        for one in self.unrolled.statements:
            if isinstance(one, Let):
                text = to.inverse(one.pivot) if isinstance(one, Inverse) else one.text
                to.let(one.name, text)
            else:
                to.line(f"if not {one.text}{one.but(' or ')}:")
                self.give_up()
        for name, beside, kind, bound in bounded(self.loop):
            for i in range(self.shape(name)[0]):
                rows = [self.unrolled.entries[one][i] for one in (name, beside)]
                both = [row[min(i, len(row) - 1)] for row in rows]
                to.line(f"if not {condition(kind, bound, both)}:")
                self.give_up()

    def put(self, array: str, operand: Any, result: str, kind: str) -> None:
        table = self.entries(operand, result)
        if kind == "diagonal":
            entries = [row[i] for i, row in enumerate(table)]
        else:
            entries = [entry for row in table for entry in row]
        if kind == "matrix":
            self.to.line("if keep_:")
        pad = "    " if kind == "matrix" else ""
        row, sign = PLACES.get(kind, ("row", "="))
        for k, entry in enumerate(entries):
            self.to.set(f"{pad}{array}_[{row}, {k}]", entry, sign)

    def entries(self, operand: Any, name: str) -> Any:
        if operand is None:
            rows, cols = self.shape(name)
            return [[0.0] * cols] * rows
        table = self.unrolled.entries[operand.name]
        return list(zip(*table)) if operand.turned else table

    def carry(self) -> None:
        moves = []
        for result, name in self.loop.carried.items():
            table = self.entries(self.program.results[result], result)
            for i, j, entry in self.unrolled.given.get(name, ()):
                moves.append((entry, table[i][j]))
        for k, (_, value) in enumerate(moves):
            self.to.let(f"c{k}", value)
        for k, (entry, _) in enumerate(moves):
            self.to.let(entry, f"c{k}")

    def leave(self) -> None:
        for name in self.loop.carried.values():
            table = self.unrolled.entries[name]
            for k, entry in enumerate(entry for row in table for entry in row):
                self.to.set(f"{name}_[{k}]", entry)


class _LoopBody(TakingBack, AskingAhead, _Body):
    """Loops; what they test, and what they take back, is in `taking_back`."""

    def prepare(self) -> None:
        lengths = arrays(self.program, self.sizes, self.to)
        self.places = in_place(self.loop)
        for name in self.loop.rows:
            if name in self.program.given:
                lengths[name] = self.length(name)
        for name in self.loop.carried.values():
            lengths[name] = lengths[f"{name}_kept"] = self.length(name)
        new = "array" if sum(lengths.values()) <= ON_STACK else "np.empty"
        for name, length in lengths.items():
            if name not in self.places:
                self.to.let(name, f"{new}({length})")
        for name, place in self.places.items():
            self.to.let(name, place)
        self.room()
        self.begin()
        self.keep("start_")

    def begin(self) -> None:
        for name in self.loop.carried.values():
            self.to.fill(f"{name}[i]", f"{name}_[i]", self.length(name))

    def turn(self) -> None:
        """Transposes of what does not change, before the loop over rows."""
        fixed = set(self.loop.matrices) - set(self.changing)
        self.turned = write_turned(self.program, self.sizes, self.to, fixed)

    def read(self, names: Iterable[str]) -> None:
        for name in names:
            self.to.let(name, f"{name}_[{self.index(name)}]")

    def steps(self) -> None:
        to = self.to
        for name, (array, ahead) in self.loop.rows.items():
            if name in self.program.given:
                row = f"row + {ahead}" if ahead else "row"
                self.to.fill(f"{name}[i]", f"{array}_[{row}, i]", self.length(name))
        self.hold()
        to.let("ok", "True")
        steps, tests = self.program.parted()
        write(steps, self.sizes, to, self.turned, after=self.ask)
        if self.program.definite:
            last = f"{self.count} + 1 == stop_"
            last += " or not good_[row + 1]" if self.goods else ""
            to.let("test", f"{self.count} % {self.every} == 0 or {last}")
            to.line("if test:")
            to.depth += 1
            write(tests, self.sizes, to, self.turned)
            write_definite(self.program, self.sizes, to)
            to.end()
        self.bounds()
        to.line("if not ok:")
        self.give_up()

    def put(self, array: str, operand: Any, result: str, kind: str) -> None:
        to, name = self.to, operand.name
        rows, cols = self.shape(name)
        if kind == "diagonal":
            self.to.fill(f"{array}_[row, i]", f"{name}[i * {cols + 1}]", rows)
            return
        if kind == "matrix":
            to.line("if keep_:")
            to.depth += 1
        row, sign = PLACES.get(kind, ("row", "="))
        self.to.fill(f"{array}_[{row}, i]", f"{name}[i]", rows * cols, sign)
        if kind == "matrix":
            to.end()

    def carry(self) -> None:
        for result, name in self.loop.carried.items():
            found = self.program.results[result]
            if self.places.get(found.name) != name:
                self.to.fill(f"{name}[i]", f"{found.name}[i]", self.length(name))
        if self.program.definite:
            self.to.line("if test:")
            self.to.depth += 1
            self.keep(f"{self.count} + 1")
            self.to.end()
        elif self.recursion.bounds and not self.backward:
            self.keep("row + 1")

    def leave(self) -> None:
        for name in self.loop.carried.values():
            self.to.fill(f"{name}_[i]", f"{name}[i]", self.length(name))
