"""Numbers for symbols: random matrices that satisfy what a derivation assumes.

The proofs rewrite symbols; here the same expressions are evaluated with NumPy, by
other code, so that a fault of the algebra or a contradictory assumption shows.
"""

from itertools import product

import numpy as np
import sympy as sp
from sympy import MatAdd
from sympy.matrices.expressions.matexpr import MatrixExpr

from luenberger.papers.leondes_novak import derivation as recursions
from luenberger.stage_list import stage_lists
from matrixproof import Solve
from matrixproof.words import ShapeError

# The stage lists on the pages of Leondes and Novak, by name.
STAGE_LISTS = [
    name
    for name, one in stage_lists(recursions.__name__).items()
    if one.where.startswith(("best_", "correlated_", "estimate.", "steady_"))
]


class Numbers:
    """Random values for matrix symbols, made when first asked for.

    `values` maps names to arrays and is used where the shape fits; a relation whose
    left side is a single symbol defines that symbol.
    """

    def __init__(self, sizes, seed=0, symmetric=(), relations=(), values=None):
        self.sizes = {str(k): v for k, v in sizes.items()}
        self.rng = np.random.default_rng(seed)
        self.symmetric = {s.name for s in symmetric}
        self.defined = {
            left: right
            for left, right in relations
            if isinstance(left, sp.MatrixSymbol)
        }
        self.values = values or {}
        self.known = {}

    def size(self, expr):
        expr = sp.sympify(expr)
        return int(expr.subs({s: self.sizes[s.name] for s in expr.free_symbols}))

    def shape(self, expr):
        return tuple(self.size(d) for d in expr.shape)

    def symbol(self, s):
        if s not in self.known:
            shape, value = self.shape(s), self.values.get(s.name)
            if s in self.defined:
                value = self.value(self.defined[s])
            elif value is None or value.shape != shape:
                value = self.rng.normal(size=shape)
                if s.name in self.symmetric:
                    value = value @ value.T + np.eye(len(value))
            self.known[s] = value
        return self.known[s]

    def value(self, expr, swap=None):
        """The value of a SymPy expression; `swap` overrides some symbols."""
        if swap:
            other = Numbers(self.sizes)
            other.known = {**{s: self.symbol(s) for s in symbols(expr)}, **swap}
            return other.value(expr)
        if isinstance(expr, MatrixExpr):
            return self.matrix(expr)
        if isinstance(expr, sp.Trace):
            return np.trace(self.value(expr.arg))
        if isinstance(expr, (sp.Add, sp.Mul)) and expr.has(sp.Trace):
            parts = [self.value(a) for a in expr.args]
            return sum(parts) if isinstance(expr, sp.Add) else np.prod(parts)
        expr = sp.sympify(expr)
        named = {s: self.sizes.get(s.name, 0.7) for s in expr.free_symbols}
        return float(expr.subs(named))

    def matrix(self, expr):
        if isinstance(expr, sp.MatrixSymbol):
            return self.symbol(expr)
        if isinstance(expr, sp.BlockMatrix):
            rows = [[self.value(x) for x in row] for row in expr.blocks.tolist()]
            return np.vstack([np.hstack(row) for row in rows])
        if isinstance(expr, sp.Identity):
            return np.eye(*self.shape(expr))
        if isinstance(expr, sp.ZeroMatrix):
            return np.zeros(self.shape(expr))
        if isinstance(expr, sp.Transpose):
            return self.value(expr.arg).T
        if isinstance(expr, (sp.Inverse, sp.MatPow)):
            return np.linalg.matrix_power(self.value(expr.base), int(expr.exp))
        parts = [self.value(a) for a in expr.args]
        if isinstance(expr, sp.MatAdd):
            return sum(parts[1:], parts[0])
        total = parts[0]
        for part in parts[1:]:
            total = (
                total * part if np.ndim(total) * np.ndim(part) == 0 else total @ part
            )
        return total


def symbols(expr):
    return expr.atoms(sp.MatrixSymbol)


def expr(side):
    """A side of a claim in SymPy."""
    return side.as_expr() if hasattr(side, "algebra") else side


def damages(left, most=None):
    """The left side with one term negated, one symbol doubled or transposed.

    At most about `most` terms and symbols, evenly spaced, where a claim is long.
    """
    if isinstance(left, (sp.Add, MatAdd)):
        for term in spaced(left.args, most):
            yield f"sign of {term}", left - 2 * term
    for s in spaced(sorted(symbols(left), key=lambda s: s.name), most):
        yield f"twice {s}", left.xreplace({s: 2 * s})
        yield f"transposed {s}", transposed(left, s)


def transposed(left, s):
    """The expression with one symbol transposed; if it has no shape, a stray scalar."""
    try:
        return left.xreplace({s: s.T})
    except ShapeError:
        return sp.Symbol("nonsense")


def spaced(items, most):
    return items if most is None else items[:: max(1, -(-len(items) // most))]


def _wrong(block):
    """With the other sign, or anything in the place of zeros."""
    zero = isinstance(block, sp.ZeroMatrix)
    return sp.MatrixSymbol("wrong", *block.shape) if zero else -block


def one_wrong_sign(stages):
    """(stage index, what, formula) with one term of one stage negated."""
    for i, stage in enumerate(stages):
        formula = stage.formula
        inner = formula.N if isinstance(formula, Solve) else formula
        if isinstance(inner, sp.BlockMatrix):
            rows, cols = inner.blockshape
            for j, k in product(range(rows), range(cols)):
                grid = inner.blocks.tolist()
                grid[j][k] = _wrong(grid[j][k])
                yield i, f"{stage.target.name}-{j}{k}", sp.BlockMatrix(grid)
            continue
        terms = inner.args if isinstance(inner, MatAdd) else (inner,)
        for k in range(len(terms)):
            flipped = sum(
                (-t if j == k else t for j, t in enumerate(terms[1:], 1)),
                -terms[0] if k == 0 else terms[0],
            )
            new = Solve(flipped, formula.M) if isinstance(formula, Solve) else flipped
            yield i, f"{stage.target.name}-{k}", new
