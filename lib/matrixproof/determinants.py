"""Determinants: claims with them, and what the proof of one rests on.

det(X Y) = det X det Y of square factors, det X' = det X, det X^-1 = 1 / det X, of
blocks of which those above or below the diagonal are zero the determinants of those on
it, det(I + U V) = det(I + V U), and det(A + U V) = det A det(I + A^-1 U V) where A^-1
is written.  So every determinant is a product of some that are known apart, and the
claim one about numbers.  Each of these steps rests on an equation between matrices,
which is proved like any other.
"""

from dataclasses import dataclass, replace
from typing import Any

import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixExpr

from .algebra import Algebra, Polynomial
from .models import possible
from .relations import unfounded
from .symbols import BlockMatrix, Identity, MatrixProduct, MatrixSum, ZeroMatrix
from .terms import columns_of, common, term, written
from .words import Formula, ShapeError, plain, same_shape, same_size

MOST = 40  # forms of one determinant that are looked at


@dataclass(frozen=True)
class Step:
    """What a determinant is, by one rule.

    Attributes
    ----------
    of : MatrixExpr
    rule : str
        One of `RULES`.
    parts : tuple of MatrixExpr
        Matrices whose determinants it is made of.
    scale : expression
        A number in front of a product.
    proofs : tuple of Proof
        The equations between matrices that the rule needs.
    within : tuple of MatrixExpr
        U and V, where I + U V is exchanged for I + V U.
    """

    of: Formula
    rule: str
    parts: tuple = ()
    scale: Formula = sp.S.One
    proofs: tuple = ()
    within: tuple = ()

    @property
    def number(self) -> Formula:
        """What stands in front of the product of determinants."""
        return self.scale ** self.of.shape[0]

    @property
    def powers(self) -> tuple[tuple[Formula, int], ...]:
        """(matrix, power) of each determinant."""
        k = int(self.of.exp) if self.rule == "a power" else 1
        return tuple((x, k) for x in self.parts)

    def wanted(self) -> tuple[bool, tuple]:
        """Whether the rule applies as it stands, and the equations that it needs."""
        of, parts = self.of, self.parts
        square = all(same_size(*x.shape) for x in (of, *parts))
        if self.rule == "a power":
            return square and parts == (of.base,), ()
        if self.rule == "a transpose":
            return square and parts == (of.arg,), ()
        if self.rule == "a product":
            whole = parts or (Identity(of.shape[0]),)
            return square, ((of, MatrixProduct(self.scale, *whole)),)
        if self.rule == "a block triangle":
            return square and triangular(of) and parts == diagonal(of), ()
        u, v = self.within  # an exchange
        first, second = (Identity(x.shape[0]) for x in (u, v))
        pairs = ((of, first + u * v), (*parts, second + v * u))
        return square and len(parts) == 1, pairs

    def complaints(self) -> list[str]:
        """What is wrong with it."""
        applies, equations = self.wanted()
        proved = tuple((p.left, p.right) for p in self.proofs)
        if not applies or proved != equations:
            return [f"{self.rule} does not say what det({self.of}) is"]
        return [fault for proof in self.proofs for fault in proof.complaints()]

    def __str__(self):
        parts = [str(self.number)] * (self.number != 1)
        parts += [f"det({x})" + f"**{k}" * (k != 1) for x, k in self.powers]
        return f"det({self.of}) = {'*'.join(parts) or 1} [{self.rule}]"


def diagonal(matrix):
    """The blocks on the diagonal."""
    grid = matrix.blocks.tolist()
    return tuple(grid[i][i] for i in range(len(grid)))


def triangular(matrix):
    """Whether the blocks above or below the diagonal are all zero."""
    grid = matrix.blocks.tolist()
    k = range(len(grid))
    if any(len(row) != len(grid) for row in grid):
        return False
    rest = [
        [grid[i][j] for i in k for j in k if (i < j) == up and i != j] for up in (0, 1)
    ]
    return any(all(isinstance(x, sp.ZeroMatrix) for x in r) for r in rest)


@dataclass(frozen=True)
class Proof:
    """A claim with determinants that has been proved, and why it holds.

    Attributes
    ----------
    left, right : expression
        The two sides.
    steps : tuple of Step
        What its determinants are.
    numbers : Proof
        Of the same claim, the determinants that are left taken for numbers.
    """

    left: Formula
    right: Formula
    steps: tuple
    numbers: Any

    @property
    def proofs(self) -> tuple[Any, ...]:
        """The proofs on which it rests."""
        return (*(p for step in self.steps for p in step.proofs), self.numbers)

    @property
    def certificate(self) -> tuple[Any, ...]:
        """The terms of all equations on which it rests."""
        return tuple(t for p in self.proofs for t in p.certificate)

    @property
    def certificates(self) -> dict[str, tuple[Any, ...]]:
        """The same, in one."""
        return {"claim": self.certificate}

    @property
    def cited(self) -> tuple[str, ...]:
        """The names of the given relations that it uses."""
        names = [name for p in self.proofs for name in p.cited]
        return tuple(dict.fromkeys(names))

    def faults(self) -> list[str]:
        """What the independent checker has to say against one of its equations."""
        return [f for p in self.proofs for f in p.faults()]

    def complaints(self) -> list[str]:
        """What is wrong; [] if every step holds, and the claim between numbers."""
        found = [fault for step in self.steps for fault in step.complaints()]
        sides = [put_in(side, self.steps) for side in (self.left, self.right)]
        if sides != [self.numbers.left, self.numbers.right]:
            found.append("what was proved is another statement than its sides say")
        told = self.numbers.given, self.numbers.symmetric
        found += self.faults() or unfounded(*told)
        if not found and not possible(*told, (self.left, self.right)):
            found = ["no matrices were found that satisfy what is given"]
        return found

    def check(self) -> bool:
        """Whether nothing is wrong."""
        return not self.complaints()

    def __str__(self):
        return "\n".join([*map(str, self.steps), str(self.numbers)])


def attempted(left, right, given, symmetric):
    """As `proofs.attempted` has it, of a claim with determinants."""
    from .proofs import attempted as prove

    for x in left.atoms(sp.Determinant) | right.atoms(sp.Determinant):
        if not same_size(*x.arg.shape):
            raise ShapeError(f"{x.arg} is not square: it has no determinant")
    found = Finder((left, right), given, symmetric)
    sides = [found.numbers(side) for side in (left, right)]
    numbers, *rest = prove(*sides, given, symmetric)
    steps = tuple(found.steps.values())
    return (numbers and Proof(left, right, steps, numbers)), *rest


def put_in(expr, steps):
    """A side of a claim, what its determinants are put in as numbers."""
    expr, known = plain(expr), {step.of: step for step in steps}
    logs = {
        x: logarithm(*resolved(x.args[0].arg, known))
        for x in expr.atoms(sp.log)
        if isinstance(x.args[0], sp.Determinant)
    }
    expr = expr.xreplace(logs)
    values = {x: number(*resolved(x.arg, known)) for x in expr.atoms(sp.Determinant)}
    return sp.expand_log(expr.xreplace(values))


def resolved(matrix, known):
    """(number, {matrix: power}) of a determinant, all steps taken."""
    if matrix not in known:
        return sp.S.One, {matrix: 1}
    step, total = known[matrix], {}
    scale = step.number
    for x, k in step.powers:
        more, parts = resolved(x, known)
        scale *= more**k
        for y, d in parts.items():
            total[y] = total.get(y, 0) + k * d
    return scale, {y: d for y, d in total.items() if d}


def number(scale, powers):
    """The product; a determinant that is divided by is not zero."""
    known = [named(x, real=True) ** k for x, k in powers.items()]
    return sp.Mul(scale, *known)


def logarithm(scale, powers):
    """The logarithm of the modulus: that of the product, where it is written."""
    known = [k * named(x, "log ", real=True) for x, k in powers.items()]
    return sp.Add(sp.expand_log(sp.log(sp.Abs(scale))), *known)


def named(matrix, mark="", **told):
    return sp.Symbol(f"{mark}det({matrix})", **told)


class Finder:
    """What the determinants of a claim are, and by which steps."""

    def __init__(self, sides, given, symmetric):
        self.given, self.symmetric = given, symmetric
        self.algebra = Algebra(symmetric)
        self.steps, self.apart = {}, []  # by matrix; those known to differ
        inverses = {x for s in sides for x in plain(s).atoms(sp.Inverse)}
        inverted = inverses | {x.base for x in inverses}
        self.inverted = inverted | {x.T for x in inverted}
        self.means = {}
        for r in given:
            if isinstance(r.left, sp.MatrixSymbol) and r.left not in self.reached(r):
                self.means.setdefault(r.left, r.right)

    def numbers(self, side):
        for x in sorted(plain(side).atoms(sp.Determinant), key=str):
            self.take_apart(x.arg)
        return put_in(side, tuple(self.steps.values()))

    def reached(self, relation):
        """The letters of a right side, and of what they stand for."""
        waiting, found = [relation.right], set()
        while waiting:
            new = plain(waiting.pop()).atoms(sp.MatrixSymbol) - found
            found |= new
            waiting += [self.means[x] for x in new if x in self.means]
        return found

    def take_apart(self, matrix):
        """Find the step of a matrix, and of what it leads to."""
        if matrix in self.steps or matrix in self.apart:
            return
        step = self.split(matrix)
        if step is None and not self.as_known(matrix):
            self.apart.append(matrix)
        if step is not None:
            self.steps[matrix] = step
            for x in step.parts:
                self.take_apart(x)

    def step(self, *said, **more):
        """The step, if all equations between matrices that it needs are proved."""
        from .proofs import attempted as prove

        step = Step(*said, **more)
        applies, equations = step.wanted()
        told = self.given, self.symmetric
        proofs = tuple(prove(*pair, *told)[0] for pair in equations if applies)
        if not applies or None in proofs:
            return None
        return replace(step, proofs=proofs)

    def split(self, matrix):
        """What is seen from how a matrix is written."""
        if isinstance(matrix, sp.Identity):
            return self.step(matrix, "a product")
        if isinstance(matrix, sp.Transpose):
            return self.step(matrix, "a transpose", (matrix.arg,))
        if isinstance(matrix, sp.MatPow) and matrix.exp.is_Integer:
            return self.step(matrix, "a power", (matrix.base,))
        if isinstance(matrix, sp.BlockMatrix):
            return self.of_blocks(matrix)
        value = self.normal(matrix)
        if matrix in self.means:
            return self.step(matrix, "a product", (self.means[matrix],))
        if isinstance(matrix, sp.MatMul):
            return self.of_product(matrix, matrix.args)
        if value is None or isinstance(matrix, sp.MatrixSymbol):
            return None
        if len(value.terms) == 1:
            whole = written(value)
            factors = whole.args if isinstance(whole, sp.MatMul) else (whole,)
            return self.of_product(matrix, factors)
        return self.of_sum(matrix, value)

    def normal(self, matrix):
        """The polynomial that a matrix is, or None."""
        try:
            value = self.algebra.normal(matrix)
        except (TypeError, ValueError):
            return None
        return value if isinstance(value, Polynomial) else None

    def of_product(self, matrix, factors):
        """Square factors and a number in front."""
        scale = sp.Mul(*(x for x in factors if not isinstance(x, MatrixExpr)))
        size, parts, run = matrix.shape[0], [], []
        for x in (x for x in factors if isinstance(x, MatrixExpr)):
            run.append(x)
            if same_size(x.shape[1], size):
                parts.append(MatrixProduct(*run))
                run = []
        if parts == [matrix]:
            return None
        return self.step(matrix, "a product", tuple(parts), scale)

    def of_blocks(self, matrix):
        if triangular(matrix):
            return self.step(matrix, "a block triangle", diagonal(matrix))
        grid = matrix.blocks.tolist()
        if len(grid) != 2 or len(grid[0]) != 2:
            return None
        (A, B), (C, D) = grid
        over, under = ZeroMatrix(*B.shape), ZeroMatrix(*C.shape)
        if A in self.inverted:
            first = [[Identity(A.rows), over], [C * A.I, Identity(C.rows)]]
            second = [[A, B], [under, D - C * A.I * B]]
        elif D in self.inverted:
            first = [[Identity(B.rows), B * D.I], [under, Identity(D.rows)]]
            second = [[A - B * D.I * C, over], [C, D]]
        else:
            return None
        parts = BlockMatrix(first), BlockMatrix(second)
        return self.step(matrix, "a product", parts)

    def of_sum(self, matrix, value):
        """A sum: a term with an inverse in front, or a number."""
        rows = matrix.shape[0]
        for word, c in value.terms.items():
            front = term(word, c, rows)
            if len(word) == 1 and front in self.inverted:
                rest = value.like((w, d) for w, d in value.terms.items() if w != word)
                inside = self.algebra.normal(front.I) @ rest
                parts = front, MatrixSum(Identity(rows), written(inside))
                return self.step(matrix, "a product", parts)
        c = value.terms.get((), sp.S.Zero)
        if c != 1 and c.is_zero is False:
            share = value.like((w, sp.cancel(d / c)) for w, d in value.terms.items())
            return self.step(matrix, "a product", (written(share),), c)
        return None

    def as_known(self, matrix):
        """Whether it is the determinant of a matrix before, in another form."""
        for form, way in self.forms(matrix):
            for other in self.apart:
                if same_shape(form.shape, other.shape):
                    for path in self.ways(form, other):
                        for step in (*way, *path):
                            self.steps.setdefault(step.of, step)
                        return True
        return False

    def ways(self, form, other):
        """The steps from one form to an equal one, or to one that is transposed."""
        if form == other:
            return [()]
        straight = self.step(form, "a product", (other,))
        if straight:
            return [(straight,)]
        turned = self.step(form, "a product", (other.T,))
        return [(turned, Step(other.T, "a transpose", (other,)))] if turned else []

    def forms(self, matrix):
        """(Form, steps to it) of matrices with the same determinant."""
        yield matrix, ()
        start = self.normal(matrix)
        if start is None or start.terms.get(()) != 1:
            return
        waiting, seen = [(matrix, start, ())], [start]
        while waiting and len(seen) < MOST:
            form, value, way = waiting.pop(0)
            for u, v in exchanges(value):
                u, v = written(u), written(v)
                new = self.normal(Identity(v.shape[0]) + v * u)
                if any(alike(new, x) for x in seen):
                    continue
                seen.append(new)
                other = written(new)
                step = self.step(form, "an exchange", (other,), within=(u, v))
                if step:
                    waiting.append((other, new, (*way, step)))
                    yield other, (*way, step)


def alike(a, b):
    """Whether two polynomials are the same."""
    return same_shape(a.shape, b.shape) and (a - b).is_zero


def exchanges(value):
    """(U, V) with value = I + U V, for each way of cutting what its words share."""
    rest = [(w, c) for w, c in value.terms.items() if w]
    words, rows = [w for w, _ in rest], value.shape[0]
    before, behind = common(words), common([w[::-1] for w in words])
    algebra = value.algebra
    for k in range(1, before + 1):
        middle = columns_of(words[0][:k], rows)
        u = Polynomial(algebra, [(words[0][:k], 1)], (rows, middle))
        v = Polynomial(algebra, [(w[k:], c) for w, c in rest], (middle, rows))
        yield u, v
    for k in range(1, behind + 1):
        tail = words[0][len(words[0]) - k :]
        middle = tail[0].rows
        u = Polynomial(algebra, [(w[: len(w) - k], c) for w, c in rest], (rows, middle))
        yield u, Polynomial(algebra, [(tail, 1)], (middle, rows))
