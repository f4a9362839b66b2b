"""Many records of one plant, smoothed by `smooth`.

The covariances depend on which outputs arrived, not on what they said.  So records with
the same gaps share them, and their estimates go forward and back side by side.  In
compiled code, records with gaps of their own are lanes.  Which way a record takes does
not depend on the records beside it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import kernels
from ..errors import DesignError
from ..fleets import records as filtered
from ..fleets.block import one_for_all
from ..fleets.fleet import Fleet
from ..fleets.own_gain import NAMES
from ..numeric import Matrix, Vector
from ..papers.leondes_novak.derivation import estimate_step
from ..plant import Plant
from ..recursion.settings import Settings
from ..recursion.settled_pass import SettledPass
from ..recursion.state import leading_on
from ..run import fleet_tasks
from ..run.filter_data import Outputs
from ..run.filter_fleet import at_rows, tables
from ..run.fleet_records import Records
from ..run.fleet_tasks import Arrays, Where
from .backward import _made_of, clear
from .carried import Ways
from .derivation import backward_step
from .finish import ways
from .forward import KEPT, Kept
from .lanes import Lanes, takes
from .record import Smoother

WIDTH = 64  # records side by side, always: products of one size have the same bits
LONG = 4000  # rows, from which on compiled code does a record sooner by itself


@dataclass(frozen=True, eq=False)
class SmoothedFleet:
    """What `smooth` returns of many records (M, N, p), the record first.

    Records, where they end and what is refused are as in `FilteredFleet`.  Noises and
    covariances of neighbours are had of one record, ``smooth(plant, y[k])``.

    Attributes
    ----------
    x, std : (M, N, n) ndarray
        Estimates of the state and their one-sigma errors, as in `Smoothed`.
    P : (M, N, n, n) ndarray
        Covariances of their errors.  Where no record has a gap all have the same, and
        memory is for one of them.  The array cannot be written to then, nor can std.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[1]], P0=[[1]])
    >>> found = lb.smooth(plant, [[[2], [2]], [[4]]])  # the second ends earlier
    >>> found
    <SmoothedFleet: 2 records of 2 rows, n = 1>
    >>> found.x[:, :, 0].round(4)
    array([[1.3333, 1.3333],
           [2.    , 2.    ]])
    """

    x: np.ndarray
    std: np.ndarray
    P: np.ndarray

    def __len__(self) -> int:
        return len(self.x)

    def __repr__(self) -> str:
        M, N, n = self.x.shape
        return f"<SmoothedFleet: {M} records of {N} rows, n = {n}>"


def smooth_fleet(
    plant: Plant, y: Any, u: Any, time: Any, m1: Outputs, lag: int | None,
    u0: Vector, weight: Any, backend: str, where: Where,
) -> SmoothedFleet | None:  # fmt: skip
    """Smooth records y (M, N, p) of one plant, all with the same instants."""
    records = Records.of(y, u, plant.p, plant.m)
    plant = at_rows(plant, records.rows, time)
    fast = _runs_compiled(backend, plant, records, u0)
    task = _Smooth(plant, m1, lag, weight, u0, "numba" if fast else "numpy")
    numbers = plant.m + plant.p + plant.n * (plant.n + 2)
    found: SmoothedFleet | None = fleet_tasks.run(
        task, records, where, _fleet, tables(plant), numbers
    )
    return found


def _fleet(x: Matrix, std: Matrix, P: Matrix) -> SmoothedFleet:
    """The result; what all records share cannot be written to."""
    for X in (std, P):
        X.flags.writeable = X.strides[0] > 0
    return SmoothedFleet(x, std, P)


def _runs_compiled(backend: str, plant: Plant, records: Records, u0: Vector) -> bool:
    """Whether compiled code is to smooth the records: all their rows count.

    For fewer than pay for compiling, if this was done.
    """
    rows, settings = len(records) * records.rows, Settings(plant, 0)
    if backend == "numpy":
        return kernels.runs_compiled(backend, rows)
    way = SettledPass(settings, None)
    fleet = Fleet(way, u0, records.rows, True)
    whole = fleet.whole
    lanes = whole is not None and takes(fleet)
    asked = ("smoothed", whole.stacks.sizes, whole.known(**NAMES)) if whole else ()

    def ready(rows: int) -> bool:
        y, _ = records.block(0, 1)
        if lanes or not len(y):
            return asked in kernels.LOADED
        return way.run.at_hand(fleet.begin, y[0], rows, KEPT)

    fast = kernels.runs_compiled(backend, rows, ready=ready)
    if fast and lanes:
        kernels.LOADED.add(asked)
    return fast


@dataclass(frozen=True)
class _Smooth:
    """The smoother of some records, which goes to where they are smoothed."""

    plant: Plant
    m1: Any
    lag: int | None
    weight: Any
    u0: Vector
    backend: str

    def room(self, M: int, N: int, complete: bool = False) -> Arrays:
        n, one = self.plant.n, complete and M > 1
        one = one and not Settings(self.plant, 0).noise_free
        std, P = (
            one_for_all(M, shape) if one else np.empty((M, *shape))
            for shape in ((N, n), (N, n, n))
        )  # fmt: skip
        return dict(x=np.empty((M, N, n)), std=std, P=P)

    def __call__(
        self, first: int, y: Matrix, u: Matrix, out: Arrays, complete: bool = False
    ) -> None:
        u = np.broadcast_to(u, (*y.shape[:2], self.plant.m))
        x, std, P = (out[name] for name in ("x", "std", "P"))
        left = self.in_lanes(first, y, u, x, std, P, complete)
        for same in (left[some] for some in self.groups(y[left])):
            shared = self.shared(y[same], u[same], first + int(same[0]))
            if shared is not None:
                where = same if P.strides[0] else same[:1]
                x[same], std[where], P[where] = shared
                continue
            for s in same.tolist():
                one = self.read(y[s], u[s], first + s).rows(last=True)
                x[s], std[s], P[s] = one.x, one.std, one.P

    def in_lanes(
        self, first: int, y: Matrix, u: Matrix, x: Matrix, std: Matrix, P: Matrix,
        complete: bool,
    ) -> Vector:  # fmt: skip
        """Smooth records in compiled lanes; return those that are left."""
        every, lanes = np.arange(len(y)), None
        if self.backend == "numba" and self.lag is None and len(y):
            accurate = Settings(self.plant, self.m1, self.weight).accurate
            way = SettledPass(Settings(self.plant, 0), None)
            fleet = Fleet(way, self.u0, y.shape[1], True)
            records = filtered.Records(fleet, y, u, first, complete)
            lanes = None if accurate else Lanes.of(records)
        return every if lanes is None else lanes.smooth(x, std, P)

    def leaves(self, found: Arrays) -> Arrays:
        return found

    def groups(self, y: Matrix) -> list[Vector]:
        """The numbers of records with the same gaps."""
        found: dict[bytes, list[int]] = {}
        for s, seen in enumerate(~np.isnan(y)):
            found.setdefault(np.packbits(seen).tobytes(), []).append(s)
        return [np.array(some) for some in found.values()]

    def read(self, y: Matrix, u: Matrix, number: int) -> Smoother:
        """A record that was filtered; DesignError with its number."""
        one = Smoother(self.plant, self.m1, self.lag, self.weight, self.backend)
        one.begin(self.u0)
        try:
            one.read(y, u)
        except DesignError as error:
            raise DesignError(f"record {number}: {error}") from error
        return one

    def shared(
        self, y: Matrix, u: Matrix, number: int
    ) -> tuple[Matrix, Matrix, Matrix] | None:
        """Records with the same gaps, or None where each is done by itself."""
        seen, compiled = ~np.isnan(y[0]), self.backend == "numba"
        if self.lag is not None or not seen.size or self.plant.n == 0:
            return None
        if compiled and (len(seen) >= LONG or not seen.all()):
            return None
        one = self.read(y[0], u[0], number)
        if one.accurate.accurate or one.settings.noise_free or one.kept.spreads:
            return None
        leads = ways(one.settings, 1, seen)
        P = covariances(one.kept, leads)
        if P is None:
            return None
        x = np.empty((*y.shape[:2], self.plant.n))
        for k in range(0, len(y), WIDTH):
            some = slice(k, k + WIDTH)
            forward = side_by_side(one, seen, y[some], u[some], self.u0)
            found = back(one.kept, leads, *forward)
            x[some] = found[:, :, : len(y[some])].transpose(2, 0, 1)
        std = np.sqrt(np.maximum(P.diagonal(axis1=1, axis2=2), 0))
        return x, std, P


def covariances(kept: Kept, leads: Ways) -> Matrix | None:
    """Those of smoothed estimates (N, n, n); None where digits would be lost."""
    N, n = kept.x.shape
    step = kernels.compiled(backward_step, "Theta", "Sigma_s", "Lambda")
    out, Lambda = np.empty((N, n, n)), np.zeros((n, n))
    for k in reversed(range(N)):
        As, C = leads.at(k)
        have = dict(As=As, C=C, K=kept.K[k], W=kept.W[k], Sigma=kept.Sigma[k])
        found = step(**have, Lambda_next=Lambda)
        Sigma_s = clear(kept.spread(k), found, _made_of(As, Lambda))
        if Sigma_s is None:
            return None
        out[k], Lambda = Sigma_s, found["Lambda"]
    return out


def side_by_side(
    one: Smoother, seen: Matrix, y: Matrix, u: Matrix, u0: Vector
) -> tuple[Matrix, Matrix]:
    """The filter's estimates (N, n, 64) and innovations (N, p, 64) of some records."""
    M, N, p = y.shape
    ys, us = np.zeros((N, p, WIDTH)), np.zeros((N, u.shape[2], WIDTH))
    ys[:, :, :M], us[:, :, :M] = y.transpose(1, 2, 0), u.transpose(1, 2, 0)
    x = np.repeat(one.plant.x0[:, None], WIDTH, axis=1)
    before, rho = np.repeat(u0[:, None], WIDTH, axis=1), np.zeros((0, WIDTH))
    xs, innovations = np.empty((N, len(x), WIDTH)), np.zeros((N, p, WIDTH))
    step, setting = kernels.compiled(estimate_step), None
    for k, here in enumerate(seen):
        _, A, B, J = leading_on(one.plant, setting)
        setting = one.settings.at(k + 1, None if here.all() else here)
        moved = step(
            A=A, B=B, C=setting.C, E=setting.E, J=J, K=one.kept.K[k][:, here], x=x,
            rho=rho, u=before, y=ys[k][here], u_next=us[k],
        )  # fmt: skip
        x, rho, before = moved["x_next"], moved["rho_next"], us[k]
        xs[k], innovations[k][here] = x, moved["innovation"]
    return xs, innovations


def back(kept: Kept, leads: Ways, xs: Matrix, innovations: Matrix) -> Matrix:
    """Smoothed estimates (N, n, 64) from those of the filter."""
    step = kernels.compiled(backward_step, "x_s", "lamda")
    out, lamda = np.empty_like(xs), np.zeros(xs.shape[1:])
    for k in reversed(range(len(xs))):
        As, C = leads.at(k)
        found = step(
            As=As, C=C, K=kept.K[k], W=kept.W[k], Sigma=kept.Sigma[k],
            innovation=innovations[k], x=xs[k], lamda_next=lamda,
        )  # fmt: skip
        out[k], lamda = found["x_s"], found["lamda"]
    return out
