"""A plant's filter in C: the covariance as U D U', one output at a time.

Up to `FEW` states it is written as statements, else, or where outputs share noises
with the next state or are accurate and noisy, as the loops of `filtering.passes`.  Both
do the operations of `Filter`, in their order.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ...errors import DesignError
from ...filtering.maps import Settings
from ...filtering.pack import begin, over
from ...filtering.passes import FEW
from ...kernels.c.file import File
from ...numeric import Matrix
from ...numeric.factors import factor
from ...plant import Plant
from . import source_and_header
from .filter_few import Few
from .filter_functions import Functions
from .filter_loops import Loops
from .identifiers import quoted
from .observer import inputs
from .source_and_header import Module, Signals

LEAST = 3  # rows of a self-test
NUMBERS = re.compile(r"(?<![\w.])(?:\d+\.\d*(?:e[-+]?\d+)?|\d+e[-+]?\d+)")
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
    few = settings.way == "nothing" and plant.n <= FEW
    made: Functions = (Few if few else Loops)(settings, file)
    functions = made.functions()
    says = {
        "x": "x^ of this sample, or of the next before it is used",
        "met": "what the prediction is a sum of, in size",
        "D": "D of its error covariance U D U'",
        "V": "U above its diagonal of ones, column by column" if few
        else "U', row by row",
        "E": "columns of gains of the sample",
        "e": "their weights",
    }  # fmt: skip
    if made.sizes["x"] > plant.n:
        says["x"] += ", and noises that its outputs share"
    members = [(k, size, says[k]) for k, size in made.sizes.items() if size]
    if made.sizes.get("e"):
        members.append(("int seen", 1, "which outputs arrived"))
    constants = {x for text in functions[-3:] for x in NUMBERS.findall(text)}
    tables = sum(X.size for X in file.tables.values())
    u, y = _record(plant)
    begins, rows = begin(settings, np.zeros(plant.m)), len(y)
    while True:  # as many rows as have digits enough, where the plant runs away
        try:
            wanted = over(settings, begins, y[:rows], u[:rows]).x
            break
        except DesignError:
            rows //= 2
            if rows < LEAST:
                raise
    accurate = ", ".join(quoted(plant.output_names[k]) for k in settings.accurate)
    kind = f", {accurate} treated as exact." if accurate else " (Kalman)."
    return source_and_header.texts(
        Module(
            file,
            f"The filter of {plant.n} states{kind}",
            EQUATIONS,
            [],
            plant.dt,
            Signals(plant.input_names, plant.output_names, plant.state_names),
            members,
            made.uses,
            functions,
            len([x for x in constants if float(x) not in (0, 1)]) + tables,
            made.costs(functions),
            (u, y, wanted),
        )
    )


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
