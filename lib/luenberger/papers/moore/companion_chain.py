"""An observer of k x with given characteristic polynomial, as a chain of factors.

F is a chain of observer companion forms, one for each factor of the polynomial; P
reads the first state.  One factor is Moore's setting; factors of degree one and two
keep the poles where they were asked for, on the diagonal of F, which a companion
matrix of high degree does not.  Within a factor the rows of T follow the same stage
as in companion form, with the factor's first row in place of k.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from ... import kernels
from ...numeric import Matrix, Vector, rationals
from .derivation import companion_row

Factors = list[list]  # b_0 .. b_(m-1) of each factor b_0 + .. + s^m


@dataclass(frozen=True)
class Chain:
    """F, D, T, P of (5) and (7) in the coordinates of A, C, k."""

    F: np.ndarray
    D: np.ndarray
    T: np.ndarray
    P: np.ndarray


def chain(A: Matrix, C: Matrix, k: Vector, factors: Factors) -> Chain:
    """The observer with characteristic polynomial prod(factors).

    A factor is the list of its coefficients b_0 .. b_(m-1), the leading one left
    out.  Entries are floats or, all of them, Fractions.  Where the polynomial is not
    admissible the last row of T A - F T = D C does not hold.
    """
    exactly = k.dtype == object
    _, zero = rationals.makers(exactly)
    p, order = len(C), sum(map(len, factors))
    inputs = injections(A, C, factors).reshape(order * p, len(A))
    _, after = rows(A, C, k, factors, zero(order, p))  # k beta(A)
    D = (_exactly if exactly else _least)(inputs, after).reshape(order, p)
    T, _ = rows(A, C, k, factors, D)
    P = zero(1, order)
    P[:, :1] += 1
    return Chain(dynamics(factors, zero), D, T, P)


def factors_of(poles: Vector) -> Factors:
    """A factor s - a for each real pole, s^2 - 2 a s + a^2 + b^2 for each pair."""
    if poles.dtype == object:
        return [[-pole] for pole in poles]
    return [
        [-pole.real] if pole.imag == 0 else [abs(pole) ** 2, -2 * pole.real]
        for pole in poles
        if pole.imag >= 0
    ]


def in_order(poles: Vector) -> Vector:
    """The poles in the order of their factors, of a pair first that with b > 0."""
    pairs = [[p] if p.imag == 0 else [p, p.conjugate()] for p in poles if p.imag >= 0]
    return np.concatenate(pairs)


def rows(
    A: Matrix, C: Matrix, k: Vector, factors: Factors, D: Matrix
) -> tuple[Matrix, Vector]:
    """The rows of T, and the one after them."""
    step = kernels.compiled(companion_row)
    t, T = k[None], list[Matrix]()
    for factor in factors:
        first = t
        for b in factor[::-1]:
            d = D[len(T)][None]
            T.append(t)
            t = step(t=t, A=A, b=np.array([[b]]), k=first, d=d, C=C)["t_next"]
    return np.vstack([k[None][:0], *T]), t[0]


def injections(A: Matrix, C: Matrix, factors: Factors) -> Matrix:
    """(r, p, n): what a unit in row i of D takes away from the row after the last."""
    M, X = [], C
    for factor in factors[::-1]:
        powers = [X]
        for _ in factor:
            powers.append(powers[-1] @ A)
        M += powers[:-1]
        X = powers[-1] + sum(b * Y for b, Y in zip(factor, powers))
    return np.array(M[::-1]).reshape(len(M), *C.shape)


def dynamics(factors: Factors, zero: Callable[..., Matrix]) -> Matrix:
    """F: companion blocks, each feeding the one before it."""
    order, at = sum(map(len, factors)), 0
    F = zero(order, order)
    for i in range(order - 1):
        F[i, i + 1] += 1
    for factor in factors:
        for i, b in enumerate(factor[::-1]):
            F[at + i, at] -= b
        at += len(factor)
    return F


def _least(M: Matrix, row: Vector) -> Vector:
    """The x of least norm with x M = row, rows of M at unit length."""
    size = np.linalg.norm(M, axis=1)
    size = np.where(size > 0, size, 1.0)
    x, *_ = scipy.linalg.lstsq((M / size[:, None]).T, row, cond=1e-13)
    return x / size


def _exactly(M: Matrix, row: Vector) -> Vector:
    """An x with x M = row, or zeros when there is none."""
    echelon, pivots = rationals.reduced(np.column_stack([M.T, row]))
    x = rationals.zeros(len(M))
    if len(M) not in pivots:
        x[pivots] = echelon[:, -1]
    return x
