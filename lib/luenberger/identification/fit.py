"""Noise covariances and unknown parameters of a plant, fitted to records."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from ..arguments import expect
from ..errors import DesignError, short
from ..numeric import Matrices, Matrix, Vector
from ..numeric.detectability import require_detectable
from ..numeric.validation import matrix
from ..plant import Plant
from ..recursion.settings import require_noise
from ..run.executor import Progress, reporting
from . import records as recorded
from .autocovariance import ROUNDS
from .held import held, said
from .identifiability import Identifiability, identifiability
from .noise_fit import NoiseFit, found
from .parameters import parameters_of
from .search import Likelihood, least
from .starts import start_of
from .unknowns import Unknowns

BUDGET = 400  # evaluations that a search takes about, for a bar
BEGINNING = 2  # gains of the autocovariances that a search begins from
STRETCHES = 10  # without gaps, from which a search begins
NOTHING = 1e-12  # of a record: noise below it is rounding
METHODS = ("likelihood", "autocovariance")


def fit_noise(
    plant: Plant,
    y: Any,
    u: Any = None,
    *,
    Q: Any = "full",
    R: Any = "full",
    S: Any = 0,
    method: str = "likelihood",
    parameters: Any = None,
    start: Any = None,
    unidentifiable: str = "refuse",
    progress: Progress = False,
) -> NoiseFit:
    """Find the noise covariances of a plant, and unknown entries, from records.

    The most likely Q and R: those that make the record most probable, as
    `Filter.log_likelihood` says.  First it is asked what a record could tell at all, by
    `identifiability`; a request for more is refused, with the direction that nothing
    determines.

    Parameters
    ----------
    plant : Plant
        Discrete.  Its P0, if it has one, is that of each record's start; without P0
        the start is unknown.  What it says of Q and R is not used, unless they are
        None below.
    y : (N, p) array_like or DataFrame, or a list of them
        One record, or several of the same plant; NaN means not measured.  With one
        output a record may also be (N,).
    u : (N, m) array_like, or a list of them, optional
        Known inputs, default zero.
    Q, R : "full", "diagonal", "scaled", (., k) array_like, callable or None
        What is sought: every entry; the diagonal; the plant's own times a number; q
        in Q = G diag(q) G' for a matrix G; or the positive numbers q of a function
        that returns the covariance.  None keeps the plant's own.  Default "full".
    S : 0, None or (n, p) array_like, default 0
        Known, and not fitted; None is the plant's own.  `identifiability` says what a
        record could tell of S as well.
    method : "likelihood" or "autocovariance"
        Autocovariance least squares is faster and needs no search; its errors are
        larger, and it fits constant plants without unknown parameters.
    parameters : dict or (callable, dict), optional
        Unknown entries such as ``{"B[1,0]": 4.0}``, counted from 0, with where to
        begin; or a function of their vector that returns the Plant, with names and
        where to begin: ``(made, {"g": 4.0, "offset": 0.0})``.
    start : dict, optional
        ``{"Q": ..., "R": ...}``: where to begin; for a function, its q.
    unidentifiable : "refuse" or "fix", default "refuse"
        What to do where no record could determine all that is asked for: refuse, or
        keep each combination that leaves no trace where the search begins.  That is
        `start`; without it, where the sizes and autocovariances of the record put it.
        The sentences are in `unidentifiable` of the fit.
    progress : bool or callable, default False
        As in `monte_carlo`.

    Returns
    -------
    NoiseFit

    Raises
    ------
    DesignError
        If a record, however long, could not determine all that is asked for, unless
        it is fixed; if this one is too short, constant or fitted without any noise; if
        S is too large for Q and R; if the plant is continuous or not detectable; or if
        its states grow too far in a gap, as in `Filter.run`.
    ValueError
        If sizes disagree, or Q, R, S, method, parameters or start is none of these.

    See Also
    --------
    identifiability, Filter

    References
    ----------
    Mehra (1970); Odelson, Rajamani and Rawlings (2006); Durbin and Koopman (2012),
    "Time series analysis by state space methods", chapter 7;
    identification/derivation/.

    Examples
    --------
    >>> import numpy as np, luenberger as lb
    >>> rng = np.random.default_rng(8)
    >>> level = np.cumsum(rng.normal(size=500))         # Q = 1
    >>> y = level + 3 * rng.normal(size=500)            # R = 9
    >>> plant = lb.Plant([[1]], None, [[1]], dt=1.0)    # a level that walks
    >>> fit = lb.fit_noise(plant, y)
    >>> fit.plant.Q.round(1), fit.plant.R.round(1)
    (array([[0.9]]), array([[9.4]]))
    >>> fit.lines[-1]  # before it each number with its error, as `fit` prints them
    'log-likelihood -1346.14'
    """
    expect(plant=plant)
    if not isinstance(method, str) or method not in METHODS:
        raise ValueError(f"method must be one of {METHODS}, got {short(method)}")
    data = recorded.read(plant, y, u)
    begin = _begin(start)
    S = _known(plant, S)
    _require_fit(plant)
    recorded.require_measured(plant, data)
    more = parameters_of(plant, parameters)
    first = more.plant(np.array(more.begin, dtype=float))
    seen = None if len(data) != 1 else ~np.isnan(data[0][0])
    told = identifiability(first, Q=Q, R=R, start=begin, seen=seen)
    fixed = _fixed(unidentifiable, told, method)
    recorded.require_enough(plant, data, told.determined + len(more.names))
    alone = method == "autocovariance"
    effort = (ROUNDS, None) if alone else (BEGINNING, STRETCHES)
    unknowns, theta, squares = start_of(first, data, Q, R, S, begin, more, *effort)
    likelihood = Likelihood(unknowns, data)
    if alone:
        return _by_squares(unknowns, squares, likelihood)
    unknowns.plant(theta)  # which refuses an S that is too large
    with reporting(progress, BUDGET, "pass") as report:
        objective = held(likelihood.per_reading, unknowns, fixed, theta)
        theta = least(objective, theta, report)
    _require_noise_left(unknowns, theta, data)
    fit = found(unknowns, theta, likelihood)
    return said(fit, told) if fixed else fit


def _fixed(wanted: str, told: Identifiability, method: str) -> tuple[Matrices, ...]:
    """The directions that are kept where the search begins."""
    if not isinstance(wanted, str) or wanted not in ("refuse", "fix"):
        raise ValueError(
            f"unidentifiable must be 'refuse' or 'fix', got {short(wanted)}"
        )
    if wanted == "refuse" or not told.directions:
        told.require()
        return ()
    if method != "likelihood":
        raise DesignError(
            "unidentifiable='fix' keeps what no record determines where a search "
            f"begins, and method={method!r} has none. Use method='likelihood'"
        )
    return told.directions


def _begin(start: Any) -> dict[str, Any]:
    """The start, checked as far as its names go."""
    if start is None:
        return {}
    if not isinstance(start, dict) or set(start) - {"Q", "R"}:
        raise ValueError(
            f"start must be a dict with 'Q' and 'R', each where to begin; got "
            f"{short(start)}. Parameters have their start in `parameters`"
        )
    return start


def _known(plant: Plant, S: Any) -> Matrix | None:
    """S as it is known; None where it is zero."""
    if S is None:
        return plant.S
    if np.isscalar(S) and S == 0:
        return None
    if np.ndim(S) != 2:
        raise ValueError(
            f"S must be 0, None for the plant's own, or the known covariance E[w v'], "
            f"{plant.n} x {plant.p}; it is not fitted. Got {short(S)}"
        )
    return matrix("S", S, plant.n, plant.p)


def _require_fit(plant: Plant) -> None:
    """Refuse plants that no filter of this kind is for."""
    noise: dict[str, Any] = dict(Q=np.eye(plant.n), R=np.eye(plant.p), S=None)
    require_noise(dataclasses.replace(plant, **noise))
    if plant.steps is None:
        require_detectable(plant.A, plant.C)


def _by_squares(unknowns: Unknowns, squares: Any, likelihood: Likelihood) -> NoiseFit:
    """The fit of autocovariance least squares alone."""
    if squares is None or unknowns.parameters.names:
        raise DesignError(
            "autocovariances are those of a constant plant, without unknown "
            "parameters, and need stretches of the record without gaps; use "
            "method='likelihood'"
        )
    return found(unknowns, squares.theta, likelihood, squares.covariance)


def _require_noise_left(
    unknowns: Unknowns, theta: Vector, data: recorded.Records
) -> None:
    """Refuse a fit whose likelihood grows without bound, as the noise vanishes."""
    plant = unknowns.plant(theta)
    for y, _ in data:
        size = np.where(np.isnan(y), 0.0, np.abs(y)).max(axis=0, initial=0)
        Q, R, _ = plant.at(0).covariances()
        shown = np.abs(plant.at(0).C) @ np.sqrt(Q.diagonal())
        total = shown + np.sqrt(R.diagonal())
        if (total <= NOTHING * size).any():
            j = int(np.flatnonzero(total <= NOTHING * size)[0])
            raise DesignError(
                f"the plant reproduces output {plant.output_names[j]!r} without any "
                "noise, so its likelihood has no greatest value. Keep the noise that "
                "you know (Q=None or R=None), or give a record of the real plant"
            )
