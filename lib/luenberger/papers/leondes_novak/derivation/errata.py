"""What the page prints and the algebra refuses.

Each entry is tried, not remembered: the printed expression goes through the same
normal form as ours, which either cannot multiply it or finds a difference.

Source: Leondes and Novak (1974), (24)-(33), as scanned.
"""

from sympy import Trace

from ....symbolic import Algebra, BlockMatrix, Identity, ShapeError, ZeroMatrix
from . import canonical_gain, coordinates, uniqueness
from .letters import *

ALGEBRA = Algebra([Omega_11, Omega_22, R_11, R_22])
TRACE = canonical_gain.noise_part.right + canonical_gain.prediction_part.right
FIRST, SECOND = canonical_gain.coupled.right.blocks


def printed():
    """(place, the printed formula in words, printed expression, ours)."""
    P, T = canonical_gain.is_P.right, canonical_gain.is_T.right
    H = canonical_gain.is_H.right
    V = BlockMatrix([[Identity(m1)], [K_1]])  # the second column is lost
    cross = 2 * Trace(K_1 * R_21.T * K_2.T)
    last = 2 * Trace(Omega_22 * H_2.T * K_2.T)
    own = Trace(K_1 * R_11 * K_1.T)
    return [
        ("(24)", "V = [I; K1]", lambda: P * T + V * H, I),
        (
            "(29)",
            "Omega21 = Omega12",
            lambda: Omega_21 - Omega_21.T,
            ZeroMatrix(r, m1),
        ),
        ("(30)", "tr K1 R11 K1", lambda: Trace(K_1 * R_11 * K_1), own),
        ("(30)", "2 tr K1 R11", lambda: TRACE - cross + 2 * Trace(K_1 * R_11), TRACE),
        (
            "(30)",
            "- 2 tr Omega22 H2 K2",
            lambda: TRACE + last - 2 * Trace(Omega_22 * H_2 * K_2),
            TRACE,
        ),
        (
            "(32) first",
            "K2 (H2 Omega21 + R)",
            lambda: FIRST - K_2 * R_21 + K_2 * R_22,
            FIRST,
        ),
        (
            "(32) second",
            "K2 (H2 Omega22 H2)",
            lambda: K_2 * H_2 * Omega_22 * H_2 + K_2 * R_22,
            SECOND,
        ),
        (
            "(32) second",
            "K2 (..) + R + K1 (..) + R",
            lambda: SECOND - K_2 * R_22 - K_1 * R_21.T + R_22 + R_21.T,
            SECOND,
        ),
        (
            "(32) second",
            "- Omega21 H2",
            lambda: SECOND + Omega_22 * H_2.T - Omega_21 * H_2,
            SECOND,
        ),
        (
            "(33)",
            "[Omega21 | Omega22 H2]",
            lambda: BlockMatrix([[Omega_21, Omega_22 * H_2]]),
            canonical_gain.N_blocks.right,
        ),
    ]


def no_input():
    """(20) leaves the input out, which (10) carries."""
    ours = coordinates.moves.right
    difference = Algebra().normal(ours - ours.xreplace({u: 0 * u}))
    assert not difference.is_zero
    return "(20)", "no term in u", f"differs from M x_+ by {difference.as_expr()}"


def too_weak():
    """The condition after (33), on the counterexample of `uniqueness`."""
    assert uniqueness.not_enough.check() == []
    place, words = "after (33)", "R22 > 0 and cov(w1) > 0 suffice"
    return (
        place,
        words,
        "A = C = I, Sigma = Q = R = ones(2, 2) satisfy it with det M = 0",
    )


def misprints():
    """List of (place, printed, why it is rejected)."""
    found = [no_input()]
    for place, words, expression, ours in printed():
        try:
            difference = ALGEBRA.normal(expression()) - ALGEBRA.normal(ours)
            if difference.is_zero:
                raise AssertionError(f"{place} {words} is no misprint")
            found.append((place, words, "not equal to what is derived"))
        except ShapeError as error:
            found.append((place, words, f"not conformable: {error}"))
    return [*found, too_weak()]
