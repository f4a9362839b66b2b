"""Write a lowered program out as C loops whose innermost loop runs along rows.

A product is summed row by row, a substitution column by column of the solution, so
that neighbours in memory are computed together: a compiler makes vector code of that
without -ffast-math, which a sum over the innermost loop does not allow.
"""

from .program import IDENTITY, Assign, Factor


class Rows:
    """The steps of a program as loops at frozen sizes, written as they are visited.

    Parameters
    ----------
    program : Program
    sizes : dict of str to int
    to : c.C
        Where the lines go.
    places : dict of str to str
        What given matrices are called in C, where not by their own name.
    constant : set of str
        Given matrices of which a table of the transpose, NAME_t, can be had.

    Attributes
    ----------
    operations : int
        Additions, multiplications, divisions and comparisons of one pass.
    stack : int
        Numbers in the arrays of one pass.
    tables : set of str
        C names of the constant matrices, and transposes of such, that are read.
    """

    def __init__(self, program, sizes, to, places=(), constant=()):
        self.program, self.sizes, self.to = program, sizes, to
        self.places, self.constant = dict(places), set(constant)
        self.turned, self.declared = {}, set()
        self.operations, self.stack, self.tables = 0, 0, set()

    def write(self):
        for step in (*self.program.steps, *self.program.definite):
            if getattr(step, "equation", ""):
                self.to.line(f"{self.to.comment} {step.equation}")
            if isinstance(step, Assign):
                self.assign(step)
            elif isinstance(step, Factor):
                self.factor(step)
            else:
                self.substitute(step)

    # -- names ------------------------------------------------------------------

    def shape(self, operand):
        rows, cols = self.program.shape(operand.name, self.sizes)
        return (cols, rows) if operand.turned else (rows, cols)

    def place(self, name):
        place = self.places.get(name, name)
        if name in self.constant:
            self.tables.add(place)
        return place

    def array(self, name, rows, cols):
        if name not in self.declared:
            self.declared.add(name)
            self.to.array(name, rows * cols)
            self.stack += rows * cols

    def of(self, operand, i, j):
        """The entry (i, j)."""
        i, j = (j, i) if operand.turned else (i, j)
        _, cols = self.program.shape(operand.name, self.sizes)
        return f"{self.place(operand.name)}[{i} * {cols} + {j}]"

    def straight(self, operand):
        """An array that holds the operand row by row."""
        name = operand.name
        cols, rows = self.shape(operand)
        if not operand.turned or 1 in (rows, cols):
            return self.place(name)
        if name in self.constant:
            self.tables.add(f"{self.places.get(name, name)}_t")
            return f"{self.places.get(name, name)}_t"
        if name not in self.turned:
            self.turned[name] = f"{name}_t"
            self.array(f"{name}_t", rows, cols)
            self.transpose(f"{name}_t", self.place(name), cols, rows)
        return self.turned[name]

    def transpose(self, target, source, rows, cols):
        self.to.loop("i", 0, rows)
        self.to.loop("j", 0, cols)
        self.to.set(f"{target}[i * {cols} + j]", f"{source}[j * {rows} + i]")
        self.to.end()
        self.to.end()

    # -- steps ------------------------------------------------------------------

    def assign(self, step):
        to, name = self.to, step.target
        rows, cols = self.program.shape(name, self.sizes)
        products = [t for t in step.terms if len(t.factors) == 2]
        rights = [self.straight(t.factors[1]) for t in products]
        self.array(name, rows, cols)
        to.loop("i", 0, rows)
        to.loop("j", 0, cols)
        to.set(f"{name}[i * {cols} + j]", self.sum(step, rows * cols))
        to.end()
        for term, right in zip(products, rights):
            left, inner = term.factors[0], self.shape(term.factors[0])[1]
            to.loop("k", 0, inner)
            to.constant("s", _scaled(term.scale, self.of(left, "i", "k")))
            to.loop("j", 0, cols)
            sign = "-=" if term.scale < 0 else "+="
            to.set(f"{name}[i * {cols} + j]", f"s * {right}[k * {cols} + j]", sign)
            to.end()
            to.end()
            self.operations += rows * inner * (2 * cols + (abs(term.scale) != 1))
        to.end()
        for term in step.terms:
            if [f.name for f in term.factors] == [IDENTITY]:
                to.loop("i", 0, rows)
                to.set(f"{name}[i * {cols} + i]", repr(float(term.scale)), "+=")
                to.end()
                self.operations += rows
        if step.symmetric:
            to.loop("i", 1, rows)
            to.loop("j", 0, "i")
            to.set(f"{name}[i * {cols} + j]", f"{name}[j * {cols} + i]")
            to.end()
            to.end()

    def sum(self, step, entries):
        """The terms that are one matrix, added up."""
        text = ""
        one = (t for t in step.terms if len(t.factors) == 1)
        one = [t for t in one if t.factors[0].name != IDENTITY]
        for term in sorted(one, key=lambda term: term.scale < 0):
            value = _scaled(term.scale, self.of(term.factors[0], "i", "j"))
            sign = "-" if term.scale < 0 else "+"
            text += (
                f" {sign} {value}" if text else value if sign == "+" else f"-{value}"
            )
        self.operations += entries * (max(len(one) - 1, 0) + text.count(" * ("))
        return text or "0.0"

    def factor(self, step):
        """matrix = L d L': L below the diagonal of the array, 1 / d on it."""
        to, name = self.to, f"{step.matrix}_l"
        matrix = self.place(step.matrix)
        size, _ = self.program.shape(step.matrix, self.sizes)

        def L(i, j):
            return f"{name}[{i} * {size} + {j}]"

        self.array(name, size, size)
        to.copy(name, matrix, size * size)
        to.loop("k", 0, size)
        unit = f"{matrix}[k * {size} + k]"
        if step.beside:
            unit = f"({unit} + {self.place(step.beside)}[k * {size} + k])"
        bound = f"{step.tol!r} * {unit}" if step.tol else "0.0"
        to.need(f"{L('k', 'k')} > {bound}")
        to.set(L("k", "k"), f"1.0 / {L('k', 'k')}")
        to.loop("i", "k + 1", size)  # the row k is still above the diagonal
        to.constant("s", f"{L('k', 'i')} * {L('k', 'k')}")
        to.loop("j", "i", size)
        to.set(L("i", "j"), f"s * {L('k', 'j')}", "-=")
        to.end()
        to.set(L("i", "k"), "s")
        to.end()
        to.end()
        self.operations += size * (2 + bool(step.tol)) + size * (size - 1) // 2
        self.operations += size * (size - 1) * (size + 1) // 3

    def substitute(self, step):
        """target L d L' = right, for all rows of target at a time."""
        to, name = self.to, step.target
        rows, size = self.program.shape(name, self.sizes)
        found = self.turned[name] = f"{name}_t"

        def less(j):
            """Take L(j, k) times the column k, or L(k, j) times it, off column j."""
            to.loop("i", 0, rows)
            to.set(f"{found}[j * {rows} + i]", f"s * {found}[k * {rows} + i]", "-=")
            to.end()
            to.end()

        self.array(found, size, rows)
        to.loop("j", 0, size)
        to.loop("i", 0, rows)
        to.set(f"{found}[j * {rows} + i]", self.of(step.right, "i", "j"))
        to.end()
        to.loop("k", 0, "j")
        to.constant("s", f"{step.matrix}_l[j * {size} + k]")
        less("j")
        to.end()
        to.loop("j", 0, size)
        to.constant("s", f"{step.matrix}_l[j * {size} + j]")
        to.loop("i", 0, rows)
        to.set(f"{found}[j * {rows} + i]", "s", "*=")
        to.end()
        to.end()
        to.loop("back", 1, size)
        to.index("j", f"{size - 1} - back")
        to.loop("k", "j + 1", size)
        to.constant("s", f"{step.matrix}_l[k * {size} + j]")
        less("j")
        to.end()
        self.array(name, rows, size)
        self.transpose(name, found, rows, size)
        self.operations += rows * size * (2 * size - 1)


def _scaled(scale, text):
    """The text times |scale|."""
    return text if abs(scale) == 1 else f"{float(abs(scale))!r} * {text}"
