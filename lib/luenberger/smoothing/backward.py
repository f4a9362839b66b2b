"""The smoother's pass over a record, from the last row to the first.

What later rows say is carried back (Bryson and Frazier): no inverse is needed, and
compiled code can do it.  Where later rows say so much more than earlier ones that the
difference of covariances would lose its digits, the rest of the way goes through
smoothed estimates of the next state (Rauch, Tung and Striebel), in factors.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from .. import kernels
from ..numeric import Matrix, Vector
from ..numeric.factors import EPS, lengths, safe, shorten
from ..recursion.root_step import Move, Read, Spread, ahead, visible
from .carried import LEFT, MOST, Back, Carried, Ways, roots
from .compiled import Compiled
from .derivation import backward_step, factor_step, handed_on, rest
from .forward import Kept, inverse_root

LOST = 1e6  # what rounding is multiplied by, where ten digits are left
ROW = ("Theta", "x_s", "Sigma_s", "lamda")


def smoothed(kept: Kept, ways: Ways, compile: bool, neighbours: bool) -> Back:
    """Smooth all rows of a record, given the filter's pass over it.

    The covariances and variances of `kept` are overwritten: to touch new memory takes
    as long as to compute a small matrix.
    """
    N, n = kept.x.shape
    U = np.zeros((N + 1, n, n)) if neighbours else None
    x, lamda, variances = np.empty((N, n)), np.empty((N + 1, n)), kept.variances
    lamda[N:] = 0
    out = Back(x, kept.Sigma, U, lamda)
    zero = np.zeros((n, n))
    carried = Carried(zero[:, :1], zero, np.eye(n), zero[:, :1], None)
    kernel = Compiled(kept, ways, out, variances) if compile and N else None
    turn = 0
    while turn < N:
        if kernel is not None and carried.half is None:
            carried, turn = kernel.run(carried, turn)
        if turn < N:
            k = N - 1 - turn
            carried = _row(kept, ways, k, carried, out)
            variances[k] = out.Sigma[k].diagonal()
            turn += 1
    return replace(out, deviations=roots(variances))


def _row(kept: Kept, ways: Ways, k: int, carried: Carried, out: Back) -> Carried:
    """Row k in NumPy."""
    if carried.half is None:
        (As, C), Lambda = ways.at(k), _handed_on(kept, ways, k + 1, carried.Theta)
        have = dict(
            As=As, C=C, K=kept.K[k], W=kept.W[k], Sigma=kept.Sigma[k],
            innovation=kept.innovation[k][:, None], x=kept.x[k][:, None],
            lamda_next=carried.lamda, Lambda_next=Lambda,
        )  # fmt: skip
        wanted = ROW
        if out.U is not None:
            have["Ahead_next"], wanted = carried.Ahead, (*ROW, "Ahead", "U_next")
        found = kernels.compiled(backward_step, *wanted)(**have)
        Sigma_s = clear(kept.spread(k), found, _made_of(As, Lambda))
        if Sigma_s is not None:
            out.x[k], out.Sigma[k] = found["x_s"][:, 0], Sigma_s
            out.lamda[k] = found["lamda"][:, 0]
            if out.U is not None:
                out.U[k + 1] = found["U_next"]
            own = (found["lamda"], found["Theta"], found.get("Ahead", carried.Ahead))
            return Carried(*own, found["x_s"], None)
        carried = carried._replace(x=out.x[k + 1][:, None], half=root(out.Sigma[k + 1]))
    carried, found, out.lamda[k + 1] = through_next(kept, ways.move(k), k, carried)
    assert carried.half is not None
    out.x[k], out.Sigma[k] = carried.x[:, 0], carried.half @ carried.half.T
    if out.U is not None:
        out.U[k + 1] = found["U_next"]
    return carried


def _handed_on(kept: Kept, ways: Ways, k: int, Theta: Matrix) -> Matrix:
    """How much row k and later ones say of its prediction; nothing behind the last."""
    if k == len(kept):
        return np.zeros_like(Theta)
    have = dict(C=ways.at(k)[1], K=kept.K[k], W=kept.W[k], Theta=Theta)
    return kernels.compiled(handed_on, "Lambda")(**have)["Lambda"]


def clear(
    spread: Spread, found: dict[str, Any], made_of: Vector | None = None
) -> Matrix | None:
    """The smoothed covariance, or None where too few of its digits are left.

    `made_of` (n,) are the magnitudes that the diagonal of Theta is a sum of.
    """
    Sigma_s, Theta = found["Sigma_s"], found["Theta"]
    if spread.half is None and enough(Sigma_s, spread.Sigma, Theta):
        return Sigma_s
    H = root(spread.Sigma) if spread.half is None else spread.half
    Rest = kernels.compiled(rest)(Theta=Theta, H=H)["Rest"]
    values, vectors = np.linalg.eigh(Rest)
    least = values[0] if values.size else 1.0
    size = (lengths(H) * np.sqrt(np.maximum(Theta.diagonal(), 0))).max(initial=0)
    if not least > LEFT or size**2 > MOST:
        return None
    if made_of is not None and (lengths(H) ** 2 * made_of).max(initial=0) > LOST:
        return None
    half = H @ (vectors * np.sqrt(values))
    return half @ half.T


def enough(Sigma_s: Matrix, Sigma: Matrix, Theta: Matrix) -> bool:
    """Whether the difference of covariances has kept its digits."""
    size, left = Sigma.diagonal(), Sigma_s.diagonal()
    if np.any(left <= LEFT * size) or np.any(Theta.diagonal() * size > MOST):
        return False
    return safe(Sigma_s, size)


def _made_of(As: Matrix, Lambda: Matrix) -> Vector:
    """The magnitudes that the diagonal of As' Lambda As is a sum of."""
    return np.add.reduce(np.abs(As) * (np.abs(Lambda) @ np.abs(As)), axis=0)


def root(Sigma: Matrix) -> Matrix:
    """A factor of a covariance."""
    return Spread.of(Sigma).factored()[0]


def known(x: Vector, half: Matrix) -> Carried:
    """From a row that is smoothed: its estimate, and a factor of its covariance."""
    zero = np.zeros((len(x), len(x)))
    return Carried(zero[:, :1], zero, np.eye(len(x)), x[:, None], half)


def through_next(
    kept: Kept, move: Move, k: int, carried: Carried
) -> tuple[Carried, dict[str, Any], Vector]:
    """Row k from the smoothed estimate of the next row.

    Returns what is carried on, the matrices of the step, and what later rows say of
    the next prediction.
    """
    before = kept.x[k + 1] - kept.K[k + 1] @ kept.innovation[k + 1]
    return by_next_state(move, kept.spread(k), kept.x[k], before, carried)


def by_next_state(
    move: Move, spread: Spread, x: Vector, x_minus_next: Vector, carried: Carried
) -> tuple[Carried, dict[str, Any], Vector]:
    """The same for an estimate x (n,) with its `Spread`, wherever it comes from.

    The next state is a measurement of this one through As, and its process noise is
    that measurement's noise.
    """
    assert carried.half is not None
    H, rounding = spread.factored()
    H_minus, rounding = ahead(move, H, rounding)
    unit = np.sqrt(np.maximum(rounding.diagonal(), (EPS * lengths(H_minus)) ** 2))
    gain, _ = visible(Read(move.A, move.G), H, unit)
    B = inverse_root(H_minus, unit)
    found = kernels.compiled(factor_step)(
        As=move.A, L_Q=move.G, H=H, G=gain["Kmv"], x=x[:, None],
        x_minus_next=x_minus_next[:, None], x_s_next=carried.x, H_s_next=carried.half,
    )  # fmt: skip
    parts = [found[name] for name in ("kept", "drawn", "passed")]
    after = carried._replace(
        x=found["x_s"], half=shorten(np.concatenate(parts, axis=1))
    )
    return after, found, B @ (B.T @ (carried.x[:, 0] - x_minus_next))
