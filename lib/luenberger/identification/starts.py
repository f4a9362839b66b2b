"""Where a search begins: sizes of noise in a record, and autocovariances of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import CertificateError, DesignError
from ..numeric import Matrix, Vector
from ..numeric.covariances import covariance
from ..numeric.independent_rows import default_tol, in_even_units
from ..plant import Plant
from .autocovariance import Fitted, by_autocovariances, noise_of_size_one
from .forms import Form, Of, form_of
from .parameters import Parameters
from .records import Records, complete_stretches
from .unknowns import Unknowns

SHARE = 0.3  # of the noise seen in the outputs, at each state, to begin with
LIFT = 0.1  # of the noise to begin with, added to what autocovariances tell
LEAST_ROWS = 10  # of a stretch, for each state, for autocovariances


@dataclass(frozen=True, eq=False)
class InUnits:
    """A form of a covariance in other units: X / unit / unit'."""

    form: Form
    unit: np.ndarray

    @property
    def known(self) -> Matrix:
        """What is known of it, in these units."""
        return self._scaled(self.form.known)

    @property
    def count(self) -> int:
        """Numbers that are free."""
        return self.form.count

    def matrix(self, theta: Vector) -> Matrix:
        """The covariance at a vector."""
        return self._scaled(self.form.matrix(theta))

    def slopes(self, theta: Vector) -> Matrix:
        """Its derivative there."""
        return self._scaled(self.form.slopes(theta))

    def _scaled(self, X: Matrix) -> Matrix:
        return X / self.unit / self.unit[:, None]


def start_of(
    plant: Plant, data: Records, Q: Any, R: Any, S: Matrix | None,
    begin: dict[str, Any], parameters: Parameters, rounds: int, most: int | None = None,
) -> tuple[Unknowns, Vector, Fitted | None]:  # fmt: skip
    """What is unknown, where to begin, and the fit of autocovariances if there is one.

    Parameters
    ----------
    plant : Plant
        At the start of the parameters.
    data : list of (y, u)
    Q, R, S, begin, parameters
        As in `fit_noise`, checked.
    rounds : int
        Gains of the autocovariances.
    most : int, optional
        Stretches without gaps that these are taken from, the longest; default all.
    """
    now = plant.at(0)
    pair, _ = in_even_units(now.A, now.C, 1.0, default_tol(plant.n))
    x, y = pair.states, pair.outputs
    stretches = complete_stretches(data, LEAST_ROWS * (plant.n + 1))
    stretches = sorted(stretches, key=lambda pair: -len(pair[0]))[:most]
    even, size, gain = None, _steps(data) / y, None
    if plant.steps is None and stretches:
        even = Plant(pair.A, plant.B / x[:, None], pair.C, plant.E / y[:, None], dt=1.0)
        stretches = [(one / y, u) for one, u in stretches]
        try:
            size, gain = noise_of_size_one(even, stretches)
        except (CertificateError, DesignError):
            even = None
    size = np.where(size > 0, size, size.max())
    units = SHARE * size.max() * x, size * y
    forms = [
        form_of(letter, wanted, len(unit), given, begin.get(letter), unit)
        for letter, wanted, given, unit in zip("QR", (Q, R), (now.Q, now.R), units)
    ]
    unknowns = Unknowns(forms[0], forms[1], S, parameters)
    theta = [_begin(form, begin, unit) for form, unit in zip(forms, units)]
    squares = None
    if even is not None and gain is not None and forms[0].count + forms[1].count:
        cross = None if S is None else S / x[:, None] / y
        both, first = (
            (InUnits(forms[0], x), InUnits(forms[1], y)),
            np.concatenate(theta),
        )
        try:
            with np.errstate(all="ignore"):  # of an S that is too large
                squares = by_autocovariances(
                    even, *both, cross, first, gain, stretches, rounds
                )
        except (CertificateError, DesignError, np.linalg.LinAlgError):
            squares = None
    if squares is not None and not set(begin) & {"Q", "R"}:
        theta = _from_squares(forms, squares, units)
    return unknowns, np.concatenate([*theta, np.zeros(len(parameters.names))]), squares


def _from_squares(
    forms: list[Form], squares: Fitted, units: tuple[Vector, Vector]
) -> list[Vector]:
    """The start of both forms near what the autocovariances tell."""
    q = forms[0].count
    parts = squares.theta[:q], squares.theta[q:]
    return [
        _lifted(form, form.matrix(part), unit, part)
        for form, part, unit in zip(forms, parts, units)
    ]


def _steps(data: Records) -> Vector:
    """How much each output changes between its readings."""
    moves = [_changes(y) for y, _ in data]
    return np.sqrt(np.mean(moves, axis=0))


def _changes(y: Matrix) -> Vector:
    columns = [column[~np.isnan(column)] for column in y.T]
    return np.array([np.mean(np.diff(c) ** 2) if len(c) > 1 else 0.0 for c in columns])


def _begin(form: Form, begin: dict[str, Any], unit: Vector) -> Vector:
    """Where a form begins: as the caller says, or with noise of the given unit."""
    given = begin.get(form.letter)
    if given is None or isinstance(form, Of):
        return form.at(np.diag(unit**2), unit)
    return form.at(covariance(f"start[{form.letter!r}]", given, len(unit)), unit)


def _lifted(form: Form, X: Matrix, unit: Vector, theta: Vector) -> Vector:
    """A vector near one that was found, away from where nothing moves."""
    lifted = form.at(X + LIFT * np.diag(unit**2), unit)
    return np.maximum(theta, lifted) if isinstance(form, Of) else lifted
