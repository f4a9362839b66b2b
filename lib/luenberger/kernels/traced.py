"""A stage list followed entry by entry: scalars, without work on zeros and ones.

What is zero drops out, a factor of one is not multiplied, an entry below the diagonal
of a symmetric matrix is the one above it, and equal sums are added up once.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from matrixproof import Derivation

from .pieces import Sum, Term, pieces
from .printing import C99, product, summed

Entry = Any  # a number that is known, or a Symbol
Table = Sequence[Sequence[float | None]]


@dataclass
class Traced:
    """What a stage list does with scalars.

    Attributes
    ----------
    statements : list of (Symbol, Expr)
        Names with the sums that they stand for, in order.
    entries : dict of str to list of lists
        Of each matrix; an entry is a number or a name.
    given : dict of Symbol to (str, int)
        What is read of the matrices that are given, in their order: which, and the
        number of the entry, row by row.

    Examples
    --------
    >>> from luenberger.papers.leondes_novak.derivation import observer_step
    >>> sizes = dict(r=1, p=1, m=0, q=2)
    >>> print(traced(observer_step(), ["w_hat"], sizes, dict(P=[[1], [0.5]])))
    w_hat_0_0 = z_0_0 + V_0_0 * y_0_0
    w_hat_1_0 = 0.5 * z_0_0 + V_1_0 * y_0_0
    """

    statements: list[tuple[sp.Symbol, sp.Expr]] = field(default_factory=list)
    entries: dict[str, list[list[Entry]]] = field(default_factory=dict)
    given: dict[sp.Symbol, tuple[str, int]] = field(default_factory=dict)

    def __str__(self) -> str:
        to = C99()
        return "\n".join(f"{name} = {to.doprint(e)}" for name, e in self.statements)


def traced(
    derivation: Derivation,
    outputs: Sequence[str],
    sizes: Mapping[str, int],
    known: Mapping[str, Table] | None = None,
) -> Traced:
    """Follow the stages that `outputs` need through entries.

    Parameters
    ----------
    derivation : Derivation
        Proved; its stages solve for nothing.
    outputs : sequence of str
        What is wanted.
    sizes : dict of str to int
    known : dict of str to nested sequence, optional
        Entries of given matrices that are numbers; those that are None are names.
    """
    work = _Tracing(sizes, known or {})
    for piece in pieces(derivation, outputs):
        if not isinstance(piece, Sum):
            raise TypeError(f"{piece.target.name} is solved for; scalars are sums only")
        work.sum(piece)
    found, kept = work.found, list[tuple[sp.Symbol, sp.Expr]]()
    read = {e for one in outputs for row in found.entries[one] for e in row}
    for symbol, e in reversed(found.statements):
        if symbol in read:
            kept.append((symbol, e))
            read |= e.free_symbols
    found.statements = kept[::-1]
    for X in derivation.given:
        flat = [e for row in found.entries.get(X.name, ()) for e in row]
        for k, e in enumerate(flat):
            if isinstance(e, sp.Symbol) and e in read:
                found.given[e] = X.name, k
    return found


class _Tracing:
    def __init__(self, sizes: Mapping[str, int], known: Mapping[str, Table]) -> None:
        self.sizes, self.known = sizes, known
        self.found, self.seen = Traced(), dict[sp.Expr, sp.Symbol]()

    def sum(self, piece: Sum) -> None:
        target, (rows, cols) = piece.target.name, self.shape(piece.target)
        table: list[list[Entry]] = [[0.0] * cols for _ in range(rows)]
        for i in range(rows):
            for j in range(cols):
                if piece.symmetric and j < i:
                    table[i][j] = table[j][i]
                else:
                    total = added(self.products(piece.terms, i, j))
                    table[i][j] = self.named(f"{target}_{i}_{j}", total)
        self.found.entries[target] = table

    def named(self, name: str, total: Any) -> Entry:
        """A sum under its name, or under that of an equal one."""
        if not isinstance(total, sp.Expr) or total.is_Symbol:
            return total
        if total not in self.seen:
            self.seen[total] = sp.Symbol(name)
            self.found.statements.append((self.seen[total], total))
        return self.seen[total]

    def products(
        self, terms: Iterable[Term], i: int, j: int
    ) -> Iterator[Sequence[Entry]]:
        """What adds up to the entry (i, j), as factors."""
        for term in terms:
            left, *right = term.factors
            if not right:
                yield term.scale, self.entry(left, i, j)
            for k in range(self.shape(left)[1] if right else 0):
                yield term.scale, self.entry(left, i, k), self.entry(right[0], k, j)

    def entry(self, X: Any, i: int, j: int) -> Entry:
        if X.is_Identity:
            return float(i == j)
        if isinstance(X, sp.Transpose):
            return self.entry(X.arg, j, i)
        if X.name not in self.found.entries:
            self.found.entries[X.name] = self.read(X)
        return self.found.entries[X.name][i][j]

    def read(self, X: Any) -> list[list[Entry]]:
        """The entries of a given matrix: numbers, or names."""
        rows, cols = self.shape(X)
        known = self.known.get(X.name) or [[None] * cols] * rows
        return [
            [
                sp.Symbol(f"{X.name}_{i}_{j}") if known[i][j] is None else known[i][j]
                for j in range(cols)
            ]
            for i in range(rows)
        ]

    def shape(self, X: Any) -> tuple[int, int]:
        rows, cols = (self.sizes.get(str(size), size) for size in X.shape)
        return int(rows), int(cols)


def added(products: Iterable[Sequence[Entry]]) -> Any:
    """A sum of products, those that are subtracted last; a number if all is known."""
    number, terms = 0.0, list[tuple[float, list[sp.Symbol]]]()
    for factors in products:
        scale, names = 1.0, []
        for one in factors:
            if isinstance(one, sp.Symbol):
                names.append(one)
            else:
                scale *= one
        if not names:
            number += scale
        elif scale:
            terms.append((scale, names))
    if not terms:
        return number
    terms.sort(key=lambda term: term[0] < 0)
    parts = [product(scale, *names) for scale, names in terms]
    return summed([*parts, sp.Float(number)] if number else parts)
