"""A row of a filter that waits for readings, with factors of the covariances.

State and readings are one vector, of which what has arrived is read without noise: the
noise of a reading is part of that reading.  So the step in factors that serves a
singular covariance serves here as it is, and tells contradictions from rounding.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dpotrf

from ..numeric import Matrix, Vector
from ..numeric.factors import SAFE
from .agreement import followed, require_agreement, rounding_of
from .late_state import Ahead, Held, LateState
from .root_step import Move, Spread, root_step
from .settings import Setting, Settings

DIGITS = 1e-4  # of a variance that is left beside the one before: twelve digits are


class Used(NamedTuple):
    """What arrived does to the rest.

    Attributes
    ----------
    K : (n + q, k) ndarray
        The gain of what arrived.
    spread : Spread
        Covariance of the state and of what is still held.
    rounding : (n + q, n + q) ndarray or None
        Covariance of the rounding in what is expected of them; None where noise
        covers it.
    """

    K: np.ndarray
    spread: Spread
    rounding: np.ndarray | None


def used_in_factors(
    settings: Settings, state: LateState, ahead: Ahead, came: Vector
) -> Used:
    """What the readings that `came` do, for any covariance.

    Raises
    ------
    DesignError
        If noise-free readings contradict each other or a state known exactly.
    """
    t = ahead.of_all(came)
    move, read = _whole_move(state, ahead), _read(ahead, t)
    found, spread, known = root_step(read, move, state.spread)
    left = ~t
    if spread.half is None or spread.rounding is None:  # nothing arrived
        return Used(found["K"][left], spread, None)
    rounding = None
    if settings.noise_free:
        rounding = _agreed(settings, state, ahead, came, move, read, found, known)
        rounding = rounding[np.ix_(left, left)]
    keep = np.ix_(left, left)
    rest = Spread(spread.Sigma[keep], spread.half[left], spread.rounding[keep])
    if _leaves_digits(rest.Sigma, len(ahead.now.A)) and not ahead.now.blind.size:
        rest, rounding = Spread(rest.Sigma), None
    return Used(found["K"][left], rest, rounding)


def _whole_move(state: LateState, ahead: Ahead) -> Move:
    """From the state and what was held to the state, what is held and what is new."""
    now, move = ahead.now, ahead.move
    n, before = len(now.A), len(state.held)
    C, V = now.C[ahead.new], now.V[ahead.new]
    A, size = np.zeros((2, n, n + before))
    for table, from_x, from_last in ((A, move.A, ahead.J), (size, move.size, None)):
        table[:, :n] = from_x
        table[:, [n + k for k in ahead.last]] = (
            np.abs(ahead.J) if from_last is None else from_last
        )
    on = np.eye(n + before)[[n + k for k in ahead.kept]]
    G = np.zeros((n + len(ahead.held), move.G.shape[1] + V.shape[1]))
    G[:n, : move.G.shape[1]] = move.G
    G[n + len(on) :] = np.concatenate([C @ move.G, V], axis=1)
    return Move(
        np.concatenate([A, on, C @ A]),
        np.zeros((0, 0)),
        G,
        np.concatenate([size, on, np.abs(C) @ size]),
    )


def _read(ahead: Ahead, t: Vector) -> Setting:
    """The setting in which the entries `t` of state and readings are read exactly."""
    C = np.eye(len(t))[t]
    k = len(C)
    return ahead.now._replace(
        C=C, V=np.zeros((k, 0)), deviation=np.zeros(k), blind=np.eye(k), Gamma=0 * C.T
    )


def _agreed(
    settings: Settings,
    state: LateState,
    ahead: Ahead,
    came: Vector,
    move: Move,
    read: Setting,
    found: dict[str, np.ndarray],
    known: Matrix,
) -> Matrix:
    """The covariance of the rounding in what is expected, unless readings disagree."""
    arrived = [one for one, now in zip(ahead.held, came) if now]
    expected = np.abs(ahead.xi[:, 0])
    n, fresh = len(ahead.now.A), len(ahead.xi) - len(ahead.new)
    C = np.abs(ahead.now.C[ahead.new])
    made_of = np.concatenate([ahead.made_of, expected[n:fresh], C @ ahead.made_of])
    size = np.array([one.size for one in arrived])
    before = rounding_of(state.xi) if state.rounding is None else state.rounding
    rounding, met = followed(before, move.A, read.C, found, made_of, size)
    if not arrived:
        return rounding
    innovation = np.array([one.value for one in arrived])
    innovation -= ahead.xi[ahead.of_all(came), 0]
    names = [_name(settings, one, ahead.instant) for one in arrived]
    require_agreement(known, innovation, met, found["unit"], names, ahead.instant)
    return rounding


def _name(settings: Settings, one: Held, instant: int) -> str:
    """An output, and the instant of its reading if that is not this one."""
    name = settings.plant.output_names[one.output]
    return name if one.instant == instant else f"{name} of instant {one.instant}"


def _leaves_digits(P: Matrix, n: int) -> bool:
    """Whether a covariance of n states and of readings can go on without a factor."""
    upper, info = dpotrf(P)
    if info != 0:
        return False
    pivots, size = upper.diagonal() ** 2, P.diagonal()
    return bool((pivots > np.where(np.arange(len(P)) < n, SAFE, DIGITS) * size).all())
