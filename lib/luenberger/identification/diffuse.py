"""A record whose start is not known: its first rows, until they determine the state.

The state at the first row has a mean that nothing is known of.  A filter from any
covariance around it goes over the first rows, with the columns that say what the mean
does.  When these rows determine it, it is integrated out, and an ordinary filter goes
on.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dtrtri

from .. import kernels
from ..errors import DesignError
from ..numeric import Matrix, Vector
from ..numeric.factors import lengths, rounded, safe, semidefinite, shorten
from ..plant import Plant
from ..recursion.growth import Gap, Passed, require_digits
from ..recursion.predicted import begins
from ..recursion.root_step import Spread
from ..recursion.settings import Settings
from ..recursion.state import Ahead, State, Step, step
from ..recursion.units import natural
from .derivation import after_start, before_start, collapse, mean_moves, with_mean
from .innovations import counted
from .score import Adjoint, Sums, row
from .trail import Trail

FIRM = 1e-4  # of the columns at unit length: the least singular value to go on from
FEW = 4  # rows for each state, that there is room for before more is asked for
LEAST = 1e-11  # below it the rows do not determine the state


class Solved(NamedTuple):
    """The mean, from what the first rows show of it.

    Attributes
    ----------
    delta : (n, 1) ndarray
        Its best value.
    inverse : (n, n) ndarray
        Of the triangle of what is shown; inverse inverse' is the covariance.
    left : float
        Squares that the best value leaves.
    log_det : float
        Of the information.
    """

    delta: np.ndarray
    inverse: np.ndarray
    left: float
    log_det: float


@dataclass
class Head:
    """The first rows: a trail, and what they show of the mean of the first state.

    Attributes
    ----------
    trail : Trail
    X : list of (n, n) ndarray
        What the mean does to the prediction of each row, and of the row after them.
    state : State
        After them, the mean integrated out.
    gap : Gap or None
        The one in which the last of them is.
    solved : Solved
    """

    trail: Trail
    X: list[Matrix]
    state: State
    gap: Gap | None
    solved: Solved

    @property
    def value(self) -> float:
        """The logarithm of the likelihood of these rows."""
        trail, solved = self.trail, self.solved
        count = int(trail.free.sum()) - len(solved.delta)
        exponent = float(trail.log_det.sum()) + solved.left + solved.log_det
        return -0.5 * float(count * np.log(2 * np.pi) + exponent)


def head(settings: Settings, y: Matrix, u: Matrix) -> Head:
    """The rows of y that determine the state, as few as do so firmly.

    Any covariance of the state at the first row will do.
    """
    plant, n = settings.plant, settings.plant.n
    states, _ = natural(settings.at(1))
    first = Ahead(np.diag(states**2).flatten(), np.zeros(n))
    state = begins(settings, 0, first, None)
    trail, X = Trail.empty(plant, y[: FEW * n], True), [np.eye(n)]
    shown, z, firm = np.zeros((0, n)), np.zeros(0), 0.0
    done: Step | None = None
    Sigmas: list[Matrix] = []
    for k in range(len(y)):
        if k == len(trail.free):
            trail = trail.longer(plant, y)
        done = step(settings, state, y[k], u[k])
        state = done.state
        Sigmas.append(state.Sigma)
        here, at = counted(done), plant.at(k + 1)
        trail.put_counted(k, done, here)
        C = at.C[state.seen][here.free]
        moved = kernels.compiled(mean_moves)(A=at.A, C=at.C, G=trail.G[k], X=X[-1])
        shown = np.vstack([shown, here.whitening @ C @ X[-1]])
        z = np.concatenate([z, here.z])
        X.append(moved["X_next"])
        firm = _firmness(shown)
        if firm > FIRM:
            break
    if not firm > LEAST:
        raise _undetermined(plant, y, shown)
    assert done is not None
    solved = _solved(shown, z)
    rows = slice(0, len(X) - 1)
    trail, state = trail.part(rows), _collapsed(done, X[-2], solved)
    Sigma = np.array(Sigmas)
    held = Passed(settings, 1, trail.variances, y[rows], lambda a, b: Sigma[a:b])
    gap = require_digits(None, held)
    return Head(trail.settled(), X, state, gap, solved)


def _firmness(shown: Matrix) -> float:
    """How well the rows determine the mean: 1 at best, and 0 if they do not."""
    if len(shown) < shown.shape[1]:
        return 0.0
    unit = lengths(shown.T)
    if not unit.all():
        return 0.0
    return float(np.linalg.svd(shown / unit, compute_uv=False)[-1])


def _undetermined(plant: Plant, y: Matrix, shown: Matrix) -> DesignError:
    """Why the start cannot be found in the record."""
    unit = lengths(shown.T)
    unit = np.where(unit > 0, unit, 1.0)
    _, values, rows = np.linalg.svd(np.vstack([shown / unit, np.zeros((plant.n,) * 2)]))
    blind = np.abs(rows[-1] / unit * (1 / np.abs(rows[-1] / unit).max()))
    names = [s for s, b in zip(plant.state_names, blind) if b > 1e-6]
    read = int((~np.isnan(y)).sum())
    return DesignError(
        f"the plant has no P0, and the record, of {len(y)} instants with {read} "
        f"measured values, does not determine where it starts: a combination of "
        f"{', '.join(names)} is not seen. Give P0, or a longer record, or measure more."
    )


def _solved(shown: Matrix, z: Vector) -> Solved:
    """Least squares: the mean, and what it leaves."""
    Q, R = np.linalg.qr(shown)
    inverse = np.triu(dtrtri(R)[0])
    along = Q.T @ z
    rest = z - Q @ along
    log_det = 2 * float(np.log(np.abs(R.diagonal())).sum())
    return Solved((inverse @ along)[:, None], inverse, float(rest @ rest), log_det)


def _collapsed(done: Step, X: Matrix, solved: Solved) -> State:
    """The state after a row, the mean integrated out."""
    state, now = done.state, done.state.setting
    assert now is not None
    found = kernels.compiled(collapse)(
        C=now.C, K=done.new["K"], X=X, inverse=solved.inverse, delta_hat=solved.delta,
        x_f=state.x, rho=state.rho,
    )  # fmt: skip
    half, rounding = state.spread.factored()
    half = shorten(np.concatenate([half, found["H_c"]], axis=1))
    Sigma, size = half @ half.T, lengths(half)
    spread = Spread(Sigma)
    if now.blind.size or not safe(Sigma, Sigma.diagonal()):
        spread = Spread(Sigma, half, rounded(rounding.copy(), size))
    if state.rounding is not None:
        made_of = np.abs(X) @ np.abs(solved.delta[:, 0])
        state = state._replace(rounding=rounded(state.rounding.copy(), made_of))
    return state._replace(x=found["x_c"], rho=found["rho_c"], spread=spread)


def back(head: Head, plant: Plant, u: Matrix, sums: Sums, now: Adjoint) -> None:
    """The score over the first rows, from what the rows after them carry back."""
    solved, n = head.solved, plant.n
    have = dict(Pi_c=now.Pi, eta_c=now.eta, inverse=solved.inverse)
    have |= dict(X=head.X[-1], delta_hat=solved.delta)
    have |= kernels.run(before_start, have)
    have["L_c"] = np.linalg.cholesky(semidefinite(have["D_c"], np.ones(n)))
    found = kernels.run(after_start, have)
    now = Adjoint(np.hstack([now.eta, found["eta_n"]]), found["Pi"])
    means = np.hstack([found["delta_all"], found["T_c"]])
    first = np.zeros((1, n + 1))
    first[0, 0] = 1
    for k in reversed(range(len(u))):
        at = plant.at(k + 1)
        have = dict(
            C=at.C, W=head.trail.W[k], x=head.trail.x[k][:, None],
            e=head.trail.e[k][:, None], X=head.X[k], first=first, Delta=means,
        )  # fmt: skip
        columns = kernels.compiled(with_mean)(**have)
        given = dict(A=at.A, C=at.C, u=u[k][:, None] @ first)
        given |= dict(x=columns["x_n"], e=columns["e_n"])
        rows = row(head.trail, k, given, now)
        now = Adjoint(rows["eta"], rows["Pi"])
        sums.add(k + 1, rows)
