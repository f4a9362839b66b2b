"""Write a lowered program out as scalars: no loops, no arrays, no work on zeros.

Every entry of a matrix is a number that is known beforehand, or a name.  What is
zero drops out, a factor of one is not multiplied, an entry below the diagonal of a
symmetric matrix is the entry above it, and equal expressions are computed once.
Expressions are plain enough for Python and C alike.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from . import guards
from .fused import Sums
from .program import (
    GUARDS,
    IDENTITY,
    Assign,
    Cost,
    Factor,
    Guard,
    Known,
    Operand,
    Program,
    Sizes,
    Substitute,
    Term,
)
from .statements import Entries as Entries
from .statements import Entry as Entry
from .statements import Inverse as Inverse
from .statements import Let as Let
from .statements import Need as Need
from .statements import Straight as Straight


def unroll(program: Program, sizes: Sizes, known: Known | None = None) -> Straight:
    """Unroll `program` at `sizes`; `known` holds entries that are numbers.

    Parameters
    ----------
    program : Program
    sizes : dict of str to int
    known : dict of str to nested sequence, optional
        For a given matrix its entries, 0.0 or 1.0 where they will always be that,
        and None where they are read at run time.
    """
    work = _Unrolling(program, sizes)
    for name in program.given:
        work.read(name, (known or {}).get(name))
    for step in program.steps:
        if isinstance(step, Assign):
            work.assign(step)
        elif isinstance(step, Factor):
            work.factor(step)
        elif isinstance(step, GUARDS):
            work.guard(step)
        else:
            work.substitute(step)
    for factor in program.definite:
        work.factor(factor)
    statements, used = _live(work.statements, program, work.entries)
    return Straight(statements, work.entries, work.given, used)


def _live(
    statements: list[Let | Need], program: Program, entries: Entries
) -> tuple[list[Let | Need], set[Any]]:
    """The statements without those whose result nothing reads, and what is read."""
    wanted, kept = set(), []
    for operand in program.results.values():
        table = entries[operand.name] if operand else []
        wanted |= {entry for row in table for entry in row}
    for one in reversed(statements):
        if isinstance(one, Need) or one.name in wanted:
            kept.append(one)
            wanted |= one.reads
    return kept[::-1], wanted


class _Unrolling:
    def __init__(self, program: Program, sizes: Sizes) -> None:
        self.program, self.sizes = program, sizes
        self.statements: list[Let | Need] = []
        self.entries: Entries = {}
        self.given: dict[str, list[tuple[int, int, str]]] = {}
        self.seen: dict[str, str] = {}
        self.factors: dict[str, tuple[list[list[Entry]], list[Entry]]] = {}

    def read(self, name: str, known: Sequence[Sequence[float | None]] | None) -> None:
        rows, cols = self.program.shape(name, self.sizes)
        table: list[list[Entry]] = [[None] * cols for _ in range(rows)]
        self.given[name] = []
        for i in range(rows):
            for j in range(cols):
                value = None if known is None else known[i][j]
                if value is None and name in self.program.symmetric and j < i:
                    value = table[j][i]
                elif value is None:
                    value = f"{name}_{i}_{j}"
                    self.given[name].append((i, j, value))
                table[i][j] = value
        self.entries[name] = table

    def of(self, operand: Operand, i: int, j: int) -> Entry:
        """The entry (i, j) of an operand."""
        if operand.name == IDENTITY:
            return float(i == j)
        i, j = (j, i) if operand.turned else (i, j)
        return self.entries[operand.name][i][j]

    def let(self, name: str, products: Iterable[Sequence[Entry]]) -> Entry:
        """The sum of `products`, each a sequence of numbers and names."""
        number, terms = 0.0, []
        for product in products:
            scale, names = 1.0, []
            for factor in product:
                if isinstance(factor, str):
                    names.append(factor)
                else:
                    scale *= factor
            if not names:
                number += scale
            elif scale:
                terms.append((scale, names))
        if not terms:
            return number
        text = _text(terms, number)
        if text.isidentifier():
            return text
        reads = _names(*(one for _, names in terms for one in names))
        cost = _cost(terms, number)
        return self.name(Let(name, text, reads, cost, terms, number))

    def name(self, one: Let) -> str:
        if one.text not in self.seen:
            self.seen[one.text] = one.name
            self.statements.append(one)
        return self.seen[one.text]

    def assign(self, step: Assign) -> None:
        rows, cols = self.program.shape(step.target, self.sizes)
        table = self.entries[step.target] = [[0.0] * cols for _ in range(rows)]
        for i in range(rows):
            for j in range(cols):
                if step.symmetric and j < i:
                    table[i][j] = table[j][i]
                    continue
                products = self.products(step.terms, i, j)
                table[i][j] = self.let(f"{step.target}_{i}_{j}", products)

    def products(
        self, terms: Iterable[Term], i: int, j: int
    ) -> Iterator[Sequence[Entry]]:
        for term in terms:
            scale = float(term.scale)
            if len(term.factors) == 1:
                yield scale, self.of(term.factors[0], i, j)
                continue
            left, right = term.factors
            for k in range(self.width(left)):
                yield scale, self.of(left, i, k), self.of(right, k, j)

    def width(self, operand: Operand) -> int:
        rows, cols = self.program.shape(operand.name, self.sizes)
        return rows if operand.turned else cols

    def factor(self, step: Factor) -> None:
        """matrix = L d L'; `inverse` holds 1 / d."""
        name, M = step.matrix, self.entries[step.matrix]
        size = len(M)
        L: list[list[Entry]] = [[0.0] * size for _ in M]
        d: list[Entry] = [0.0] * size
        inverse: list[Entry] = [0.0] * size
        for j in range(size):
            rest = [(-1.0, L[j][k], L[j][k], d[k]) for k in range(j)]
            d[j] = self.let(f"{name}_d{j}", [(M[j][j],), *rest])
            self.need(step, j, d[j])
            cost = Cost(1, 1 + _numbers(d[j]), 1, 1)
            inverse[j] = self.inverse(step, f"{name}_i{j}", d[j], cost)
            for i in range(j + 1, size):
                rest = [(-1.0, L[i][k], L[j][k], d[k]) for k in range(j)]
                above = self.let(f"{name}_a{i}_{j}", [(M[j][i],), *rest])
                L[i][j] = self.let(f"{name}_l{i}_{j}", [(above, inverse[j])])
        self.factors[name] = L, inverse

    def inverse(self, step: Factor, name: str, pivot: Entry, cost: Cost) -> Entry:
        """1 / pivot, or 0 where what is known exactly has none."""
        if step.known and pivot == 0:
            return 0.0
        text, reads = f"1.0 / {pivot}", _names(pivot)
        if not step.known or not reads:
            return self.name(Let(name, text, reads, cost))
        self.statements.append(Inverse(name, text, reads, cost, pivot=pivot))
        return name

    def need(self, step: Factor, j: int, pivot: Entry) -> None:
        """That pivot j of a factor is above its bound, or known exactly."""
        unit, bound, beside = self.entries[step.matrix][j][j], "0.0", ()
        if step.beside and step.tol:
            beside = unit, self.beside(step, j)
            bound = f"{step.tol!r} * {step.unit(*beside)}"
        elif step.tol and pivot != unit:
            beside = (unit,)
            bound = f"{step.tol!r} * {unit}"
        entries = pivot, *beside
        cost = Cost(1 + len(beside), 1 + _numbers(*entries))
        unless = self.zeros(step, j) if step.known else ()
        if unless is None:
            return
        reads = _names(*entries, *unless)
        self.statements.append(Need(f"{pivot} > {bound}", reads, cost, unless))

    def beside(self, step: Factor, j: int) -> Entry:
        """What stands beside pivot j."""
        row = self.entries[step.beside][j]
        return row[min(j, len(row) - 1)]

    def zeros(self, step: Factor, j: int) -> tuple[str, ...] | None:
        """What is zero where row j is known: no names if it cannot be, None if it is.

        That is, where some entry is another number, or where all are the number 0.
        """
        all_ = [*self.entries[step.matrix][j]]
        all_ += [self.beside(step, j)] if step.beside else []
        if any(one for one in all_ if not isinstance(one, str)):
            return ()
        names = tuple(dict.fromkeys(one for one in all_ if isinstance(one, str)))
        return names or None

    def substitute(self, step: Substitute) -> None:
        """target L d L' = right, row by row."""
        L, inverse = self.factors[step.matrix]
        rows, size = self.program.shape(step.target, self.sizes)
        table = self.entries[step.target] = []
        for i in range(rows):
            name, row = f"{step.target}_{i}", [0.0] * size
            for j in range(size):
                rest = [(-1.0, L[j][k], row[k]) for k in range(j)]
                row[j] = self.let(f"{name}_f{j}", [(self.of(step.right, i, j),), *rest])
            row = [
                self.let(f"{name}_s{j}", [(row[j], inverse[j])]) for j in range(size)
            ]
            for j in reversed(range(size)):
                rest = [(-1.0, L[k][j], row[k]) for k in range(j + 1, size)]
                row[j] = self.let(f"{name}_{j}", [(row[j],), *rest])
            table.append(row)

    def guard(self, step: Guard) -> None:
        rows, cols = self.program.shape(step.matrix, self.sizes)
        found = guards.unrolled(step, rows, cols, self.entries, self.name)
        self.statements.extend(found)


def _names(*entries: Entry) -> frozenset[str]:
    """Those that are read, not numbers."""
    return frozenset(one for one in entries if isinstance(one, str))


def _numbers(*entries: Entry) -> int:
    return sum(not isinstance(one, str) for one in entries)


def _cost(terms: Sums, number: float) -> Cost:
    """The cost of a sum that is kept under a name: what `_text` writes, counted."""
    scaled = sum(abs(scale) != 1 for scale, _ in terms)
    count = len(terms) + bool(number)
    products = sum(len(names) - 1 for _, names in terms)
    return Cost(count - 1 + products + scaled, scaled + bool(number), 1, count)


def _text(terms: Sums, number: float) -> str:
    """A sum as Python and C read it; a minus sign in front only where it must be."""
    terms = sorted(terms, key=lambda term: term[0] < 0)  # stable
    text = ""
    for scale, names in terms:
        product = " * ".join(names)
        if abs(scale) != 1:
            product = f"{abs(scale)!r} * {product}"
        sign = "-" if scale < 0 else "+"
        text += (
            f" {sign} {product}" if text else product if scale > 0 else f"-{product}"
        )
    return text + (f" {'-' if number < 0 else '+'} {abs(number)!r}" if number else "")
