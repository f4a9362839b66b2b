"""Derivations that find their lines: one names an operation, and not its result.

Each operation works out the next line and adds it to a chain, with what it cites; the
chain is then checked as any other is, by code that knows nothing of operations.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixExpr

from .algebra import Algebra, Blocks, Polynomial, Traces
from .chains import Chain
from .dependence import Scope, declared, letters
from .lines import AtLeast, Line, cited_text, in_blocks
from .operators import Differential, Expect, Gradient, Moments, Transposed, as_traces
from .orders import prove_at_least, root_of
from .proofs import prove
from .relations import Relation, equation, named, under
from .symbols import MatrixProduct, MatrixSum, Own, ZeroMatrix, plus
from .terms import (
    Pattern,
    as_before,
    common,
    factored,
    joined,
    negative,
    opened,
    put_in,
    scalar,
    summed,
    together,
    whole,
    written,
)
from .typeset import Show, latex, text
from .words import Formula, Symbols, is_letter, plain, rotations, same_size


@dataclass(frozen=True, repr=False)
class Solved(Relation):
    """What an equation says of an unknown, and what was inverted to say it."""

    invertible: tuple = ()

    word = ""

    def condition(self, show: Show) -> str:
        """What is taken to be invertible, in words, or nothing."""
        taken = ", ".join(map(show, self.invertible))
        said = r"\quad \text{{if }} {} \text{{ can be inverted}}"
        said = said if show is latex else ", if {} can be inverted"
        return said.format(taken) if taken else ""


@dataclass(frozen=True, repr=False)
class ForEvery(Relation):
    """An equation between coefficients of a letter that may be anything.

    Attributes
    ----------
    every : MatrixSymbol
        The letter: the equation is needed, and enough, for every value of it.
    """

    every: Formula = None

    def condition(self, show: Show) -> str:
        """For what it is, in words."""
        if show is latex:
            return rf"\quad \text{{for every }} {latex(self.every)}"
        return f", for every {show(self.every)}"


def derive(
    left: Formula,
    number: str = "",
    says: str = "",
    symmetric: Symbols = (),
    known: Any = (),
) -> Derived:
    """Begin a derivation: its operations find the lines.

    Parameters
    ----------
    left : expression, Relation or Chain
        What the derivation begins with.  Of a relation that is its left side, and
        its right side is the first line.
    number, says : str
        As for a `Chain`.
    symmetric : iterable of MatrixSymbol
        Symbols equal to their transpose; those that `letters` made so are known.
    known : iterable of Relation
        What else is known: a letter that depends by it on what a gradient moves is
        not taken for constant.

    Returns
    -------
    Derived
        A `Chain` without lines yet, with the operations.

    Examples
    --------
    S is a quadratic in K; where does the slope of its trace vanish?

    >>> from sympy import Trace
    >>> from matrixproof import derive, letters
    >>> K, P, N, M, S = letters("K:n*p P:n*n= N:n*p M:p*p= S:n*n=")
    >>> cost = derive(Trace(S)).put((S, P - K * N.T - N * K.T + K * M * K.T))
    >>> slope = cost.expand().gradient(K)
    >>> print(slope)
      tr(S)
        = tr(P - K N' - N K' + K M K')              S = P - K N' - N K' + K M K'  ✓
        = tr(P) - tr(K N') - tr(N K') + tr(K M K')  multiply out                  ✓
        ∂/∂K [·] = 2 (K M - N)                      differentiate                 ✓
    >>> slope.solve(K)
    K M = N
    """
    return begun(number, says, left, symmetric, known=named(known))


def begun(number, says, left, symmetric, **more):
    """A derivation that has just begun; from a relation it has a line."""
    by = getattr(left, "relation", left)
    if not isinstance(by, Relation):
        return Derived(number, says, left, (), tuple(symmetric), **more)
    lines = (Line(by.right, (by,)),)
    return Derived(number, says, by.left, lines, tuple(symmetric), **more)


@dataclass(frozen=True, eq=False, repr=False)
class Derived(Chain):
    """A derivation so far: a chain, and the operations that find its next line.

    Every operation returns a new derivation, with a line more.

    Attributes
    ----------
    brackets : dict of expression to expression
        After `collect`, what multiplies each of what was collected.

    Examples
    --------
    What is known is used:

    >>> from sympy import Trace
    >>> from matrixproof import BlockMatrix, Identity, Relation, derive, letters
    >>> A, B, C, D, S = letters("A:n*n B:n*n C:n*n D:n*n S:n*n")
    >>> K, H, M, N, P, R = letters("K:n*p H:p*n M:p*p= N:n*p P:n*n= R:p*p=")
    >>> print(derive(A * S).put((S, A + B)))
      A S
        = A (A + B)  S = A + B  ✓
    >>> print(derive(D * A * B + D * C).use((A * B + C, Identity(A.rows))))
      D A B + D C
        = D  A B + C = I  ✓
    >>> line = derive(K * H * P * H.T * K.T + P + K * R * K.T)
    >>> print(line.fold((M, H * P * H.T + R)))
      K H P H' K' + P + K R K'
        = K M K' + P  M = H P H' + R  ✓
    >>> print(derive(A * B * A).by(C * A, (D, A), (A * B, C)))
      A B A
        = C A  A B = C  ✓
    >>> print(derive(A).insert(A * B * C, (B * C, Identity(A.rows))))
      A
        = A B C  B C = I, inserted  ✓

    The line is written otherwise:

    >>> print(derive((A + B) * (A + B).T).expand())
      (A + B) (A + B)'
        = A A' + A B' + B A' + B B'  multiply out  ✓
    >>> print(derive(2 * A * B - 2 * A * C * B).factor())
      2 A B - 2 A C B
        = 2 A (I - C) B  factor  ✓
    >>> x, z, e, w = letters("x:n z:n e:n w:n")
    >>> found = derive(D * z + C * A * x - C * B * x).collect(x)
    >>> print(found)
      D z + C A x - C B x
        = D z + (C A - C B) x  collect x  ✓
    >>> found.brackets[x]
    C*A - C*B
    >>> H_1, H_2, x_1, x_2 = letters("H_1:p*r H_2:p*n-r x_1:r x_2:n-r")
    >>> blocks = (H, BlockMatrix([[H_1, H_2]])), (x, BlockMatrix([[x_1], [x_2]]))
    >>> print(derive(H * x).multiply(*blocks))
      H x
        = [H₁ H₂] [x₁; x₂]  H, x                 ✓
        = H₁ x₁ + H₂ x₂     multiply the blocks  ✓
    >>> print(derive(Trace(A * B) + Trace(A.T * B.T)).cyclic())
      tr(A B) + tr(A' B')
        = 2 tr(A B)  the trace is cyclic  ✓

    Something is done to it:

    >>> print(derive(A * P + A).transpose())
      A P + A
        [·]' = P A' + A'  transpose  ✓
    >>> noise = (e * e.T, P), (w * w.T, S), (e * w.T, 0 * A)
    >>> print(derive((A * e - w) * (A * e - w).T).expect(*noise))
      (A e - w) (A e - w)'
        E[·] = A P A' + S  E[e e'] = P, E[w w'] = S, E[e w'] = 0  ✓
    >>> print(derive(Trace(K * M * K.T - 2 * N * K.T)).gradient(K))
      tr(K M K' - 2 N K')
        ∂/∂K [·] = 2 (K M - N)  differentiate  ✓
    >>> derive(Trace(S * K * N.T), known=[(S, K * N.T)]).gradient(K)
    Traceback (most recent call last):
        ...
    ValueError: the line takes S for constant, which S = K N' ties to K: put that \
in first, or say that it is held
    >>> print(derive(A.I * B).differential({A: D}))
      A⁻¹ B
        d[·] = -A⁻¹ D A⁻¹ B  differentiate  ✓
    >>> print(derive(P + (K - N) * M * (K - N).T).drop(M))
      P + (K - N) M (K - N)'
        ≥ P  (K - N) L_M ((K - N) L_M)' ≥ 0, M = L_M L_M'  ✓

    It is solved, compared, completed to a square:

    >>> derive(2 * S * (K * M - N)).solve(K, "33")
    (33) K M = N, if S can be inverted
    >>> derive(K * M * K.T).solve(K)
    Traceback (most recent call last):
        ...
    ValueError: the line is not linear in K: it is K M K'
    >>> slope = derive(Relation("S", C, 2 * S * (B - A) * D))
    >>> print(slope.solved(B, (C, 0 * C)))
      B
        = B - 1/2 S⁻¹ C D⁻¹  C = 0              ✓
        = A                  C = 2 S (B - A) D  ✓
    >>> T, V, F = letters("T:n*n V:n*n F:n*n")
    >>> [one.name for one in derive(A * P * T + A * V * C).match(F * T + D * C, "14")]
    ['(14) F = A P', 'D = A V']
    >>> (B,) = letters("B:n*p")
    >>> print(derive(P - K * N.T - N * K.T + K * M * K.T).square(K, (B * M, N)))
      P - K N' - N K' + K M K'
        = P - N B' + (K - B) M (K - B)'  B M = N, complete the square  ✓
    """

    known: tuple = ()
    brackets: dict = field(default_factory=dict)

    def _then(self, line, brackets=()):
        """The derivation with a line more."""
        if line.right == self.right and not hasattr(line, "applied"):
            raise ValueError(f"nothing changes: the line is {text(self.right)} already")
        lines = (*self.lines, line)
        return replace(self, lines=lines, brackets=dict(brackets))

    def _algebra(self, *relations):
        """What is known of the letters of the line and of relations."""
        return Algebra(declared(self.symmetric, (self.right, *relations)))

    def _normal(self, wanted=(Polynomial, Traces, Blocks), what=""):
        """The line multiplied out."""
        value = self._algebra().normal(self.right)
        if not isinstance(value, wanted):
            raise TypeError(f"{what}, and the line is {text(self.right)}")
        return value

    def _missing(self, x):
        return ValueError(f"the line has no {text(x)}: it is {text(self.right)}")

    # -- what is known is used --------------------------------------------------------

    def put(self, *definitions: Any) -> Derived:
        """Definitions put in, as they stand, one after the other.

        Each has a letter on its left, or blocks on both sides, of which those that are
        letters are put in.  `multiply` opens the blocks of a right side.
        """
        right, by = self.right, named(definitions)
        for relation in by:
            meant = meanings(relation)
            if not meant:
                said = cited_text(relation)
                raise ValueError(f"{said} does not say what a letter is: `use` it")
            if not letters(plain(right)) & set(meant):
                which = " or ".join(map(text, meant))
                raise ValueError(f"the line has no letter {which}")
            right = put_in(right, meant)
        return self._then(Line(right, by))

    def use(self, *relations: Any) -> Derived:
        """Relations used from left to right: what is their left side is replaced.

        A left side that is a sum is looked for as a whole; where it does not stand,
        the longest of its products that stands is replaced by the rest.
        """
        return self._found(relations, used)

    def fold(self, *definitions: Any) -> Derived:
        """Definitions recognised: what is their right side gets their letter.

        Where a sum does not stand as a whole, the longest of its products that stands
        is the letter less the rest.
        """
        return self._found(definitions, folded)

    def _found(self, relations, find):
        """The line after each relation, by what finds where it stands."""
        right, by = self.right, named(relations)
        for relation in by:
            seen = find(self._algebra(*by), right, relation)
            if seen is None or seen == right:
                sought = relation.left if find is used else relation.right
                said = f"{text(sought)}: it is {text(right)}"
                raise ValueError(f"the line has no {said}")
            right = seen
        return self._then(Line(right, by))

    def by(self, right: Formula, *relations: Any) -> Derived:
        """What the engine proves the line to equal, from some of these relations.

        The line cites those that the proof needs.

        Raises
        ------
        Unproved
            It does not follow.
        """
        line = Line(right, named(relations))
        symmetric = self._algebra(right, *line.by).symmetric
        opened = in_blocks(self.right, right, line.by)
        idle = {r.name for r in opened[2]}.difference(prove(*opened, symmetric).cited)
        needed = tuple(r for r in line.by if r.name not in idle)
        for r in needed:  # a proof may use what another one does without
            others = tuple(x for x in needed if x is not r)
            if line.follows(self.right, others, symmetric):
                needed = others
        return self._then(Line(right, needed, "" if needed else "multiply out"))

    def insert(self, right: Formula, *relations: Any, why: str = "inserted") -> Derived:
        """A line that is typed, as where an identity is put between two factors."""
        return self._then(Line(right, named(relations), why))

    # -- how it is written ------------------------------------------------------------

    def expand(self) -> Derived:
        """The line multiplied out, in the order of its factors."""
        return self._then(Line(self._expanded(), why="multiply out"))

    def _expanded(self):
        if isinstance(self.right, MatrixExpr):
            return written(self._normal())
        if plain(self.right).has(sp.Trace):
            return scalar(opened(self.right, self._algebra()))
        return sp.expand(self.right)

    def multiply(self, *definitions: Any) -> Derived:
        """Blocks put in, where definitions are given, and multiplied."""
        start = self.put(*definitions) if definitions else self
        if not sp.sympify(start.right).has(sp.BlockMatrix):
            raise ValueError(f"the line has no blocks: it is {text(start.right)}")
        why = "multiply the blocks"
        if isinstance(start.right, MatrixExpr):
            return start._then(Line(whole(start._normal()), why=why))
        terms = opened(start.right, start._algebra())
        total = joined(terms, start._algebra())
        why += "" if len(total) == len(terms) else ", the trace is cyclic"
        return start._then(Line(scalar(total), why=why))

    def factor(self) -> Derived:
        """What its terms have in common before and behind brackets, block by block."""
        if not isinstance(self.right, MatrixExpr):
            return self._then(Line(scalar_factors(self.right), why="factor"))
        return self._then(Line(factored(self._normal()), why="factor"))

    def collect(self, *columns: Formula) -> Derived:
        """What multiplies each of these last factors, in brackets.

        Where the last factors can be anything, as a state and an input can, and the
        line must vanish, each of its `brackets` must vanish: `vanishing` says so.
        """
        value, groups, rest = self._tails(columns)
        parts, brackets = [summed(rest, *value.shape)] if rest else [], {}
        for v, found in groups.items():
            brackets[v] = summed(found, value.shape[0], v.rows)
            parts.append(brackets[v] * v)
        why = "collect " + " and ".join(map(text, columns))
        right = sum(parts[1:], parts[0])
        if right == self.right:  # and has its brackets
            return replace(self, brackets=brackets)
        return self._then(Line(right, why=why), brackets)

    def vanishing(self, *numbers: str) -> tuple[Relation, ...]:
        """That each bracket is zero, as relations that can be cited.

        Together they say that the line is the same whatever was collected is.  What has
        a minus in a bracket stands on the right.

        Parameters
        ----------
        *numbers : str
            Those of the relations, in the order in which was collected.

        Raises
        ------
        ValueError
            What was collected is not free: it is no letter, a bracket has it, or
            something known ties it to another letter.

        Examples
        --------
        >>> from matrixproof import derive, letters
        >>> A, B, T, G, x, u = letters("A:n*n B:n*m T:r*n G:r*m x:n u:m")
        >>> line = derive(T * A * x + T * B * u - G * u).collect(x, u)
        >>> for found in line.vanishing("9", "10"):
        ...     print(found)
        Suppose (9) T A = 0, for every x
        Suppose (10) T B = G, for every u
        """
        if not self.brackets:
            raise ValueError("nothing was collected: collect(x, u) before")
        equations = []
        for v, b in self.brackets.items():
            terms = self._algebra().normal(b).terms.items()
            halves = [(w, c) for w, c in terms if not negative(c)]
            across = [(w, -c) for w, c in terms if negative(c)]
            sides = (summed(x, *b.shape) for x in (halves, across))
            equations.append((*sides, v))
        return self._for_every(equations, numbers)

    def _for_every(self, equations, numbers, mend=""):
        """Relations (left, right, of what) that hold for all of what is compared.

        What is compared must be letters that differ, of which nothing else in the
        equations is one, and that nothing known ties to anything.
        """
        equations = list(equations)
        columns = [v for _, _, v in equations]
        for v in columns:
            if not isinstance(v, sp.MatrixSymbol):
                said = f"{text(v)} is no letter, so it may not be anything"
                raise ValueError(said + mend)
        inside = {x for a, b, _ in equations for e in (a, b) for x in letters(plain(e))}
        if caught := inside & set(columns):
            x = text(min(caught, key=str))
            raise ValueError(
                f"{x} is not free: a coefficient that is compared has it, so that "
                "others may do as well"
            )
        scope = Scope([*self.known, *self.relations])
        for v in columns:
            if tied := scope.tied([v]).keys() & (inside | set(columns) - {v}):
                x = min(tied, key=str)
                said = cited_text(scope.tied([v])[x])
                said = f"{text(v)} is not free: {said} ties it to {text(x)}"
                raise ValueError(said + mend)
        return tuple(
            ForEvery(under(k, equation(a, b)), a, b, every=v)
            for (a, b, v), k in zip(equations, [*numbers, *[""] * len(equations)])
        )

    def _tails(self, columns):
        """The line, {column: terms before it} for columns, and its other terms."""
        value = self._normal(Polynomial, "only in a matrix can one collect")
        words = {next(iter(self._algebra().normal(v).terms)): v for v in columns}
        groups, rest = {v: [] for v in columns}, []
        for w, c in value.terms.items():
            for end, v in words.items():
                if w[-len(end) :] == end:
                    groups[v].append((w[: -len(end)], c))
                    break
            else:
                rest.append((w, c))
        for v, found in groups.items():
            if not found:
                raise self._missing(v)
        return value, groups, rest

    def transpose(self) -> Derived:
        """The transpose of the line."""
        value = self._normal((Polynomial, Blocks), "only a matrix has a transpose")
        return self._then(Transposed(written(value.T), why="transpose"))

    def cyclic(self, first: Formula = None) -> Derived:
        """Traces rotated, so that those that are equal are joined.

        A trace begins with the factor `first`, where it has that.
        """
        self._normal(Traces, "only the factors in a trace can be rotated")
        algebra = self._algebra()
        total = joined(opened(self.right, algebra), algebra, first)
        return self._then(Line(scalar(total), why="the trace is cyclic"))

    # -- what is done to it -----------------------------------------------------------

    def expect(self, *moments: Any) -> Derived:
        """The expectation, by those of these moments that it needs."""
        known = Expect(self.right, moments=moments).moments
        found = Moments(known, self._algebra(*known).symmetric)
        value = found.expectation(self.right)
        used = tuple(r for r in known if r in found.seen)
        if not used:
            raise ValueError(f"nothing in the line is random: {text(self.right)}")
        return self._then(Expect(written(value), moments=used))

    def gradient(self, of: Formula, held: Any = ()) -> Derived:
        """The gradient of a trace in a letter, or the derivative of a number.

        Where the letter stands for blocks, `multiply` shows the gradient in each.  A
        letter of the line that depends on it is refused, unless it is `held`.
        """
        if of not in letters(plain(self.right)):
            raise self._missing(of)
        line = self._constant(Gradient(0, why="differentiate", of=of, held=tuple(held)))
        if isinstance(of, sp.Symbol):
            return self._then(replace(line, right=line.applied(self.right, ())))
        scalar, inverses = as_traces(self.right, self._algebra())
        said = "only a trace has a gradient in a matrix"
        value = replace(self, left=scalar, lines=())._normal(Traces, said)
        found = together(value.algebra.gradient(value, of)).xreplace(inverses)
        return self._then(replace(line, right=found))

    def differential(self, increments: dict[Any, Any], held: Any = ()) -> Derived:
        """The first differential, for letters that move by these increments."""
        for x in increments:
            if x not in letters(plain(self.right)):
                raise self._missing(x)
        line = self._constant(
            Differential(0, why="differentiate", of=increments, held=tuple(held))
        )
        value = self._algebra().differential(self.right, increments)
        return self._then(replace(line, right=written(value)))

    def _constant(self, line):
        """The line, if what it takes for constant is not known to move."""
        for fault in line.hidden(self.right, Scope([*self.known, *self.relations])):
            raise ValueError(f"the line {fault}")
        return line

    # -- what comes out ---------------------------------------------------------------

    def solve(self, X: Formula, number: str = "", name: Formula = None) -> Solved:
        """The equation that says that the line is zero, solved for a letter.

        What stands before and behind all its terms is taken to be invertible, and so
        is what stands before the unknown alone; the relation says so.  In the solution
        the letter `name` stands for the unknown, where it is given.
        """
        if isinstance(X, sp.Symbol):
            left, right, inverted = root(X, self.right)
        else:
            left, right, *words, _ = solution(self._normal(), X, self.right)
            found = (x.atom for word in words for x in word if not x.inverted)
            inverted = tuple(dict.fromkeys(found))
        if name is not None:
            left = left.xreplace({X: name})
        return Solved(under(number, equation(left, right)), left, right, inverted)

    def solved(self, X: Formula, zero: Any, number: str = "", says: str = "") -> Chain:
        """What a letter is, as a chain, where what the derivation began with is zero.

        The relation `zero` says so; `solve` says what is taken to be invertible.
        """
        (zero,) = named([zero])
        if zero.left != self.left or not self._algebra().normal(zero.right).is_zero:
            raise ValueError(
                f"{zero.show(text)} does not say that {text(self.left)} = 0"
            )
        value, turned = upright(self._normal(), X)
        left, right, front, back, share = solution(value, X, self.right)
        start = self.left.T if turned else self.left
        front, back = ([x.as_expr().I for x in reversed(w)] for w in (front, back))
        moved = MatrixProduct(-1 / share, *front, start, *back)
        lines = Line(MatrixSum(left, moved), (zero,)), Line(right, (self.relation,))
        return Derived(number, says, left, lines, self.symmetric)

    def match(
        self, form: Formula, *numbers: str, enough: bool = False
    ) -> tuple[Relation, ...]:
        """What the first factors of a form are, so that it equals the line.

        Terms that end alike are compared.  That is needed if what they end with are
        letters that may be anything, each whatever the others are; then the relations
        say so.  With `enough` the last factors need not be free: the relations are then
        one way in which the form equals the line, and there may be others.
        """
        words = [*self._algebra().normal(form).terms]
        columns = [MatrixProduct(1, *(x.as_expr() for x in w[1:])) for w in words]
        value, groups, rest = self._tails(columns)
        if rest:
            said = text(summed(rest, *value.shape))
            raise ValueError(f"{said} in the line ends like no term of {text(form)}")
        unknowns = [w[0].as_expr() for w in words]
        rights = [summed(groups[v], *x.shape) for v, x in zip(columns, unknowns)]
        if not enough:
            mend = "; say enough=True where one way will do"
            return self._for_every(zip(unknowns, rights, columns), numbers, mend)
        numbers = (*numbers, *[""] * len(words))
        return tuple(
            Relation(under(k, equation(a, b)), a, b)
            for a, b, k in zip(unknowns, rights, numbers)
        )

    def square(self, K: Formula, solved: Any) -> Derived:
        """A quadratic in a letter, completed to a square around a solution.

        Where the relation `solved` holds of another letter, the slope of the line
        vanishes.
        """
        (by,) = named([solved])
        value = self._normal((Polynomial, Traces), "blocks are no quadratic")
        times = {w: sum(x.atom == K for x in w) for w in value.terms}
        new = [
            x
            for x in letters(plain(by.left)) - letters(plain(self.right))
            if getattr(x, "shape", ()) == K.shape
        ]
        if max(times.values()) != 2 or len(new) != 1:
            raise ValueError(
                f"the line is no quadratic in {text(K)} whose slope vanishes where "
                f"{by.show(text)}: it is {text(self.right)}"
            )
        algebra, best = self._algebra(by), new[0]
        twice = value.like((w, c) for w, c in value.terms.items() if times[w] == 2)
        quadratic = together(twice).xreplace({K: K - best})
        rest = algebra.normal(written(value).xreplace({K: best}))
        old, new = (algebra.normal(side) for side in by)
        rest = replaced(rest, [Pattern(old.T, new.T), Pattern(old, new)]) or rest
        parts = [written(rest), quadratic]
        if all(map(negative, rest.terms.values())):
            parts.reverse()
        right = (plus if isinstance(value, Traces) else MatrixSum)(*parts)
        return self._then(Line(right, (by,), "complete the square"))

    def drop(self, *roots: Any, of: Formula = None) -> Derived:
        """A term dropped that is not negative: the machine finds its root.

        What is not negative is told by a letter, for which a root is made, or by the
        relation that says of what it is the square, `M = L L'`.  Where several terms
        could be dropped, `of` is a letter in the one that is.
        """
        relations = [rooted(x) if isinstance(x, sp.MatrixSymbol) else x for x in roots]
        by = {r.left: r for r in named(relations)}
        terms = parts_of(self.right)
        found = [
            (k, *square_root(term, by, self._algebra(*by.values()).symmetric))
            for k, term in enumerate(terms)
            if of is None or of in letters(term)
        ]
        found = [(k, root, used) for k, root, used in found if root is not None]
        if len(found) != 1:
            what = "several terms are squares" if found else "no term is a square"
            mend = "say of which letter" if found else "say which letters are squares"
            raise ValueError(f"{what}, {mend}: the line is {text(self.right)}")
        ((k, root, used),) = found
        rest = [term for j, term in enumerate(terms) if j != k]
        if isinstance(self.right, MatrixExpr):
            right = MatrixSum(*rest) if rest else ZeroMatrix(*self.right.shape)
        else:
            right = plus(*rest)
        return self._then(AtLeast(right, tuple(by[M] for M in used), root=root))

    def at_least(self, right: Formula, *relations: Any) -> Derived:
        """What the machine finds the line to be at least, by some of these relations.

        The difference is a sum of squares; the machine finds it.

        Parameters
        ----------
        right : expression
        *relations : Relation, pair or Chain
            What `orders.at_least` says among them.

        Raises
        ------
        Unproved
            No sum of squares was found; with a counterexample, if one was.

        Examples
        --------
        >>> from matrixproof import derive, letters
        >>> from matrixproof.orders import at_least
        >>> A, P, Q = letters("A:n*n P:n*n= Q:n*n=")
        >>> print(derive(A * P * A.T).at_least(A * Q * A.T, at_least(P, Q)))
          A P A'
            ≥ A Q A'  A L_P_Q (A L_P_Q)' ≥ 0, P ≥ Q  ✓
        """
        given = named(relations)
        symmetric = self._algebra(right, *given).symmetric
        cited = prove_at_least(self.right, right, given, symmetric).cited
        needed = tuple(r for r in given if r.name in cited)
        root, _ = root_of(self.right, right, needed, symmetric)
        return self._then(AtLeast(right, needed, root=root))


def scalar_factors(expr):
    """A number in factors, a minus in front of them put into a bracket."""
    stands = {t: sp.Dummy() for t in sp.sympify(expr).atoms(sp.Trace)}
    found = sp.factor(sp.sympify(expr).xreplace(stands))
    number, rest = found.xreplace({x: t for t, x in stands.items()}).as_coeff_Mul()
    sums = [x for x in sp.Mul.make_args(rest) if isinstance(x, sp.Add)]
    if number.is_negative and sums:
        return sp.Mul(
            -number, *(-x if x == sums[0] else x for x in rest.args or [rest])
        )
    return number * rest


def meanings(relation):
    """{letter: what it is} of a definition, or of an equation between blocks."""
    pairs, found = [tuple(relation)], {}
    if all(isinstance(side, sp.BlockMatrix) for side in relation):
        pairs = zip(*(side.blocks for side in relation))
    for old, new in pairs:
        if is_letter(old):
            found.setdefault(old, new)
    return found


def used(algebra, expr, relation):
    """An expression in which a relation is used from left to right, multiplied out."""
    old, new = relation
    if not isinstance(old, MatrixExpr):
        return put_in(expr, {old: new})
    old, new, value = (algebra.normal(e) for e in (old, new, expr))
    if getattr(old, "is_scaled_identity", False):  # I = A B says what A B is
        old, new = new, old
    found = exchanged(value, old, new)
    return found and as_before(found, expr)


def folded(algebra, expr, relation):
    """An expression in which a definition is recognised, as it stands or opened."""
    seen = put_in(expr, {relation.right: relation.left})
    if not isinstance(relation.left, MatrixExpr):
        return seen
    try:
        new, old, value = (algebra.normal(e) for e in (*relation, seen))
    except TypeError:  # what is inverted needs a letter first
        return seen
    found = exchanged(value, old, new, parts=seen == expr)
    return as_before(found, seen) if found else seen


def exchanged(value, old, new, parts=True):
    """A normal form with a sum replaced, or else the longest of its products."""
    if isinstance(old, Blocks):
        if isinstance(new, Blocks) and not isinstance(value, Blocks):
            return each_block(value, old, new)
        same = isinstance(value, Blocks) and value.shape == old.shape
        return new if same and (value - old).is_zero else None
    patterns = [Pattern(old, new), Pattern(old.T, new.T)]
    found = replaced(value, patterns)
    for k in range(len(old.terms) if parts else 0):
        found = found or replaced(value, [pattern.solved(k) for pattern in patterns])
    return found


def replaced(value, patterns):
    """A normal form after all of these patterns, or None if none of them stands."""
    found = None
    for pattern in patterns:
        seen = pattern.replaced(value if found is None else found)
        found = found if seen is None else seen
    return found


def root(X, shown):
    """(X, right, what is not zero): a number of which the line is zero."""
    roots = sp.solve(plain(shown), X)
    if len(roots) != 1:
        raise not_linear(X, shown)
    below = sp.fraction(sp.together(roots[0]))[1]
    return X, roots[0], () if below.is_zero is False else (below,)


def not_linear(X, shown):
    return ValueError(f"the line is not linear in {text(X)}: it is {text(shown)}")


def upright(value, X):
    """A polynomial, or its transpose where an unknown is transposed; and whether."""
    if not isinstance(value, Polynomial):
        raise TypeError("only a matrix is solved for a matrix")
    turned = any(x.atom == X and x.transposed for w in value.terms for x in w)
    return (value.T if turned else value), turned


def each_block(value, old, new):
    """A normal form after each of the equations between the blocks of two matrices."""
    found = None
    for pair in zip(sum(old.entries, ()), sum(new.entries, ())):
        found = exchanged(value if found is None else found, *pair) or found
    return found


def solution(value, X, shown):
    """(left, right, front, back, c): of value = 0, solved for X.

    The value, or its transpose, is c * front * (left - right) * back; these words are
    of what is taken to be invertible.
    """
    value, _ = upright(value, X)
    at = {w: [i for i, x in enumerate(w) if x.atom == X] for w in value.terms}
    with_X = [w for w in at if at[w]]
    if not with_X:
        raise ValueError(f"the line has no {text(X)}: it is {text(shown)}")
    unknown = {w[i] for w in with_X for i in at[w]}
    if len(unknown) > 1 or any(len(at[w]) > 1 or w[at[w][0]].inverted for w in with_X):
        raise not_linear(X, shown)
    first = with_X[0]
    a = squares(first[: min(common([*at]), *(at[w][0] for w in with_X))])
    b = common([w[a:][::-1] for w in at])
    b = squares(first[::-1][: min(b, *(len(w) - 1 - at[w][0] for w in with_X))])
    front, back = first[:a], first[len(first) - b :]
    rest = [(w[a : len(w) - b], -c) for w, c in value.terms.items() if not at[w]]
    around = [(w[a : at[w][0]], w[at[w][0] + 1 : len(w) - b]) for w in with_X]
    numbers = [value.terms[w] for w in with_X]
    heads, tails = map(list, zip(*around))
    behind = len(set(heads)) == 1  # the unknown stands before a bracket
    if not behind and len(set(tails)) > 1:
        raise not_linear(X, shown)
    outer, inner = (heads[0], tails) if behind else (tails[0], heads)
    across = outer if squares(outer) == len(outer) else ()
    share = numbers[0] if len(numbers) == 1 else sp.S.One
    inside = [(w, c / share) for w, c in zip(inner, numbers)]
    bracket = [] if inside == [((), 1)] else [summed(inside, X.shape[behind], 0)]
    kept = [] if across else [x.as_expr() for x in outer]
    left = (
        MatrixProduct(1, *kept, X, *bracket)
        if behind
        else (MatrixProduct(1, *bracket, X, *kept))
    )
    inverse = tuple(x._replace(inverted=not x.inverted) for x in reversed(across))
    rest = [(inverse + w if behind else w + inverse, c / share) for w, c in rest]
    front, back = (front + across, back) if behind else (front, across + back)
    return left, summed(rest, *left.shape), front, back, share


def squares(word):
    """With how many square letters a word begins."""
    square = [same_size(*x.atom.shape) for x in word]
    return [*square, False].index(False)


def rooted(M):
    """The relation that says that a letter is a square."""
    L = Own(f"L_{M.name}", *M.shape)
    return Relation(f"{text(M)} = {text(L * L.T)}", M, L * L.T)


def parts_of(expr):
    return list(expr.args) if isinstance(expr, (sp.MatAdd, sp.Add)) else [expr]


def factors_of(expr):
    """(number, factors) of a product; a transposed product is opened."""
    if isinstance(expr, sp.MatMul):
        found = [factors_of(x) for x in expr.args if isinstance(x, MatrixExpr)]
        number = sp.Mul(*(x for x in expr.args if not isinstance(x, MatrixExpr)))
        return sp.Mul(number, *(c for c, _ in found)), [x for _, f in found for x in f]
    if isinstance(expr, sp.Transpose) and isinstance(expr.arg, sp.MatMul):
        number, found = factors_of(expr.arg)
        return number, [x.T for x in reversed(found)]
    return sp.S.One, [expr]


def square_root(term, roots, symmetric):
    """(root, letters whose roots it needs) of a term that is a square, or None."""
    number, inside = sp.S.One, term
    if not isinstance(term, MatrixExpr):
        traces = [x for x in sp.Mul.make_args(term) if isinstance(x, sp.Trace)]
        if len(traces) != 1:
            return None, ()
        number, inside = term / traces[0], traces[0].arg
    more, factors = factors_of(inside)
    number, opened_ = number * more, []
    for x in factors:
        opened_ += factors_of(roots[x].right)[1] if x in roots else [x]
    half, odd = divmod(len(opened_), 2)
    flip = lambda x: x if x in symmetric else x.T  # noqa: E731
    turned = rotations(opened_) if inside is not term else [opened_]
    for each in turned if number.is_nonnegative and not odd else ():
        if each[half:] == [flip(x) for x in reversed(each[:half])]:
            root = MatrixProduct(sp.sqrt(number), *each[:half])
            return root, tuple(dict.fromkeys(x for x in factors if x in roots))
    return None, ()
