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


def output_of_4():
    """w - k x = (P T - k)[x; eps], where the row has a second block, P."""
    error = FREE.normal(P * (T * x + eps) - k * x)
    row = P * T - k
    return error - FREE.normal(row * x), error - FREE.normal(row * x + P * eps)


def stability_of_6():
    """Re[lambda < 0] compares a complex number, as lambda = -1 + j is, with zero."""
    eigenvalue = -1 + sp.I
    try:
        printed = sp.Integer(0 if eigenvalue < 0 else 1)
    except TypeError:  # SymPy: invalid comparison of a number that is not real
        printed = sp.Integer(1)
    return printed, sp.Max(sp.re(eigenvalue), 0)


def left_side_of_7():
    """z - T x -> 0 does not give k = P T; together with it, it gives w - k x -> 0."""
    tracked, state = sp.Matrix([[1, -1]]), sp.Matrix(sp.symbols("x_1 x_2"))
    w = 2 * tracked * state  # z = T x, P = 2
    return w - sp.Matrix([[1, 0]]) * state, w - sp.Matrix([[2, -2]]) * state


def shared_eigenvalue_in_7():
    """x+ = -x + u copied by z+ = -z + u, w = z: T = 2 solves (5) too, as b = 0.

    w tends to x, though d = 1 is not T'g = 2.  One T satisfies (5), (6) and (7), but
    if A and F share an eigenvalue it is not any solution of (5).
    """
    pole, g, d = -1, 1, sp.Integer(1)
    for tracked in (1, 2):
        assert tracked * pole - pole * tracked == 0  # (5)
    return d - 2 * g, d - 1 * g


def equation_before_8():
    """(6) now has the form (8), (9): it is (5) that has, and (6) leaves d to choose."""
    A, C, alpha = observable_form(2)
    F, t = pair(1)
    columns = krylov(F, t, 3)
    T, D = columns[:, :2], -columns * sp.Matrix([*alpha, 1])
    d, g = sp.Matrix([sp.Symbol("d")]), sp.Matrix(sp.symbols("g_1 g_2"))
    return d - T * g, (T * A - F * T - D * C).expand()


def rows_of_11():
    """As scanned every row ends in the same column; each must end one further on."""
    F, t = pair(2)
    b0, b1, b2 = characteristic(F)
    scanned = sp.Matrix([[b0, b1, b2, 0], [0, b0, b2, 0]])
    page_T = krylov(F, t, 4).T
    return (
        (scanned * page_T).expand(),
        (S([b0, b1, b2], 4) * page_T).expand(),
    )


def product_after_12():
    """S_p T' = 0: S_p is (n - p) x n and the page's T' is p x n; it is S_p T."""
    F, t = pair(2)
    page_T, shift = krylov(F, t, 5).T, S(characteristic(F), 5)
    return sp.Integer(shift.cols - page_T.T.rows), (shift * page_T).expand()


def stability_after_13():
    """Stability condition (8): (8) holds for the unstable F = 1 as well."""
    A, C, alpha = observable_form(2)
    F, t = sp.Matrix([[1]]), sp.Matrix([[1]])
    columns = krylov(F, t, 3)
    T, D = columns[:, :2], -columns * sp.Matrix([*alpha, 1])
    assert T * A - F * T - D * C == sp.zeros(1, 2)
    return sp.Max(F[0], 0), sp.Max(-F[0], 0)  # F = -1 is what (6) and (7) ask


def output_in_remark():
    """k = h is ruled out by beta > 0: it is ruled out by beta_p = 1, any signs."""
    beta = [*sp.symbols("beta_:2"), sp.S.One]
    unit = sp.Matrix([0, 0, 0, 1])
    return not_positive(beta), (S(beta, 4) * unit)[-1] - 1


def discrete_remark():
    """beta > 0 for stability: not in discrete time, where the remark fails."""
    beta, kappa = [-sp.Rational(1, 2), 1], sp.Matrix([1, sp.Rational(1, 2)])
    assert not_positive(kappa) == 0
    return not_positive(beta), S(beta, 2) * kappa


def entries():
    """{place and what is printed: (printed residual, correct residual)}."""
    return {
        "(4) w - k'x = (l'T' - k')[x; z - T'x] has lost the block l'": output_of_4(),
        "(6),(7) Re[lambda_i(A) < 0] for Re[lambda_i(A)] < 0": stability_of_6(),
        "(7) lim |z - T'x| = 0 on the left for lim |w - k'x| = 0": left_side_of_7(),
        "(7) d = T'g for every T of (5): only without a shared eigenvalue": (
            shared_eigenvalue_in_7()
        ),
        "before (8): (6) for (5)": equation_before_8(),
        "(11) the rows must be shifted against each other": rows_of_11(),
        "after (12): S_p T' = 0 for S_p T = 0": product_after_12(),
        "after (13): stability condition (8) for (6), (7)": stability_after_13(),
        "remark: k = h is ruled out without beta > 0": output_in_remark(),
        "remark: beta > 0, and with it the remark, is for continuous time": (
            discrete_remark()
        ),
    }
