"""Many records of one plant, filtered together as far as they share a covariance.

The covariance does not depend on what is measured, only on which outputs arrive.  So
records without gaps have one, which is found once; their estimates then go on side by
side.  Every other record is filtered by itself.  Which way a record takes, and its
bits, do not depend on the records beside it.

What is done with many records at once enters here.  It uses `recursion` and what is
below it.
"""

from typing import NamedTuple

import numpy as np

from .. import kernels
from ..errors import DesignError
from ..numeric import Matrix, Vector
from ..papers.leondes_novak.derivation import estimate_step
from ..recursion.settings import Settings
from ..recursion.settled_pass import Progress, SettledPass
from ..recursion.state import History, leading_on, start

WIDTH = 64  # records side by side, always: products of one size have the same bits


class Block(NamedTuple):
    """What was found in a block of records, the record first.

    ``x`` and ``std`` are (M, N, n); ``P`` is (M, n, n) at the last row, or at every row
    (M, N, n, n) with K (M, N, n, p), which is None otherwise.
    """

    x: np.ndarray
    std: np.ndarray
    P: np.ndarray
    K: np.ndarray | None


def filter_block(
    settings: Settings, y: Matrix, u: Matrix, u0: Vector, compile: bool = False,
    history: bool = False, first: int = 0,
) -> Block:  # fmt: skip
    """Filter records y (M, N, p) with inputs u (M, N, m), NaN where not measured.

    Raises
    ------
    DesignError
        As `filter_data`; it names the record, counted from `first`.
    """
    out = _empty(settings, y, history)
    together = np.zeros(len(y), dtype=bool)
    if not compile and y.shape[1] and not settings.noise_free:
        together = ~np.isnan(y).any(axis=(1, 2))
    members = np.flatnonzero(together)
    if len(members):
        _, shared = _one(settings, y, u, u0, int(members[0]), False, True, first)
        for k in range(0, len(members), WIDTH):
            some = members[k : k + WIDTH]
            out.x[some] = _side_by_side(settings, shared.K, y[some], u[some], u0)
        _put(out, members, shared, shared.P[-1])
    for s in np.flatnonzero(~together).tolist():
        state, found = _one(settings, y, u, u0, s, compile, history, first)
        out.x[s] = found.x
        _put(out, s, found, state.Sigma)
    return out


def _empty(settings: Settings, y: Matrix, history: bool) -> Block:
    (M, N, p), n = y.shape, settings.plant.n
    rows = (N,) if history else ()
    K = np.empty((M, N, n, p)) if history else None
    x, std, P = np.empty((M, N, n)), np.empty((M, N, n)), np.empty((M, *rows, n, n))
    return Block(x, std, P, K)


def _put(out: Block, which: Vector | int, found: History, last: Matrix) -> None:
    """Write what does not depend on measurements to one record, or to several."""
    out.std[which] = np.sqrt(np.maximum(found.variances, 0))
    out.P[which] = last if out.K is None else found.P
    if out.K is not None:
        out.K[which] = found.K


def _one(
    settings: Settings, y: Matrix, u: Matrix, u0: Vector, s: int, compile: bool,
    history: bool, first: int,
) -> tuple[Progress, History]:  # fmt: skip
    """Record s by itself."""
    run = SettledPass(settings, None)
    begin = Progress(start(run, settings.plant.x0, u0))
    try:
        return run.over(begin, y[s], u[s], compile, history)
    except DesignError as error:
        raise DesignError(f"record {first + s}: {error}") from error


def _side_by_side(
    settings: Settings, K: Matrix, y: Matrix, u: Matrix, u0: Vector
) -> Matrix:
    """The estimates (M, N, n) of at most `WIDTH` records without gaps; K (N, n, p)."""
    M, N, p = y.shape
    ys, us = np.zeros((N, p, WIDTH)), np.zeros((N, u.shape[2], WIDTH))
    ys[:, :, :M], us[:, :, :M] = y.transpose(1, 2, 0), u.transpose(1, 2, 0)
    x = np.repeat(settings.plant.x0[:, None], WIDTH, axis=1)
    before = np.repeat(u0[:, None], WIDTH, axis=1)
    rho, found = np.zeros((0, WIDTH)), np.empty((N, len(x), WIDTH))
    step, setting = kernels.compiled(estimate_step), None
    for k in range(N):
        _, A, B, J = leading_on(settings.plant, setting)
        setting = settings.at(k + 1)
        moved = step(
            A=A, B=B, C=setting.C, E=setting.E, J=J, K=K[k], x=x, rho=rho, u=before,
            y=ys[k], u_next=us[k],
        )  # fmt: skip
        x, rho, before = moved["x_next"], moved["rho_next"], us[k]
        found[k] = x
    return found[:, :, :M].transpose(2, 0, 1)
