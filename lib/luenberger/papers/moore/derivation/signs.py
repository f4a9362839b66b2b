"""Moore's remark: no observer of order r < n when k has all entries of one sign.

In the coordinates of (1), (2), that is for kappa_i = k A^i g in any, and in
continuous time: a stable beta has only positive coefficients, and then S_r kappa = 0
would make a sum of terms of one sign vanish.  Some entries of kappa may even be
zero.  The paper's example k = C needs no signs at all, and in discrete time, where
beta may have negative coefficients, the remark is false.

The claims are proved for concrete n and r.

Source: Moore (1973), the remark after (13); weak signs, k = C without signs and
discrete time are our own.
"""

from functools import cache
from itertools import product

import sympy as sp

from ....symbolic import Claim, Derivation
from .recurrence import SIZES, S, observable_form


def not_positive(entries):
    """How many entries are not positive for sure."""
    return sp.Integer(sum(not sp.sympify(entry).is_positive for entry in entries))


def hurwitz_steps():
    """Every root in Re s < 0: products of s + a and s^2 + 2 c s + d."""
    s, steps = sp.Symbol("s"), {}
    for real, pairs in product(range(6), range(3)):
        if not 1 <= real + 2 * pairs <= 5:
            continue
        a, c = (sp.symbols(f"{x}_:3", positive=True) for x in "cd")
        roots = sp.symbols("a_:5", positive=True)
        factors = [s + x for x in roots[:real]]
        factors += [s**2 + 2 * x * s + y for x, y in zip(a[:pairs], c)]
        coefficients = sp.Poly(sp.Mul(*factors), s).all_coeffs()
        steps[
            f"remark: a stable beta is positive, {real} real roots, {pairs} pairs"
        ] = Claim(not_positive(coefficients))
    return steps


def sign_steps(size, order):
    """No kappa of one sign obeys a recurrence with a positive beta.

    The sum of the rows of S_r kappa is c'kappa with every c_i positive, so that it
    vanishes for no kappa >= 0 but zero; some entries of kappa may be zero.
    """
    beta = [*sp.symbols(f"beta_:{order}", positive=True), sp.S.One]
    total = sp.ones(1, size - order) * S(beta, size)
    return {
        "remark: the rows of S_r add up to a positive row, "
        f"n = {size}, r = {order}": Claim(not_positive(total))
    }


def output_step(size, order):
    """k = C, which needs no sign: the last row of S_r kappa is beta_r."""
    beta = [*sp.symbols(f"beta_:{order}"), 1]
    _, C, _ = observable_form(size)
    unit = sp.Matrix(size - order, 1, lambda i, _: int(i == size - order - 1))
    return {
        "remark: k = C gives S_r kappa = [0 .. 0 1]' for every beta, "
        f"n = {size}, r = {order}": Claim(S(beta, size) * C.T, unit)
    }


def discrete_steps():
    """In discrete time one sign is no obstacle: the pole 1/2 and kappa = 1, 1/2."""
    half = sp.Rational(1, 2)
    shift, kappa = S([-half, 1], 2), sp.Matrix([1, half])
    A, C, alpha = observable_form(2)
    F, T = sp.Matrix([[half]]), sp.Matrix([[1, half]])
    D = -sp.Matrix([[half**2 + alpha[1] * half + alpha[0]]])
    return {
        "remark: false in discrete time, S_1 kappa = 0 with kappa = 1, 1/2": Claim(
            shift * kappa
        ),
        "remark: its observer z+ = z/2 + D y, w^ = z, T = kappa'": Claim(
            (T * A - F * T - D * C).expand()
        ),
    }


@cache
def derive():
    steps = hurwitz_steps() | discrete_steps()
    for size, order in SIZES:
        steps |= sign_steps(size, order) | output_step(size, order)
    return Derivation(steps=steps, source="Moore (1973), the remark after (13)")
