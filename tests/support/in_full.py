"""Filter rows one by one, with covariances and gains: what designs over steps run."""

from types import SimpleNamespace

import numpy as np

from luenberger import kernels
from luenberger.recursion.filter_pass import Pass
from luenberger.recursion.settings import Settings
from luenberger.recursion.state import start


def in_full(plant, y, u=None, u0=None, m1=0, weight=None, backend="numpy", parts=None):
    """x, std, P and K of each row; `parts` are the rows at which the pass is parted."""
    y = np.array(y, dtype=float)
    u = np.zeros((len(y), plant.m)) if u is None else np.array(u, dtype=float)
    run = Pass(Settings(plant, m1, weight))
    state = start(run.settings, plant.x0, np.zeros(plant.m) if u0 is None else u0)
    fast, found = kernels.runs_compiled(backend, len(y)), []
    for rows in np.split(np.arange(len(y)), parts or []):
        state, out = run.over(state, y[rows], u[rows], fast)
        found.append(out)
    x, variances, P, K = map(np.concatenate, zip(*found))
    return SimpleNamespace(x=x, std=np.sqrt(np.maximum(variances, 0)), P=P, K=K)
