"""A stage list cut into pieces that loops and scalars can write: sums and solves.

A sum adds up products of at most two matrices; of a longer product the neighbours that
make a vector are multiplied first, else those on the left.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from matrixproof import Derivation, Solve

from .printing import require_forms
from .text import needed, require_proved, symbols_in


@dataclass(frozen=True)
class Term:
    """A number times one matrix or the product of two, each perhaps transposed."""

    scale: float
    factors: tuple[sp.MatrixExpr, ...]


@dataclass(frozen=True)
class Sum:
    """target = sum of terms; of a symmetric one a triangle is computed and mirrored."""

    target: sp.MatrixSymbol
    terms: tuple[Term, ...]
    symmetric: bool = False
    equation: str = ""


@dataclass(frozen=True)
class Quotient:
    """target M = N, through the factor of M; `first` if M was not factored before."""

    target: sp.MatrixSymbol
    N: sp.MatrixExpr
    M: sp.MatrixSymbol
    first: bool
    equation: str = ""


Piece = Sum | Quotient


def read_by(piece: Piece) -> set[sp.MatrixSymbol]:
    """The matrices that a piece reads."""
    if isinstance(piece, Quotient):
        return symbols_in(piece.N) | symbols_in(piece.M)
    return {s for term in piece.terms for f in term.factors for s in symbols_in(f)}


def pieces(derivation: Derivation, outputs: Sequence[str] = ()) -> list[Piece]:
    """The pieces of the stages that `outputs` need; of all if none are named."""
    require_proved(derivation)
    stages = needed(derivation.stages, outputs)
    names = {s.name for stage in stages for s in symbols_in(stage.formula)}
    work = _Cutting(names | {stage.target.name for stage in stages})
    for stage in stages:
        require_forms(stage.formula)
        if isinstance(stage.formula, Solve):
            work.solve(stage.target, stage.formula, stage.equation)
        else:
            work.add(stage.target, stage.formula, stage.symmetric, stage.equation)
    return work.found


class _Cutting:
    def __init__(self, taken: set[str]) -> None:
        self.found: list[Piece] = []
        self.taken, self.made = taken, dict[Any, sp.MatrixSymbol]()
        self.factored: set[sp.MatrixSymbol] = set()

    def add(self, target: Any, e: Any, symmetric: bool, equation: str) -> None:
        terms = tuple(self.term(part) for part in sp.MatAdd.make_args(e))
        self.found.append(Sum(target, terms, symmetric, equation))

    def solve(self, target: Any, formula: Solve, equation: str) -> None:
        N, M = self.factor(formula.N), self.factor(formula.M)
        M = M if isinstance(M, sp.MatrixSymbol) else self.named(M)
        self.found.append(Quotient(target, N, M, M not in self.factored, equation))
        self.factored.add(M)

    def term(self, e: Any) -> Term:
        scale, matrices = e.as_coeff_mmul() if e.is_MatMul else (1, e)
        parts = matrices.args if matrices.is_MatMul else (matrices,)
        factors = [self.factor(part) for part in parts]
        factors = [f for f in factors if not f.is_Identity] or factors[:1]
        while len(factors) > 2:
            ends = [(a.shape[0], b.shape[1]) for a, b in zip(factors, factors[1:])]
            at = min(range(len(ends)), key=lambda k: 1 not in ends[k])
            factors[at : at + 2] = [self.named(factors[at] * factors[at + 1])]
        return Term(float(scale), tuple(factors))

    def factor(self, e: Any) -> Any:
        """A matrix or its transpose, which has an array."""
        if isinstance(e, sp.Transpose):
            return self.factor(e.arg).T
        return e if isinstance(e, sp.MatrixSymbol | sp.Identity) else self.named(e)

    def named(self, e: Any) -> Any:
        """An array for a part of a formula; equal parts share one."""
        if e not in self.made:
            names = (f"t{k}" for k in range(len(self.taken) + 1))
            name = next(one for one in names if one not in self.taken)
            self.taken.add(name)
            self.made[e] = sp.MatrixSymbol(name, *e.shape)
            self.add(self.made[e], e, False, "")
        return self.made[e]
