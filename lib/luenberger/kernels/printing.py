"""SymPy's printers, with what stage lists add: solves, sizes, and arrays of C.

Which matrices a stage may be made of is said in `FORMS`; an inverse is not among them.
"""

from collections.abc import Mapping
from typing import Any

import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixExpr
from sympy.printing.c import C99CodePrinter
from sympy.printing.numpy import NumPyPrinter
from sympy.printing.precedence import precedence

from matrixproof import Solve

SUMS = sp.MatAdd, sp.MatMul
FORMS = (*SUMS, sp.MatrixSymbol, sp.Transpose, sp.Identity)
BLOCKS = sp.BlockMatrix, sp.ZeroMatrix  # NumPy has them, loops do not


def require_forms(e: Any, forms: tuple[type, ...] = FORMS) -> None:
    """Raise TypeError if a formula has a part that there is no code for."""
    if isinstance(e, Solve):
        parts: Any = e.N, e.M
    elif isinstance(e, MatrixExpr) and not isinstance(e, forms):
        raise TypeError(
            f"no code for {type(e).__name__} in {e}; write an inverse as Solve"
        )
    else:
        parts = e.blocks if isinstance(e, sp.BlockMatrix) else e.args
    for part in parts:
        require_forms(part, forms)


class NumPy(NumPyPrinter):
    """Stages as NumPy source, in one of three ways.

    "stacks" broadcasts leading axes.  "flat" is for matrices only: ``dot`` takes half
    the time of ``@`` on small ones, which is most of a step's time.  "numba" is for
    matrices, in the part of NumPy that numba knows.
    """

    def __init__(self, sizes: Mapping[Any, str], way: str) -> None:
        super().__init__({"fully_qualified_modules": False, "order": "none"})
        self.sizes, self.way = sizes, way

    def doprint(self, expr: Any, assign_to: Any = None) -> str:
        require_forms(expr, FORMS + BLOCKS)
        return self._print(expr)

    def _print_Solve(self, e: Solve) -> str:
        return f"solve_right({self._print(e.N)}, {self._print(e.M)})"

    def _print_MatAdd(self, e: sp.MatAdd) -> str:
        return " + ".join(map(self._print, e.args)).replace("+ -", "- ")

    def _print_MatMul(self, e: sp.MatMul) -> str:
        scale, (first, *rest) = e.as_coeff_matrices()
        if self.way == "flat":
            code = self.factor(first) + "".join(f".dot({self._print(a)})" for a in rest)
        else:
            code = " @ ".join(map(self.factor, (first, *rest)))
        text = {1: "", -1: "-"}.get(scale, f"{float(scale)!r} * ")
        return f"{text}({code})" if text else code

    def _print_Transpose(self, e: sp.Transpose) -> str:
        return f"{self.factor(e.arg)}.{'mT' if self.way == 'stacks' else 'T'}"

    def _print_MatrixSymbol(self, e: sp.MatrixSymbol) -> str:
        return e.name

    def _print_Identity(self, e: sp.Identity) -> str:
        return f"eye({self.size(e.shape[0])})"

    def _print_ZeroMatrix(self, e: sp.ZeroMatrix) -> str:
        return f"np.zeros(({', '.join(map(self.size, e.shape))}))"

    def _print_BlockMatrix(self, e: sp.BlockMatrix) -> str:
        """Blocks side by side or one above the other; `np.block` does both, slowly."""
        rows = [[self._print(one) for one in row] for row in e.blocks.tolist()]
        if self.way == "numba":  # which has no `np.block`, and joins tuples
            joined = [self.joined(row, -1) for row in rows]
            return self.joined(joined, -2)
        if len(rows) == 1:
            return f"np.concatenate([{', '.join(rows[0])}], axis=-1)"
        if len(rows[0]) == 1:
            column = ", ".join(one for (one,) in rows)
            return f"np.concatenate([{column}], axis=-2)"
        blocks = "], [".join(", ".join(row) for row in rows)
        return f"np.block([[{blocks}]])"

    def joined(self, codes: list[str], axis: int) -> str:
        one = len(codes) == 1
        return codes[0] if one else f"np.concatenate(({', '.join(codes)}), axis={axis})"

    def size(self, e: Any) -> str:
        return str(e) if e.is_Integer else self.sizes[e]

    def factor(self, e: Any) -> str:
        """The code of `e`, in parentheses where an operator would tear it apart."""
        return f"({self._print(e)})" if isinstance(e, SUMS) else self._print(e)


class C99(C99CodePrinter):
    """Scalars of C99; an entry of a matrix is one of a flat array, row by row.

    `names` are the arrays, and `sizes` the sizes, where they are not what the letters
    say.  Terms and factors stay in the order in which they are given.
    """

    def __init__(
        self, names: Mapping[str, str] | None = None, sizes: Mapping | None = None
    ) -> None:
        super().__init__({"order": "none"})
        self.names, self.sizes = names or {}, sizes or {}

    def size(self, e: Any) -> str:
        return str(self.sizes.get(str(e), e))

    def _print_MatrixElement(self, e: Any) -> str:
        name, cols = self.names.get(e.parent.name, e.parent.name), e.parent.shape[1]
        i, j, width = self._print(e.i), self._print(e.j), self.size(cols)
        if width == "1":
            return f"{name}[{i}]"
        return f"{name}[{j}]" if i == "0" else f"{name}[{i} * {width} + {j}]"

    def _print_KroneckerDelta(self, e: Any) -> str:
        return f"({self._print(e.args[0])} == {self._print(e.args[1])})"

    def _print_Float(self, flt: sp.Float) -> str:
        return repr(float(flt))

    def _print_Mul(self, expr: sp.Mul) -> str:
        first, *rest = expr.args
        if first.is_Number and first < 0:  # which a sum takes for its own sign
            return f"-{self._print(product(-float(first), *rest))}"
        level = precedence(expr)
        return " * ".join(self.parenthesize(one, level) for one in expr.args)


def summed(terms: list[sp.Expr]) -> sp.Expr:
    """A sum in the order of its terms."""
    return sp.Add(*terms, evaluate=False) if len(terms) > 1 else terms[0]


def product(scale: float, *factors: sp.Expr) -> sp.Expr:
    """A product in the order of its factors; a factor of 1 is none."""
    first = (
        () if scale == 1 else (sp.S.NegativeOne if scale == -1 else sp.Float(scale),)
    )
    factors = (*first, *factors)
    return sp.Mul(*factors, evaluate=False) if len(factors) > 1 else factors[0]
