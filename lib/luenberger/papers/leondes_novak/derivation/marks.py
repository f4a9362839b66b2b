"""The outputs that arrived, marked by ones on a diagonal, as a device sees them.

The matrices of what arrived then follow from the plant's by stages, and no size depends
on the data.

Source: our own; the push is that of Leondes and Novak (1974), (47).
"""

from functools import cache

from ....symbolic import Derivation, Line, Solve, Stage
from .best_coordinates import is_Gamma
from .correlated_noise import is_As
from .letters import *
from .places import (
    C_seen,
    E_seen,
    J_seen,
    Missing,
    Pick,
    R_seen,
    is_C,
    is_E,
    is_J,
    is_Missing,
    is_R,
    pa,
    picks,
    rest,
)
from .places import letters as placed

letters = placed.here()
chain, define = letters.chain, letters.define
C_all = letters("C_all", p, n, "what is measured if all arrives")
E_all = letters("E_all", p, m, "what the input does to all outputs")
R_all = letters("R_all", p, p, "noise of all outputs", symmetric=True)
S_all = letters("S_all", n, p, "covariance of the two noises, for all outputs")
S_seen = letters("S_seen", n, pa, "the same for what arrived")
Q_all = letters("Q_all", n, n, "covariance of the process noise", symmetric=True)
Inverse = letters("Inverse", n, n, "inverse weight of the error", symmetric=True)
Seen = letters("Seen", p, p, "diagonal: ones for the outputs that arrived")
Taken = letters("Taken", p, p, "diagonal: ones for the accurate ones of these")
Untaken = letters("Untaken", p, p, "diagonal: ones for all the others")
Lifted = letters("Lifted", n, p, "the push, before it is scaled")
Spread = letters("Spread", p, p, "what scales it", symmetric=True)

MARKED = (
    """`Seen` has ones on its diagonal for the outputs that arrived, and zeros
    elsewhere; `Taken` marks the accurate ones among them. `Pick` and `S_1` hold the
    rows of the identity that belong to these.""",
    is_Seen := define(Seen, Pick.T * Pick),
    is_Taken := define(Taken, S1.T * S1),
    picks,
    is_C_seen := define(C_seen, Pick * C_all),
    is_E_seen := define(E_seen, Pick * E_all),
    is_R_seen := define(R_seen, Pick * R_all * Pick.T),
    """What arrived keeps its place as in a step over a record. Products with the marks
    give the same matrices.""",
    is_C,
    is_E,
    is_R,
    marked_C := chain(
        "",
        "what is measured, by marks",
        C,
        Line(Pick.T * C_seen, by=(is_C,)),
        Line(Pick.T * Pick * C_all, by=(is_C_seen,)),
        Line(Seen * C_all, by=(is_Seen,)),
    ),
    marked_E := chain(
        "",
        "what the input does to the measurement, by marks",
        E,
        Line(Pick.T * E_seen, by=(is_E,)),
        Line(Pick.T * Pick * E_all, by=(is_E_seen,)),
        Line(Seen * E_all, by=(is_Seen,)),
    ),
    marked_R := chain(
        "",
        "the noise, by marks",
        R,
        Line(Pick.T * R_seen * Pick + rest, by=(is_R,)),
        Line(Pick.T * Pick * R_all * Pick.T * Pick + rest, by=(is_R_seen,)),
        Line(Seen * R_all * Seen + Identity(p) - Seen, by=(is_Seen,)),
    ),
    """What did not arrive has noise of its own, of variance one, that is put together
    first.""",
    is_Missing,
    chain(
        "",
        "the noise of what did not arrive",
        (Identity(p) - Seen) * R,
        Line(rest * (Pick.T * R_seen * Pick + rest), by=(is_Seen, is_R)),
        Line(rest, by=(picks,)),
        Line(Identity(p) - Seen, by=(is_Seen,)),
    ),
    """With correlated noises, what arrived tells of the process noise what it would
    tell in the shorter problem.""",
    is_S_seen := define(S_seen, S_all * Pick.T),
    told_seen := define(J_seen * R_seen, S_seen),
    is_S := define(S, S_seen * Pick),
    is_J,
    marked_S := chain(
        "",
        "the covariance of the two noises, by marks",
        S,
        Line(S_seen * Pick, by=(is_S,)),
        Line(S_all * Pick.T * Pick, by=(is_S_seen,)),
        Line(S_all * Seen, by=(is_Seen,)),
    ),
    marked_J := chain(
        "",
        "what arrived tells of the process noise",
        J * R,
        Line(J_seen * Pick * (Pick.T * R_seen * Pick + rest), by=(is_J, is_R)),
        Line(J_seen * R_seen * Pick, by=(picks,)),
        Line(S_seen * Pick, by=(told_seen,)),
        Line(S, by=(is_S,)),
    ),
    is_As,
    chain(
        "",
        "what moves the state once that is told",
        As,
        Line(A - J * C, by=(is_As,)),
        Line(A - J_seen * Pick * Pick.T * C_seen, by=(is_J, is_C)),
        Line(A - J_seen * C_seen, by=(picks,)),
    ),
    is_Q := define(Q, Q_all - J * S.T),
    chain(
        "",
        "the process noise that is left once that is told",
        Q,
        Line(Q_all - J * S.T, by=(is_Q,)),
        Line(Q_all - J_seen * Pick * Pick.T * S_seen.T, by=(is_J, is_S)),
        Line(Q_all - J_seen * S_seen.T, by=(picks,)),
    ),
    """The push has columns for the accurate outputs only. `Spread` holds `G_1` in the
    rows and columns of these, and ones on the rest of its diagonal. So it is definite,
    also where no output is accurate.""",
    is_G_1 := define(G_1, S1 * C_all * Inverse * C_all.T * S1.T),
    is_Gamma_1 := define(Gamma_1, Inverse * C_all.T * S1.T * G_1.I, "47"),
    is_Gamma,
    firsts := define(S1 * S1.T, Identity(m1)),
    chain(
        "47",
        "the accurate outputs that arrived are met",
        S1 * C_all * Gamma_1,
        Line(S1 * C_all * Inverse * C_all.T * S1.T * G_1.I, by=(is_Gamma_1,)),
        Line(G_1 * G_1.I, by=(is_G_1,)),
        Line(Identity(m1), why="an inverse"),
    ),
    is_Lifted := define(Lifted, Inverse * C_all.T * Taken),
    is_Untaken := define(Untaken, Identity(p) - Taken),
    is_Spread := define(Spread, Taken * C_all * Lifted + Identity(p) - Taken),
    beside := chain(
        "47",
        "what scales the push, beside ones",
        Spread,
        Line(Taken * C_all * Lifted + Identity(p) - Taken, by=(is_Spread,)),
        Line(
            Taken * C_all * Inverse * C_all.T * Taken + Identity(p) - Taken,
            by=(is_Lifted,),
        ),
        Line(
            S1.T * S1 * C_all * Inverse * C_all.T * S1.T * S1 + Identity(p) - S1.T * S1,
            by=(is_Taken,),
        ),
        Line(S1.T * G_1 * S1 + Identity(p) - S1.T * S1, by=(is_G_1,)),
    ),
    marked_push := chain(
        "47",
        "the push, by marks",
        Gamma * Spread,
        Line(
            Gamma_1 * S1 * (S1.T * G_1 * S1 + Identity(p) - S1.T * S1),
            by=(is_Gamma, beside),
        ),
        Line(Gamma_1 * G_1 * S1, by=(firsts,)),
        Line(Inverse * C_all.T * S1.T * S1, by=(is_Gamma_1,)),
        Line(Inverse * C_all.T * Taken, by=(is_Taken,)),
        Line(Lifted, by=(is_Lifted,)),
    ),
)


@cache
def arrived():
    """The matrices of the outputs that arrived, from the plant's.

    Seen (p, p) has ones on its diagonal for the outputs that arrived, Taken for the
    accurate ones among them; all else is zero.  Inverse is that of the weight.
    """
    return Derivation(
        (A, Q_all, C_all, E_all, R_all, S_all, Inverse, Seen, Taken),
        (
            Stage(C, marked_C.right, by=(marked_C,)),
            Stage(E, marked_E.right, by=(marked_E,)),
            Stage(
                Missing, Identity(p) - Seen, symmetric=True, by=(is_Missing, is_Seen)
            ),
            Stage(
                R,
                Seen * R_all * Seen + Missing,
                symmetric=True,
                by=(marked_R, is_Missing, is_Seen),
            ),
            Stage(S, marked_S.right, by=(marked_S,)),
            Stage(J, Solve(S, R), by=(marked_J,)),
            Stage(As, A - J * C, by=(is_As,)),
            Stage(Q, Q_all - J * S.T, symmetric=True, by=(is_Q,)),
            Stage(Lifted, is_Lifted.right, by=(is_Lifted,)),
            Stage(Untaken, is_Untaken.right, symmetric=True, by=(is_Untaken, is_Taken)),
            Stage(
                Spread,
                Taken * C_all * Lifted + Untaken,
                symmetric=True,
                by=(is_Spread, is_Untaken),
            ),
            Stage(Gamma, Solve(Lifted, Spread), "(47)", by=(marked_push,)),
        ),
        source="our own",
        letters=letters,
        says="the matrices of what arrived, from those of the plant",
    )


@cache
def derive():
    """The page."""
    page = (*MARKED, arrived())
    return Derivation(page=page, letters=letters, source=f"our own; {SOURCE}")
