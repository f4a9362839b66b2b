"""A theorem in other letters: its lines, and all that they cite, put in and checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixExpr

from .algebra import Algebra
from .chains import Chain
from .dependence import declared, letters
from .lines import (
    AtLeast,
    Equation,
    Iff,
    Line,
    cited,
    cited_text,
    listed,
    numbered,
    worded,
)
from .operators import Operator
from .relations import Moment, Reasons, Relation, Result, named
from .symbols import MatrixProduct, ZeroMatrix, plus
from .typeset import Show, latex, text
from .words import ShapeError, Symbols, is_letter, plain, same_shape


@dataclass(frozen=True, eq=False, repr=False)
class Instance(Chain):
    """A theorem in other letters, as `Chain.at` makes it.

    Its lines are those of the theorem and are checked as any others are; what is shown
    is where it starts and ends.

    Attributes
    ----------
    of : Chain
        The theorem.
    """

    of: Any = None

    @property
    def full(self) -> Chain:
        """The chain with all its lines."""
        return Chain(
            self.number, self.says, self.left, self.lines, self.symmetric, self.witness
        )

    def displayed(self, show: Show) -> list[tuple]:
        """Where it ends, and where it ended before each operation but the first."""
        cuts = [k for k, x in enumerate(self.lines) if isinstance(x, Operator)]
        cuts = [*(cuts or [0]), len(self.lines)]
        found = []
        for k, (first, after) in enumerate(zip(cuts, cuts[1:])):
            part = self.lines[0 if k == 0 else first : after]
            sign = signed(part, show)
            head, last = self.lines[first].head(show), part[-1]
            faults = [x for x in self._faults[first:after] if x]
            why = self._why(show) if after == len(self.lines) else ""
            found.append((head, sign, last.body(show), last.pieces(show), why, faults))
        return found

    def _why(self, show):
        """The theorem, and what it was given."""
        said = [
            r.show(show)
            if isinstance(r, Moment)
            else worded(numbered(r)[0], show) or cited(r, show)
            for r in self.supposed
        ]
        theorem = f"theorem: {self.of.title}" + ", with " * bool(said)
        return worded(theorem, show) + listed(dict.fromkeys(said), show)

    @property
    def supposed(self) -> tuple[Relation, ...]:
        """What it was given, which is all that it rests on but its own steps."""
        waiting, found = list(super().relations), []
        while waiting:
            r = waiting.pop(0)
            if isinstance(r, Result) and isinstance(r.chain, Step):
                waiting[:0] = r.chain.relations
            else:
                found.append(r)
        return tuple(dict.fromkeys(found))

    @property
    def relations(self) -> Reasons:
        """Everything that its lines cite, and its steps."""
        return tuple(dict.fromkeys((*super().relations, *self.supposed)))

    def too_wide(self, line: Line) -> list[str]:
        return line.too_wide() if line is self.lines[-1] else []


class Step(Instance):
    """A chain that a theorem cites, in the letters of its instance."""

    def too_wide(self, line: Line) -> list[str]:
        return []


def signed(lines, show):
    """The sign between the first side and the last."""
    signs = [x for x in lines if x.sign != "="]
    weak = [x for x in signs if isinstance(x, AtLeast) or not isinstance(x, Iff)]
    line = (weak or signs or lines)[0]
    return line.latex_sign if show is latex else line.sign


def instance(
    chain: Chain, put: Mapping[Any, Any], given: Any, symmetric: Symbols
) -> Mapped:
    """A theorem and what it cites, with other letters; see `Chain.at`."""
    made = Mapped(chain, put, named(given), symmetric)
    if made.missing:
        said = " and ".join(
            f"{old.show(text)}, which is here {new.show(text)}"
            for old, new in made.missing.items()
        )
        raise ValueError(
            f"{chain.title} rests on {said}: give it, as in .at({{...}}, relation)"
        )
    return made


class Mapped:
    """What a theorem becomes in other letters."""

    def __init__(self, chain, put, given, symmetric):
        self.given, self.missing, self.known, self.normals = given, {}, {}, {}
        self.map = {sp.sympify(x): plain(y) for x, y in put.items()}
        self.renames = all(is_letter(y) for y in self.map.values())
        self.sizes()
        own = declared(chain.symmetric, chain.expressions)
        turned = [self.put(x) for x in own]
        self.symmetric = (
            *symmetric,
            *(
                x
                for x in turned
                if isinstance(x, sp.MatrixSymbol) and x not in symmetric
            ),
        )
        self.algebra = Algebra(declared(self.symmetric, turned))
        for x, value in zip(own, turned):
            if x in (*chain.supposes, *declared((), [x])) and not self.same(
                value, value.T
            ):
                raise ValueError(
                    f"{text(x)} is symmetric in {chain.title}, and nothing shows that "
                    f"{text(value)} is: name its symmetric letters, symmetric=(...)"
                )
        self.left, self.lines = self.put(chain.left), self.of(chain)

    def sizes(self):
        """Sizes are what letters of these sizes stand for; no two may differ."""
        told = {x: y for x, y in self.map.items() if not hasattr(x, "shape")}
        for x, value in self.map.items():
            if not isinstance(x, sp.MatrixSymbol):
                continue
            here = getattr(value, "shape", ())
            for old, new in zip(x.shape, here):
                if not old.is_Integer:
                    told.setdefault(old, sp.sympify(new))
            shape = tuple(d.xreplace(told) for d in x.shape)
            if not here or not same_shape(shape, here):
                raise ShapeError(
                    f"{text(x)} is {shape} in these letters, and {text(value)} is "
                    f"{here or 'a number'}"
                )
        self.map |= told

    def put(self, expr):
        """An expression in the other letters; the terms of a sum keep their order."""
        if isinstance(expr, Equation):
            return Equation(self.put(expr.left), self.put(expr.right))
        expr = plain(expr)
        if isinstance(expr, sp.Add) and not isinstance(expr, sp.MatAdd):
            return plus(*filter(None, map(self.put, expr.args)))
        found = expr.xreplace(self.map)
        return found if self.renames else tidy(found)

    def same(self, a, b):
        """Whether two expressions are equal, multiplied out."""
        if a == b:
            return True
        a, b = self.normal(a), self.normal(b)
        try:
            return a is not None and b is not None and (a - b).is_zero
        except (TypeError, ValueError):  # of other shapes
            return False

    def normal(self, expr):
        """An expression multiplied out, or None for what is not."""
        if expr not in self.normals:
            try:
                self.normals[expr] = self.algebra.normal(expr)
            except (TypeError, ValueError):
                self.normals[expr] = None
        return self.normals[expr]

    def cited(self, relation):
        """What stands here for a relation of the theorem; None for an identity."""
        if relation not in self.known:
            self.known[relation] = self._cited(relation)
        return self.known[relation]

    def _cited(self, relation):
        left, right = self.put(relation.left), self.put(relation.right)
        mean = isinstance(relation, Moment)
        if not mean and self.same(left, right):
            return None
        for r in self.given:
            if isinstance(r, Moment) == mean and self.says(r, left, right, mean):
                return r
        if isinstance(relation, Result):
            chain = relation.chain
            lines = self.of(chain)
            step = Step(
                "", chain.says, left, lines, self.symmetric, chain.witness, chain
            )
            return step.relation
        self.missing[relation] = replace(relation, left=left, right=right)
        return relation

    def says(self, relation, left, right, mean):
        """Whether a relation says this, perhaps turned round or transposed."""
        said = relation.left, relation.right
        if all(map(self.same, (left, right), said)):
            return True
        if not all(getattr(side, "shape", ()) for side in (left, relation.left)):
            return not mean and all(map(self.same, (right, left), said))
        if mean:
            return all(map(self.same, (left.T, right.T), said))
        one, other = left - right, relation.left - relation.right
        return any(self.same(one, x) for x in (other, -other, other.T, -other.T))

    def of(self, chain):
        """The lines of a chain; those that say nothing any more are left out."""
        before, found = self.put(chain.left), []
        for line in chain.lines:
            new = self.line(line)
            if type(new) is Line and new.right == before and not new.by:
                continue
            if not self.missing and not self.renames:
                new = self.lean(new, before)
            found.append(new)
            before = new.right
        return tuple(found)

    def line(self, line):
        """A line in the other letters."""
        new = {x.name: getattr(line, x.name) for x in fields(line)}
        for name, value in new.items():
            if name in ("right", "root"):
                new[name] = self.put(value)
            elif name in ("by", "moments"):
                found = [self.cited(r) for r in value]
                new[name] = tuple(dict.fromkeys(r for r in found if r is not None))
            elif name == "held":
                found = [letters(self.put(x)) for x in value]
                new[name] = tuple(sorted(frozenset().union(*found), key=str))
            elif name == "of" and isinstance(value, Mapping):
                new[name] = {self.letter(x): self.letter(d) for x, d in value.items()}
            elif name == "of":
                new[name] = self.letter(value)
        if type(line) is Line and not new["by"]:
            new["why"] = new["why"] or "multiply out"
        return type(line)(**new)

    def letter(self, x):
        found = self.put(x)
        if not is_letter(found):
            raise ValueError(f"{text(x)} moves, so {text(found)} cannot stand for it")
        return found

    def lean(self, line, left):
        """The line without what it does not need in these letters."""
        known = declared(self.symmetric, (left, line.right, *line.cites))
        while True:
            try:
                idle = line.complaints(left, known)
            except (TypeError, ValueError):
                return line  # whose check says so
            said = [x.removeprefix("does not need ") for x in idle]
            for name in ("by", "moments"):
                cites = getattr(line, name, ())
                spare = [r for r in cites if {cited_text(r), r.show(text)} & set(said)]
                if spare:
                    kept = tuple(r for r in cites if r is not spare[0])
                    line = replace(line, **{name: kept})
                    break
            else:
                return line


def tidy(expr):
    """An expression without products that vanish, and without factors that are I."""
    if not expr.args or isinstance(expr, sp.MatrixSymbol | sp.Identity | sp.ZeroMatrix):
        return expr
    args = [tidy(x) for x in expr.args]
    if isinstance(expr, sp.MatMul):
        if any(isinstance(x, sp.ZeroMatrix) for x in args):
            return ZeroMatrix(*expr.shape)
        kept = [x for x in args if not isinstance(x, sp.Identity)]
        several = any(isinstance(x, MatrixExpr) for x in kept)
        return MatrixProduct(*(kept if several else args))
    if isinstance(expr, sp.Transpose | sp.Trace) and isinstance(
        args[0], sp.Identity | sp.ZeroMatrix
    ):
        return args[0].T if isinstance(expr, sp.Transpose) else sp.Trace(args[0]).doit()
    return expr.func(*args)
