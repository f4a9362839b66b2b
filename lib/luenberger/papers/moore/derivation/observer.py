"""Moore's observer of a functional k x without feedthrough: the case V = 0.

For the plant x+ = A x + B u, y = C x + E u an observer z+ = F z + G u + D y with
w^ = P z tracks k x exactly when T A - F T = D C, G = T B - D E, P T = k (x+ is the
next state or the derivative).  In companion coordinates T is built row by row from
k; what is left is a condition on beta, the characteristic polynomial of F: k beta(A)
is a combination of the rows of C, CA, ..., CA^(r-1), in any coordinates.

    letter of the paper   F  g  h'  k'  A  b  d  l'  T'  p
    letter here           A  B  C   k   F  D  G  P   T   r

Sizes are symbols except where a step's name gives r or a power.  The condition is
proved in `condition`, in Moore's own form in `recurrence`.

Source: Moore (1973), (1)-(7), (10), (13); the rest is our own.
"""

from dataclasses import replace
from functools import cache

import sympy as sp

from ....certificate import residuals
from ....symbolic import (
    Algebra,
    BlockMatrix,
    Claim,
    Derivation,
    Identity,
    MatrixSymbol,
    Solve,
    Stage,
    ZeroMatrix,
    claims,
)
from . import condition as condition
from .condition import FREE, SOLVED, A, B, C, D, E, F, G, P, T, column, k, m, n, p, q, r

V, W = ZeroMatrix(q, p), ZeroMatrix(q, m)
x, z, u, eps = (
    MatrixSymbol(name, size, 1)
    for name, size in (("x", n), ("z", r), ("u", m), ("varepsilon", r))
)
MET = SOLVED.with_relations((G, T * B - D * E), (P * T, k))  # (6), (7)
PAPER = "Moore (1973)"

# -- stage lists --------------------------------------------------------------------


@cache
def companion_row():
    """One row of T from the row above it, for (F, P) in observer companion form.

    t_1 = k; then t_next of row i with b = beta_(r-i) and d = D_i is row i + 1, and
    the row that would follow the last, r + 1, must come out as zero.
    """
    t, t_next, row = (MatrixSymbol(s, 1, n) for s in ("t", "t_next", "k"))
    b, d = MatrixSymbol("b", 1, 1), MatrixSymbol("d", 1, p)
    stages = (Stage(t_next, t * A + b * row - d * C, "(5)"),)
    found = Derivation((t, A, b, row, d, C), stages, source=PAPER)
    return replace(found, steps=condition.row_steps(found))


@cache
def observer():
    """G of (6), given T and D."""
    stages = (Stage(G, T * B - D * E, "(6)"),)
    found = Derivation((T, B, D, E), stages, source=PAPER)
    return replace(found, steps=prove_observer(found))


def prove_observer(found):
    """The error is not driven by the input."""
    gain = found.unfolded()["G"]
    _, input_, _, _ = residuals(A, B, C, E, k, F, gain, D, P, V, W, T, T)
    y = C * x + E * u
    error = F * (T * x + eps) + gain * u + D * y - T * (A * x + B * u)
    return claims(FREE, {"(6) input residual T B - G - D E = 0": (input_, 0)}) | claims(
        SOLVED, {"(6) with this G eps_+ = F eps": (error, F * eps)}
    )


# -- (3)-(7) ------------------------------------------------------------------------


def bracket():
    """The four residuals with V = 0 and W = 0: (5), (6), (7), and one that is zero."""
    return residuals(A, B, C, E, k, F, G, D, P, V, W, T, T)


def error_steps():
    """(4)-(7): what drives the error, and that nothing does when (5)-(7) hold."""
    dynamics, input_, output, feedthrough = bracket()
    error = F * (T * x + eps) + G * u + D * (C * x + E * u) - T * (A * x + B * u)
    estimate = P * (T * x + eps) - k * x
    return claims(
        FREE,
        {
            "(4) eps_+ = F eps - residual(5) x - residual(6) u": (
                error,
                F * eps - dynamics * x - input_ * u,
            ),
            "(4) w^ - k x = P eps + residual(7) x": (estimate, P * eps + output * x),
        },
    ) | claims(
        MET,
        {
            "(5) T A - F T - D C = 0 is the first of the four residuals": (dynamics, 0),
            "(6) T B - G - D E = 0 is the second": (input_, 0),
            "(7) P T - k = 0 is the third, with V = 0": (output, 0),
            "(3) W = 0 with V = 0: the fourth vanishes for every E": (feedthrough, 0),
            "(6) sufficient: eps_+ = F eps": (error, F * eps),
            "(7) sufficient: w^ - k x = P eps": (estimate, P * eps),
        },
    )


def composite():
    """State matrix, input matrix and output row of x and z together."""
    state = BlockMatrix([[A, ZeroMatrix(n, r)], [D * C, F]])
    return state, column([B, G + D * E]), BlockMatrix([[-k, P]])


def composite_steps():
    """(4) in the page's arrangement, and the error after some steps, all under (5)."""
    state, drive, seen = composite()
    turn = BlockMatrix([[Identity(n), ZeroMatrix(n, r)], [-T, Identity(r)]])
    back = BlockMatrix([[Identity(n), ZeroMatrix(n, r)], [T, Identity(r)]])
    parted = BlockMatrix([[A, ZeroMatrix(n, r)], [ZeroMatrix(r, n), F]])
    gap = G + D * E - T * B
    steps = {
        "(4) in x and eps the composite system is diag(A, F)": (
            turn * state * back,
            parted,
        ),
        "(4) driven by [B; G + D E - T B] u": (turn * drive, column([B, gap])),
        "(4) with w^ - k x = [P T - k, P][x; eps]": (
            seen * back,
            BlockMatrix([[P * T - k, P]]),
        ),
    }
    now, z_now, eps_now = x, T * x + eps, eps
    for j in range(1, 5):
        u_j = MatrixSymbol(f"u_{j - 1}", m, 1)
        z_now = F * z_now + G * u_j + D * (C * now + E * u_j)
        now, eps_now = A * now + B * u_j, F * eps_now + gap * u_j
        steps[
            f"(7) after {j} steps w^ - k x = P (F^{j} eps + sum F^i (G + D E - T B) u) "
            "+ (P T - k) x"
        ] = (P * z_now - k * now, P * eps_now + (P * T - k) * now)
    return claims(SOLVED, steps)


def necessity_steps():
    """If w^ - k x -> 0 for all x(0), z(0), u, then some T satisfies (5), (6), (7).

    Let (A, B) be controllable and (F, P) observable.  From rest the error must be
    zero for every u, since u may go on for ever.  Let R be the set of [x; z] that u
    reaches from rest: invariant, and inside the null space of [-k, P].  It has every
    x, as (A, B) is controllable, and no [0; z] but zero, which (F, P) would not see.
    So it is a graph z = T x; that a graph is invariant, holds the columns of the
    input and is sent to zero is (5), (6), (7).  There is only one such T.
    """
    state, drive, seen = composite()
    graph = column([Identity(n), T])
    dynamics, input_, output, _ = bracket()
    Delta = MatrixSymbol("Delta", r, n)
    both = Algebra([], [(F * Delta, Delta * A), (P * Delta, ZeroMatrix(q, n))])
    return claims(
        FREE,
        {
            "(5) necessary: the graph z = T x is invariant exactly if (5) holds": (
                state * graph - graph * A,
                column([ZeroMatrix(n, n), -dynamics]),
            ),
            "(6) necessary: the input drives along it exactly if (6) holds": (
                drive - graph * B,
                column([ZeroMatrix(n, m), -input_]),
            ),
            "(7) necessary: the error vanishes on it exactly if (7) holds": (
                seen * graph,
                output,
            ),
        },
    ) | claims(
        both,
        {
            f"(7) the difference Delta of two such T is unseen: P F^{j} Delta = 0": (
                P * F**j * Delta,
                0,
            )
            for j in range(5)
        },
    )


# -- l = (T'T)^-1 T'k ---------------------------------------------------------------


def output_steps():
    """P = k T' (T T')^-1 of the construction: the answer if k = P T has one.

    T has full row rank, so that T T', named M here, has an inverse.  Otherwise the
    formula returns least squares, which is no observer: see `least_squares`.
    """
    M, P0 = MatrixSymbol("M", r, r), MatrixSymbol("P_0", q, r)
    named = Algebra([M], [(T * T.T, M)])
    P_of = lambda row: row * T.T * M.I  # noqa: E731
    onto = T.T * M.I * T
    return claims(
        named,
        {
            "(10) k = P_0 T: k T'(T T')^-1 = P_0, the only P": (P_of(P0 * T), P0),
            "(10) Pi = T'(T T')^-1 T is a projector: Pi Pi = Pi": (onto * onto, onto),
            "(10) symmetric: Pi' = Pi": (onto.T, onto),
            "(10) onto the rows of T: T Pi = T": (T * onto, T),
            "(10) P T - k = -k (I - Pi), zero exactly if k is a combination of rows": (
                P_of(k) * T - k,
                -k * (Identity(n) - onto),
            ),
            "(10) else least squares: (P T - k) T' = 0": (
                (P_of(k) * T - k) * T.T,
                ZeroMatrix(q, r),
            ),
        },
    )


def least_squares():
    """A cart's velocity from its position with one state: there is no such observer.

    In the paper's coordinates x = (velocity, position), f = -1 and t_1 = 1 give
    T = [1, -1]; the formula answers P = 1/2, and the error is driven by the state.
    """
    plant_A, plant_C = sp.Matrix([[0, 0], [1, 0]]), sp.Matrix([[0, 1]])
    tracked, wanted, pole = sp.Matrix([[1, -1]]), sp.Matrix([[1, 0]]), sp.Integer(-1)
    gain = (wanted * tracked.T * (tracked * tracked.T).inv())[0]
    velocity, position = sp.symbols("velocity position")
    state = sp.Matrix([velocity, position])
    return {
        "(10) a cart, r = 1: T A - F T = D C with D = -1": Claim(
            tracked * plant_A - pole * tracked, -plant_C
        ),
        "(10) a cart, r = 1: (T'T)^-1 T'k = 1/2": Claim(gain, sp.Rational(1, 2)),
        "(10) a cart, r = 1: the error tends to -(velocity + position)/2": Claim(
            (gain * tracked * state - wanted * state)[0], -(velocity + position) / 2
        ),
    }


def formulas():
    dynamics, input_, output, _ = bracket()
    return {
        "(1) x_+": A * x + B * u,
        "(1) y": C * x + E * u,
        "(3) z_+": F * z + G * u + D * MatrixSymbol("y", p, 1),
        "(3) w^": P * z,
        "(4) eps_+": F * eps - dynamics * x - input_ * u,
        "(4) w^ - k x": P * eps + output * x,
        "(5) residual": dynamics,
        "(6) residual": input_,
        "(6) G": observer().unfolded()["G"],
        "(7) residual": output,
        "(10) P": Solve(k * T.T, T * T.T).as_inverse(),
        "companion row": companion_row().unfolded()["t_next"],
    }


@cache
def derive():
    return Derivation(
        given=(A, B, C, E, k),
        formulas=formulas(),
        steps=error_steps()
        | composite_steps()
        | necessity_steps()
        | companion_row().steps
        | observer().steps
        | condition.steps()
        | output_steps()
        | least_squares(),
        source=f"{PAPER}, (1)-(7), (10), (13)",
    )
