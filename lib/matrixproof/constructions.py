"""Steps that are not lines: an object that exists, and a claim that is false.

Both are shown and checked as chains are.
"""

from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from .chains import framed
from .models import differ, evaluate, model
from .reasons import cited_latex, cited_text, gap, idle, shown
from .relations import Reasons, named, refuse_means, unfounded
from .typeset import Show, latex, text
from .words import Formula, denied, kept, same_shape


@dataclass(frozen=True, eq=False, repr=False)
class Construction:
    """Something exists, because here it is.

    Parameters
    ----------
    number, says : str
        As for a `Chain`.
    values : dict of MatrixSymbol to expression
        What is constructed, from other letters than these.
    satisfies : tuple of Relation
        What it must satisfy.
    by : tuple of Relation
        What is known, and needed; it says nothing of what is constructed.
    symmetric : iterable of MatrixSymbol
        Symbols equal to their transpose; what is constructed must be shown to be.

    Examples
    --------
    >>> from sympy import symbols
    >>> from matrixproof import Identity, MatrixSymbol, Relation
    >>> n, p = symbols("n p", integer=True, positive=True)
    >>> C, G = MatrixSymbol("C", p, n), MatrixSymbol("G", n, p)
    >>> X, N = MatrixSymbol("X", n, p), MatrixSymbol("N", p, p)
    >>> right_inverse = Relation("C G = I", C * G, Identity(p))
    >>> solved = Construction("", "an equation that can be solved", {X: G * N},
    ...                       satisfies=[Relation("C X = N", C * X, N)],
    ...                       by=[right_inverse])
    >>> solved.check()
    []
    >>> print(solved)
    an equation that can be solved
      X = G N
        satisfies C X = N  C G = I  ✓
    """

    number: str
    says: str
    values: dict
    satisfies: tuple
    by: tuple = ()
    symmetric: tuple = ()

    def __post_init__(self):
        object.__setattr__(self, "satisfies", named(self.satisfies))
        object.__setattr__(self, "by", named(self.by))
        object.__setattr__(self, "symmetric", tuple(self.symmetric))
        object.__setattr__(self, "values", kept(self.values))
        refuse_means(self.relations)

    @property
    def relations(self) -> Reasons:
        """What it rests on."""
        return (*self.by, *self.satisfies)

    @property
    def expressions(self) -> list[Formula]:
        """Every expression in it."""
        return [
            *self.values,
            *self.values.values(),
            *(e for r in self.relations for e in r),
        ]

    def check(self) -> list[str]:
        """What is wrong with the construction; [] when it does what it says."""
        return list(self._faults)

    @cached_property
    def _faults(self):
        if found := self._circular() or unfounded(self.by, self.symmetric):
            return found
        known = tuple(s for s in self.symmetric if s not in self.values)
        wanted = {
            f"{cited_text(r)} is not satisfied": [
                sp.sympify(side).xreplace(dict(self.values)) for side in r
            ]
            for r in self.satisfies
        }
        for s, value in self.values.items():
            if s in self.symmetric:
                wanted[f"{text(s)} is not symmetric"] = value.T, value
        missing = {what: gap(*two, self.by, known) for what, two in wanted.items()}
        found = [f"{what}: {why}" for what, why in missing.items() if why is not None]
        if found:
            return found
        holds = lambda others: all(  # noqa: E731
            gap(*two, others, known) is None for two in wanted.values()
        )
        found = [f"does not need {cited_text(r)}" for r in idle(self.by, holds)]
        also = [*self.values.values(), *(e for two in wanted.values() for e in two)]
        if model(self.by, known, also) is None:
            found.append(
                "no matrices were found that satisfy what is cited and have the "
                "inverses that are taken"
            )
        return found

    def _circular(self):
        """What would make it exist by supposing that it does, or be something else."""
        made, found = set(self.values), []
        if not made:
            return ["nothing is constructed"]
        for r in self.by:
            if named := made & letters_of(r.left, r.right):
                found.append(f"{cited_text(r)} supposes {listed(named)}, made here")
        for s, value in self.values.items():
            if named := made & letters_of(value):
                found.append(f"{text(s)} is constructed from {listed(named)}")
            if not same_shape(s.shape, value.shape):
                found.append(
                    f"{text(s)} has the shape {s.shape}, and its value {value.shape}"
                )
        asked = letters_of(*(side for r in self.satisfies for side in r))
        if idle_ones := made - asked:
            found.append(f"nothing is asked of {listed(idle_ones)}")
        return found

    def __str__(self):
        title = f"({self.number}) {self.says}" if self.number else self.says
        out = [title, *(f"  {text(s)} = {text(v)}" for s, v in self.values.items())]
        does = ", ".join(map(cited_text, self.satisfies))
        reason = ", ".join(map(cited_text, self.by))
        out.append(f"    satisfies {does}  {reason}  {'✗' if self.check() else '✓'}")
        return "\n".join([*out, *(f"  {fault}" for fault in self.check())])

    __repr__ = __str__

    def _repr_latex_(self):
        does = r",\; ".join(map(cited_latex, self.satisfies))
        reason = r",\; ".join(map(cited_latex, self.by))
        mark = r"\times" if self.check() else r"\checkmark"
        rows = [f"{latex(s)} &= {latex(v)}" for s, v in self.values.items()]
        rows.append(rf"&\text{{satisfies }} {does} && {reason} && {mark}")
        return framed(rows, self.number)


@dataclass(frozen=True, eq=False, repr=False)
class Counterexample:
    """A claim that is false, because here are matrices that deny it.

    Parameters
    ----------
    number, says : str
        As for a `Chain`.
    left, right : expression
        The sides of the claim.
    values : dict of symbol to explicit Matrix
        With rational entries.
    given : tuple of Relation
        What the claim supposes; the matrices must satisfy it.
    symmetric : iterable of MatrixSymbol

    Examples
    --------
    >>> from sympy import Matrix, symbols
    >>> from matrixproof import MatrixSymbol
    >>> n = symbols("n", integer=True, positive=True)
    >>> A, B = MatrixSymbol("A", n, n), MatrixSymbol("B", n, n)
    >>> sums = Counterexample("", "the inverse of a sum", (A + B).I, A.I + B.I,
    ...                       {A: Matrix([[1]]), B: Matrix([[1]])})
    >>> sums.check()
    []
    >>> print(sums)
    the inverse of a sum
      (A + B)⁻¹ ≠ A⁻¹ + B⁻¹
        with A = 1, B = 1, the sides are 1/2 and 2  ✓
    """

    number: str
    says: str
    left: Formula
    right: Formula
    values: dict
    given: tuple = ()
    symmetric: tuple = ()

    def __post_init__(self):
        object.__setattr__(self, "given", named(self.given))
        object.__setattr__(self, "symmetric", tuple(self.symmetric))
        object.__setattr__(self, "values", kept(self.values))
        refuse_means(self.given)

    @property
    def relations(self) -> Reasons:
        """What the claim supposes."""
        return self.given

    @property
    def expressions(self) -> list[Formula]:
        """Every expression in it."""
        return [self.left, self.right, *(e for r in self.given for e in r)]

    def check(self) -> list[str]:
        """What is wrong with the example; [] when it denies the claim and no more."""
        found = [
            f"does not satisfy {cited_text(r)}"
            for r in self.given
            if differ(r.left, r.right, self.values)
        ]
        found += [
            f"{text(s)} is not symmetric"
            for s in self.symmetric
            if s in self.values and differ(s, sp.Transpose(s), self.values)
        ]
        found += [says for pair in self.values.items() if (says := denied(*pair))]
        one, other = (getattr(side, "shape", ()) for side in (self.left, self.right))
        alike = same_shape(one, other) if one and other else one == other
        if not alike and self.right != 0:
            found.append(f"no claim: the sides have shapes {one} and {other}")
        elif not differ(self.left, self.right, self.values):
            found.append("the sides are equal")
        return found

    def said(self, show: Show) -> tuple[list[str], list[str]]:
        """The values as equations, and the two sides at them."""
        values = [f"{show(s)} = {shown(v, show)}" for s, v in self.values.items()]
        sides = [
            shown(evaluate(side, self.values), show) for side in (self.left, self.right)
        ]
        return values, sides

    def __str__(self):
        title = f"({self.number}) {self.says}" if self.number else self.says
        values, (left, right) = self.said(text)
        faults = self.check()
        out = [
            title,
            f"  {text(self.left)} ≠ {text(self.right)}",
            f"    with {', '.join(values)}, the sides are {left} and {right}  "
            + ("✗" if faults else "✓"),
        ]
        return "\n".join([*out, *(f"  {fault}" for fault in faults)])

    __repr__ = __str__

    def _repr_latex_(self):
        values, (left, right) = self.said(latex)
        mark = r"\times" if self.check() else r"\checkmark"
        joined = r",\; ".join(values)
        rows = [
            rf"{latex(self.left)} &\ne {latex(self.right)}",
            rf"{left} &\ne {right} && {joined} && {mark}",
        ]
        return framed(rows, self.number)


def letters_of(*expressions):
    """The matrix symbols in expressions."""
    return {s for e in expressions for s in sp.sympify(e).atoms(sp.MatrixSymbol)}


def listed(letters):
    return " and ".join(sorted(map(text, letters)))
