"""A plant's filter in C: the covariance as U D U', one output at a time.

Up to `FEW` states it is written as statements, else, or where outputs share noises
with each other or with the next state, as the loops of `filtering.passes`.  Both do
the operations of `Filter`, in their order.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ...errors import DesignError
from ...filtering.maps import Settings
from ...filtering.pack import begin, over
from ...kernels.c.file import File
from ...numeric import Matrix
from ...numeric.factors import factor
from ...plant import Plant
from . import source_and_header
from .filter_few import Few
from .filter_functions import Functions
from .filter_loops import Loops
from .filter_start import Start
from .identifiers import quoted
from .observer import inputs
from .selftest import selftest
from .source_and_header import Signals

LEAST = 3  # rows of a self-test
EQUATIONS = [
    "x- = A x^ + B u                     and its covariance U D U'         (43)",
    "K = P c' / (c P c' + r)             for one output c x after the other (33)",
    "x^ = x- + K (y - e u - c x-)        and its covariance (I - K c) P    (43)",
]


def texts(
    plant: Plant,
    m1: int | Sequence[int | str],
    weight: ArrayLike | str | None,
    name: str,
    real: str,
) -> dict[str, str]:
    """The two files of a plant's filter, by name."""
    if plant.steps is not None:
        raise DesignError(
            "the plant varies with time, and a device has no room for its matrices at "
            "every instant; give a constant plant"
        )
    if plant.p == 0:
        raise DesignError("the plant has no outputs, so there is nothing to filter")
    plant.at_first_sample()  # raises where it overflows
    settings, file = Settings(plant, m1, weight), File(name, real)
    start = Start(settings, real)
    made: Functions = (Few if start.few else Loops)(start, file)
    u, y = _record(plant)
    wanted = _found(settings, u, y)
    functions = made.functions()
    body = source_and_header.source(file, functions)
    body += "\n" + selftest(file, made.uses, u, y, wanted)
    accurate = ", ".join(quoted(plant.output_names[k]) for k in settings.accurate)
    head = source_and_header.header(
        file,
        f"The filter of {plant.n} states"
        + (f", {accurate} treated as exact." if accurate else " (Kalman)."),
        EQUATIONS,
        plant.dt,
        Signals(plant.input_names, plant.output_names, plant.state_names),
        made.members(),
        made.uses,
        _arguments(plant),
        made.notes(functions),
    )
    return source_and_header.stamped(name, head, body)


def _record(plant: Plant) -> tuple[Matrix, Matrix]:
    """Inputs and measurements for a self-test, which an exact output may see too."""
    u, y = inputs(plant.m, plant.p)
    rng, n = np.random.default_rng(8), plant.n
    S = np.zeros((n, plant.p)) if plant.S is None else plant.S
    H = factor(np.block([[plant.Q, S], [S.T, plant.R]]))
    first = factor(np.asarray(plant.P0))
    drawn = rng.uniform(-1, 1, (len(y) + 1, H.shape[1])) @ H.T
    x = plant.x0 + first @ rng.uniform(-1, 1, first.shape[1])
    x = x if plant.at_first else plant.A @ x + drawn[-1, :n]
    for k, noise in enumerate(drawn[:-1]):
        y[k] = plant.C @ x + plant.E @ u[k] + noise[n:]
        x = plant.A @ x + plant.B @ u[k] + noise[:n]
    y[4::5, 0], y[7::9] = np.nan, np.nan  # one missing, all missing
    return u, y


def _found(settings: Settings, u: Matrix, y: Matrix) -> Matrix:
    """Estimates of as many rows as have digits enough, where the plant runs away."""
    begins, rows = begin(settings, np.zeros(settings.plant.m)), len(y)
    while True:
        try:
            return over(settings, begins, y[:rows], u[:rows]).x
        except DesignError:
            rows //= 2
            if rows < LEAST:
                raise


def _arguments(plant: Plant) -> dict[str, list[str]]:
    """What the arguments of all functions are."""
    early = ["and, in an estimate, at its own instant"] * bool(plant.E.any())
    return {
        "x0": ["the state at the first sample, before it is used; NULL: that of the",
               "plant's data"],
        "sigma0": ["its standard deviations, 0 of what is known exactly; NULL: with",
                   "the covariance of the plant's data"],
        "u": ["known inputs, which act from this sample to the next", *early],
        "y": ["measurements of this sample; NaN: not measured, the others are used"],
        "what": ["the estimate, written by an estimate"],
        "variances": ["of the errors of the state's estimates, written"],
    }  # fmt: skip
