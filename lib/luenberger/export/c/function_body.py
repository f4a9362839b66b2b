"""A lowered program as the body of a C function, its constants written into it."""

from dataclasses import dataclass, field, replace

import numpy as np

from .identifiers import listed

SHORT, LONG = 400, 3000  # operations: scalars up to SHORT; up to LONG if mostly zeros
SPARSE = 3  # that is, where loops would do this many times the work
FLOAT_TOL = 1e-6  # a pivot relative to its diagonal: float has 1.2e-7


@dataclass
class Cost:
    """Operations of one pass, and numbers kept in tables and on the stack.

    `terms` counts the products and names that sums add up: multiply-adds, where
    nothing is divided.
    """

    operations: int = 0
    constants: int = 0
    stack: int = 0
    terms: int = 0

    def __add__(self, other):
        return Cost(
            self.operations + other.operations,
            self.constants + other.constants,
            self.stack + other.stack,
            self.terms + other.terms,
        )


@dataclass
class Module:
    """What the functions of one C file share: its name, number type and tables."""

    name: str
    real: str
    tables: dict = field(default_factory=dict)

    def steps(self, program, sizes, to, constants, places, results):
        """Write one pass of `program`; return its Cost.

        Parameters
        ----------
        program : Program
        sizes : dict of str to int
        to : kernels.c.C
        constants : dict of str to ndarray
            Given matrices that never change; zeros and ones in them cost nothing
            where the pass is short enough to be written as scalars.
        places : dict of str to str
            C names of the other given matrices, where they are not their own.
        results : dict of str to (str, int)
            C arrays that take the results, and their lengths.
        """
        if self.real == "float":
            steps = (
                replace(step, tol=FLOAT_TOL) if getattr(step, "tol", 0) else step
                for step in program.steps
            )
            program = replace(program, steps=tuple(steps))
        constants = {k: v for k, v in constants.items() if k in program.given}
        straight = _straight(program, sizes, constants)
        write = self._loops if straight is None else self._scalars
        return write(program, sizes, to, constants, places, results, straight)

    def _scalars(self, program, sizes, to, constants, places, results, straight):
        from ...kernels.scalars import WORD, Let

        wanted = _results(program, straight.entries, results)
        used = {entry for _, entry in wanted}
        used |= {w for one in straight.statements for w in WORD.findall(one.text)}
        read = 0
        for name in program.given:
            _, cols = program.shape(name, sizes)
            for i, j, entry in straight.given[name]:
                if name not in constants and entry in used:
                    place = places.get(name, name)
                    to.constant(entry, f"{place}[{i * cols + j}]")
                    read += 1
        lets = 0
        for one in straight.statements:
            if isinstance(one, Let):
                to.constant(one.name, one.text)
                lets += 1
            else:
                to.need(one.text)
        for target, entry in wanted:
            to.set(target, entry if isinstance(entry, str) else repr(entry))
        text = "\n".join(one.text for one in straight.statements)
        numbers = sum(not w[0].isalpha() for w in text.split() if w[0].isalnum())
        terms = lets + sum(text.count(sign) for sign in (" + ", " - "))
        return Cost(straight.operations, numbers, read + lets, terms)

    def _loops(self, program, sizes, to, constants, places, results, _):
        from ...kernels.rows import Rows

        own = {name: f"{self.name}_{name}" for name in constants}
        work = Rows(program, sizes, to, own | places, constants)
        work.write()
        before = sum(np.size(X) for X in self.tables.values())
        for name, X in constants.items():
            for label, table in ((own[name], X), (f"{own[name]}_t", X.T)):
                if label in work.tables:
                    self.tables[label] = table
        for name, (place, length) in results.items():
            operand = program.results[name]
            if operand is not None:
                to.copy(place, work.straight(operand), length)
                continue
            to.loop("i", 0, length)
            to.set(f"{place}[i]", "0.0")
            to.end()
        added = sum(np.size(X) for X in self.tables.values()) - before
        return Cost(work.operations, added, work.stack, work.operations // 2)

    def table_lines(self):
        """The tables as C declarations."""
        return [
            f"static const {self.real} {name}[{X.size}] = {self.numbers(X)};"
            for name, X in self.tables.items()
        ]

    def numbers(self, X):
        """A braced list of numbers of this module's type."""
        return self.literal(listed(X))

    def number(self, value):
        """One number of this module's type."""
        return self.literal(repr(float(value)))

    def literal(self, text):
        from ...kernels.c import LITERAL

        return LITERAL.sub(r"\1f", text) if self.real == "float" else text


def _straight(program, sizes, constants):
    """The pass as scalars if that is the faster form, else None."""
    from ...kernels.c import C
    from ...kernels.rows import Rows
    from ...kernels.scalars import unroll

    loops = Rows(program, sizes, C("double"))
    loops.write()
    if loops.operations > 100 * LONG:
        return None  # unrolling alone would take a while
    known = {name: X.tolist() for name, X in constants.items()}
    straight = unroll(program, sizes, known)
    sparse = SPARSE * straight.operations < loops.operations
    if straight.operations > (LONG if sparse else SHORT):
        return None
    return straight


def _results(program, entries, results):
    """(C entry, name or number) of each result, row by row."""
    wanted = []
    for name, (place, length) in results.items():
        operand, flat = program.results[name], [0.0] * length
        if operand is not None:
            table = entries[operand.name]
            table = zip(*table) if operand.turned else table
            flat = [entry for row in table for entry in row]
        wanted += [(f"{place}[{k}]", entry) for k, entry in enumerate(flat)]
    return wanted
