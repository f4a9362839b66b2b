"""Whether a record agrees with Q and R: the report's sentences and picture of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ..compare import Comparison
from ..compare.attempts import KALMAN, Attempt
from ..identification.whiteness import Whiteness, whiteness
from ..numeric import Matrix, Vector
from ..observer import Observer
from ..plant import Plant
from ..run.estimate import estimate
from ..run.filter import Filter
from ..run.measurements import Measurements
from ..run.record import Record
from ..show import Picture, Prose, number

LIMIT = 1.5  # times what is promised that predictions may miss by
LEAST = 20  # samples of which an autocorrelation says something


def judged(
    plant: Plant, data: Measurements | None, fitted: int = 0
) -> Whiteness | None:
    """The tests of a record's innovations; None without noises or without a record.

    `fitted` is how many numbers were fitted to this record, as in `whiteness`.
    """
    if data is None or plant.Q is None or plant.R is None or not plant.dt:
        return None
    if plant.multiplicative or len(data.y) - data.missing / plant.p < LEAST:
        return None
    try:
        record = Record(data.y, data.u if plant.m else None, "rows")
        return whiteness(Filter(plant).innovations(record), fitted)
    except ValueError:  # the record contradicts the plant, or does not tell the state
        return None


def agreement(
    found: Whiteness | None,
    table: Comparison | None = None,
    data: Measurements | None = None,
) -> Prose:
    """What the tests say of the model, and the record of the recommended observer."""
    if found is None:
        return Prose(
            f"Nothing was tested: this needs Q, R and {LEAST} samples that the plant "
            "can produce."
        )
    good = found.white and found.sized
    verdict = "agrees" if good else "does not agree"
    return Prose(
        *found.sentences,
        f"The record {verdict} with the model, the plant with its Q and R, as the "
        "innovations of its Kalman filter tell; no other observer is tested by that."
        + ("" if good else " One-sigma bounds are only as good as these are."),
        *_recommended(table, data),
    )


def _recommended(table: Comparison | None, data: Measurements | None) -> Iterator[str]:
    """How the recommended observer predicts the record, beside the Kalman filter."""
    if table is None or data is None or data.missing:
        return
    plant, chosen, kalman = table.plant, table.chosen, table.yardstick
    if chosen is None or kalman is None or kalman is chosen:
        return
    if kalman.method != KALMAN or not (chosen.whole and kalman.whole):
        return
    observers = chosen.observer, kalman.observer
    if observers[0] is None or observers[1] is None:
        return
    settled = max(chosen.settling, kalman.settling) / plant.dt
    first = int(min(np.ceil(settled), len(data.y) // 2))
    own, least = (_missed(one, plant, data)[first:] for one in observers if one)
    own, least = (np.sqrt((x**2).mean(axis=0)) for x in (own, least))
    promised = np.sqrt(_promised(chosen, plant))
    each = (
        f"{name} by {number(a, 4)} instead of {number(b, 4)} (promised {number(c, 4)})"
        for name, a, b, c in zip(plant.output_names, own, least, promised)
    )
    yield (
        "One sample ahead, the recommended observer misses, as a root mean square from "
        f"sample {first + 2} on and beside the Kalman filter, {'; '.join(each)}."
    )
    if (own > LIMIT * np.maximum(promised, least)).any():
        yield (
            "The recommended observer is worse on this record than its errors promise: "
            "do not take it, nor the bounds of its estimates, for this input."
        )


def _missed(observer: Observer, plant: Plant, data: Measurements) -> Matrix:
    """Readings from the second on, less what the estimates before predict of them."""
    x = estimate(observer, data.record, x0=plant.at_first_sample().x0)
    ahead = x[:-1] @ plant.A.T + data.u[:-1] @ plant.B.T
    missed: Matrix = data.y[1:] - ahead @ plant.C.T - data.u[1:] @ plant.E.T
    return missed


def _promised(one: Attempt, plant: Plant) -> Vector:
    """Variances of that, as the steady error of a design says."""
    Q, R, _ = plant.at(0).covariances()
    A, C = plant.A, plant.C
    found: Vector = (C @ (A @ one.covariance @ A.T + Q) @ C.T + R).diagonal()
    return found


def innovations(found: Whiteness | None, axes: Sequence[Any]) -> Prose | Picture:
    """The picture of `plot.innovations`."""
    if found is None:
        return Prose("No figure: there are no innovations to show.")
    first = found.autocorrelation[0].diagonal()
    return Picture(
        axes[0].figure,
        "Autocorrelations of the normalised innovations at "
        f"{len(found.autocorrelation)} lags, a curve for each output; "
        f"{number(first[0], 2)} at the first. The band of white ones is "
        f"{number(found.bound, 2)} to each side of zero.",
    )
