"""Write a lowered program out as loops over arrays at frozen sizes.

Arrays are flat, row by row, so an index is written out with the size in it, and a
transpose is an index turned round.  A `Writer` knows a language; what the loops are
is the same for Python and C.
"""

from .program import IDENTITY, Assign, Factor


class Writer:
    """Lines of code in a language with loops; indented by four."""

    def __init__(self, depth=1):
        self.lines, self.depth = [], depth

    def line(self, text):
        self.lines.append("    " * self.depth + text)

    def let(self, name, text):
        """A scalar that changes."""
        raise NotImplementedError

    def loop(self, index, start, stop):
        raise NotImplementedError

    def end(self):
        """End of a loop or a condition."""
        raise NotImplementedError

    def need(self, text):
        """Note a failure unless the condition holds."""
        raise NotImplementedError

    def set(self, target, text, sign="="):
        self.line(f"{target} {sign} {text}" + self.stop)


def write(program, sizes, writer):
    """Write every step of `program` at `sizes`; arrays are there, of their size."""
    work = _Loops(program, sizes, writer)
    for step in program.steps:
        if step_tag := getattr(step, "equation", ""):
            writer.line(f"{writer.comment} {step_tag}")
        if isinstance(step, Assign):
            work.assign(step)
        elif isinstance(step, Factor):
            work.factor(step)
        else:
            work.substitute(step)


def arrays(program, sizes):
    """Lengths of the arrays that the steps write, factors included, by name."""
    lengths = {}
    for step in program.steps:
        if isinstance(step, Factor):
            rows, cols = program.shape(step.matrix, sizes)
            lengths[f"{step.matrix}_l"] = rows * cols
        else:
            rows, cols = program.shape(step.target, sizes)
            lengths[step.target] = rows * cols
    return lengths


class _Loops:
    def __init__(self, program, sizes, writer):
        self.program, self.sizes, self.to = program, sizes, writer

    def at(self, name, i, j):
        _, cols = self.program.shape(name, self.sizes)
        if cols == 1:
            return f"{name}[{i}]"
        return f"{name}[{i} * {cols} + {j}]"

    def of(self, operand, i, j):
        i, j = (j, i) if operand.turned else (i, j)
        return self.at(operand.name, i, j)

    def assign(self, step):
        to = self.to
        rows, cols = self.program.shape(step.target, self.sizes)
        single = [t for t in step.terms if len(t.factors) == 1]
        double = [t for t in step.terms if len(t.factors) == 2]
        first = [t for t in single if t.factors[0].name != IDENTITY]
        to.loop("i", 0, rows)
        to.loop("j", "i" if step.symmetric else 0, cols)
        to.let("s", self.sum(first))
        for term in double:
            left, right = term.factors
            to.loop("k", 0, self.width(left))
            product = f"{self.of(left, 'i', 'k')} * {self.of(right, 'k', 'j')}"
            to.set("s", *_signed(term.scale, product))
            to.end()
        to.set(self.at(step.target, "i", "j"), "s")
        if step.symmetric:
            to.set(self.at(step.target, "j", "i"), "s")
        to.end()
        to.end()
        for term in single:
            if term.factors[0].name == IDENTITY:
                to.loop("i", 0, rows)
                to.set(self.at(step.target, "i", "i"), *_signed(term.scale, "1.0"))
                to.end()

    def sum(self, terms):
        text = ""
        for term in sorted(terms, key=lambda term: term.scale < 0):
            value, sign = _signed(term.scale, self.of(term.factors[0], "i", "j"))
            text += f" {sign[0]} {value}" if text else f"{sign[0]}{value}".lstrip("+")
        return text or "0.0"

    def width(self, operand):
        rows, cols = self.program.shape(operand.name, self.sizes)
        return rows if operand.turned else cols

    def factor(self, step):
        """matrix = L d L': L below the diagonal of the array, 1 / d on it.

        The row under work holds L d above... until its pivot is known.
        """
        to, M, name = self.to, step.matrix, f"{step.matrix}_l"
        size, _ = self.program.shape(M, self.sizes)

        def L(i, j):
            return f"{name}[{i} * {size} + {j}]"

        to.loop("i", 0, size)
        to.loop("j", 0, "i")  # L d in row i, column by column
        to.let("s", self.at(M, "i", "j"))
        to.loop("k", 0, "j")
        to.set("s", f"{L('i', 'k')} * {L('j', 'k')}", "-=")
        to.end()
        to.set(L("i", "j"), "s")
        to.end()
        to.let("s", self.at(M, "i", "i"))
        to.loop("k", 0, "i")  # divide by d, and take the row off the pivot
        to.let("q", f"{L('i', 'k')} * {L('k', 'k')}")
        to.set("s", f"{L('i', 'k')} * q", "-=")
        to.set(L("i", "k"), "q")
        to.end()
        bound = f"{step.tol!r} * {self.at(M, 'i', 'i')}" if step.tol else "0.0"
        to.need(f"s > {bound}")
        to.set(L("i", "i"), "1.0 / s")
        to.end()

    def substitute(self, step):
        """target L d L' = right, row by row."""
        to, name, target = self.to, f"{step.matrix}_l", step.target
        rows, size = self.program.shape(target, self.sizes)

        def L(i, j):
            return f"{name}[{i} * {size} + {j}]"

        to.loop("i", 0, rows)
        to.loop("j", 0, size)
        to.let("s", self.of(step.right, "i", "j"))
        to.loop("k", 0, "j")
        to.set("s", f"{L('j', 'k')} * {self.at(target, 'i', 'k')}", "-=")
        to.end()
        to.set(self.at(target, "i", "j"), "s")
        to.end()
        to.loop("j", 0, size)
        to.set(self.at(target, "i", "j"), L("j", "j"), "*=")
        to.end()
        to.loop("back", 1, size)
        to.index("j", f"{size - 1} - back")
        to.let("s", self.at(target, "i", "j"))
        to.loop("k", "j + 1", size)
        to.set("s", f"{L('k', 'j')} * {self.at(target, 'i', 'k')}", "-=")
        to.end()
        to.set(self.at(target, "i", "j"), "s")
        to.end()
        to.end()


def _signed(scale, text):
    """The text times |scale|, and the operator that adds it with its sign."""
    size = abs(scale)
    text = text if size == 1 else f"{float(size)!r} * {text}"
    return text, "-=" if scale < 0 else "+="
