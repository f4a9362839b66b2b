"""Lower a stage list, sizes still symbols, to steps that any printer can write out.

A step sums products of at most two matrices, factors a symmetric matrix as L d L',
or substitutes through such a factor.  Nothing of SymPy is left in the result: sizes
are names such as "n", matrices are names, a transpose is an order of indices.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import count
from typing import Any

import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixExpr

from ..numeric.linalg import SINGULAR_TOL
from ..symbolic import Derivation, Solve, Stage
from .program import (
    IDENTITY,
    Assign,
    Factor,
    Guard,
    Operand,
    Program,
    Shape,
    Step,
    Substitute,
    Term,
    made,
    reads,
)
from .text import needed, require_proved


def lower(
    derivation: Derivation,
    outputs: Sequence[str] = (),
    *,
    zero: Iterable[str] = (),
    symmetric: Iterable[str] = (),
    definite: Sequence[Factor] = (),
    same: Iterable[tuple[str, str]] = (),
    guards: Sequence[Guard] = (),
) -> Program:
    """Lower the stages that `outputs` need; all of them if none are named.

    Parameters
    ----------
    derivation : Derivation
        Proved.
    outputs : sequence of str
        What is wanted.
    zero : sequence of str
        Given matrices that vanish; what they multiply is left out.
    symmetric : sequence of str
        Given matrices that are symmetric.
    definite : sequence of Factor
        Of symmetric targets that must be definite, or the step gives up.
    same : sequence of (str, str)
        Given matrices that are the same as another one.
    guards : sequence of Guard
        By what the step judges its rounding; what they make is named among the given.
    """
    require_proved(derivation)
    work = _Lowering(zero, symmetric)
    work.named = {s.name for s in derivation.given}
    work.named |= {stage.target.name for stage in derivation.stages}
    work.alias.update((one, Operand(other)) for one, other in same)
    for symbol in derivation.given:
        work.shapes[symbol.name] = sizes_of(symbol)
    judged = {name for guard in guards for name in reads(guard)}
    also = [s.target.name for s in derivation.stages if s.target.name in judged]
    for stage in needed(derivation.stages, [*outputs, *also] if outputs else ()):
        work.stage(stage)
    outputs = outputs or [stage.target.name for stage in derivation.stages]
    results = {
        name: None if name in work.zero else work.alias.get(name, Operand(name))
        for name in outputs
    }
    work.strict(definite)
    steps = _guarded(_used(work.steps, results, judged), guards)
    read = {name for step in steps for name in reads(step)}
    read |= {op.name for op in results.values() if op is not None}
    computed = {made(step) for step in steps}
    given = tuple(
        s.name for s in derivation.given if s.name in read and s.name not in computed
    )
    shapes = {k: v for k, v in work.shapes.items() if k in computed or k in given}
    known = frozenset(work.symmetric & set(shapes))
    held = {name: op.name for name, op in results.items() if op is not None}
    definite = tuple(
        replace(one, matrix=held.get(one.matrix, one.matrix))
        for one in definite
        if one.matrix not in work.factored
    )
    return Program(given, shapes, steps, results, known, definite)


def _used(
    steps: list[Step], results: dict[str, Operand | None], judged: set[str]
) -> tuple[Step, ...]:
    """The steps that the results need, and what is judged, in order."""
    wanted = judged | {op.name for op in results.values() if op is not None}
    kept = []
    for step in reversed(steps):
        if isinstance(step, Factor) or made(step) in wanted:
            kept.append(step)
            wanted |= reads(step)
    return tuple(reversed(kept))


def sizes_of(e: Any) -> Shape:
    """The shape of a SymPy matrix, as names and numbers."""
    sizes = tuple(map(sp.sympify, e.shape))
    if odd := [d for d in sizes if not (d.is_Integer or d.is_Symbol)]:
        raise TypeError(f"no loops for the size {odd[0]} of {e}; give it a letter")
    rows, cols = (int(d) if d.is_Integer else d.name for d in sizes)
    return rows, cols


def _guarded(steps: tuple[Step, ...], guards: Sequence[Guard]) -> tuple[Step, ...]:
    """The steps, and each guard behind the last one that makes what it reads."""
    found = list(steps)
    for guard in guards:
        makers = [k for k, step in enumerate(found) if made(step) in reads(guard)]
        found.insert(max(makers, default=-1) + 1, guard)
    return tuple(found)


class _Lowering:
    def __init__(self, zero: Iterable[str], symmetric: Iterable[str]) -> None:
        self.zero, self.symmetric = set(zero), set(symmetric)
        self.alias: dict[str, Operand] = {}
        self.shapes: dict[str, Shape] = {}
        self.named: set[str] = set()
        self.steps: list[Step] = []
        self.products: dict[tuple[Operand, Operand], Operand] = {}
        self.factored: set[str] = set()
        self.sums: dict[tuple[tuple[Term, ...], bool], Operand] = {}
        self.made: dict[Operand, tuple[Term, ...]] = {}

    def stage(self, stage: Stage) -> None:
        name, formula = stage.target.name, stage.formula
        if isinstance(formula, Solve):
            self.solve(name, formula, stage.equation)
        else:
            self.assign(name, formula, stage.symmetric, stage.equation)

    def assign(
        self, name: str, e: Any, symmetric: bool = False, equation: str = ""
    ) -> None:
        terms = self.terms(e)
        self.shapes[name] = sizes_of(e)
        if symmetric:
            self.symmetric.add(name)
        if not terms:
            self.zero.add(name)
        elif _is_copy(terms) and (not symmetric or self.is_symmetric(terms)):
            self.alias[name] = terms[0].factors[0]
        elif (terms, symmetric) in self.sums:
            self.alias[name] = self.sums[terms, symmetric]
        else:
            self.steps.append(Assign(name, terms, symmetric, equation))
            self.sums[terms, symmetric] = Operand(name)
            self.made[Operand(name)] = terms

    def is_symmetric(self, terms: tuple[Term, ...]) -> bool:
        return terms[0].factors[0].name in self.symmetric

    def solve(self, name: str, formula: Solve, equation: str) -> None:
        right, M = self.operand(formula.N), self.operand(formula.M)
        self.shapes[name] = sizes_of(formula.N)
        if right is None:
            self.zero.add(name)
            return
        if (known := self.solution(right, M)) is not None:
            self.alias[name] = known
            return
        if M.name not in self.factored:
            self.factored.add(M.name)
            self.steps.append(Factor(M.name, SINGULAR_TOL))
        self.steps.append(Substitute(name, right, M.name, equation))

    def strict(self, definite: Sequence[Factor]) -> None:
        """Have what is solved with pass its test of definiteness on the way."""
        for one in definite:
            if one.matrix in self.factored:
                k = self.steps.index(Factor(one.matrix, SINGULAR_TOL))
                self.steps[k] = one

    def solution(self, right: Operand, M: Operand) -> Operand | None:
        """The X of X M = right, where it can be read off: X M = X M, or X I = X."""
        if _is_unit(self.made.get(M, ())):
            return right
        terms = self.made.get(right, ())
        if len(terms) != 1 or terms[0].scale != 1 or len(terms[0].factors) != 2:
            return None
        X, last = terms[0].factors
        return X if last == M else None

    def terms(self, e: Any) -> tuple[Term, ...]:
        """The sum e as terms, longer products cut down by earlier steps."""
        out = []
        for part in sp.MatAdd.make_args(e):
            args = part.args if isinstance(part, sp.MatMul) else (part,)
            scale = sp.Mul(*(a for a in args if not isinstance(a, MatrixExpr)))
            factors = [self.operand(a) for a in args if isinstance(a, MatrixExpr)]
            if None in factors:
                continue
            factors = [f for f in factors if f.name != IDENTITY] or factors[:1]
            out.append(Term(Fraction(int(scale.p), int(scale.q)), self.pair(factors)))
        return tuple(out)

    def pair(self, factors: list[Operand]) -> tuple[Operand, ...]:
        """At most two factors: the cheapest neighbours are multiplied first."""
        while len(factors) > 2:
            costs = [_cost(*map(self.shape, two)) for two in zip(factors, factors[1:])]
            at = costs.index(min(costs))
            factors[at : at + 2] = [self.product(*factors[at : at + 2])]
        return tuple(factors)

    def product(self, left: Operand, right: Operand) -> Operand:
        if (left, right) not in self.products:
            shape = self.shape(left)[0], self.shape(right)[1]
            name = self.fresh(shape)
            terms = (Term(Fraction(1), (left, right)),)
            self.steps.append(Assign(name, terms))
            self.products[left, right] = Operand(name)
        return self.products[left, right]

    def operand(self, e: Any) -> Operand | None:
        """The matrix e as an operand, None if it is zero."""
        if isinstance(e, sp.Transpose):
            found = self.operand(e.arg)
            return found if self.same_turned(found) else found.T
        if isinstance(e, sp.Identity):
            return Operand(IDENTITY)
        if isinstance(e, sp.MatrixSymbol):
            if e.name in self.zero:
                return None
            return self.alias.get(e.name, Operand(e.name))
        if isinstance(e, sp.MatAdd | sp.MatMul):
            name = self.fresh(sizes_of(e))
            self.assign(name, e)
            return None if name in self.zero else self.alias.get(name, Operand(name))
        raise TypeError(
            f"no kernel for {type(e).__name__} in {e}; write an inverse as Solve"
        )

    def same_turned(self, operand: Operand | None) -> bool:
        return operand is None or operand.name in self.symmetric | {IDENTITY}

    def fresh(self, shape: Shape) -> str:
        names = (f"t{k}" for k in count())
        name = next(k for k in names if k not in self.named)
        self.named.add(name)
        self.shapes[name] = shape
        return name

    def shape(self, operand: Operand) -> Shape:
        rows, cols = self.shapes[operand.name]
        return (cols, rows) if operand.turned else (rows, cols)


def _is_copy(terms: tuple[Term, ...]) -> bool:
    one = len(terms) == 1 and terms[0].scale == 1 and len(terms[0].factors) == 1
    return one and terms[0].factors[0].name != IDENTITY


def _is_unit(terms: tuple[Term, ...]) -> bool:
    return len(terms) == 1 and terms[0].is_identity and terms[0].scale == 1


def _cost(left: Shape, right: Shape) -> int:
    """Multiplications of a product, at sizes as they mostly are."""
    usual = {"n": 12, "r": 10, "p": 4, "m": 3}
    a, b, c = (usual.get(k, k if isinstance(k, int) else 4) for k in (*left, right[1]))
    return a * b * c
