"""The filter and its covariance in one pass over a record, with missing values."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from . import kernels
from .designs.setting import Settings, require_start
from .errors import DesignError
from .recorded import rows, single

CONFLICT_TOL = 1e-6  # noise-free outputs may disagree by this, relative to the data
NOISE_TOL = 1e-12  # and by this, relative to the largest data so far: rounding remains


@dataclass(frozen=True, eq=False)
class Filtered:
    """What `filter_data` returns; row k is instant k + 1 of the record.

    Attributes
    ----------
    x : (N, n) ndarray
        Estimates of the state, each using y up to and including its row.
    std : (N, n) ndarray
        Their one-sigma errors, square roots of the diagonal of P.
    P : (n, n) or (N, n, n) ndarray
        Error covariance at the last row; with ``history=True`` at every row.
    K : (N, n, p) ndarray or None
        Gains, with ``history=True``; the columns of missing outputs are zero.
    orders : (N,) ndarray of int
        States the reduced-order filter needs at each row: n minus the number of
        accurate outputs that arrived.
    """

    x: np.ndarray
    std: np.ndarray
    P: np.ndarray
    K: np.ndarray | None
    orders: np.ndarray


def filter_data(
    plant, y, u=None, *, m1=0, u0=None, weight=None, history=False, backend="auto"
):
    """Filter a record in one pass, with its covariance; NaN means not measured.

    At each instant the outputs that arrived form C, and the step is that of
    `reduced_order_filter` for them.  An accurate output that is missing cannot be
    taken at its word, so the order rises by one there: its direction is predicted
    and filtered like the others, and drops out again when the output returns.

    Parameters
    ----------
    plant : Plant
        Discrete, with Q, R and P0.
    y : (N, p) array_like, or an iterator of such chunks
        Measurements at instants 1 .. N.  With an iterator the result is an iterator
        of `Filtered`, one for each chunk, and memory stays flat.
    u : (N, m) array_like, or an iterator of chunks like y's, optional
        Known input at the same instants, default zero.
    m1 : int or sequence, default 0
        Accurate outputs, as in `reduced_order_filter`; 0 is the Kalman filter.
    u0 : (m,) array_like, optional
        Input from instant 0 to 1, default zero.
    weight : optional
        As in `reduced_order_filter`.
    history : bool, default False
        Keep the covariance and gain of every row.
    backend : "auto" or "numpy"

    Returns
    -------
    Filtered, or an iterator of Filtered

    Raises
    ------
    ValueError
        If sizes disagree or a value is infinite.
    DesignError
        If the plant lacks Q, R or P0, accurate outputs are dependent, or
        noise-free outputs contradict each other or a state known exactly; the
        message names outputs and instant.

    References
    ----------
    Leondes and Novak (1974), equations (27)-(36), (41)-(43);
    derivations/trace_minimisation.py; derivations/missing_outputs.py.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[1]], P0=[[1]])
    >>> nan = float("nan")
    >>> lb.filter_data(plant, [[2], [nan], [2]]).std[:, 0].round(4)
    array([0.7071, 0.7071, 0.5774])
    """
    kernels.require_backend(backend)
    run = _Pass(plant, m1, weight, u0, history)
    if not isinstance(y, Iterator):
        return run.chunk(y, u)
    if u is not None and not isinstance(u, Iterator):
        raise ValueError("y is an iterator of chunks, so u must be one too")
    return run.chunks(y, u)


class _Pass:
    """The state of one pass: estimate, covariance, residual, instant."""

    def __init__(self, plant, m1, weight, u0, history):
        self.settings = Settings(plant, m1, weight)
        require_start(plant)
        self.plant, self.history = plant, history
        self.x, self.Sigma = plant.x0[:, None], plant.P0
        self.u = np.zeros(plant.m) if u0 is None else single("u0", u0, plant.m)
        self.i = 0
        self.largest = np.zeros(plant.p)  # of each output so far
        self.before = None  # setting of the instant before, and its residual
        self.estimate = kernels.estimate_step(
            "x_minus", "innovation", "x_next", "rho_next"
        )

    def chunks(self, y, u):
        for part in y:
            inputs = None if u is None else next(u, ())
            if inputs is not None and len(inputs) == 0 < len(part):
                raise ValueError("u has fewer chunks, or emptier ones, than y")
            yield self.chunk(part, inputs)

    def chunk(self, y, u):
        plant = self.plant
        y = rows("y", y, plant.p, missing=True)
        u = rows("u", np.zeros((len(y), plant.m)) if u is None else u, plant.m)
        if len(u) != len(y):
            raise ValueError(f"y has {len(y)} rows but u has {len(u)}")
        if plant.steps is not None and self.i + len(y) >= plant.steps:
            raise ValueError(
                f"the plant has rows for instants 0 .. {plant.steps - 1}, the data "
                f"reach instant {self.i + len(y)}"
            )
        N, n, p = len(y), plant.n, plant.p
        x, std, orders = np.empty((N, n)), np.empty((N, n)), np.empty(N, dtype=int)
        P = np.empty((N, n, n)) if self.history else None
        K = np.zeros((N, n, p)) if self.history else None
        for k in range(N):
            seen = ~np.isnan(y[k])
            gain, now = self.step(y[k], u[k], seen)
            x[k], std[k] = self.x[:, 0], self.Sigma.diagonal()
            orders[k] = now.Phat.shape[1]
            if self.history:
                P[k], K[k][:, seen] = self.Sigma, gain
        std = np.sqrt(std.clip(0))
        return Filtered(x, std, self.Sigma if P is None else P, K, orders)

    def step(self, y, u, seen):
        """Advance to the next instant with the outputs that arrived."""
        self.i += 1
        now = self.settings.at(self.i, None if seen.all() else seen)
        A, B, Q, As, J, rho = self.transition()
        new = now.step(As, Q, self.Sigma)
        moved = self.estimate(
            A=A, B=B, C=now.C, E=now.E, J=J, K=new["K"], x=self.x, rho=rho,
            u=self.u[:, None], y=y[seen, None], u_next=u[:, None],
        )  # fmt: skip
        self.Sigma, self.x, self.u = new["Sigma_next"], moved["x_next"], u
        self.before = now, moved["rho_next"]
        if now.blind.size:
            states = np.abs(moved["x_minus"]) + np.abs(moved["x_next"])
            size = np.abs(now.C) @ states[:, 0] + np.abs(now.E) @ np.abs(u)
            # before accurate outputs are taken at their word: that moves C x^ again
            left = moved["innovation"] - now.C @ (new["Kmv"] @ moved["innovation"])
            self.require_agreement(now.blind, left, size + np.abs(y[seen]), seen)
        return new["K"], now

    def transition(self):
        """A, B, Q, As, J and residual that lead from the instant before."""
        if self.before is not None:
            old, rho = self.before
            return old.A, old.B, old.Qs, old.As, old.J, rho
        A, B, Q = self.plant.first_step()
        return A, B, Q, A, np.zeros((len(A), 0)), np.zeros((0, 1))  # no y before

    def require_agreement(self, blind, left, size, seen):
        """Noise-free combinations of outputs must be met by the best estimate."""
        left = np.abs(blind.T @ left).max(axis=1)
        self.largest[seen] = np.maximum(self.largest[seen], size)
        size = np.maximum(CONFLICT_TOL * size, NOISE_TOL * self.largest[seen])
        bad = left > np.abs(blind).T @ size
        if bad.any():
            part = np.abs(blind[:, bad]).max(axis=1) > 1e-9
            which = [self.plant.output_names[j] for j in np.flatnonzero(seen)[part]]
            raise DesignError(
                f"at instant {self.i} the noise-free outputs {which} contradict each "
                "other, or a state that is believed known exactly, by "
                f"{left[bad].max():.3g}. Give them noise in R, or raise Q or P0."
            )
