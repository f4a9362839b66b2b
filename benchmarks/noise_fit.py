"""The fit of Q and R to a record, beside statsmodels' own fit of the same model.

Three states, a diagonal Q and a full R, a start that is not known (exact diffuse), and
10,000 rows.  statsmodels fits by L-BFGS with differences: with its default settings,
which stop short of the optimum; with logarithms for parameters, which suit it best; and
with tolerances that reach the optimum, which is what "statsmodels" stands for.

Rows with gaps lack a twentieth of the entries of the same records.  There "statsmodels"
is by tolerances alone, and is timed less often: a fit of its own takes minutes.

Run:  OMP_NUM_THREADS=1 python benchmarks/noise_fit.py [--quick]
"""

import sys
import warnings

import numpy as np
from common import in_turns, line, plant, record
from statsmodels.tsa.statespace.mlemodel import MLEModel

import luenberger as lb

STEPS, ROUNDS = 10_000, 5
OUTPUTS = (1, 2)
MISSING = 0.05  # of the entries, in the rows with gaps
REACHED = 1e-3  # of the logarithm of the likelihood, that "statsmodels" may lack
TIGHT = dict(factr=10, pgtol=1e-9)


class Model(MLEModel):
    """The same model for statsmodels: deviations, or their logarithms, are sought."""

    def __init__(self, plant, y, logs):
        super().__init__(y, k_states=plant.n)
        self["design"], self["transition"] = plant.C, plant.A
        self["selection"] = np.eye(plant.n)
        self.ssm.initialize_diffuse()
        self.n, self.p, self.logs = plant.n, plant.p, logs
        self.rows = np.tril_indices(plant.p)
        self.diagonal = np.r_[np.ones(plant.n, bool), self.rows[0] == self.rows[1]]

    @property
    def param_names(self):
        return [f"s{k}" for k in range(len(self.diagonal))]

    @property
    def start_params(self):
        size = np.sqrt(np.nanmean(np.diff(self.endog, axis=0) ** 2, axis=0))
        begin = np.r_[np.full(self.n, size.max()), np.diag(size)[self.rows]]
        return self.turned(begin, np.log) if self.logs else begin

    def turned(self, params, function):
        params = np.array(params)
        params[self.diagonal] = function(params[self.diagonal])
        return params

    def update(self, params, **options):
        params = super().update(params, **options)
        if self.logs:
            params = self.turned(params, np.exp)
        half = np.zeros((self.p, self.p), dtype=params.dtype)
        half[self.rows] = params[self.n :]
        self["state_cov"] = np.diag(params[: self.n] ** 2)
        self["obs_cov"] = half @ half.T


def simulated(p, steps):
    """A plant of unknown noise and a record of it."""
    one = plant(3, p)
    rng = np.random.default_rng(1)
    Q, half = np.diag(np.diag(one.Q)), np.linalg.cholesky(one.R)
    x, y = np.zeros(3), np.empty((steps, p))
    for row in y:
        row[:] = one.C @ x + half @ rng.normal(size=p)
        x = one.A @ x + np.sqrt(Q.diagonal()) * rng.normal(size=3)
    return lb.Plant(one.A, None, one.C, dt=1.0), y


def with_gaps(y):
    """The record with some of its entries missing."""
    lost = np.random.default_rng(2).random(y.shape) < MISSING
    return np.where(lost, np.nan, y)


def contestants(one, y):
    """Each returns the logarithm of the likelihood that it reached."""

    def ours():
        return lb.fit_noise(one, y, Q="diagonal").log_likelihood

    def theirs(logs=False, **options):
        found = Model(one, y, logs).fit(disp=0, maxiter=500, **options)
        return found.llf + one.n / 2 * np.log(2 * np.pi)  # it counts n more factors

    found = {"numba": ours, "statsmodels": lambda: theirs(**TIGHT)}
    if np.isnan(y).any():
        return found
    return found | {
        "statsmodels, default": theirs,
        "statsmodels, logarithms": lambda: theirs(logs=True),
    }


def records(quick=False):
    """Rows for one output and for two, complete and with gaps; seconds a fit."""
    warnings.simplefilter("ignore")
    for p in OUTPUTS[: 1 if quick else None]:
        one, y = simulated(p, STEPS // (10 if quick else 1))
        rounds = 2 if quick else ROUNDS
        yield row("fit of noise, 10000 rows", one, y, rounds)
        name = f"fit of noise, 10000 rows, {MISSING:.0%} missing"
        yield row(name, one, with_gaps(y), 1 if quick else 2)


def row(name, one, y, rounds):
    """One row, if statsmodels arrives where we do."""
    runs = contestants(one, y)
    reached = {who: run() for who, run in runs.items()}
    best = reached["numba"]
    if not best >= max(reached.values()) - 1e-6:
        raise SystemExit(f"statsmodels climbs higher: {reached}")
    if not reached["statsmodels"] >= best - REACHED:
        raise SystemExit(f"statsmodels does not arrive: {reached}")
    for who in runs:
        print(f"  {who} lacks {best - reached[who]:.1e}", flush=True)
    times = in_turns(runs, rounds)
    return record(name, f"n = {one.n}, p = {one.p}", "s", times)


if __name__ == "__main__":
    for one in records("--quick" in sys.argv):
        print(line(one), flush=True)
