"""One pass of a filter over a record, row by row or in compiled code."""

import numpy as np

from .. import kernels
from .agreement import Agreement
from .filter_stacks import Compiled
from .root_step import Spread, first_move
from .settings import require_start

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
        self.x, self.spread, self.u = x[:, None], Spread.of(plant.P0), u
        self.agreement = Agreement(x)
        self.i = 0
        self.before = None  # setting of the instant before, and its residual
        self.seen = np.ones(plant.p, dtype=bool)  # which outputs it had
        self.compiled = None
        self.waiting, self.patience = 0, 1
        self.estimate = kernels.estimate_step(
            "x_minus", "innovation", "x_next", "rho_next"
        )

    @property
    def Sigma(self):
        """Error covariance at the last row that was done."""
        return self.spread.Sigma

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
            ready = self.before is not None and self.spread.half is None
            if compile and ready and self.waiting == 0:
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
        self.spread = Spread(state["Sigma"].reshape(self.Sigma.shape))
        self.agreement = Agreement(state["x"])
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
        move, A, B, J, rho = self.transition()
        new, self.spread, known = now.step(move, self.spread)
        moved = self.estimate(
            A=A, B=B, C=now.C, E=now.E, J=J, K=new["K"], x=self.x, rho=rho,
            u=self.u[:, None], y=y[seen, None], u_next=u[:, None],
        )  # fmt: skip
        if now.blind.size:
            self.agreement.step(
                move.A, now.C, new,
                made_of=move.size @ np.abs(self.x[:, 0]) + np.abs(B) @ np.abs(self.u)
                + np.abs(J) @ np.abs(rho[:, 0]),
                read=np.abs(y[seen]) + np.abs(now.E) @ np.abs(u),
            )  # fmt: skip
            names = [self.plant.output_names[j] for j in np.flatnonzero(seen)]
            self.agreement.require(known, moved["innovation"][:, 0], names, self.i)
        self.x, self.u = moved["x_next"], u
        self.before, self.seen = (now, moved["rho_next"]), seen
        return new["K"]

    def transition(self):
        """What leads from the instant before: `Move`, A, B, J, and the residual."""
        if self.before is not None:
            old, rho = self.before
            return old.move, old.A, old.B, old.J, rho
        A, B, _ = self.plant.first_step()
        move = first_move(self.plant)
        return move, A, B, np.zeros((len(A), 0)), np.zeros((0, 1))  # no y before
