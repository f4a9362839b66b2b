"""The gain of least error trace, step by step.

In the user's own coordinates.  `Gamma` (n, p) holds the columns that turn the
accurate outputs into states, C1 Gamma1 = I, and zeros for the other outputs.

Source: Leondes and Novak (1975), section III.
"""

import sympy as sp

from . import Derivation, Solve, Stage

n, p, m = sp.symbols("n p m", integer=True, positive=True)


def gain_stages():
    """One step of the covariance recursion: Sigma of step i to K and Sigma of i + 1."""
    A, Q, Sigma = (sp.MatrixSymbol(s, n, n) for s in ("A", "Q", "Sigma"))
    C, R = sp.MatrixSymbol("C", p, n), sp.MatrixSymbol("R", p, p)
    Gamma, Kmv, K = (sp.MatrixSymbol(s, n, p) for s in ("Gamma", "Kmv", "K"))
    Omega, M = sp.MatrixSymbol("Omega", n, n), sp.MatrixSymbol("M", p, p)
    Y, Next = sp.MatrixSymbol("Y", n, n), sp.MatrixSymbol("Sigma_next", n, n)
    given = (A, Q, C, R, Gamma, Sigma)
    stages = (
        Stage(Omega, A * Sigma * A.T + Q, "(29)", symmetric=True),
        Stage(M, C * Omega * C.T + R, "(33)", symmetric=True),
        Stage(Kmv, Solve(Omega * C.T, M), "(33)"),
        Stage(K, Kmv + Gamma - Gamma * C * Kmv),
        Stage(Y, sp.Identity(n) - K * C, "(13)"),
        Stage(Next, Y * Omega * Y.T + K * R * K.T, "(27)", symmetric=True),
    )
    return given, stages


def derive():
    given, stages = gain_stages()
    return Derivation(given=given, stages=stages)
