"""Stretches of rows that are on time, and estimates that go through them.

A stretch maps any estimate of the state where it begins to the estimate at its end.
The formulas are those of late_prior.py in papers/leondes_novak/derivation.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from .. import kernels
from ..kernels.program import Factor
from ..numeric import Matrices, Matrix, Vector
from ..numeric.factors import SAFE
from ..papers.leondes_novak.derivation import late_end

MOST = 1e2  # what rows may say of a variance by itself, the others being known
PARTS = ("Phi", "xi", "Sigma", "theta", "Lambda")
END = kernels.Recursion(
    late_end,
    carried=(),
    rows=(("x_0", "x_0s", 0), ("xi", "xis", 0), ("theta", "thetas", 0)),
    written=(
        ("ends", "x_end", "vector"),
        ("variances", "P_end", "diagonal"),
        ("covariances", "P_end", "matrix"),
    ),
    before=("P",),
    symmetric=("P", "Sigma", "Lambda"),
    definite=(Factor("Both", SAFE),),
)
SILENT = replace(END, zero=("theta", "Lambda"), definite=())


class Stretches(NamedTuple):
    """Some stretches, one a row: xi, theta (S, n) and flat matrices (S, n n)."""

    Phi: np.ndarray
    xi: np.ndarray
    Sigma: np.ndarray
    theta: np.ndarray
    Lambda: np.ndarray

    @classmethod
    def unknown(cls, count: int, n: int, silent: bool = False) -> Stretches:
        """Room for some, of which nothing is known yet; `silent` ones say nothing."""
        widths = (n * n, n, n * n, n, n * n)
        found = [np.full((count, width), np.nan) for width in widths[:3]]
        said = np.zeros if silent else partial(np.full, fill_value=np.nan)
        return cls(*found, *(said((count, width)) for width in widths[3:]))

    @classmethod
    def empty(cls, count: int, n: int) -> Stretches:
        """Stretches of no rows."""
        found = cls(*(np.zeros_like(X) for X in cls.unknown(count, n)))
        found.Phi[:] = np.eye(n).ravel()
        return found

    def at(self, index: Any) -> Stretches:
        """Some of them, in any order."""
        return Stretches(*(X[index] for X in self))

    def put(self, index: Any, some: Stretches) -> None:
        """Write some of them."""
        for X, part in zip(self, some):
            X[index] = part

    def copy(self) -> Stretches:
        """The same in memory of its own."""
        return Stretches(*(X.copy() for X in self))

    def named(self, mark: str = "") -> Matrices:
        """As the stage lists name them, in stacks of matrices."""
        n = self.xi.shape[1]
        return {
            f"{name}{mark}": X.reshape(len(X), n, -1) for name, X in zip(PARTS, self)
        }

    def arrays(self, rows: slice = slice(None)) -> Matrices:
        """As compiled code names what it writes."""
        return {f"{name}s": X[rows] for name, X in zip(PARTS, self)}


def found_of(found: Matrices, mark: str = "") -> Stretches:
    parts = (found[f"{name}{mark}"] for name in PARTS)
    return Stretches(*(X.reshape(len(X), -1) for X in parts))


class Ends(NamedTuple):
    """Estimates (N, n), their covariances (N, n n), and whether digits are kept."""

    x: np.ndarray
    P: np.ndarray
    good: np.ndarray

    def at(self, index: Vector) -> Ends:
        """Some of them, in any order."""
        return Ends(*(X[index] for X in self))


def gone_through(
    begun: Ends, origin: Vector, stretches: Stretches, index: Vector, compile: bool,
    silent: bool,
) -> Ends:  # fmt: skip
    """Estimates led through stretches, both given by their numbers."""
    N, n = len(origin), begun.x.shape[1]
    x, P, good = begun.x[origin], begun.P, begun.good[origin]
    out = Ends(np.empty((N, n)), np.empty((N, n * n)), good)
    if compile:
        matrices = frozenset(("P", "Phi", "Sigma", "Lambda"))
        kernel = kernels.over_record(
            SILENT if silent else END, (("n", n),), (), matrices
        )
        theta = stretches.theta if silent else stretches.theta[index]
        done = kernel(
            start=0, stop=N, now=index, before=origin, good=out.good, keep=True,
            x_0s=x, xis=stretches.xi[index], thetas=theta, P=P,
            Phi=stretches.Phi, Sigma=stretches.Sigma, Lambda=stretches.Lambda,
            ends=out.x, variances=np.empty((N, n)), covariances=out.P,
        )  # fmt: skip
        out.good[done:] = False
    elif N:
        have = stretches.at(index).named()
        have |= dict(x_0=x[..., None], P=P[origin].reshape(N, n, n))
        wanted = ("Both", "P_end", "x_end")
        found = kernels.run(late_end, have, *wanted, stacks=True)
        out.x[:], out.P[:] = found["x_end"][..., 0], found["P_end"].reshape(N, -1)
        out.good[:] &= _definite(found["Both"])
    with np.errstate(invalid="ignore"):
        out.good[:] &= np.isfinite(out.x).all(axis=1)
        if not silent:
            diagonal = slice(None, None, n + 1)
            said = stretches.Lambda[:, diagonal][index]
            much = np.einsum("ki,ki->k", P[:, diagonal][origin], said)
            out.good[:] &= much <= MOST
    return out


def _definite(X: Matrix) -> Vector:
    """Of some covariances, whether they are definite beyond rounding."""
    size = np.sqrt(np.abs(X.diagonal(axis1=1, axis2=2)))
    size = np.where((size > 0) & np.isfinite(size), size, 1.0)
    X = np.nan_to_num(X / size[:, None] / size[..., None], posinf=0, neginf=0)
    return np.asarray(np.linalg.eigvalsh(X)[:, 0] > SAFE)
