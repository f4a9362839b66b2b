"""The recursions that run, as lists of small assignments at symbolic sizes.

Each function returns a `Derivation` whose `stages` the kernels compile and whose
`steps` prove what the stages are used for.  All are in the user's own coordinates:
`Gamma` (n, p) holds the columns that turn accurate outputs into states,
C1 Gamma1 = I, and zeros for the other outputs, so that Gamma = 0 is the Kalman
filter.

Source: Leondes and Novak (1974), equations (9)-(15), (26)-(33), (41)-(43); the
differential, the steady gradient and the correlated noise are our own.
"""

from dataclasses import replace
from functools import cache

import sympy as sp

from ....symbolic import Derivation, Identity, MatrixSymbol, Solve, Stage
from ....symbolic.symbols import matrices
from . import claims as prove
from .best_coordinates import gain_step as gain_step

n, p, m, r = sp.symbols("n p m r", integer=True, nonnegative=True)

PAPER = "Leondes and Novak (1974)"


def square(names, size=n):
    """Matrix symbols of one square size, from a string of names."""
    return [MatrixSymbol(name, size, size) for name in names.split()]


@cache
def estimate_step():
    """One step of the estimate; rho is the measurement's residual after the update."""
    (A,) = square("A")
    (B,) = matrices("B", n, m)
    (C,) = matrices("C", p, n)
    (E,) = matrices("E", p, m)
    J, K = matrices("J K", n, p)
    x, x_minus, x_next = matrices("x x_minus x_next", n, 1)
    u, u_next = matrices("u u_next", m, 1)
    y, rho, innovation, rho_next = matrices("y rho innovation rho_next", p, 1)
    stages = (
        Stage(x_minus, A * x + B * u + J * rho, "(43)"),
        Stage(innovation, y - E * u_next - C * x_minus, "(43)"),
        Stage(x_next, x_minus + K * innovation, "(43)"),
        Stage(rho_next, y - E * u_next - C * x_next),
    )
    found = Derivation((A, B, C, E, J, K, x, u, rho, y, u_next), stages, source=PAPER)
    return replace(found, steps=prove.estimate_step(found))


@cache
def step_differential():
    """How the gain and Sigma_next of `gain_step` move when Omega moves."""
    (C,) = matrices("C", p, n)
    R, M = square("R M", p)
    Gamma, Kmv, dK = matrices("Gamma Kmv dK", n, p)
    Y, dOmega, dSigma = square("Y dOmega dSigma")
    moved = (Identity(n) - Gamma * C) * (Identity(n) - Kmv * C) * dOmega * C.T
    stages = (
        Stage(dK, Solve(moved, M)),
        Stage(
            dSigma,
            Y * dOmega * Y.T + dK * R * Gamma.T + Gamma * R * dK.T,
            symmetric=True,
        ),
    )
    found = Derivation((C, R, Gamma, M, Kmv, Y, dOmega), stages, source="our own")
    return replace(found, steps=prove.step_differential(found, gain_step()))


@cache
def steady_gradient():
    """Gradient of the steady weighted trace with respect to a constant gain K."""
    (K,) = matrices("K", n, p)
    (M,) = square("M", p)
    (C,) = matrices("C", p, n)
    Omega, Lambda = square("Omega Lambda")
    (Gradient,) = matrices("Gradient", n, p)
    stages = (Stage(Gradient, 2 * Lambda * (K * M - Omega * C.T)),)
    found = Derivation((K, M, Omega, C, Lambda), stages, source="our own")
    return replace(found, steps=prove.steady_gradient(found))


@cache
def observer():
    """A gain K written as an observer with P = Phat and V = K."""
    (As,) = square("As")
    (B,) = matrices("B", n, m)
    J, K = matrices("J K", n, p)
    (C,) = matrices("C", p, n)
    (E,) = matrices("E", p, m)
    (Phat,) = matrices("Phat", n, r)
    That, T, T_next = matrices("That T T_next", r, n)
    (F,) = square("F", r)
    (D,) = matrices("D", r, p)
    (G,) = matrices("G", r, m)
    (W,) = matrices("W", n, m)
    stages = (
        Stage(T, That - That * K * C, "(25)"),
        Stage(F, T_next * As * Phat, "(14)"),
        Stage(D, T_next * As * K + T_next * J, "(15)"),
        Stage(G, T_next * B - D * E, "(10)"),
        Stage(W, -K * E),
    )
    found = Derivation((As, B, J, C, E, Phat, That, K, T_next), stages, source=PAPER)
    return replace(found, steps=prove.observer(found))


@cache
def decorrelation():
    """The plant driven by the part of w that v does not show, J = S R^+.

    Where R is singular, J R = S leaves J free in the directions b with b'R = 0, and
    J + Z b' adds Z b'rho to the prediction.  That is zero for the Kalman filter, which
    meets noise-free outputs exactly, and for accurate outputs without noise.  Beside a
    noisy output taken at its word it is -b'C Gamma R M^-1 times the innovation: there
    the gain (33), and its trace, are those of the J that is taken (`square_root`).
    """
    A, Q, As, Qs = square("A Q As Qs")
    (C,) = matrices("C", p, n)
    S, J = matrices("S J", n, p)
    stages = (
        Stage(As, A - J * C),
        Stage(Qs, Q - J * S.T, symmetric=True),
    )
    found = Derivation((A, C, Q, S, J), stages, source="our own")
    return replace(found, steps=prove.decorrelation(found))


@cache
def error_recursion():
    """Covariance of any observer's error: X = cov(eps), Sigma = cov(P eps + V v)."""
    F, X, X_next = square("F X X_next", r)
    (D,) = matrices("D", r, p)
    (T_next,) = matrices("T_next", r, n)
    (P,) = matrices("P", n, r)
    V, S = matrices("V S", n, p)
    Q, Sigma = square("Q Sigma")
    (R,) = square("R", p)
    crossed = D * S.T * T_next.T
    stages = (
        Stage(
            X_next,
            F * X * F.T + D * R * D.T + T_next * Q * T_next.T - crossed - crossed.T,
            "(11)",
            symmetric=True,
        ),
        Stage(Sigma, P * X * P.T + V * R * V.T, "(26)", symmetric=True),
    )
    found = Derivation((F, D, T_next, P, V, Q, R, S, X), stages, source=PAPER)
    return replace(found, steps=prove.error_recursion(found))
