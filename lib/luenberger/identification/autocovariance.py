"""Noise covariances from autocovariances of innovations, by least squares.

A constant gain, first that for noises of size one and then that of the last estimate,
leaves innovations whose autocovariances are linear in Q and R.  Near the best gain they
are nearly white, so that their sample autocovariances err independently and equally in
units of their own covariance, which is the weight.  A search begins there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy  # its parts load when first used

from .. import kernels
from ..errors import DesignError
from ..numeric import Matrix, Vector
from ..numeric.covariance_maps import Sums, packing
from ..numeric.covariances import covariance
from ..numeric.independent_rows import default_tol, in_even_units
from ..numeric.linalg import UNIT_TOL, radius
from ..plant import Plant
from .derivation import autocovariance_step, error_noise, first_autocovariances
from .forms import Form, Of, form_of
from .parameters import Parameters, Unknowns, require_room

ROUNDS = 4  # gains: that of noises of size one, and then of the estimates
BEGINNING = 2, 10  # gains, and stretches without gaps, that a search begins from
LAGS = 60  # at most
FADED = 0.05  # lags go on until the errors of the gain have died out to this
PART = 8  # lags take at most this part of a record
DRIVEN = 1e-4  # process noise, beside its size, that every gain is made for
SHARE = 0.3  # of the noise seen in the outputs, at each state, to begin with
LIFT = 0.01  # of the noise to begin with, added to what autocovariances tell
LEAST_ROWS = 10  # of a stretch, for each state, for autocovariances

Records = Sequence[tuple[Matrix, Matrix]]  # (y, u) of complete rows


class Moments(NamedTuple):
    """Sample autocovariances h, and the map H of (Q, R) to what they are to be.

    Both in units of the innovation's deviation; each entry of h errs by one over the
    square root of `rows`, independently.  What a known S explains is taken off.
    """

    h: np.ndarray
    H: np.ndarray
    rows: int


class Start(NamedTuple):
    """Where a search begins.

    Attributes
    ----------
    unknowns : Unknowns
    theta : (k,) ndarray
    information : (j, j) ndarray
        About what a reading tells of each number of Q and R there.
    squares : (k,) ndarray or None
        Where the autocovariances put it, if there are any.
    spread : (j, j) ndarray or None
        The covariance of its error there, in what covariances are linear in.
    """

    unknowns: Unknowns
    theta: np.ndarray
    information: np.ndarray
    squares: np.ndarray | None = None
    spread: np.ndarray | None = None


def start_of(
    plant: Plant, data: list[tuple[Matrix, Matrix]], Q: Any, R: Any, S: Matrix | None,
    begin: dict[str, Any], parameters: Parameters, alone: bool,
) -> Start:  # fmt: skip
    """What is unknown and where to begin; `alone`, the autocovariances are the fit.

    The other arguments are those of `fit_noise`, checked.
    """
    now = plant.at(0)
    pair, _ = in_even_units(now.A, now.C, 1.0, default_tol(plant.n))
    x, y = pair.states, pair.outputs
    rounds, most = (ROUNDS, None) if alone else BEGINNING
    some = _stretches(data, LEAST_ROWS * (plant.n + 1))
    some = [(one / y, u) for one, u in sorted(some, key=lambda one: -len(one[0]))]
    even, size, gain, some = None, _steps(data) / y, None, some[:most]
    if plant.steps is None and some:
        even = Plant(pair.A, plant.B / x[:, None], pair.C, plant.E / y[:, None], dt=1.0)
        gain = gain_for(even, np.eye(plant.n), np.eye(plant.p))
    if even is not None and gain is not None:
        nu = np.concatenate([left(even, gain, *one) for one in some])
        size = np.sqrt((nu**2).mean(axis=0))
    size = np.where(size > 0, size, size.max())
    units = SHARE * size.max() * x, size * y
    forms = (
        form_of("Q", Q, plant.n, now.Q, begin.get("Q"), units[0]),
        form_of("R", R, plant.p, now.R, begin.get("R"), units[1]),
    )
    parts = [_begin(form, begin) for form in forms]
    rest = np.zeros(len(parameters.names))
    found = Start(Unknowns(*forms, S, parameters), np.concatenate([*parts, rest]),
                  np.eye(sum(map(len, parts))))  # fmt: skip
    if even is None or gain is None or not len(found.information):
        return found
    cross = None if S is None else S / x[:, None] / y
    try:
        with np.errstate(all="ignore"):  # of an S that is too large
            told = by_autocovariances(
                even, forms, (x, y), cross, np.concatenate(parts), gain, some, rounds
            )
    except (DesignError, np.linalg.LinAlgError):
        return found
    theta, q = told.theta, forms[0].count
    if not set(begin) & {"Q", "R"}:
        parts = [_lifted(one, part) for one, part in zip(forms, (theta[:q], theta[q:]))]
    at = np.concatenate(parts)
    J = told.slope(at)
    readings = sum(int((~np.isnan(one)).sum()) for one, _ in data)
    near = told.data.rows / readings * J.T @ J
    return Start(
        found.unknowns, np.concatenate([at, rest]), near,
        np.concatenate([theta, rest]), told.spread(theta),
    )  # fmt: skip


def _stretches(data: Records, least: int) -> list[tuple[Matrix, Matrix]]:
    """The stretches of at least so many rows in which every output was measured."""
    found = []
    for y, u in data:
        gaps = np.flatnonzero(np.isnan(y).any(axis=1))
        for a, b in zip([0, *(gaps + 1)], [*gaps, len(y)]):
            if b - a >= least:
                found.append((y[a:b], u[a:b]))
    return found


def _steps(data: Records) -> Vector:
    """How much each output changes between its readings."""
    moves = [[np.mean(np.diff(c[~np.isnan(c)]) ** 2) if (~np.isnan(c)).sum() > 1 else 0
              for c in y.T] for y, _ in data]  # fmt: skip
    found: Vector = np.sqrt(np.mean(moves, axis=0))
    return found


def _begin(form: Form, begin: dict[str, Any]) -> Vector:
    """Where a form begins: as the caller says, or with noise of the given unit."""
    given, unit = begin.get(form.letter), form.unit
    if given is None or isinstance(form, Of):
        return form.at(np.diag(unit**2), unit)
    return form.at(covariance(f"start[{form.letter!r}]", given, len(unit)), unit)


def _lifted(form: Form, theta: Vector) -> Vector:
    """A vector near one that was found, away from where nothing moves."""
    lifted = form.at(form.matrix(theta) + LIFT * np.diag(form.unit**2), form.unit)
    return np.maximum(theta, lifted) if isinstance(form, Of) else lifted


def gain_for(
    plant: Plant, Q: Matrix, R: Matrix, S: Matrix | None = None
) -> Matrix | None:
    """The predictor's steady gain for these noises; None where there is none."""
    A, C = plant.A, plant.C
    cross = np.zeros((plant.n, plant.p)) if S is None else S
    require_room(Q, R, S)
    try:
        X = scipy.linalg.solve_discrete_are(A.T, C.T, Q, R, s=cross)
        gain: Matrix = np.linalg.solve(C @ X @ C.T + R, (A @ X @ C.T + cross).T).T
    except (np.linalg.LinAlgError, ValueError):
        return None
    return gain if radius(A - gain @ C) < 1 - UNIT_TOL else None


def carried(A: Matrix, rows: Matrix) -> Matrix:
    """Rows z[0] = rows[0], z[k] = A z[k - 1] + rows[k]; each takes up twice as many."""
    step = 1
    while step < len(rows) and np.abs(A).max(initial=0) > FADED**10:
        rows = np.concatenate([rows[:step], rows[step:] + rows[:-step] @ A.T])
        A, step = A @ A, 2 * step
    return rows


def left(plant: Plant, gain: Matrix, y: Matrix, u: Matrix) -> Matrix:
    """Innovations (N, p) of a constant gain, less what the unknown start explains."""
    A_L = plant.A - gain @ plant.C
    shown = y - u @ plant.E.T
    drive = shown @ gain.T + u @ plant.B.T
    x = carried(A_L, np.concatenate([np.zeros((1, plant.n)), drive[:-1]]))
    nu = shown - x @ plant.C.T
    seen: list[Matrix] = []
    rows = plant.C
    while len(seen) < len(y) and np.abs(rows).max(initial=0) > 1e-9:
        seen.append(rows)
        rows = rows @ A_L
    stack = np.concatenate(seen)
    x0 = np.linalg.lstsq(stack, nu[: len(seen)].ravel(), rcond=None)[0]
    nu[: len(seen)] -= (stack @ x0).reshape(-1, plant.p)
    return nu


def moments(
    plant: Plant, gain: Matrix, records: Records, cross: Matrix | None = None
) -> Moments:
    """What a gain leaves of records, and how Q and R enter that; `cross` is S."""
    n, p = plant.n, plant.p
    series = [left(plant, gain, y, u) for y, u in records]
    rows = sum(map(len, series))
    A_L = plant.A - gain @ plant.C
    lags = _lags(radius(A_L), n, min(map(len, series)))
    sample = np.array(
        [sum(nu[k:].T @ nu[: len(nu) - k] for nu in series) / rows for k in range(lags)]
    )
    white = np.linalg.inv(np.linalg.cholesky(sample[0]))
    (_, unpack), (pack, unpack_y) = packing(n), packing(p)
    wide, high = n * (n + 1) // 2, p * (p + 1) // 2
    Q = np.concatenate([unpack(np.eye(wide)), np.zeros((high + 1, n, n))])
    R = np.concatenate(
        [np.zeros((wide, p, p)), unpack_y(np.eye(high)), np.zeros((1, p, p))]
    )
    S = np.zeros((wide + high + 1, n, p))
    if cross is not None:
        S[-1] = cross
    model = _autocovariances(plant, gain, Q, R, S, lags)

    def packed(X: Matrix) -> Matrix:
        X = white @ X @ white.T
        first = pack(X[..., 0, :, :]) / np.sqrt(2)
        return np.concatenate(
            [first, X[..., 1:, :, :].reshape(*first.shape[:-1], -1)], -1
        )

    H = packed(model)
    return Moments(packed(sample) - H[-1], H[:-1].T, rows)


def _lags(size: float, n: int, rows: int) -> int:
    wanted = (
        LAGS if size >= 1 else int(np.ceil(np.log(FADED) / np.log(max(size, 1e-9))))
    )
    return max(min(max(wanted, n + 2), LAGS, rows // PART), 2)


def _autocovariances(
    plant: Plant, gain: Matrix, Q: Matrix, R: Matrix, S: Matrix, lags: int
) -> Matrix:
    """(k, lags, p, p): what noises Q, R, S, stacks of k, make of the innovations."""
    A_L = plant.A - gain @ plant.C
    W = kernels.compiled(error_noise, stacks=True)(Q=Q, R=R, S=S, L=gain)["W"]
    first = kernels.compiled(first_autocovariances, stacks=True)(
        A_L=A_L, C=plant.C, L=gain, R=R, S=S, P=Sums(A_L)(W)
    )
    step = kernels.compiled(autocovariance_step, stacks=True)
    found, N = [first["Lambda_0"]], first["N_1"]
    for _ in range(lags - 1):
        now = step(A_L=A_L, C=plant.C, N_k=N)
        found.append(now["Lambda_k"])
        N = now["N_next"]
    return np.stack(found, axis=1)


class Fit(NamedTuple):
    """Least squares of autocovariances, and the vector that they end at.

    Attributes
    ----------
    data : Moments
    forms, units
        Of Q and R, and the units in which the autocovariances are.
    theta : (k,) ndarray
    """

    data: Moments
    forms: Sequence[Form]
    units: Sequence[Vector]
    theta: np.ndarray

    def of(self, stacks: Sequence[Matrix]) -> Matrix:
        """What stacks of Q and R make of the autocovariances, a row each."""
        packed = (packing(len(unit))[0](X / unit / unit[:, None])
                  for X, unit in zip(stacks, self.units))  # fmt: skip
        found: Matrix = np.concatenate(list(packed), axis=-1) @ self.data.H.T
        return found

    def error(self, theta: Vector) -> Vector:
        """What is left at a vector."""
        q = self.forms[0].count
        parts = zip(self.forms, (theta[:q], theta[q:]))
        return self.of([form.matrix(part) for form, part in parts]) - self.data.h

    def slope(self, theta: Vector, linear: bool = False) -> Matrix:
        """How it moves with the vector, or with what covariances are linear in."""
        q, (Q, R) = self.forms[0].count, self.forms
        one, other = ((X.directions if linear else X.slopes) for X in (Q, R))
        dQ, dR = one(theta[:q]), other(theta[q:])
        none = np.zeros((len(dR), *dQ.shape[1:])), np.zeros((len(dQ), *dR.shape[1:]))
        return self.of([np.concatenate([dQ, none[0]]), np.concatenate([none[1], dR])]).T

    def spread(self, theta: Vector) -> Matrix:
        """The covariance of the error, in what covariances are linear in."""
        J = self.slope(theta, linear=True)
        found: Matrix = np.linalg.pinv(J.T @ J, hermitian=True) / self.data.rows
        return found

    def least(self) -> Fit:
        """The semidefinite Q and R nearest to the autocovariances, from here."""
        found = scipy.optimize.least_squares(  # SciPy's first step is as long as x0
            lambda step: self.error(self.theta + step), np.zeros(len(self.theta)),
            jac=lambda step: self.slope(self.theta + step),
            xtol=1e-12, ftol=1e-12, gtol=1e-12, max_nfev=200,
        )  # fmt: skip
        return self._replace(theta=self.theta + found.x)


def by_autocovariances(
    plant: Plant, forms: Sequence[Form], units: Sequence[Vector], S: Matrix | None,
    theta: Vector, gain: Matrix, records: Records, rounds: int = ROUNDS,
) -> Fit:  # fmt: skip
    """Fit Q and R to records of a constant plant in even units, round by round.

    `forms` are in the user's units, `units` are what even ones are in these.  Least
    squares begin at `theta`, with the innovations of `gain`; two gains are enough for
    a start.
    """
    for k in range(rounds):
        data = moments(plant, gain, records, S)
        found = Fit(data, forms, units, theta).least()
        theta, q = found.theta, forms[0].count
        parts = zip(forms, (theta[:q], theta[q:]), units)
        Q, R = (one.matrix(part) / unit / unit[:, None] for one, part, unit in parts)
        size = max(R.diagonal().max(), Q.diagonal().max())
        try:
            driven = Q + DRIVEN * size * np.eye(plant.n)
            more = gain_for(plant, driven, R, S) if k < rounds - 1 else None
        except DesignError:  # S is too large
            more = None
        if more is None:
            break  # what the last gain has found stands
        gain = more
    return found
