"""What the page prints and the algebra refuses.

Each entry is tried, not remembered: the printed expression goes through the same
normal form as ours, which either cannot multiply it or finds a difference.

Source: Leondes and Novak (1975), (24)-(33), as scanned.
"""

import sympy as sp
from sympy import BlockMatrix, Identity, Trace, ZeroMatrix

from .algebra import ShapeError
from .canonical_gain import (
    ALGEBRA,
    H2,
    K1,
    K2,
    O11,
    O21,
    O22,
    R11,
    R21,
    R22,
    H,
    P,
    T,
    gradients_32,
    m1,
    n,
    nz,
    trace_30,
)


def printed():
    """(place, the printed formula in words, printed expression, ours)."""
    first, second = gradients_32()
    V = BlockMatrix([[Identity(m1)], [K1]])  # the second column is lost
    J = trace_30()
    cross, last = 2 * Trace(K1 * R21.T * K2.T), 2 * Trace(O22 * H2.T * K2.T)
    return [
        ("(24)", "V = [I; K1]", lambda: P * T + V * H, Identity(n)),
        (
            "(25)",
            "T = [-K1 | I] - K2 H2",
            lambda: sp.MatAdd(BlockMatrix([[-K1, Identity(nz)]]), -K2 * H2),
            T,
        ),
        ("(29)", "Omega21 = Omega12", lambda: O21 - O21.T, ZeroMatrix(nz, m1)),
        ("(30)", "tr K1 R11 K1", lambda: Trace(K1 * R11 * K1), Trace(K1 * R11 * K1.T)),
        ("(30)", "2 tr K1 R11", lambda: J - cross + 2 * Trace(K1 * R11), J),
        (
            "(30)",
            "- 2 tr Omega22 H2 K2",
            lambda: J + last - 2 * Trace(O22 * H2 * K2),
            J,
        ),
        (
            "(32) first",
            "K2 (H2 Omega21 + R)",
            lambda: first - K2 * R21 + K2 * R22,
            first,
        ),
        (
            "(32) second",
            "K2 (H2 Omega22 H2)",
            lambda: K2 * H2 * O22 * H2 + K2 * R22,
            second,
        ),
        (
            "(32) second",
            "K2 (..) + R + K1 (..) + R",
            lambda: second - K2 * R22 - K1 * R21.T + R22 + R21.T,
            second,
        ),
        (
            "(32) second",
            "- Omega21 H2",
            lambda: second + O22 * H2.T - O21 * H2,
            second,
        ),
        (
            "(33)",
            "[Omega21 | Omega22 H2]",
            lambda: BlockMatrix([[O21, O22 * H2]]),
            BlockMatrix([[O21, O22 * H2.T]]),
        ),
        ("after (33)", "Omega11 of (33) as Omega21", lambda: O21 + R11, O11 + R11),
    ]


def misprints():
    """List of (place, printed, why it is rejected)."""
    found = []
    for place, words, expression, ours in printed():
        try:
            difference = ALGEBRA.normal(expression()) - ALGEBRA.normal(ours)
            if difference.is_zero:
                raise AssertionError(f"{place} {words} is no misprint")
            found.append((place, words, "not equal to what is derived"))
        except (ShapeError, sp.ShapeError) as error:
            found.append((place, words, f"not conformable: {error}"))
    return found
