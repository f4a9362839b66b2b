"""How large the innovations of rows were that a recursion has passed."""

from __future__ import annotations

import numpy as np

from .. import kernels
from ..numeric import Matrix
from ..numeric.factors import EPS, lengths
from ..papers.leondes_novak.derivation import gain_step, settled_gain, settled_row
from .alike import alike
from .measure import Measure
from .settings import Setting, Settings
from .state import State


def largest(
    settings: Settings, begin: State, y: Matrix, u: Matrix, xs: Matrix
) -> float:
    """The largest innovation of rows of y, at most, in units of its covariance M.

    The plant does not change.  `xs` are the estimates of the rows, which follow
    `begin`.  M is at least what noise alone makes of it, and infinite is returned where
    that is singular.
    """
    if not len(y):
        return 0.0
    last = begin.setting
    assert last is not None
    first = np.zeros_like(y[0])
    first[begin.seen] = begin.rho[:, 0] + last.E @ begin.u + last.C @ begin.x[:, 0]
    before = ((begin.x[:, 0], xs), (begin.u, u), (first, y))
    x, u_before, y_before = (np.concatenate([[a], X[:-1]]) for a, X in before)
    read = np.concatenate([y, u, u_before, y_before], axis=1)
    seen = np.concatenate([begin.seen[None], ~np.isnan(y)])
    most = 0.0
    for rows in alike(np.concatenate([seen[:-1], seen[1:]], axis=1)):
        was, now = seen[rows[0]], seen[rows[0] + 1]
        inputs = np.ones(2 * u.shape[1], dtype=bool)
        r = read[np.ix_(rows, np.concatenate([now, inputs, was]))]
        most = max(most, _largest(settings.at(1, was), settings.at(1, now), x[rows], r))
    return most


def _largest(was: Setting, now: Setting, x: Matrix, r: Matrix) -> float:
    """The same of rows with one kind of outputs, behind rows with one kind."""
    n, p = now.C.T.shape
    if not p:
        return 0.0
    made = kernels.compiled(settled_gain, "N_x", "N_y", "N_u")(
        B=now.B, C=now.C, E=was.E, J=was.J, As=was.As
    )
    least = kernels.compiled(gain_step, "M")(
        A=was.As, Q=was.Qs, C=now.C, R=now.R, Sigma=np.zeros((n, n))
    )
    try:
        M = Measure(np.linalg.cholesky(least["M"]))
    except np.linalg.LinAlgError:
        return np.inf
    W_x = -M.inverse @ made["N_x"]
    shown = np.concatenate([np.eye(p), -now.E, -made["N_u"], -made["N_y"]], axis=1)
    W_r = M.inverse @ shown
    row = kernels.compiled(settled_row, "epsilon")
    found = lengths(row(W_x=W_x, W_r=W_r, x=x.T, r=r.T)["epsilon"].T).max()
    size = np.abs(W_x) @ np.abs(x).max(axis=0) + np.abs(W_r) @ np.abs(r).max(axis=0)
    rounding = (n + r.shape[1] + p + 4) * EPS * np.linalg.norm(size)
    return float(M.slack * (found + rounding))
