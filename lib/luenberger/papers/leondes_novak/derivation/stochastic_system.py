"""The plant and its statistics, (1)-(6), and what each assumption is good for.

Means follow the equations with the noises left out, as (3) says.  A covariance is
that of a map times what is independent: (4) gives the blocks on its diagonal, (5)
the zeros beside them, and (6) the first block.  A correlation S = E[w v'], which (5)
excludes, would add two terms.

Source: Leondes and Novak (1974), section I, (1)-(6).
"""

from functools import cache

from ....symbolic import (
    Algebra,
    BlockMatrix,
    Derivation,
    Identity,
    MatrixSymbol,
    ZeroMatrix,
    claims,
)
from .huddle import FREE, A, B, C, D, E, F, P, Q, R, S, Tn, V, eps, n, p, r, u, v, w, x

X = MatrixSymbol("X", r, r)  # cov(eps)
Sigma = MatrixSymbol("Sigma", n, n)  # cov of x_i less its mean
COVARIANCES = Algebra([Q, R, X, Sigma])


def mean_steps():
    """(1)-(3), (6): means, here under the names of what they are means of."""
    quiet = FREE.with_relations((w, ZeroMatrix(n, 1)), (v, ZeroMatrix(p, 1)))
    return claims(
        quiet,
        {
            "(1),(3) the mean of x moves without w": (
                A * x + B * u + w,
                A * x + B * u,
            ),
            "(2),(3) the mean of y is that of C x + E u": (
                C * x + E * u + v,
                C * x + E * u,
            ),
            "(3) the mean of eps moves by F alone": (
                F * eps + D * v - Tn * w,
                F * eps,
            ),
            "(3),(6) z_i = T x_i in the mean: the estimate has no bias": (
                P * eps + V * v,
                P * eps,
            ),
        },
    )


def covariance_steps():
    """(4)-(6): the covariance of a map of what is independent."""
    zero = ZeroMatrix
    map_ = BlockMatrix([[F, D, -Tn]])
    both = BlockMatrix([[R, S.T], [S, Q]])
    joint = BlockMatrix(
        [
            [X, zero(r, p), zero(r, n)],
            [zero(p, r), *both.blocks[0, :]],
            [zero(n, r), *both.blocks[1, :]],
        ]
    )
    plain = F * X * F.T + D * R * D.T + Tn * Q * Tn.T
    one = Identity(n)
    two = BlockMatrix([[A, one]])
    white = BlockMatrix([[Sigma, zero(n, n)], [zero(n, n), Q]])
    uncorrelated = COVARIANCES.with_relations((S, zero(n, p)))
    return claims(
        COVARIANCES,
        {
            "(4),(6) cov x_+ = A Sigma A' + Q: w is independent of the past": (
                two * white * two.T,
                A * Sigma * A.T + Q,
            ),
            "(5) with E[w v'] = S: cov eps_+ has - D S'T_+' - T_+ S D' besides": (
                map_ * joint * map_.T,
                plain - D * S.T * Tn.T - Tn * S * D.T,
            ),
        },
    ) | claims(
        uncorrelated,
        {
            "(4),(5) cov eps_+ = F X F' + D R D' + T_+ Q T_+'": (
                map_ * joint * map_.T,
                plain,
            )
        },
    )


@cache
def derive():
    return Derivation(
        given=(A, B, C, E, Q, R),
        formulas={
            "(1) x_+": A * x + B * u + w,
            "(2) y": C * x + E * u + v,
            "(4) cov w": Q,
            "(4) cov v": R,
            "(6) cov x_0": Sigma,
        },
        steps=mean_steps() | covariance_steps(),
        source="Leondes and Novak (1974), section I",
    )
