"""What the fixed-order filter computes, as lists of small assignments.

Each function returns a `Derivation` whose `stages` the kernels compile and whose
`steps` prove what they are used for.  The letters are those of `augmented`.  The
multiplicative noise enters only through V1, V12 and V2, which are always those of
the equivalent plant: V1 + sum A_i Q1 A_i' and so on, with `equivalent_noise` for the
terms of the sums.

Source: Haddad and Bernstein (1987), (4.4)-(4.11); the differentials are our own.
"""

from dataclasses import replace
from functools import cache

from ....symbolic import BlockMatrix, Derivation, MatrixSymbol, Solve, Stage
from . import moment_claims as prove
from .augmented import (
    GAINS,
    P2,
    P12,
    Q1,
    Q2,
    Q12,
    V2,
    V12,
    A,
    Ae,
    Be,
    C,
    Ce,
    De,
    L,
    R,
    l,
    n,
    q,
    r,
)

PAPER = "Haddad and Bernstein (1987)"


def matrices(names, rows, cols):
    """Matrix symbols of one shape, from a string of names."""
    return [MatrixSymbol(name, rows, cols) for name in names.split()]


Qxy, Qxy_next = matrices("Qxy Qxy_next", n, l)
(Qyy,) = matrices("Qyy", l, l)
INCREMENTS = tuple(
    MatrixSymbol(f"d{X.name}", *X.shape) for X in (*GAINS, Q12, Q2, P12, P2)
)


@cache
def equivalent_noise():
    """What one pair (A1, C1) adds to V1, V12 and V2; X is the second moment of x."""
    A1, X, dV1 = matrices("A1 X dV1", n, n)
    (C1,) = matrices("C1", l, n)
    (dV12,), (dV2,) = matrices("dV12", n, l), matrices("dV2", l, l)
    stages = (
        Stage(dV1, A1 * X * A1.T, "(4.4)", symmetric=True),
        Stage(dV12, A1 * X * C1.T, "(4.4)"),
        Stage(dV2, C1 * X * C1.T, "(4.4)", symmetric=True),
    )
    found = Derivation((A1, C1, X), stages, source=PAPER)
    return replace(found, steps=prove.equivalent_noise(found))


@cache
def output_moments():
    """E[x y'], E[x+ y'] and E[y y'], which no estimator changes."""
    stages = (
        Stage(Qxy, Q1 * C.T),
        Stage(Qxy_next, A * Q1 * C.T + V12),
        Stage(Qyy, C * Q1 * C.T + V2, symmetric=True),
    )
    found = Derivation((A, C, V12, V2, Q1), stages, source=PAPER)
    return replace(found, steps=prove.output_moments(found))


@cache
def estimator_moments():
    """Right sides of Q12 = A Q12 Ae' + N12 and of Q2 = Ae Q2 Ae' + N2."""
    (N12,), (N2,) = matrices("N12", n, r), matrices("N2", r, r)
    shown = Be * C * Q12 * Ae.T
    stages = (
        Stage(N12, Qxy_next * Be.T, "(4.6)"),
        Stage(N2, shown + shown.T + Be * Qyy * Be.T, "(4.6)", symmetric=True),
    )
    found = Derivation((C, Qyy, Qxy_next, Ae, Be, Q12), stages, source=PAPER)
    return replace(found, steps=prove.estimator_moments(found))


@cache
def adjoint_moments():
    """Right sides of P2 = Ae'P2 Ae + M2, P12 = A'P12 Ae + M12, P1 = A'P1 A + M1."""
    (M1,), (M12,) = matrices("M1", n, n), matrices("M12", n, r)
    (M2,) = matrices("M2", r, r)
    missed = L - De * C
    shown = A.T * P12 * Be * C
    stages = (
        Stage(M2, Ce.T * R * Ce, "(4.7)", symmetric=True),
        Stage(M12, C.T * Be.T * P2 * Ae - missed.T * R * Ce, "(4.7)"),
        Stage(
            M1,
            shown + shown.T + C.T * Be.T * P2 * Be * C + missed.T * R * missed,
            "(4.7)",
            symmetric=True,
        ),
    )
    found = Derivation((A, C, L, R, Ae, Be, Ce, De, P12, P2), stages, source=PAPER)
    return replace(found, steps=prove.adjoint_moments(found))


@cache
def projection_cost():
    """Covariance Sigma of L x - y_e; the cost is the trace of R Sigma."""
    Sigma, J = matrices("Sigma J", q, q)
    shown = (L * Q12 - De * C * Q12) * Ce.T + L * Qxy * De.T
    stages = (
        Stage(
            Sigma,
            L * Q1 * L.T - shown - shown.T + Ce * Q2 * Ce.T + De * Qyy * De.T,
            "(3.5)",
            symmetric=True,
        ),
        Stage(J, R * Sigma, "(3.5)"),
    )
    given = (C, L, R, Ce, De, Qxy, Qyy, Q1, Q12, Q2)
    found = Derivation(given, stages, source=PAPER)
    return replace(found, steps=prove.projection_cost(found))


@cache
def projection_gradient():
    """Gradients of the cost in the four gains: the whole, not half of it."""
    grads = [MatrixSymbol(f"grad{X.name}", *X.shape) for X in GAINS]
    halves = (
        P12.T * A * Q12 + P2 * (Be * C * Q12 + Ae * Q2),
        P12.T * Qxy_next + P2 * (Be * Qyy + Ae * Q12.T * C.T),
        R * (Ce * Q2 + De * C * Q12 - L * Q12),
        R * (De * Qyy + Ce * Q12.T * C.T - L * Qxy),
    )
    stages = tuple(
        Stage(grad, 2 * half, f"(4.{k})")
        for k, (grad, half) in enumerate(zip(grads, halves), 8)
    )
    moments = (Qxy, Qxy_next, Qyy, Q12, Q2, P12, P2)
    found = Derivation((A, C, L, R, Ae, Be, Ce, De, *moments), stages, source=PAPER)
    return replace(found, steps=prove.projection_gradient(found))


@cache
def best_output():
    """[Ce De] of least cost for given Ae, Be; or Ce alone, if De = 0."""
    (Czy,) = matrices("Czy", r + l, r + l)
    Nzy, CeDe = matrices("Nzy CeDe", q, r + l)
    stages = (
        Stage(Czy, BlockMatrix([[Q2, Q12.T * C.T], [C * Q12, Qyy]]), symmetric=True),
        Stage(Nzy, BlockMatrix([[L * Q12, L * Qxy]])),
        Stage(CeDe, Solve(Nzy, Czy), "(4.10),(4.11)"),
        Stage(Ce, Solve(L * Q12, Q2), "(4.10)"),
    )
    found = Derivation((C, L, Qxy, Qyy, Q12, Q2), stages, source=PAPER)
    return replace(found, steps=prove.best_output(found))


@cache
def best_output_differential():
    """How `best_output` moves with Q12 and Q2: of [Ce De], or of Ce if De = 0."""
    (Czy,) = matrices("Czy", r + l, r + l)
    Nzy, dCeDe = matrices("dNzy dCeDe", q, r + l)
    (dCe,) = matrices("dCe", q, r)
    dQ12, dQ2 = MatrixSymbol("dQ12", n, r), MatrixSymbol("dQ2", r, r)
    left = L * dQ12 - De * C * dQ12 - Ce * dQ2
    stages = (
        Stage(Nzy, BlockMatrix([[left, -Ce * dQ12.T * C.T]])),
        Stage(dCeDe, Solve(Nzy, Czy)),
        Stage(dCe, Solve(L * dQ12 - Ce * dQ2, Q2)),
    )
    found = Derivation((C, L, Ce, De, Q2, Czy, dQ12, dQ2), stages, source="our own")
    return replace(found, steps=prove.best_output_differential(found, best_output()))


@cache
def projection_differential():
    """How right sides and gradients move with the gains: exact second derivatives.

    The moved moments solve the same equations: dQ12 = A dQ12 Ae' + dN12,
    dQ2 = Ae dQ2 Ae' + dN2, dP2 = Ae'dP2 Ae + dM2 and dP12 = A'dP12 Ae + dM12.
    """
    dAe, dBe, dCe, dDe, dQ12, dQ2, dP12, dP2 = INCREMENTS
    (dN12, dM12), (dN2, dM2) = matrices("dN12 dM12", n, r), matrices("dN2 dM2", r, r)
    missed, dmissed = L - De * C, -dDe * C
    # each is half of a symmetric sum
    dN2_half = (
        (dAe * Q2 + dBe * C * Q12) * Ae.T
        + Be * C * (dQ12 * Ae.T + Q12 * dAe.T)
        + dBe * Qyy * Be.T
    )
    dM2_half = dAe.T * P2 * Ae + dCe.T * R * Ce
    halves = (
        P12.T * A * dQ12
        + dP12.T * A * Q12
        + dP2 * (Be * C * Q12 + Ae * Q2)
        + P2 * (dBe * C * Q12 + Be * C * dQ12 + dAe * Q2 + Ae * dQ2),
        dP12.T * Qxy_next
        + dP2 * (Be * Qyy + Ae * Q12.T * C.T)
        + P2 * (dBe * Qyy + dAe * Q12.T * C.T + Ae * dQ12.T * C.T),
        R * (dCe * Q2 + Ce * dQ2 + dDe * C * Q12 + De * C * dQ12 - L * dQ12),
        R * (dDe * Qyy + dCe * Q12.T * C.T + Ce * dQ12.T * C.T),
    )
    moved = [MatrixSymbol(f"dgrad{X.name}", *X.shape) for X in GAINS]
    stages = (
        Stage(dN12, A * Q12 * dAe.T + Qxy_next * dBe.T),
        Stage(dN2, dN2_half + dN2_half.T, symmetric=True),
        Stage(dM2, dM2_half + dM2_half.T, symmetric=True),
        Stage(
            dM12,
            A.T * P12 * dAe
            + C.T * (dBe.T * P2 * Ae + Be.T * dP2 * Ae + Be.T * P2 * dAe)
            - dmissed.T * R * Ce
            - missed.T * R * dCe,
        ),
        *(Stage(target, 2 * half) for target, half in zip(moved, halves)),
    )
    moments = (Qxy_next, Qyy, Q12, Q2, P12, P2)
    given = (A, C, L, R, Ae, Be, Ce, De, *moments, *INCREMENTS)
    found = Derivation(given, stages, source="our own")
    return replace(found, steps=prove.projection_differential(found))
