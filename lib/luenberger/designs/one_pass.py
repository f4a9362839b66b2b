"""One pass of a filter over a record, row by row or in compiled code."""

import numpy as np

from .. import kernels
from ..errors import DesignError
from .compiled import Compiled
from .setting import require_start

CONFLICT_TOL = 1e-6  # noise-free outputs may disagree by this, relative to the data
NOISE_TOL = 1e-12  # and by this, relative to the largest data so far: rounding remains
PATIENCE = 64  # rows at most that NumPy takes before compiled code is tried again


class Pass:
    """The state of one pass: estimate, covariance, residual, instant.

    NumPy's `step` can do every row.  Compiled code does the rows it can, and gives
    up, before it has written anything of the row, where a covariance is singular or
    outputs are noise-free; NumPy does such a row, and so decides what it means.
    """

    def __init__(self, settings, x, u):
        plant = settings.plant
        require_start(plant)
        self.settings, self.plant = settings, plant
        self.x, self.Sigma, self.u = x[:, None], plant.P0, u
        self.i = 0
        self.largest = np.zeros(plant.p)  # of each output so far
        self.before = None  # setting of the instant before, and its residual
        self.seen = np.ones(plant.p, dtype=bool)  # which outputs it had
        self.compiled = None
        self.waiting, self.patience = 0, 1
        self.estimate = kernels.estimate_step(
            "x_minus", "innovation", "x_next", "rho_next"
        )

    def over(self, y, u, compile, history=False):
        """Filter the rows of y; return x, variances, P and K (None without history).

        `compile` asks for compiled code where it can be had.
        """
        N, n, p = len(y), self.plant.n, self.plant.p
        x, variances = np.empty((N, n)), np.empty((N, n))
        P = np.empty((N if history else 0, n, n))
        K = np.zeros((N if history else 0, n, p))
        out = x, variances, P, K
        if compile and self.compiled is None:
            self.compiled = Compiled(self.settings)
        compile = compile and self.compiled.applies
        rows = self.compiled.rows(self, y, u) if compile and N else None
        k = 0
        while k < N:
            if compile and self.before is not None and self.waiting == 0:
                k = self.run(rows, k, out)
            if k < N:
                self.row(k, y, u, out)
                k, self.waiting = k + 1, max(self.waiting - 1, 0)
        return (x, variances, P, K) if history else (x, variances, None, None)

    def run(self, rows, k, out):
        """Rows from k on in compiled code; the first row that is left to NumPy."""
        done = rows.run(self, k, *out)
        self.patience = min(2 * self.patience, PATIENCE) if done == k else 1
        self.waiting = self.patience if done == k else 0
        return done

    def resume(self, rows, state, u, seen):
        """Go on after `rows` rows that compiled code has done."""
        self.i += rows
        self.x, self.u, self.seen = state["x"][:, None], u, seen
        self.Sigma = state["Sigma"].reshape(self.Sigma.shape)
        now = self.settings.at(self.i, None if seen.all() else seen)
        self.before = now, state["rho"][seen][:, None]

    def row(self, k, y, u, out):
        """Row k in NumPy."""
        x, variances, P, K = out
        seen = ~np.isnan(y[k])
        gain = self.step(y[k], u[k], seen)
        x[k], variances[k] = self.x[:, 0], self.Sigma.diagonal()
        if len(P):
            P[k], K[k][:, seen] = self.Sigma, gain

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
        self.before, self.seen = (now, moved["rho_next"]), seen
        if now.blind.size:
            states = np.abs(moved["x_minus"]) + np.abs(moved["x_next"])
            size = np.abs(now.C) @ states[:, 0] + np.abs(now.E) @ np.abs(u)
            # before accurate outputs are taken at their word: that moves C x^ again
            left = moved["innovation"] - now.C @ (new["Kmv"] @ moved["innovation"])
            self.require_agreement(now.blind, left, size + np.abs(y[seen]), seen)
        return new["K"]

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
