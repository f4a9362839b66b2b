"""Pieces of a stage list as loops in C99, at sizes that are numbers or arguments."""

from collections.abc import Mapping, Sequence
from typing import Any

import sympy as sp

from ...numeric.linalg import SINGULAR_TOL
from ..pieces import Piece, Quotient, Sum, Term
from ..printing import C99, product, summed

I, J, K = sp.symbols("i j k", integer=True)  # of rows, columns, inner products

FACTOR = """\
for (int i = 0; i < {p}; i++) {{
    for (int j = 0; j < i; j++) {{
        {real} s = {M_ij};
        for (int k = 0; k < j; k++) {{
            s -= {L}[i * {p} + k] * {L}[j * {p} + k];
        }}
        {L}[i * {p} + j] = s;
    }}
    {real} d = {M_ii};
    for (int k = 0; k < i; k++) {{
        const {real} q = {L}[i * {p} + k] * {L}[k * {p} + k];
        d -= {L}[i * {p} + k] * q;
        {L}[i * {p} + k] = q;
    }}
    if (!(d > {tol} * {M_ii})) {{
        return 1;
    }}
    {L}[i * {p} + i] = 1.0 / d;
}}"""

SUBSTITUTE = """\
for (int i = 0; i < {rows}; i++) {{
    for (int j = 0; j < {p}; j++) {{
        {real} s = {N_ij};
        for (int k = 0; k < j; k++) {{
            s -= {L}[j * {p} + k] * {X}[i * {p} + k];
        }}
        {X}[i * {p} + j] = s;
    }}
    for (int j = {p} - 1; j >= 0; j--) {{
        {real} s = {X}[i * {p} + j] * {L}[j * {p} + j];
        for (int k = j + 1; k < {p}; k++) {{
            s -= {L}[k * {p} + j] * {X}[i * {p} + k];
        }}
        {X}[i * {p} + j] = s;
    }}
}}"""


class Loops:
    """Loops over flat arrays, row by row; they return 1 if a solve finds no pivot.

    Parameters
    ----------
    names : dict of str to str
        C names of matrices, where they are not their own.
    sizes : dict of str to int or str
        What the letters of sizes are in C.
    real : str
        The type of the numbers.
    """

    def __init__(
        self,
        names: Mapping[str, str],
        sizes: Mapping[str, Any],
        real: str = "double",
    ) -> None:
        self.printer = C99(names, sizes)
        self.names, self.real = names, real

    def arrays(self, found: Sequence[Piece]) -> dict[str, str]:
        """Lengths of the arrays that pieces write, by their names in C."""
        lengths = {}
        for piece in found:
            lengths[self.array(piece.target)] = self.length(piece.target)
            if isinstance(piece, Quotient) and piece.first:
                lengths[self.factor(piece.M)] = self.length(piece.M)
        return lengths

    def array(self, X: Any) -> str:
        return self.names.get(X.name, X.name)

    def factor(self, M: Any) -> str:
        """The array of the factor of a matrix, by a name that no other one has."""
        name = f"{M.name}_l"
        while name in self.names.values():
            name += "_"
        return name

    def length(self, X: Any) -> str:
        sizes = [self.printer.size(size) for size in X.shape]
        return " * ".join(size for size in sizes if size != "1") or "1"

    def lines(self, found: Sequence[Piece]) -> list[str]:
        """All pieces, in order, each behind the number of its equation."""
        out = []
        for piece in found:
            if piece.equation:
                out.append(f"// {piece.equation}")
            out += self.sum(piece) if isinstance(piece, Sum) else self.solve(piece)
        return out

    def sum(self, piece: Sum) -> list[str]:
        """An entry at a time; that of a symmetric target is written on both sides."""
        rows, cols = (self.printer.size(size) for size in piece.target.shape)
        j = sp.S.Zero if cols == "1" else J
        products = [t for t in piece.terms if len(t.factors) == 2]
        if cols == "1" and any(
            isinstance(t.factors[0], sp.Transpose) for t in products
        ):
            return self.columns(piece, products)
        body = [f"{self.real} s = {self.start(piece, j)};"]
        for term in products:
            sign, size = "-" if term.scale < 0 else "+", abs(term.scale)
            code = self.printer.doprint(self.entry(Term(size, term.factors), j))
            width = self.printer.size(term.factors[0].shape[1])
            body += _loop("k", "0", width, [f"s {sign}= {code};"])
        body.append(f"{self.printer.doprint(piece.target[I, j])} = s;")
        if piece.symmetric and cols != "1":
            body.append(f"{self.printer.doprint(piece.target[J, I])} = s;")
        if cols != "1":
            body = _loop("j", "i" if piece.symmetric else "0", cols, body)
        return _loop("i", "0", rows, body)

    def columns(self, piece: Sum, products: Sequence[Term]) -> list[str]:
        """A vector a column at a time: of a transpose they are without gaps."""
        target, write = piece.target[I, sp.S.Zero], self.printer.doprint
        rows = self.printer.size(piece.target.shape[0])
        start = self.start(piece, sp.S.Zero)
        lines = _loop("i", "0", rows, [f"{write(target)} = {start};"])
        for term in products:
            left, right = term.factors
            factor = write(product(term.scale, right[K, sp.S.Zero]))
            along = _loop(
                "i", "0", rows, [f"{write(target)} += {write(left[I, K])} * f;"]
            )
            body = [f"const {self.real} f = {factor};", *along]
            lines += _loop("k", "0", self.printer.size(left.shape[1]), body)
        return lines

    def start(self, piece: Sum, j: Any) -> str:
        """The terms of a sum that are no products."""
        single = [self.entry(t, j) for t in piece.terms if len(t.factors) == 1]
        return self.printer.doprint(summed(single)) if single else "0.0"

    def entry(self, term: Term, j: Any) -> sp.Expr:
        """What a term adds to the entry (i, j), for one k if it is a product."""
        if len(term.factors) == 1:
            return product(term.scale, term.factors[0][I, j])
        left, right = term.factors
        return product(term.scale, left[I, K], right[K, j])

    def solve(self, piece: Quotient) -> list[str]:
        rows, p = (self.printer.size(size) for size in piece.target.shape)
        words = dict(rows=rows, p=p, L=self.factor(piece.M), tol=repr(SINGULAR_TOL))
        words |= dict(X=self.array(piece.target), real=self.real)
        entries = dict(N_ij=piece.N[I, J], M_ij=piece.M[I, J], M_ii=piece.M[I, I])
        words |= {name: self.printer.doprint(e) for name, e in entries.items()}
        text = SUBSTITUTE.format(**words)
        text = FACTOR.format(**words) + "\n" + text if piece.first else text
        return text.split("\n")


def _loop(index: str, start: str, stop: str, body: list[str]) -> list[str]:
    head = f"for (int {index} = {start}; {index} < {stop}; {index}++) {{"
    return [head, *(f"    {line}" for line in body), "}"]
