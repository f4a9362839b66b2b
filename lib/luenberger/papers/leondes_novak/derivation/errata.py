"""What the page prints and the algebra refuses.

Each entry is tried, not remembered: the printed expression goes through the same
normal form as ours, which either cannot multiply it or finds a difference.

Source: Leondes and Novak (1974), (24)-(33), as scanned.
"""

from sympy import Trace

from ....symbolic import BlockMatrix, Claim, Identity, ShapeError, ZeroMatrix
from . import coordinates, uniqueness
from .canonical_gain import (
    ALGEBRA,
    H2,
    K1,
    K2,
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
    ]


def no_input():
    """(20) leaves the input out, which (10) carries."""
    claim = coordinates.derive().steps["(17),(20) q_+ = M A M^-1 q + M B u + M w"]
    silent = Claim(
        claim.left.xreplace({coordinates.u: 0 * coordinates.u}),
        claim.right,
        claim.algebra,
    )
    assert not silent.is_zero
    return "(20)", "no term in u", f"differs from M x_+ by {silent.residual.as_expr()}"


def too_weak():
    """The condition after (33), on the counterexample of `uniqueness`."""
    assert all(step.is_zero for step in uniqueness.counterexample().values())
    place, words = "after (33)", "R22 > 0 and cov(w1) > 0 suffice"
    return place, words, "A = 0, Q = R = ones(2, 2), H = I satisfy it with det M = 0"


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
