"""What a filter carries from row to row of a record, and one row of it in NumPy."""

from typing import NamedTuple

import numpy as np

from .. import kernels
from ..numeric import Matrices, Matrix, Vector
from ..papers.leondes_novak.derivation import estimate_step
from ..plant import Plant
from .agreement import followed, require_agreement, rounding_of
from .root_step import Move, Spread, first_move
from .settings import Setting, Settings, require_start

TOGETHER = 64  # rows whose largest entries are looked for at once
PATIENCE = 64  # rows at most that NumPy takes before compiled code is tried again


class Turn(NamedTuple):
    """When compiled code is tried again: at an instant, and how much later after that.

    It doubles its distance each time it gives up at once, so that a record on which
    it can do nothing costs few attempts.
    """

    instant: int = 0
    patience: int = 1

    def later(self, instant: int) -> "Turn":
        """After it gave up at this instant."""
        patience = min(2 * self.patience, PATIENCE)
        return Turn(instant + patience, patience)


class Ahead(NamedTuple):
    """The next prediction as compiled code left it: covariance and mean, both flat."""

    Omega: np.ndarray
    x: np.ndarray


class State(NamedTuple):
    """A filter between two rows of a record: all that the rows to come depend on.

    Attributes
    ----------
    instant : int
        That of the last row; 0 before the first.
    x : (n, 1) ndarray
        The estimate there.
    spread : Spread
        Covariance of its error.
    rounding : (n, n) ndarray or None
        Covariance of the rounding in x; None where noise covers it.
    u : (m,) ndarray
        The input.
    seen : (p,) ndarray of bool
        Which outputs arrived.
    rho : (p_seen, 1) ndarray
        Their residual y - E u - C x.
    setting : Setting or None
        The plant there, with these outputs; None at instant 0, which has none.
    turn : Turn
    ahead : Ahead or None
        The next prediction, where it is known.
    """

    instant: int
    x: np.ndarray
    spread: Spread
    rounding: np.ndarray | None
    u: np.ndarray
    seen: np.ndarray
    rho: np.ndarray
    setting: Setting | None
    turn: Turn = Turn()
    ahead: Ahead | None = None

    @property
    def Sigma(self) -> Matrix:
        """Error covariance."""
        return self.spread.Sigma

    @property
    def ready(self) -> bool:
        """Whether compiled code can go on from here, and it is its turn."""
        return (
            self.setting is not None
            and self.spread.half is None
            and self.instant >= self.turn.instant
        )


class Step(NamedTuple):
    """One row: the `State` after it, and how it came about.

    Attributes
    ----------
    state : State
    new : dict
        The matrices of `Setting.step`.
    innovation : (p_seen, 1) ndarray
        What the prediction left of the measurement.
    """

    state: State
    new: Matrices
    innovation: np.ndarray


class History(NamedTuple):
    """What a pass found, a row for each row of the record.

    ``x, variances`` (N, n) are estimates and the diagonals of P (N, n, n); K is
    (N, n, p).
    """

    x: np.ndarray
    variances: np.ndarray
    P: np.ndarray
    K: np.ndarray

    @classmethod
    def empty(cls, rows: int, plant: Plant) -> "History":
        """Room for so many rows of a plant."""
        n = plant.n
        x, variances = np.empty((rows, n)), np.empty((rows, n))
        return cls(x, variances, np.empty((rows, n, n)), np.zeros((rows, n, plant.p)))

    def put(self, k: int, row: Step) -> None:
        """Write row k."""
        state = row.state
        self.x[k], self.variances[k] = state.x[:, 0], state.Sigma.diagonal()
        self.P[k], self.K[k][:, state.seen] = state.Sigma, row.new["K"]

    def repeat(self, rows: slice, P: Matrix, K: Matrix) -> None:
        """Write the same covariance and gain, of all outputs, to some rows."""
        self.variances[rows], self.P[rows], self.K[rows] = P.diagonal(), P, K

    @property
    def arrays(self) -> Matrices:
        """What compiled code writes to."""
        P, K = flat(self.P), flat(self.K)
        return dict(xs=self.x, variances=self.variances, covariances=P, gains=K)


def start(settings: Settings, x: Vector, u: Vector) -> State:
    """The state at instant 0: the mean x (n,) with covariance P0, and the input u."""
    return State(
        0, x[:, None], Spread.of(require_start(settings.plant)), None, u,
        seen=np.ones(settings.plant.p, dtype=bool), rho=np.zeros((0, 1)), setting=None,
    )  # fmt: skip


def sizes(rows: Matrix) -> Vector:
    """The largest size in each column, of many rows side by side."""
    whole = len(rows) // TOGETHER * TOGETHER
    wide = rows[:whole].reshape(whole // TOGETHER, TOGETHER * rows.shape[1])
    ends = [wide.max(axis=0, initial=0), wide.min(axis=0, initial=0)]
    parts = [one.reshape(TOGETHER, rows.shape[1]) for one in ends]
    return np.abs(np.concatenate([*parts, rows[whole:]])).max(axis=0, initial=0)


def flat(stack: Matrix) -> Matrix:
    """(N, rows, cols) as (N, rows * cols), the same memory."""
    return stack.reshape(len(stack), stack.shape[1] * stack.shape[2])


def step(settings: Settings, state: State, y: Vector, u: Vector) -> Step:
    """The state one instant on, and how it came about.

    Parameters
    ----------
    settings : Settings
    state : State
    y : (p,) ndarray
        Measurements there; NaN where an output did not arrive.
    u : (m,) ndarray
        The input there.

    Raises
    ------
    DesignError
        If noise-free outputs contradict each other or a state known exactly.
    """
    i, seen = state.instant + 1, ~np.isnan(y)
    now = settings.at(i, None if seen.all() else seen)
    move, A, B, J = leading_on(settings.plant, state.setting)
    new, spread, known = now.step(move, state.spread)
    moved = kernels.compiled(estimate_step)(
        A=A, B=B, C=now.C, E=now.E, J=J, K=new["K"], x=state.x, rho=state.rho,
        u=state.u[:, None], y=y[seen, None], u_next=u[:, None],
    )  # fmt: skip
    rounding = None
    if spread.half is not None and settings.noise_free:
        made_of = move.size @ np.abs(state.x[:, 0]) + np.abs(B) @ np.abs(state.u)
        made_of += np.abs(J) @ np.abs(state.rho[:, 0])
        read = np.abs(y[seen]) + np.abs(now.E) @ np.abs(u)
        before = rounding_of(state.x) if state.rounding is None else state.rounding
        rounding, met = followed(before, move.A, now.C, new, made_of, read)
        if now.blind.size:
            names = [settings.plant.output_names[j] for j in np.flatnonzero(seen)]
            innovation = moved["innovation"][:, 0]
            require_agreement(known, innovation, met, new["unit"], names, i)
    x, rho = moved["x_next"], moved["rho_next"]
    after = State(i, x, spread, rounding, u, seen, rho, now, state.turn)
    return Step(after, new, moved["innovation"])


def leading_on(
    plant: Plant, setting: Setting | None
) -> tuple[Move, Matrix, Matrix, Matrix]:
    """`Move`, A, B and J from an instant to the next; None is instant 0."""
    if setting is not None:
        return setting.move, setting.A, setting.B, setting.J
    A, B, _ = plant.first_step()
    return first_move(plant), A, B, np.zeros((len(A), 0))  # no y before
