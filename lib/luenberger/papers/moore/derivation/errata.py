"""What Moore's page prints and what holds, each entry tried.

`entries()` gives for every place the printed claim as a residual that does not
vanish, and the correct one as a residual that does.  A product that cannot be formed
is shown by the difference of its inner sizes.  The letters are those of
`letters`; what the page calls T' is T there.

Source: Moore (1973), as scanned; what a shared eigenvalue does to (7), and the
limits of the remark on signs, are our own findings.
"""

import sympy as sp

from matrixproof.algebra import Algebra

from .letters import P, T, eps, k, x
from .recurrence import characteristic, krylov, observable_form
from .recurrence import observer_pair as pair
from .recurrence import recurrence_rows as S

FREE = Algebra()


def not_positive(entries):
    """How many entries are not positive for sure."""
    return sp.Integer(sum(not sp.sympify(entry).is_positive for entry in entries))


def is_not_compared(value):
    """1 where SymPy refuses to compare a number that is not real with zero."""
    try:
        return sp.Integer(0 if value < 0 else 1)
    except TypeError:
        return sp.Integer(1)


def of_order_one(F, t):
    """T A - F T - D C and T for a plant of two states in the form (8), (9)."""
    A, C, alpha = observable_form(2)
    columns = krylov(F, t, 3)
    T, D = columns[:, :2], -columns * sp.Matrix([*alpha, 1])
    return (T * A - F * T - D * C).expand(), T


def entries():
    """{place and what is printed: (printed residual, correct residual)}."""
    error, row = FREE.normal(P * (T * x + eps) - k * x), P * T - k
    eigenvalue = -1 + sp.I
    tracked, state = sp.Matrix([[1, -1]]), sp.Matrix(sp.symbols("x_1 x_2"))
    w = 2 * tracked * state  # z = T x, P = 2
    of_8, T_8 = of_order_one(*pair(1))
    d, g = sp.Matrix([sp.Symbol("d")]), sp.Matrix(sp.symbols("g_1 g_2"))
    F, t = pair(2)
    b0, b1, b2 = characteristic(F)
    scanned = sp.Matrix([[b0, b1, b2, 0], [0, b0, b2, 0]])
    four, five, shift = krylov(F, t, 4).T, krylov(F, t, 5).T, S([b0, b1, b2], 5)
    one = sp.Matrix([[1]])
    assert of_order_one(one, one)[0] == sp.zeros(1, 2)  # (8) holds for F = 1
    beta, unit = [*sp.symbols("beta_:2"), sp.S.One], sp.Matrix([0, 0, 0, 1])
    discrete, kappa = [-sp.Rational(1, 2), 1], sp.Matrix([1, sp.Rational(1, 2)])
    assert not_positive(kappa) == 0
    return {
        "(4) w - k'x = (l'T' - k')[x; z - T'x] has lost the block l'": (
            error - FREE.normal(row * x),
            error - FREE.normal(row * x + P * eps),
        ),
        "(6),(7) Re[lambda_i(A) < 0] for Re[lambda_i(A)] < 0": (
            is_not_compared(eigenvalue),
            sp.Max(sp.re(eigenvalue), 0),
        ),
        # z - T x -> 0 does not give k = P T; with it, it gives w - k x -> 0
        "(7) lim |z - T'x| = 0 on the left for lim |w - k'x| = 0": (
            w - sp.Matrix([[1, 0]]) * state,
            w - sp.Matrix([[2, -2]]) * state,
        ),
        # x+ = -x + u copied by z+ = -z + u, w = z: T = 2 solves (5) too, as b = 0.
        # w tends to x, though d = 1 is not T g = 2.
        "(7) d = T'g for every T of (5): only without a shared eigenvalue": (
            sp.Integer(1) - 2,
            sp.Integer(1) - 1,
        ),
        "before (8): (6) for (5)": (d - T_8 * g, of_8),  # (6) leaves d to choose
        # as scanned every row ends in the same column; each must end one further on
        "(11) the rows must be shifted against each other": (
            (scanned * four).expand(),
            (S([b0, b1, b2], 4) * four).expand(),
        ),
        # S_p is (n - p) x n and the page's T' is p x n
        "after (12): S_p T' = 0 for S_p T = 0": (
            sp.Integer(shift.cols - five.T.rows),
            (shift * five).expand(),
        ),
        # F = -1 is what (6) and (7) ask
        "after (13): stability condition (8) for (6), (7)": (
            sp.Max(sp.S.One, 0),
            sp.Max(-sp.S.One, 0),
        ),
        # it is ruled out by beta_p = 1, whatever the signs are
        "remark: k = h is ruled out without beta > 0": (
            not_positive(beta),
            (S(beta, 4) * unit)[-1] - 1,
        ),
        "remark: beta > 0, and with it the remark, is for continuous time": (
            not_positive(discrete),
            S(discrete, 2) * kappa,
        ),
    }
