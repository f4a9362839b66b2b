"""Induction: a statement for every k, from the first k and from one to the next."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from .algebra import Algebra
from .dependence import behind
from .lines import Line, words
from .relations import Reasons, Relation, Result
from .typeset import Show, latex, text
from .words import Formula, Symbols, kept, plain


@dataclass(frozen=True, eq=False)
class Induced(Line):
    """An equation that holds at every k, because two chains prove it so.

    Parameters
    ----------
    statement : Relation
        The equation at any k, which the second chain supposes.
    base, step : Chain
        They prove it at the first k, and one step after k.
    first, then : dict of letter to expression
        What the letters of the statement that depend on k are there.
    """

    statement: Any = None
    base: Any = None
    step: Any = None
    first: Mapping[Any, Any] = field(default_factory=dict)
    then: Mapping[Any, Any] = field(default_factory=dict)

    def __post_init__(self):
        super().__post_init__()
        for name in ("first", "then"):
            object.__setattr__(self, name, kept(getattr(self, name)))

    @property
    def cites(self) -> Reasons:
        """What both chains rest on, but for the statement itself."""
        waiting, found = [self.base.relation, self.step.relation], []
        while waiting:
            r = waiting.pop(0)
            if isinstance(r, Result) and (
                r.chain in (self.base, self.step) or self.statement in behind([r])
            ):
                waiting[:0] = r.chain.relations
            elif r != self.statement:
                found.append(r)
        return tuple(dict.fromkeys(found))

    def complaints(self, left: Formula, symmetric: Symbols) -> list[str]:
        if set(self.first) != set(self.then):
            odd = sorted(set(self.first) ^ set(self.then), key=str)
            return [f"does not say what {text(odd[0])} is at the first k and one on"]
        if (left, self.right) != tuple(self.statement):
            return [f"is not {self.statement.show(text)}, which the step supposes"]
        found = []
        for name, chain, put in (
            ("base", self.base, self.first),
            ("step", self.step, self.then),
        ):
            if wrong := chain.check():
                found.append(f"has a {name} that fails: {wrong[0]}")
            missing = [s for s in chain.supposes if s not in symmetric]
            if missing and not chain.holds_without(*missing):
                found.append(f"has a {name} in which {text(missing[0])} is symmetric")
            wanted = moved(self.statement, put)
            if not same(wanted, chain.relation, symmetric):
                said = f"has a {name} that proves {chain.relation.show(text)}, and not"
                found.append(f"{said} {wanted.show(text)}")
        if self.statement in behind([self.base.relation]):
            found.append("has a base that supposes what is to be proved")
        if self.statement not in behind([self.step.relation]):
            found.append("has a step that does not suppose the statement before it")
        return found

    def reason(self, show: Show) -> str:
        said = f"induction: {self.base.title}; {self.step.title}"
        return words(said) if show is latex else said


def moved(statement, put):
    """A statement with other letters, and their sizes."""
    sizes = {
        old: new
        for x, y in put.items()
        for old, new in zip(getattr(x, "shape", ()), getattr(y, "shape", ()))
        if isinstance(old, sp.Symbol)
    }
    move = lambda e: plain(e).xreplace({**sizes, **put})  # noqa: E731
    return Relation("", move(statement.left), move(statement.right))


def same(one, other, symmetric):
    """Whether two equations say the same, perhaps turned round."""
    algebra = Algebra(symmetric)
    try:
        a, b = (algebra.normal(r.left) - algebra.normal(r.right) for r in (one, other))
        return (a - b).is_zero or (a + b).is_zero
    except (TypeError, ValueError):  # of other shapes
        return tuple(one) == tuple(other)
