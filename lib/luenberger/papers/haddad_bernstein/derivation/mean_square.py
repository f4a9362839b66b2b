"""Mean-square stability of plant and estimator: lemma 4.1, and the largest noise.

The map Q~ -> A~Q~A~' + sum A~_i Q~ A~_i' is block triangular in (Q1, Q12, Q2), so its
eigenvalues are those of Q1 -> A Q1 A' + sum A_i Q1 A_i', of Q12 -> A Q12 Ae' and of
Q2 -> Ae Q2 Ae'.  The first is never less stable than A itself, so the augmented
system is mean-square stable exactly if the first map and Ae are.  A stable, as
printed, is not enough.

With the noises scaled by s the first map is A X A' + s^2 Pi X.  If Y solves
Y = A Y A' + Pi X, what matters is the largest eigenvalue rho of X -> Y: the map keeps
a semidefinite cone and so takes it there (Krein and Rutman), and the plant is
mean-square stable exactly for s^2 rho < 1.

Source: Haddad and Bernstein (1987), lemma 4.1; the scaling is our own.
"""

from functools import cache

import sympy as sp
from sympy import Trace
from sympy import kronecker_product as kron

from ....symbolic import (
    Algebra,
    Claim,
    Derivation,
    Identity,
    MatrixSymbol,
    ZeroMatrix,
    claims,
)
from .blocks import PAIRS, Q1, Q2, Q12, SYMMETRIC, V1, V2, V12, A, Ae, moment, n
from .projecting import noise

k = sp.Symbol("k", integer=True, nonnegative=True)
X, Y = MatrixSymbol("X", n, n), MatrixSymbol("Y", n, n)
s, c = sp.symbols("s c", positive=True)
quiet = {V: ZeroMatrix(*V.shape) for V in (V1, V12, V2)}


def scaled(X, s=1):
    """X -> A X A' + s^2 sum A_i X A_i'."""
    return A * X * A.T + s**2 * noise(X, 0, 0)


def lyapunov(X):
    """X - A X A'."""
    return X - A * X * A.T


def triangular():
    """Each block of the map, with the blocks before it set to zero."""
    ahead = moment(PAIRS)
    no_Q1 = {Q1: ZeroMatrix(n, n)}
    no_Q12 = no_Q1 | {Q12: ZeroMatrix(*Q12.shape)}
    block = lambda i, j: ahead[i, j].as_expr().xreplace(quiet)  # noqa: E731
    return claims(
        Algebra(SYMMETRIC),
        {
            "lemma 4.1: block 11 depends on Q1 alone: A Q1 A' + sum A_i Q1 A_i'": (
                block(0, 0),
                scaled(Q1),
            ),
            "lemma 4.1: block 12 depends on Q12 and Q1: A Q12 Ae' if Q1 = 0": (
                block(0, 1).xreplace(no_Q1),
                A * Q12 * Ae.T,
            ),
            "lemma 4.1: block 22: Ae Q2 Ae' if Q1 = 0, Q12 = 0": (
                block(1, 1).xreplace(no_Q12),
                Ae * Q2 * Ae.T,
            ),
        },
    )


def at_least():
    """The map has an eigenvalue as large as |lambda|^2 for each eigenvalue of A.

    V spans the real invariant space of lambda: A'V = V M with M M' = c I and
    c = |lambda|^2.  For X = H H' the functional tr V'X V grows at least by c.
    """
    V, M = MatrixSymbol("V", n, k), MatrixSymbol("M", k, k)
    H = MatrixSymbol("H", n, n)
    invariant = Algebra(
        [X], [(A.T * V, V * M), (M * M.T, c * Identity(k)), (X, H * H.T)]
    )
    grown = sum((Trace((H.T * Ai.T * V).T * (H.T * Ai.T * V)) for Ai, _ in PAIRS), 0)
    return claims(
        invariant,
        {
            "lemma 4.1: tr V'(A X A' + sum)V = c tr V'X V + squares, so radius >= c": (
                Trace(V.T * scaled(X) * V),
                c * Trace(V.T * X * V) + grown,
            )
        },
    )


def scaling():
    """Y = A Y A' + Pi X with Pi X = sum A_i X A_i'; s^2 rho(X -> Y) < 1."""
    (A1, _), (A2, _) = PAIRS
    rest = A2 * X * A2.T
    solved = Algebra([X, Y], [(A1 * X * A1.T, lyapunov(Y) - rest)])
    limit = Algebra([X], [(A1 * X * A1.T, s**-2 * lyapunov(X) - rest)])
    Xk, Xn = MatrixSymbol("X_k", n, n), MatrixSymbol("X_k+1", n, n)
    steps = Algebra(
        [Q1, Xk, Xn, V1],
        [
            (A1 * Q1 * A1.T, lyapunov(Q1) - V1 - A2 * Q1 * A2.T),
            (A1 * Xk * A1.T, lyapunov(Xn) - V1 - A2 * Xk * A2.T),
        ],
    )
    return (
        claims(
            solved,
            {
                "scaling: X - A X A' - s^2 Pi X = Z - A Z A' with Z = X - s^2 Y": (
                    X - scaled(X, s),
                    lyapunov(X - s**2 * Y),
                )
            },
        )
        | claims(
            limit,
            {
                "scaling: if s^2 Y = X, then X is a fixed point, the limit": (
                    scaled(X, s),
                    X,
                )
            },
        )
        | claims(
            steps,
            {
                "X_k+1 = A X_k+1 A' + Pi X_k + V1: Q1 - X_k+1 is the Y of Q1 - X_k": (
                    lyapunov(Q1 - Xn),
                    noise(Q1 - Xk, 0, 0),
                )
            },
        )
    )


def kronecker():
    """Concrete sizes: the matrices of these maps."""
    a, a1, ae, b, cc, c1, z = sp.symbols("a a_1 a_e b c c_1 z")
    At, A1t = sp.Matrix([[a, 0], [b * cc, ae]]), sp.Matrix([[a1, 0], [b * c1, 0]])
    both = kron(At, At) + kron(A1t, A1t)
    roots = (z - a**2 - a1**2) * (z - a * ae) ** 2 * (z - ae**2)
    rho = a1**2 / (1 - a**2)
    numbers = {a: sp.Rational(1, 2), a1: sp.Rational(6, 5), ae: sp.Rational(3, 10)}
    F = sp.Matrix(2, 2, sp.symbols("f:4"))
    Z = sp.Matrix(2, 2, sp.symbols("z:4"))
    stacked = lambda Z: sp.Matrix(list(Z))  # noqa: E731  row by row
    return {
        "lemma 4.1, n = 2: A (x) A is the matrix of X -> A X A'": Claim(
            kron(F, F) * stacked(Z) - stacked((F * Z * F.T).expand())
        ),
        "lemma 4.1, n = n_e = 1: det(z - A~(x)A~ - A~1(x)A~1) has the roots "
        "a^2 + a_1^2, a a_e twice, a_e^2": Claim((z * sp.eye(4) - both).det(), roots),
        "lemma 4.1, n = n_e = 1: A = 0.5, A_1 = 1.2, A_e = 0.3: radius 1.69": Claim(
            (a**2 + a1**2).subs(numbers), sp.Rational(169, 100)
        ),
        "scaling, n = 1: rho = a_1^2 / (1 - a^2), from Y = a^2 Y + a_1^2 X": Claim(
            rho - a**2 * rho, a1**2
        ),
    }


@cache
def derive():
    return Derivation(
        formulas={
            "X -> A X A' + s^2 sum A_i X A_i'": scaled(X, s),
            "(4.4) Q1": scaled(Q1) + V1,
        },
        steps=triangular() | at_least() | scaling() | kronecker(),
        source="Haddad and Bernstein (1987), lemma 4.1; our own",
    )
