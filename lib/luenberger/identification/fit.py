"""Noise covariances and unknown parameters of a plant, fitted to records."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ..arguments import expect
from ..errors import DesignError, short
from ..filtering.likelihood import normalised, value
from ..numeric import Matrix
from ..numeric.detectability import require_detectable
from ..numeric.validation import matrix
from ..plant import Plant
from ..recursion.settings import require_noise
from ..run.executor import Progress, reporting
from ..run.filter import Filter
from ..show.blocks import counted
from ..show.tables import Prose, Table
from . import records as recorded
from .autocovariance import start_of
from .identifiability import identifiability
from .parameters import parameters_of
from .search import NONE, Likelihood, least
from .standard_errors import errors, face, spread_of
from .whiteness import Whiteness, whiteness

BUDGET = 30  # evaluations that a search takes about, for a bar
NOTHING = 1e-12  # of a record: noise below it is rounding
LOSS = 1e-3  # in the logarithm of the likelihood, that a variance of zero may cost
METHODS = ("likelihood", "autocovariance")
FORMS = (("full", "full"), ("diagonal", "full"), ("diagonal", "diagonal"))


@dataclass(frozen=True, eq=False, repr=False)
class NoiseFit:
    """The most likely noise of a plant, as `fit_noise` returns it.

    Attributes
    ----------
    plant : Plant
        The plant with the Q, R and S that were found, and the parameters.
    log_likelihood : float
        Of all records together.
    parameters : dict of str to float
        {name: value} of the unknown parameters, and of the numbers q of a form.
    standard_errors : dict
        {"Q": (n, n), "R": (p, p), and each name in `parameters`: float}: one standard
        error each, from the curvature of the likelihood.  Zero for what was known;
        infinite for what this record does not determine; NaN for a variance at its
        bound, zero, where the error is not normal and has none.  The errors beside
        such a variance are those that hold without the bound: at a bound estimates
        vary less, so that two errors hold the truth more often than 95 times in a
        hundred.
    unidentifiable : list of str
        What the record left open, in words.
    innovations : (N, p) ndarray, or a list of them
        Normalised: of variance one and uncorrelated, if the model is right.  NaN
        where nothing was measured, or not yet enough to predict it.
    whiteness : Whiteness
        The test of that.

    Printed, it is every number with its standard error, and what the tests say.
    """

    plant: Plant
    log_likelihood: float
    parameters: dict[str, float]
    standard_errors: dict[str, Any]
    unidentifiable: list[str]
    innovations: Any
    whiteness: Whiteness

    @property
    def lines(self) -> list[str]:
        """Every number that was found with its standard error, a line each."""
        found = [f"{name:<10} {said}" for name, *_, said in self._found()]
        return [*found, f"log-likelihood {self.log_likelihood:.2f}"]

    def _found(self) -> list[tuple[str, str, str, str]]:
        """Name, value and standard error, and both in words, of all that was found."""
        out = []
        for letter in "QR":
            X, error = getattr(self.plant, letter), self.standard_errors[letter]
            for i, j in zip(*np.triu_indices(len(X)), strict=True):
                if error[i, j] != 0:
                    out.append(_told(f"{letter}[{i},{j}]", X[i, j], error[i, j]))
        for name, found in self.parameters.items():
            out.append(_told(name, found, self.standard_errors[name]))
        return out

    def _about(self) -> list[str]:
        """What was known, and what the tests say."""
        known = sum(
            int((self.standard_errors[letter][np.triu_indices(size)] == 0).sum())
            for letter, size in (("Q", self.plant.n), ("R", self.plant.p))
        )
        said = [f"Known of Q and R: {counted(known, 'number')}."]
        return said * bool(known) + [*self.unidentifiable, *self.whiteness.sentences]

    def __repr__(self) -> str:
        return "\n".join([*self.lines, *self._about()])

    def _repr_html_(self) -> str:
        table = Table(
            ["", "value", "standard error"], [cells[:3] for cells in self._found()]
        )
        likely = f"log-likelihood {self.log_likelihood:.2f}"
        return Prose(likely, *self._about())._repr_html_() + "\n" + table._repr_html_()


def _told(name: str, value: float, error: float) -> tuple[str, str, str, str]:
    """Name, value and standard error, and the last two in words."""
    shown = f"{value:.5g}"
    if error == math.inf:
        return name, shown, "not determined", f"{shown}, not determined by this record"
    if math.isnan(error):
        return name, shown, "at its bound", f"{shown}, at its bound"
    return name, shown, f"{error:.2g}", f"{shown}, standard error {error:.2g}"


def fit_noise(
    plant: Plant,
    record: Any,
    *,
    Q: Any = "full",
    R: Any = "full",
    S: Any = 0,
    method: str = "likelihood",
    parameters: Any = None,
    start: Any = None,
    progress: Progress = False,
) -> NoiseFit:
    """Find the noise covariances of a plant, and unknown entries, from records.

    >>> import numpy as np, luenberger as lb
    >>> rng = np.random.default_rng(8)
    >>> y = np.cumsum(rng.normal(size=500)) + 3 * rng.normal(size=500)  # Q = 1, R = 9
    >>> fit = lb.fit_noise(lb.Plant([[1]], None, [[1]], dt=1.0), y)
    >>> fit.plant.Q.round(1), fit.plant.R.round(1), round(fit.log_likelihood, 2)
    (array([[0.9]]), array([[9.4]]), -1346.14)

    The most likely Q and R: those that make the record most probable, as
    `Filter.log_likelihood` says.  What no record could determine is refused, with the
    direction that nothing determines, as `identifiability` says it.

    Parameters
    ----------
    plant : Plant
        Discrete.  Without P0 the start of each record is unknown.  Its Q and R are not
        used, unless they are None below.
    record : Record, or what one is made of
        Of one run or several; NaN means not measured.
    Q, R : "full", "diagonal", "scaled", (., k) array_like, callable or None
        What is sought: every entry; the diagonal; the plant's own times a number; q
        in Q = G diag(q) G' for a matrix G; or the positive numbers q of a function
        that returns the covariance.  None keeps the plant's own.  Default "full".
    S : 0, None or (n, p) array_like, default 0
        Known, and not fitted; None is the plant's own.
    method : "likelihood" or "autocovariance"
        Autocovariance least squares needs no search; its errors are larger, and it
        fits constant plants without unknown parameters.
    parameters : dict or (callable, dict), optional
        Unknown entries such as ``{"B[1,0]": 4.0}``, counted from 0, with where to
        begin; or a function of their vector that returns the Plant, with names and
        where to begin: ``(made, {"g": 4.0, "offset": 0.0})``.
    start : dict, optional
        ``{"Q": ..., "R": ...}``: where to begin; for a function, its q.
    progress : bool or callable, default False
        As in `monte_carlo`.

    Raises
    ------
    DesignError
        If a record, however long, could not determine all that is asked for; if this
        one is too short, constant or fitted without any noise; if S is too large; if
        the plant is continuous or not detectable; or as from `Filter.run`.
    ValueError
        If sizes disagree, or Q, R, S, method, parameters or start is none of these.

    References
    ----------
    Durbin and Koopman (2012), chapter 7; Mehra (1970); identification/derivation/.
    """
    expect(plant=plant)
    if not isinstance(method, str) or method not in METHODS:
        raise ValueError(f"method must be one of {METHODS}, got {short(method)}")
    if start is not None and (not isinstance(start, dict) or set(start) - {"Q", "R"}):
        raise ValueError(
            f"start must be a dict with 'Q' and 'R', each where to begin; got "
            f"{short(start)}. Parameters have their start in `parameters`"
        )
    begin, alone, S = start or {}, method != METHODS[0], _known(plant, S)
    noise: dict[str, Any] = dict(Q=np.eye(plant.n), R=np.eye(plant.p), S=None)
    require_noise(dataclasses.replace(plant, **noise))
    data = recorded.read(plant, record)
    if plant.steps is None:
        require_detectable(plant.A, plant.C)
    recorded.require_measured(plant, data)
    more = parameters_of(plant, parameters)
    first = more.plant(np.array(more.begin, dtype=float))
    seen = None if len(data) != 1 else ~np.isnan(data[0].y)
    told = identifiability(first, Q=Q, R=R, start=begin, seen=seen)
    told.require()
    recorded.require_enough(plant, data, told.determined + len(more.names))
    found = start_of(
        first, [(rows.y, rows.u) for rows in data], Q, R, S, begin, more, alone
    )
    theta = found.theta
    likelihood = Likelihood(found.unknowns, data, theta)
    if alone:
        if found.squares is None or more.names:
            raise DesignError(
                "autocovariances are those of a constant plant, without unknown "
                "parameters, and need stretches of the record without gaps; use "
                "method='likelihood'"
            )
        return _found(likelihood, found.squares, found.spread)
    with reporting(progress, BUDGET, "pass") as report:
        information = likelihood.information(theta, found.information)
        theta = least(likelihood.per_reading, theta, information, report)
    _require_noise_left(likelihood, theta, data)
    return _found(likelihood, theta)


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


def _require_noise_left(
    likelihood: Likelihood, theta: Matrix, data: recorded.Records
) -> None:
    """Refuse a fit whose likelihood grows without bound, as the noise vanishes."""
    unknowns = likelihood.unknowns
    plant = likelihood.plant(unknowns.noises(theta), unknowns.split(theta)[2])
    for y in (rows.y for rows in data):
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


def _found(
    likelihood: Likelihood, theta: Matrix, spread: Matrix | None = None
) -> NoiseFit:
    """The `NoiseFit` at a vector.

    `spread` is the covariance of the unknowns there, by default from the curvature of
    the likelihood.
    """
    unknowns, (q, r, values) = likelihood.unknowns, likelihood.unknowns.split(theta)
    noises, error = unknowns.noises(theta), None
    if alone := spread is not None:
        best = likelihood.of(noises, values)
    else:
        spread, best = spread_of(unknowns, theta, likelihood, noises)
        error = np.sqrt(np.maximum(spread.diagonal(), 0))

    def likely(name: str, X: Matrix) -> bool:
        try:
            return likelihood.of(noises | {name: X}, values) >= best - LOSS
        except NONE:
            return False

    faces = {}
    for name, form, part, where in (
        ("Q", unknowns.Q, q, slice(len(q))),
        ("R", unknowns.R, r, slice(len(q), len(q) + len(r))),
    ):
        own = None if error is None else error[where]
        faces[name] = face(form, part, partial(likely, name), own)
        noises = noises | {name: faces[name].X}
    sentences = [said for one in faces.values() for said in one.sentences]
    if sentences and not alone:
        spread = spread_of(unknowns, theta, likelihood, noises)[0]
    plant = likelihood.plant(noises, values, checked=True)
    passed = [Filter(plant).passed(rows, "values") for rows in likelihood.rows]
    left = [normalised(one) for one in passed]
    gap = np.full((1, plant.p), np.nan)  # between two records
    joined = np.concatenate([part for one in left for part in (one, gap)][:-1])
    beyond = max(unknowns.count - plant.p * (plant.p + 1) // 2, 0)
    named = dict(zip(unknowns.parameters.names, values.tolist()))
    return NoiseFit(
        plant, sum(value(one, plant) for one in passed),
        faces["Q"].values | faces["R"].values | named,
        errors(unknowns, theta, spread, faces), sentences,
        left[0] if len(left) == 1 else left, whiteness(joined, beyond),
    )  # fmt: skip


def lacking(plant: Plant) -> list[str]:
    """Which of Q and R the plant does not give."""
    return [name for name in "QR" if getattr(plant, name) is None]


def fit_missing(plant: Plant, record: Any) -> tuple[NoiseFit, list[str]]:
    """Fit Q and R where the plant has none, and say what was fitted, in sentences.

    Every entry is sought if a record can determine that, else the diagonal.  Raises a
    DesignError as `fit_noise`; also if not even diagonals can be determined.
    """
    missing, why = lacking(plant), ()
    seen = np.concatenate([~np.isnan(one.y) for one in recorded.read(plant, record)])
    forms = [{"Q": Q if "Q" in missing else None, "R": R if "R" in missing else None}
             for Q, R in FORMS]  # fmt: skip
    for wanted in forms:
        told = identifiability(plant, **wanted, seen=seen)
        if not told.sentences:
            break
        why = why or told.sentences
    told.require()
    verb = "was" if len(missing) == 1 else "were"
    said = [
        f"{' and '.join(missing)} {verb} missing and {verb} fitted to the record by "
        "maximum likelihood."
    ]
    narrow = [name for name in missing if wanted[name] != forms[0][name]]
    if narrow:
        said.append(
            f"{' and '.join(narrow)} was sought as a diagonal matrix, because no "
            f"record of this plant determines {why[0]}"
        )
    return fit_noise(plant, record, Q=wanted["Q"], R=wanted["R"]), said
