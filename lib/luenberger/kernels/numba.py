"""Print a recursion, its loop over time included, as Python that numba compiles."""

from .loops import Writer, arrays, write
from .scalars import Let

START = ("start", "stop", "now", "before", "good", "keep")


class Python(Writer):
    """Python, in the part of it that numba compiles."""

    comment, stop = "#", ""

    def let(self, name, text):
        self.line(f"{name} = {text}")

    index = let

    def loop(self, index, start, stop):
        span = f"{stop}" if start == 0 else f"{start}, {stop}"
        self.line(f"for {index} in range({span}):")
        self.depth += 1

    def end(self):
        self.depth -= 1

    def need(self, text):
        self.line(f"if not {text}:")
        self.line("    ok = False")


def arguments(recursion):
    """Names of the arguments of `run`, in order, and the numba type of each."""
    types = dict(zip(START, ("i8", "i8", "i8[::1]", "i8[::1]", "b1[::1]", "b1")))
    for array, _ in recursion.rows.values():
        types[array] = "f8[:,::1]"
    for name in recursion.matrices:
        types[name] = "f8[:,::1]"
    for name in recursion.carried.values():
        types[name] = "f8[::1]"
    for array, *_ in recursion.written:
        types[array] = "f8[:,::1]"
    return types


def source(recursion, sizes, known, changing, unrolled):
    """The text of a module with the function `run`.

    ``run(start, stop, now, before, good, keep, ...)`` works on rows start to stop
    and returns the row at which it gave up, or stop.  Matrices come as stacks
    (S, rows * cols), of which row k uses index ``now[k]``, or ``before[k]`` for those
    of the instant before; a matrix that is not `changing` uses index 0.  What is
    carried comes flat and is left as after the last row that was done.

    Parameters
    ----------
    recursion : Recursion
    sizes : dict of str to int
    known : dict of str to nested tuples
        Entries that are 0 or 1; see `scalars.unroll`.
    changing : set of str
        Matrices whose index changes from row to row.
    unrolled : Straight or None
        Scalar code, or None for loops.
    """
    form = "loops" if unrolled is None else "scalars"
    to = Python(0)
    shown = ", ".join(f"{name} = {value}" for name, value in sorted(sizes.items()))
    to.line(f'"""{recursion.name}, {shown}, as {form}.  Generated: do not edit."""')
    to.line("import numpy as np\n\n")
    to.line(f"def run({', '.join(f'{name}_' for name in arguments(recursion))}):")
    to.depth = 1
    body = _Scalars if unrolled else _LoopBody
    body(recursion, sizes, changing, unrolled, to).write()
    return "\n".join(to.lines) + "\n"


class _Body:
    """The function's body around the steps; arguments end in an underscore."""

    def __init__(self, recursion, sizes, changing, unrolled, to):
        self.recursion, self.sizes, self.to = recursion, sizes, to
        self.changing, self.unrolled = changing, unrolled
        self.program = recursion.program

    def write(self):
        to, all_ = self.to, self.recursion.matrices
        to.let("done", "stop_")
        self.prepare()
        self.read([name for name in all_ if name not in self.changing])
        to.loop("row", "start_", "stop_")
        to.line("if not good_[row]:")
        self.give_up()
        self.read([name for name in all_ if name in self.changing])
        self.steps()
        for array, result, kind in self.recursion.written:
            self.put(array, self.program.results[result], result, kind)
        self.carry()
        to.end()
        self.leave()
        to.line("return done")

    def give_up(self):
        self.to.line("    done = row")
        self.to.line("    break")

    def index(self, name):
        if name not in self.changing:
            return "0"
        return "before_[row]" if name in self.recursion.before else "now_[row]"

    def shape(self, name):
        return self.program.shape(name, self.sizes)


class _Scalars(_Body):
    def prepare(self):
        for name in self.recursion.carried.values():
            _, cols = self.shape(name)
            for i, j, entry in self.unrolled.given.get(name, ()):
                self.to.let(entry, f"{name}_[{i * cols + j}]")

    def read(self, names):
        for name in names:
            _, cols = self.shape(name)
            for i, j, entry in self.unrolled.given[name]:
                self.to.let(entry, f"{name}_[{self.index(name)}, {i * cols + j}]")

    def steps(self):
        to = self.to
        for name, (array, ahead) in self.recursion.rows.items():
            row = f"row + {ahead}" if ahead else "row"
            for i, _, entry in self.unrolled.given.get(name, ()):
                to.let(entry, f"{array}_[{row}, {i}]")
        for one in self.unrolled.statements:
            if isinstance(one, Let):
                to.let(one.name, one.text)
            else:
                to.line(f"if not {one.text}:")
                self.give_up()

    def put(self, array, operand, result, kind):
        table = self.entries(operand, result)
        if kind == "diagonal":
            entries = [row[i] for i, row in enumerate(table)]
        else:
            entries = [entry for row in table for entry in row]
        if kind == "matrix":
            self.to.line("if keep_:")
        pad = "    " if kind == "matrix" else ""
        for k, entry in enumerate(entries):
            self.to.set(f"{pad}{array}_[row, {k}]", entry)

    def entries(self, operand, name):
        if operand is None:
            rows, cols = self.shape(name)
            return [[0.0] * cols] * rows
        table = self.unrolled.entries[operand.name]
        return list(zip(*table)) if operand.turned else table

    def carry(self):
        moves = []
        for result, name in self.recursion.carried.items():
            table = self.entries(self.program.results[result], result)
            for i, j, entry in self.unrolled.given.get(name, ()):
                moves.append((entry, table[i][j]))
        for k, (_, value) in enumerate(moves):
            self.to.let(f"c{k}", value)
        for k, (entry, _) in enumerate(moves):
            self.to.let(entry, f"c{k}")

    def leave(self):
        for name in self.recursion.carried.values():
            table = self.unrolled.entries[name]
            for k, entry in enumerate(entry for row in table for entry in row):
                self.to.set(f"{name}_[{k}]", entry)


class _LoopBody(_Body):
    def prepare(self):
        for name, length in arrays(self.program, self.sizes).items():
            self.to.let(name, f"np.empty({length})")
        for name in self.recursion.rows:
            if name in self.program.given:
                self.to.let(name, f"np.empty({self.shape(name)[0]})")
        for name in self.recursion.carried.values():
            self.to.let(name, f"{name}_")

    def read(self, names):
        for name in names:
            self.to.let(name, f"{name}_[{self.index(name)}]")

    def steps(self):
        to = self.to
        for name, (array, ahead) in self.recursion.rows.items():
            if name in self.program.given:
                row = f"row + {ahead}" if ahead else "row"
                self.copy(f"{name}[i]", f"{array}_[{row}, i]", self.shape(name)[0])
        to.let("ok", "True")
        write(self.program, self.sizes, to)
        to.line("if not ok:")
        self.give_up()

    def copy(self, target, value, length):
        self.to.loop("i", 0, length)
        self.to.set(target, value)
        self.to.end()

    def put(self, array, operand, result, kind):
        to, name = self.to, operand.name
        rows, cols = self.shape(name)
        if kind == "diagonal":
            self.copy(f"{array}_[row, i]", f"{name}[i * {cols + 1}]", rows)
            return
        if kind == "matrix":
            to.line("if keep_:")
            to.depth += 1
        self.copy(f"{array}_[row, i]", f"{name}[i]", rows * cols)
        if kind == "matrix":
            to.end()

    def carry(self):
        for result, name in self.recursion.carried.items():
            rows, cols = self.shape(name)
            found = self.program.results[result]
            self.copy(f"{name}[i]", f"{found.name}[i]", rows * cols)

    def leave(self):
        pass
