"""A table of design problems: every design on every plant, here or on many workers."""

import pickle
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from contextlib import closing
from dataclasses import dataclass

import numpy as np

from ..analysis.error_covariance import error_covariance
from ..arguments import expect_as
from ..certificate import certify
from ..observer import Observer
from ..plant import Plant
from ..run.executor import Progress, in_order, reporting
from ..show import Table, number


@dataclass(frozen=True, eq=False)
class Trial:
    """One design on one plant, or the reason why there is none.

    Attributes
    ----------
    design, plant : str
        Names, as given to `sweep`.
    observer : Observer or None
    order : int or None
    trace : float or None
        Of the error covariance: the steady one, or at the last step of a filter over
        steps.  None where the plant has no noise to make an error of.
    residual : float or None
        The largest residual of the certificate on this plant.
    refusal : str
        Why there is no observer, or none with a finite error; empty otherwise.
    """

    design: str
    plant: str
    observer: Observer | None = None
    order: int | None = None
    trace: float | None = None
    residual: float | None = None
    refusal: str = ""


@dataclass(frozen=True, eq=False)
class Sweep:
    """All trials, plant by plant, in the order in which they were given.

    In a notebook it shows as a table.
    """

    trials: tuple

    def __iter__(self) -> Iterator[Trial]:
        return iter(self.trials)

    def __len__(self) -> int:
        return len(self.trials)

    def find(self, design: str, plant: str) -> Trial:
        """The trial of a design on a plant, by their names."""
        for one in self.trials:
            if (one.design, one.plant) == (design, plant):
                return one
        raise KeyError(f"no trial of {design!r} on {plant!r}")

    def best(self, plant: str) -> Trial:
        """The trial of least error trace on a plant; of equal ones the first."""
        fit = [t for t in self.trials if t.plant == plant and t.trace is not None]
        if not fit:
            raise KeyError(f"no trial on {plant!r} has an error trace")
        return min(fit, key=lambda one: one.trace)

    @property
    def table(self) -> Table:
        """A `show.Table` of plant, design, order, error trace and refusal."""
        rows = [
            (t.plant, t.design, _text(t.order), _text(t.trace, 4), t.refusal)
            for t in self.trials
        ]
        return Table(["plant", "design", "order", "error trace", "refused"], rows)

    def __repr__(self) -> str:
        return repr(self.table)

    def _repr_html_(self) -> str:
        return self.table._repr_html_()


Design = Callable[[Plant], Observer]


def sweep(
    designs: Mapping[str, Design],
    plants: Mapping[str, Plant],
    *,
    executor: Executor | None = None,
    progress: Progress = False,
) -> Sweep:
    """Try every design on every plant.

    Parameters
    ----------
    designs : dict of str to callable
        Functions of a plant that return an observer, such as `kalman_filter`, or
        ``functools.partial(reduced_order_filter, m1=1)``.  For an executor with
        processes they must be importable there: no lambdas, except on a Dask cluster.
    plants : dict of str to Plant
    executor : concurrent.futures.Executor, optional
        Where the trials are made, as in `monte_carlo`.
    progress : bool or callable, default False
        True shows a bar (needs tqdm); a function is called with (trials done, all).

    Returns
    -------
    Sweep
        The same for any executor, plant by plant, in the order given.  A design that
        refuses a plant (DesignError or another ValueError) is listed with its reason.

    Raises
    ------
    ValueError
        If there is nothing to try, or something cannot be sent to another process.
    BrokenExecutor
        If a worker died and its pool does not replace it.

    Any other error of a design ends the sweep, with a note that says which it was.

    Examples
    --------
    >>> import luenberger as lb
    >>> noise = dict(dt=1.0, Q=[[0, 0], [0, 1]], R=[[1]])
    >>> cart = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], **noise)
    >>> deaf = lb.Plant([[1, 1], [0, 1]], None, [[0, 1]], **noise)
    >>> found = lb.sweep({"Kalman": lb.kalman_filter}, {"cart": cart, "deaf": deaf})
    >>> [(t.plant, t.order, t.refusal[:13]) for t in found]
    [('cart', 2, ''), ('deaf', None, 'not detectabl')]
    """
    for what, given in (("designs", designs), ("plants", plants)):
        if not isinstance(given, Mapping):
            raise ValueError(
                f"{what} must be a dict, by name, got {type(given).__name__}"
            )
    if not designs or not plants:
        raise ValueError("a sweep needs at least one design and one plant")
    for name, design in designs.items():
        if not callable(design):
            raise ValueError(
                f"design {name!r} must be a function of a plant, got {design!r}"
            )
    for name, plant in plants.items():
        expect_as(f"plants[{name!r}]", "plant", plant)
    jobs = [
        (name, design, of, plant)
        for of, plant in plants.items()
        for name, design in designs.items()
    ]
    _require_sendable(designs, executor)
    trials, made = [], in_order(_trial, jobs, executor)
    with reporting(progress, len(jobs), "trial") as report, closing(made):
        for trial in made:
            trials.append(trial)
            report(len(trials))
    return Sweep(tuple(trials))


def _trial(job: tuple[str, Design, str, Plant]) -> Trial:
    name, design, of, plant = job
    try:
        observer = design(plant)
        if not isinstance(observer, Observer):
            raise TypeError(f"a design must return an Observer, got {observer!r}")
        residual = certify(observer, plant).worst
        trace = _trace(observer, plant)
    except ValueError as refusal:  # DesignError and CertificateError too
        return Trial(name, of, refusal=str(refusal))
    except Exception as error:
        error.add_note(f"in design {name!r} on plant {of!r}")
        raise
    return Trial(name, of, observer, observer.order, trace, residual)


def _trace(observer: Observer, plant: Plant) -> float | None:
    if plant.dt == 0 or plant.Q is None or plant.R is None:
        return None
    if observer.steps is None:
        return float(np.trace(error_covariance(observer, plant)))
    if plant.P0 is None:
        return None
    return float(np.trace(error_covariance(observer, plant, steps=observer.steps)[-1]))


def _require_sendable(designs: Mapping[str, Design], executor: Executor | None) -> None:
    """A pool of processes pickles what it sends; say which design it cannot send."""
    if executor is None:
        return
    from concurrent.futures import ProcessPoolExecutor

    if not isinstance(executor, ProcessPoolExecutor):
        return
    for name, design in designs.items():
        try:
            pickle.dumps(design)
        except (pickle.PicklingError, AttributeError, TypeError):
            raise ValueError(
                f"design {name!r} cannot be sent to another process. Define it with "
                "def in a module that can be imported, or use functools.partial of "
                "such a function."
            ) from None


def _text(value: float | None, digits: int = 6) -> str:
    return "" if value is None else number(value, digits)
