"""The rows of a filter, of which those of one that has settled are one."""

from __future__ import annotations

import numpy as np

from .. import kernels
from ..numeric import Matrices, Matrix
from ..plant import Plant
from ..recursion.filter_pass import Pass
from ..recursion.growth import passed, require_digits
from ..recursion.settings import Settings
from ..recursion.state import State
from ..recursion.units import natural
from .derivation import driven, gain_of_prediction
from .predictions import filtered
from .stretch import Stretch
from .trail import Trail
from .ways import Ways

BLOCK = 128  # rows after which it is asked whether the filter still moves
STILL = 1e-12  # of the prediction's variances: what a settled filter moves by in a row
GONE = 1e-8  # of a change: what is left of it when a settled filter has forgotten it


def rows_of(
    settings: Settings, ways: Ways, state: State, y: Matrix, u: Matrix, fast: bool
) -> Stretch:
    """The rows of y (N, p), from the state before them.

    Of a constant plant and a record without gaps, rows between those in which the
    filter settles, and those at the end, are one row that stands for all.
    """
    N, plant, first = len(y), settings.plant, state.instant + 1
    trail, run = Trail.empty(plant, y, True), Pass(settings)
    even = plant.steps is None and ways.constant and bool(trail.free.all())
    done, last, tail, begin = 0, N, 0, state
    while done < last:
        here = slice(done, min(done + BLOCK, last) if even else last)
        out = trail.part(here)
        state = filtered(settings, out, state, y[here], u[here], fast)
        out.settled()
        done = here.stop
        if even and not tail and _still(out.Omega):
            tail = _forgets(settings, ways, _given(plant, out, first), N)
            even = done + 2 * tail < N
            last, tail = (done + tail, tail) if even else (N, 0)
    rows = passed(run, begin, y, u, trail.variances, fast)
    require_digits(None, rows)
    source = np.concatenate([np.arange(last), np.full(tail, last - 1)])
    middle = np.full(N - last - tail, last - 1)
    index = np.concatenate([np.arange(last), middle, last + np.arange(tail)])
    whole = trail.part(slice(last)) if tail else trail
    given = {
        name: X if len(X) == 1 else X[source]
        for name, X in _given(plant, whole, first).items()
    }
    changes = ways.rows(first, N)
    changes = {k: X if len(X) == 1 else X[source] for k, X in changes.items()}
    return Stretch(given, changes, len(source), u[:, None, :, None], index)


def _still(Omega: Matrix) -> bool:
    """Whether the covariance of the prediction has come to rest in the last rows."""
    if len(Omega) < 2:
        return False
    size = np.sqrt(Omega[-1].diagonal())
    moved = np.abs(Omega[-1] - Omega[-2])
    return bool((moved <= STILL * size * size[:, None]).all())


def _given(plant: Plant, trail: Trail, first: int) -> Matrices:
    """The plant and its filter in the rows of a trail, from the instant `first` on.

    Outputs that do not count have zeros in W and in the gain, which meet all else.
    """
    N, (n, p) = len(trail.free), (plant.n, plant.p)
    S = np.zeros((n, p)) if plant.S is None else plant.S
    given = dict(A=plant.A, B=plant.B, C=plant.C, E=plant.E, S=S)
    here = slice(first, first + N)
    given = {k: X[here] if X.ndim == 3 else X[None] for k, X in given.items()}
    given |= dict(Omega=trail.Omega, W=trail.W)
    gain = kernels.run(gain_of_prediction, given, "G", stacks=True)["G"]
    given["G"] = np.where(trail.compiled[:, None, None], gain, trail.G)
    return {name: X[:, None] for name, X in given.items()}


def _forgets(settings: Settings, ways: Ways, given: Matrices, N: int) -> int:
    """After how many rows a settled filter has forgotten a change; N, if too late.

    What is carried on are changes of the prediction and, where A or C moves, the
    prediction beside them.
    """
    states, _ = natural(settings.at(1))
    last = {name: X[-1] for name, X in (given | ways.rows(1, 1)).items()}
    found = kernels.run(driven, last, "F", "H", stacks=True)
    F, H = (X / states[:, None] * states for X in (found["F"], found["H"]))
    power = F
    if ways.moving:
        n, q = len(states), ways.count
        size = np.maximum(np.abs(H).max(axis=(1, 2), keepdims=True), 1e-300)
        power = np.zeros((q, 2 * n, 2 * n))
        power[:, :n, :n] = last["A"] / states[:, None] * states
        power[:, n:, :n], power[:, n:, n:] = H / size, F
    rows = 1
    while rows < N and not np.linalg.norm(power, axis=(1, 2)).max() <= GONE:
        with np.errstate(over="ignore", invalid="ignore"):
            power, rows = power @ power, 2 * rows
    return rows
