"""Error covariances from the start on, of the best design and of the chosen one."""

from collections.abc import Iterable, Mapping

import numpy as np

from ..analysis.error_covariance import error_covariance
from ..numeric import Matrix
from ..observer import Observer
from ..papers.leondes_novak.design import reduced_order_filter
from ..plant import Plant
from ..run.measurements import covariance_from_start
from .table import Comparison

SETTLED = 1e-3  # the time axis ends when transients are this small
LEAST, MOST = 10, 400  # steps that it shows


def transients(
    table: Comparison, steps: int | None = None
) -> tuple[dict[str, Matrix], list[str]]:
    """Error covariances of a comparison from the start on, and remarks on them.

    The Kalman filter and the recommended structure with the gains of each instant,
    from P0; and the recommended observer with its constant gain.

    Parameters
    ----------
    table : Comparison
    steps : int, optional
        Default until the slowest error has died away.

    Returns
    -------
    (dict of str to (steps + 1, q, q) ndarray, list of str)
        Covariances by label; and what is not shown, and why.
    """
    plant, chosen = table.plant, table.chosen
    if table.yardstick is None:
        return {}, ["Without noise in discrete time there is no error to follow."]
    if chosen is None:
        return {}, ["No design is within the budget, so there is none to follow."]
    if plant.P0 is None:
        return {}, ["The plant gives no P0, so there is no start to show."]
    steps = settling_steps(table) if steps is None else steps
    attempts = {
        "Kalman filter": lambda: _varying(table, (), steps),
        "recommended, gains of each instant": lambda: _varying(
            table, chosen.accurate, steps
        ),
        "recommended, constant gain": lambda: _from_start(
            chosen.observer, plant, steps
        ),
    }
    if not chosen.accurate:
        attempts.pop("recommended, gains of each instant")
    curves, remarks = {}, [f"{steps} steps from P0."]
    if chosen.disturbed:
        remarks.append("The known input begins at the first sample.")
    for name, attempt in attempts.items():
        try:
            curves[name] = attempt()
        except ValueError as error:
            remarks.append(f"Not shown: {name}. {error}")
    return curves, remarks


def from_start(
    observers: Mapping[str, Observer], plant: Plant, steps: int | None = None
) -> dict[str, Matrix]:
    """Error covariances from P0 on, by label; arrays among the observers stay.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[4]])
    >>> found = from_start({"Kalman": lb.kalman_filter(plant)}, plant, 2)
    >>> found["Kalman"][:, 0, 0].round(3)
    array([4.   , 0.722, 0.542])
    """
    constant = [
        one
        for one in observers.values()
        if isinstance(one, Observer) and one.steps is None
    ]
    steps = settling(_radius(constant)) if steps is None else steps
    return {
        label: _from_start(one, plant, steps) if isinstance(one, Observer) else one
        for label, one in observers.items()
    }


def _from_start(observer: Observer, plant: Plant, steps: int) -> Matrix:
    if observer.steps is not None:
        return error_covariance(observer, plant, steps=observer.steps)
    later = covariance_from_start(observer, plant, steps)
    return np.concatenate([[observer.L @ plant.P0 @ observer.L.T], later])


def _varying(table: Comparison, accurate: tuple[int, ...], steps: int) -> Matrix:
    observer = reduced_order_filter(table.plant, accurate, L=table.L, steps=steps)
    return error_covariance(observer, table.plant, steps=steps)


def settling_steps(table: Comparison) -> int:
    """How many steps show the start of a comparison."""
    shown = (table.yardstick, table.recommended())
    return settling(_radius([one.observer for one in shown if one is not None]))


def _radius(observers: Iterable[Observer]) -> float:
    return max((np.abs(o.poles).max(initial=0.0) for o in observers), default=0.0)


def settling(radius: float) -> int:
    """Steps until variances of errors with this slowest pole have died away."""
    if not 0 < radius < 1:
        return LEAST
    steps = np.ceil(np.log(SETTLED) / np.log(radius) / 2)
    return int(np.clip(steps, LEAST, MOST))
