"""Print one step of a lowered program as a C99 function: loops, or scalars.

The function allocates nothing, calls nothing and keeps nothing:

    static int NAME(const double A[9], ..., double K_out[6], ...)

reads the program's given matrices, row by row, and writes its results that are not
zero; it returns 0, or 1 as soon as a pivot shows that a matrix is not definite.
Compile without -ffast-math, which would let the pivots' tests be dropped.
"""

import re

from .loops import Writer, arrays, write
from .scalars import WORD, Let, unroll

LITERAL = re.compile(r"(?<![\w.])(\d+\.\d*(?:e[+-]?\d+)?|\d+e[+-]?\d+)")


class C(Writer):
    """C99; `real` is "double" or "float"."""

    comment, stop = "//", ";"

    def __init__(self, real, depth=1):
        super().__init__(depth)
        self.real = real

    def line(self, text):
        super().line(LITERAL.sub(r"\1f", text) if self.real == "float" else text)

    def let(self, name, text):
        self.line(f"{self.real} {name} = {text};")

    def constant(self, name, text):
        self.line(f"const {self.real} {name} = {text};")

    def index(self, name, text):
        self.line(f"const int {name} = {text};")

    def array(self, name, length):
        self.line(f"{self.real} {name}[{max(length, 1)}];")

    def loop(self, index, start, stop):
        self.line(f"for (int {index} = {start}; {index} < {stop}; {index}++) {{")
        self.depth += 1

    def end(self):
        self.depth -= 1
        self.line("}")

    def need(self, text):
        self.line(f"if (!({text})) return 1;")

    def copy(self, target, source, length):
        self.loop("i", 0, length)
        self.set(f"{target}[i]", f"{source}[i]")
        self.end()


def function(program, sizes, name, *, known=None, unrolled=False, real="double"):
    """The text of a static C function that does one pass through the steps.

    Parameters
    ----------
    program : Program
    sizes : dict of str to int
    name : str
        A C identifier.
    known : dict of str to table, optional
        With `unrolled`, entries that are 0 or 1; see `scalars.unroll`.
    unrolled : bool
        Scalars instead of loops.
    real : "double" or "float"
    """
    to = C(real)
    if unrolled:
        _scalars(program, unroll(program, sizes, known), sizes, to)
    else:
        _loops(program, sizes, to)
    to.line("return 0;")
    head = f"static int {name}({', '.join(parameters(program, sizes, real))})"
    return "\n".join([head, "{", *to.lines, "}"]) + "\n"


def outputs(program):
    """Names of the results that the function writes, in order; the rest are zero."""
    return [name for name, operand in program.results.items() if operand is not None]


def parameters(program, sizes, real="double"):
    """Declarations of the function's parameters: given matrices, then results."""

    def length(name):
        rows, cols = program.shape(name, sizes)
        return max(rows * cols, 1)

    out = [f"const {real} {name}[{length(name)}]" for name in program.given]
    for name in outputs(program):
        size = length(program.results[name].name)
        out.append(f"{real} {name}_out[{size}]")
    return out


def _loops(program, sizes, to):
    for name, length in arrays(program, sizes).items():
        to.array(name, length)
    write(program, sizes, to)
    for name in outputs(program):
        operand = program.results[name]
        rows, cols = program.shape(operand.name, sizes)
        if not operand.turned or 1 in (rows, cols):
            to.copy(f"{name}_out", operand.name, rows * cols)
            continue
        to.loop("i", 0, cols)
        to.loop("j", 0, rows)
        to.set(f"{name}_out[i * {rows} + j]", f"{operand.name}[j * {cols} + i]")
        to.end()
        to.end()


def _scalars(program, straight, sizes, to):
    results = []
    for name in outputs(program):
        operand = program.results[name]
        table = straight.entries[operand.name]
        table = zip(*table) if operand.turned else table
        results += [
            (f"{name}_out[{k}]", entry)
            for k, entry in enumerate(entry for row in table for entry in row)
        ]
    used = {word for one in straight.statements for word in WORD.findall(one.text)}
    used |= {entry for _, entry in results}
    for name in program.given:
        _, cols = program.shape(name, sizes)
        read = [(i, j, e) for i, j, e in straight.given[name] if e in used]
        for i, j, entry in read:
            to.constant(entry, f"{name}[{i * cols + j}]")
        if not read:
            to.line(f"(void){name};")
    for one in straight.statements:
        if isinstance(one, Let):
            to.constant(one.name, one.text)
        else:
            to.need(one.text)
    for target, entry in results:
        to.set(target, entry if isinstance(entry, str) else repr(entry))
