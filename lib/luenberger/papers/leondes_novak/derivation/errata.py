"""What the page prints and the algebra refuses.

Each entry is tried, not remembered: the printed expression goes through the same
normal form as ours, which either cannot multiply it or finds a difference.

Source: Leondes and Novak (1974), (24)-(33), as scanned.
"""

from sympy import Trace

from matrixproof import BlockMatrix, Identity
from matrixproof.algebra import Algebra
from matrixproof.words import ShapeError

from . import canonical_gain, coordinates, uniqueness
from .letters import I, m1
from .letters.canonical import (
    H_2,
    K_1,
    K_2,
    R_11,
    R_21,
    R_22,
    Omega_11,
    Omega_21,
    Omega_22,
)
from .letters.plant import u

ALGEBRA = Algebra([Omega_11, Omega_22, R_11, R_22])
FIRST, SECOND = canonical_gain.coupled.right.blocks
DERIVED = {
    "(30)": canonical_gain.noise_part.right + canonical_gain.prediction_part.right,
    "(32) first": FIRST,
    "(32) second": SECOND,
}


def printed():
    """(place, the page in words, what it prints, what is derived, or a part of it)."""
    P, T, H = (getattr(canonical_gain, name).right for name in ("is_P", "is_T", "is_H"))
    V = BlockMatrix([[Identity(m1)], [K_1]])  # the second column is lost
    N = canonical_gain.N_blocks.right
    noise, crossed = Trace(K_1 * R_11 * K_1.T), 2 * Trace(K_1 * R_21.T * K_2.T)
    seen, last = K_2 * H_2 * Omega_22 * H_2.T, -2 * Trace(Omega_22 * H_2.T * K_2.T)
    both, words = K_2 * R_22 + K_1 * R_21.T, "K2 (..) + R + K1 (..) + R"
    return [
        ("(24)", "V = [I; K1]", lambda: P * T + V * H, I),
        ("(29)", "Omega21 = Omega12", lambda: Omega_21.T, Omega_21),
        ("(30)", "tr K1 R11 K1", lambda: Trace(K_1 * R_11 * K_1), noise),
        ("(30)", "2 tr K1 R11", lambda: 2 * Trace(K_1 * R_11), crossed),
        (
            "(30)",
            "- 2 tr Omega22 H2 K2",
            lambda: -2 * Trace(Omega_22 * H_2 * K_2),
            last,
        ),
        ("(32) first", "K2 (H2 Omega21 + R)", lambda: K_2 * R_22, K_2 * R_21),
        ("(32) second", "K2 (H2 Omega22 H2)", lambda: K_2 * H_2 * Omega_22 * H_2, seen),
        ("(32) second", words, lambda: R_22 + R_21.T, both),
        ("(32) second", "- Omega21 H2", lambda: -Omega_21 * H_2, -Omega_22 * H_2.T),
        ("(33)", "[Omega21 | Omega22 H2]", lambda: [Omega_21, Omega_22 * H_2], N),
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
    for place, words, wrong, right in printed():
        if place in DERIVED:
            whole, part = (ALGEBRA.normal(e).terms for e in (DERIVED[place], right))
            assert part.items() <= whole.items(), f"{place} has no such term"
        try:
            assert not ALGEBRA.normal(right - wrong()).is_zero, f"{place} is right"
            found.append((place, words, "not equal to what is derived"))
        except ShapeError as error:
            found.append((place, words, f"not conformable: {error}"))
    return [*found, too_weak()]
