"""One row of a filter that waits for readings: predict, take, use what has arrived.

What has arrived may be of this instant or of an earlier one.  The covariance is carried
itself where it loses few digits, and as a factor (`late_roots`) where it would lose
more, or where it is singular.
"""

import numpy as np
from scipy.linalg.lapack import dpotrf

from .. import kernels
from ..numeric import Matrix, Vector
from ..numeric.factors import safe
from ..papers.leondes_novak.derivation import (
    late_ahead,
    late_corrected,
    late_fresh,
    late_known,
)
from .late_roots import DIGITS, Used, used_in_factors
from .late_state import Ahead, LateState, Row, predicted
from .root_step import Spread
from .settings import Settings


def step(settings: Settings, state: LateState, row: Row) -> tuple[LateState, Matrix]:
    """The state one row on, and the gain (n, p) of the readings of this row.

    Parameters
    ----------
    settings : Settings
        Of the Kalman filter: without accurate outputs.
    state : LateState
    row : Row

    Raises
    ------
    DesignError
        If noise-free readings contradict each other or a state known exactly.
    """
    ahead = predicted(settings, state, row)
    came = np.array([one.arrived(row.label) for one in ahead.held], dtype=bool)
    used = used_as_they_are(state, ahead, came)
    if used is None:
        used = used_in_factors(settings, state, ahead, came)
    return _after(row, ahead, came, used)


def used_as_they_are(state: LateState, ahead: Ahead, came: Vector) -> Used | None:
    """What the readings that `came` do; None where covariances lose too many digits."""
    if state.spread.half is not None or ahead.now.blind.size:
        return None
    n, t = len(ahead.now.A), ahead.of_all(came)
    P = covariance_ahead(state, ahead)
    size = P.diagonal()
    R = ahead.now.R[np.ix_(ahead.new, ahead.new)]
    if not _well_above(R, size[len(size) - len(R) :]):
        return None
    found = kernels.compiled(late_known)(
        P_rr=P[np.ix_(~t, ~t)], P_rt=P[np.ix_(~t, t)], P_tt=P[np.ix_(t, t)]
    )
    left, size = found["P_next"], size[~t]
    if (left.diagonal() <= DIGITS * size).any() or not safe(left[:n, :n], size[:n]):
        return None
    return Used(found["K_t"], Spread(left), None)


def covariance_ahead(state: LateState, ahead: Ahead) -> Matrix:
    """The covariance of the state, of readings held and of new ones."""
    now, move, last, kept = ahead.now, ahead.move, ahead.last, ahead.kept
    P, n = state.spread.Sigma, len(now.A)
    X, Z = P[:n, n:], P[n:, n:]
    moved = kernels.compiled(late_ahead, "X_h_next", "Omega")(
        As=move.A, Qs=move.Q, J=ahead.J, Sigma=P[:n, :n], X_f=X[:, last],
        X_h=X[:, kept], Z_f=Z[np.ix_(last, last)], Z_fh=Z[np.ix_(last, kept)],
    )  # fmt: skip
    Omega, X_h, C = moved["Omega"], moved["X_h_next"], now.C[ahead.new]
    R = now.R[np.ix_(ahead.new, ahead.new)]
    new = kernels.compiled(late_fresh, "N", "N_h", "M")(C=C, R=R, Omega=Omega, X_h=X_h)
    N, N_h, Z_h = new["N"], new["N_h"], Z[np.ix_(kept, kept)]
    return np.block([[Omega, X_h, N], [X_h.T, Z_h, N_h], [N.T, N_h.T, new["M"]]])


def _well_above(X: Matrix, size: Vector) -> bool:
    """Whether X has pivots that leave twelve digits of numbers of that size."""
    upper, info = dpotrf(X) if len(X) else (X, 0)
    return info == 0 and bool((upper.diagonal() ** 2 > DIGITS * size).all())


def _after(
    row: Row, ahead: Ahead, came: Vector, used: Used
) -> tuple[LateState, Matrix]:
    """The state after the readings that `came`, and the gain of those of this row."""
    n, p, t = len(ahead.now.A), len(ahead.now.C), ahead.of_all(came)
    arrived = [one for one, now in zip(ahead.held, came) if now]
    held = tuple(one for one, now in zip(ahead.held, came) if not now)
    values = np.array([one.value for one in arrived]).reshape(-1, 1)
    xi = kernels.compiled(late_corrected)(
        K_t=used.K, xi_hat=ahead.xi[~t], t=values, t_hat=ahead.xi[t]
    )["xi_hat_next"]
    gain, y_hat = np.zeros((n, p)), np.zeros((p, 1))
    for k, one in enumerate(arrived):
        if one.instant == ahead.instant:
            gain[:, one.output], y_hat[one.output] = used.K[:n, k], one.value
    state = LateState(
        ahead.instant, xi, used.spread, used.rounding, row.u, y_hat, held, ahead.now,
        row.label,
    )  # fmt: skip
    return state, gain
