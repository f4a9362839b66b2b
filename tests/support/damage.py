"""A claim with one thing wrong in it: a sign, a factor or a transpose."""

import dataclasses
from itertools import islice

import sympy as sp
from sympy import MatAdd
from worlds import damages, expr

from matrixproof import Chain, Derivation, Explicit, Line, MatrixSymbol
from matrixproof.explicit import Counterexample
from matrixproof.instances import Step
from matrixproof.lines import Equation
from matrixproof.relations import Result

SIGNS = 4  # terms, or entries of an explicit matrix, whose sign is tried


def broken(claim):
    """(what, the claim with its left side damaged), one at a time, signs first."""
    if hasattr(claim, "check"):
        yield from broken_step(claim)
        return
    left = claim.left
    if claim.algebra is not None:
        sides = [*damages(expr(left)), ("twice the whole", 2 * expr(left))]
        zero = zero_terms(claim)
        sides = [(what, side) for what, side in sides if what not in zero]
    elif isinstance(left, sp.MatrixBase):
        sides = damaged_entries(left)
    else:
        sides = damaged_scalar(sp.sympify(left))
    for what, side in sides:
        yield what, dataclasses.replace(claim, left=side)


def broken_step(step):
    """A chain with one line damaged, a construction or an example with other values."""
    if isinstance(step, Chain):
        for k, line in enumerate(step.lines):
            for what, right in damaged_sides(line.right):
                lines = list(step.lines)
                lines[k] = dataclasses.replace(line, right=right)
                damaged = dataclasses.replace(step, lines=lines)
                yield f"sign in line {k + 1}, {what}", damaged
        return
    if isinstance(step, Explicit):
        for what, right in damaged_sides(step.right):
            yield f"sign of {what}", dataclasses.replace(step, right=right)
        return
    if isinstance(step, Counterexample):  # the same matrices may deny other claims
        yield "sign: nothing is denied", dataclasses.replace(step, right=step.left)
        for k, given in enumerate(step.given):
            for _, right in damaged_sides(given.right):
                found = list(step.given)
                found[k] = dataclasses.replace(given, right=right)
                yield f"sign in {given.name}", dataclasses.replace(step, given=found)
        return
    for symbol, value in step.values.items():
        damaged = step.values | {symbol: 2 * value}
        yield f"sign of {symbol}", dataclasses.replace(step, values=damaged)


def damaged_sides(right):
    """A line's right side with the sign of a term turned, or doubled if it is zero."""
    if isinstance(right, Equation):
        zero = isinstance(right.right, sp.ZeroMatrix)  # twice nothing is nothing
        part = "right" if zero else "left"
        for what, side in damaged_sides(getattr(right, part)):
            yield what, dataclasses.replace(right, **{part: side})
    elif isinstance(right, sp.ZeroMatrix):
        yield "one for zero", ones_of(right)
    elif right == 0:
        yield "one for zero", sp.S.One
    elif isinstance(right, (sp.Add, MatAdd)):
        for what, wrong in damages(right):
            if what.startswith("sign"):
                yield what, wrong
    else:
        yield "the whole", 2 * right


def ones_of(zero):
    return MatrixSymbol("wrong", *zero.shape)


def zero_terms(claim):
    """Terms that vanish: a wrong sign of theirs changes nothing."""
    left = expr(claim.left)
    terms = left.args if isinstance(left, (sp.Add, MatAdd)) else ()
    return {f"sign of {t}" for t in terms if claim.algebra.normal(t).is_zero}


def damaged_entries(matrix):
    """An explicit matrix with one entry negated, transposed, or all doubled."""
    rows, cols = matrix.shape
    places = [(i, j) for i in range(rows) for j in range(cols) if matrix[i, j] != 0]
    for i, j in places[:: 1 + len(places) // SIGNS]:
        wrong = matrix.as_mutable()
        wrong[i, j] = -wrong[i, j]
        yield f"sign of entry {i}, {j}", wrong
    if rows == cols and matrix != matrix.T:
        yield "transposed the whole", matrix.T
    yield "twice the whole", 2 * matrix


def damaged_scalar(value):
    """A scalar with one of its terms negated, or doubled."""
    for term in sp.Add.make_args(value):
        yield f"sign of {term}", value - 2 * term
    yield "twice the whole", 2 * value


def fails(item, sound=None):
    """Whether something damaged is refused.

    Lines and stages that it shares with what is `sound` are not asked again.
    """
    try:
        if isinstance(item, Chain):
            known = steps_of(sound) if sound else ()
            changed = (step for step in steps_of(item) if step not in known)
            return any(line_fails(*step, item.symmetric) for step in changed)
        if isinstance(item, Derivation):
            symmetric = getattr(item.letters, "symmetric", ())
            changed = (x for x in item.stages if not sound or x not in sound.stages)
            return any(line_fails(x.target, x.line, symmetric) for x in changed)
        return bool(item.check())
    except (ValueError, TypeError, AssertionError):  # ShapeError, ours or SymPy's
        return True


def steps_of(chain):
    """(what stands before, the line) of every line of a chain."""
    return list(zip((chain.left, *(line.right for line in chain.lines)), chain.lines))


def line_fails(left, line, symmetric):
    """Whether a line has complaints; most that are damaged are refuted by numbers."""
    steps = (r.chain for r in line.cites if isinstance(r, Result))
    if any(isinstance(chain, Step) and fails(chain) for chain in steps):
        return True  # of a theorem in other letters
    if type(line) is Line and not line.follows(left, line.by, symmetric):
        return True
    return bool(line.complaints(left, symmetric))


def survives(claim):
    """Whether a claim is proved; what cannot be multiplied is not."""
    try:
        return claim.is_zero if claim.algebra else unrefuted(claim) and claim.is_zero
    except (ValueError, TypeError):  # ShapeError, ours or SymPy's
        return False


def unrefuted(claim):
    """Whether the two sides agree at some numbers: quicker than simplifying them."""
    residual = sp.Matrix([claim.residual])
    some = sorted(residual.free_symbols, key=str)
    values = {s: sp.Rational(k + 2, k + 5) for k, s in enumerate(some)}
    return all(abs(sp.N(entry)) < 1e-9 for entry in residual.xreplace(values))


def unnoticed(claim):
    """Damage that the proof lets pass: any wrong sign, or everything that was tried.

    A transpose or a factor need not matter by itself, as where a symbol stands on both
    sides of a definite matrix; of each kind one must be noticed unless a sign was.
    """
    found = list(broken(claim))
    if hasattr(claim, "check"):
        passed = [what for what, wrong in found if not fails(wrong, claim)]
        return passed if found else ["nothing was tried"]
    signs = [pair for pair in found if pair[0].startswith("sign")]
    passed = [what for what, wrong in signs[:SIGNS] if survives(wrong)]
    others = (wrong for what, wrong in found if not what.startswith("sign"))
    noticed = next(islice((1 for w in others if not survives(w)), 1), 0)
    return passed or ([] if noticed else ["a factor or a transpose"])
