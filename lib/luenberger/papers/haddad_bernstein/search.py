"""Where to start, and which minima the descents arrive at.

The theorem with tau = I names n directions: those that diagonalise Qh and Ph of the
Kalman filter.  Any choice of `order` of them is a filter near a stationary point, so
these are the first starts, the strongest directions before all.  Then come random
ones, uniform over the stable filters of that order.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, islice
from typing import NamedTuple

import numpy as np

from ...analysis.optimality import Optimality
from ...errors import CertificateError
from ...kernels import run
from ...numeric import Matrix, Vector
from ...numeric.linalg import radius
from ...observer import Observer
from .derivation import projection_gains
from .descent import Frame, descend
from .target import Target

RANK_TOL = 1e-8  # direction too weak, beside the strongest, to change the cost
UNUSED = 1e-7  # the same beside the estimate that is sought, when all are weak
AHEAD = 8  # strongest directions from which the first starts are chosen, at least
EQUAL = 1e-10  # difference of two costs, beside their scale, that is none
SAME = 1e-4  # relative distance of two frequency responses that are one minimum


@dataclass(frozen=True, eq=False)
class Minimum:
    """One local minimum of the cost.

    Attributes
    ----------
    observer : Observer
    cost : float
        Steady E[(w^ - L x)' weight (w^ - L x)].
    excess : float
        `cost` less what an estimator of any order must cost.  It is computed by
        itself, not as a difference, and tells minima apart that `cost` does not.
    optimality : Optimality
        The residuals of its necessary conditions.
    starts : tuple of str
        The starts that led to it.
    """

    observer: Observer
    cost: float
    excess: float
    optimality: Optimality
    starts: tuple


@dataclass(frozen=True, eq=False)
class Search:
    """What the search for a fixed-order filter found.

    Attributes
    ----------
    minima : tuple of Minimum
        Different local minima, the best first.
    failed : tuple of (str, str)
        Starts that led to no minimum, and why.
    least_cost : float
        The cost of the best estimator of any order, the Kalman filter.
    enough : int
        The order at which the Kalman filter's accuracy is reached; n when no state
        can be spared, and for a search of order n, which does not ask.
    """

    minima: tuple
    failed: tuple
    least_cost: float
    enough: int

    @property
    def best(self) -> Minimum:
        """The minimum of least cost."""
        return self.minima[0]


class Directions(NamedTuple):
    """The columns of `lift` are the directions, the rows of `read` their duals."""

    strength: np.ndarray
    lift: np.ndarray
    read: np.ndarray


def directions(target: Target) -> Directions:
    """Those that diagonalise Qh and Ph of the Kalman filter, the strongest first."""
    A, C, L = (target.matrices[name] for name in ("A", "C", "L"))
    driven = gramian_root(A, target.Kq)
    seen = gramian_root((A - target.Kq @ C).T, L.T)
    left, strength, right = np.linalg.svd(seen.T @ driven)
    least = max(strength.max(initial=0), UNUSED * np.sqrt(target.power))
    count = int((strength > RANK_TOL * least).sum())
    root = np.sqrt(strength[:count])
    return Directions(
        strength[:count],
        driven @ right[:count].T / root,
        (seen @ left[:, :count] / root).T,
    )


def gramian_root(A: Matrix, B: Matrix) -> Matrix:
    """H with H H' = sum of A^k B B' A^k', as accurate in weak directions as B is."""
    H, power = B, A
    for _ in range(64):
        more = power @ H
        if np.abs(more).max(initial=0) <= 1e-17 * np.abs(H).max(initial=0):
            break
        R = np.linalg.qr(np.hstack([H, more]).T, mode="r")
        H = np.transpose(R)
        power = power @ power
    return H


def starts(
    target: Target, found: Directions, order: int, number: int, seed: int
) -> Iterator[tuple[str, Matrix, Matrix]]:
    """(name, Ae, Be) of each start."""
    p, projected = len(target.matrices["C"]), number - number // 2
    for chosen in _choices(found.strength, order, projected):
        Ae, Be = _projection(target, found, chosen)
        size = radius(Ae)
        Ae = Ae if size < 1 else Ae * 0.98 / size
        names = ", ".join(str(k + 1) for k in chosen)
        yield f"directions {names}", Ae, Be
        projected -= 1
    for k in range(number // 2 + projected):
        draw = np.random.default_rng([seed, k]).normal(size=(order + p, order))
        Ae, Be = np.split(np.linalg.qr(draw)[0].T, [order], axis=1)
        yield f"random {k + 1}", Ae, Be


def _choices(strength: Vector, order: int, number: int) -> list[tuple[int, ...]]:
    """The strongest choices of `order` directions."""
    ahead = range(min(len(strength), max(order + 3, AHEAD)))
    ranked = sorted(
        islice(combinations(ahead, order), 100_000),
        key=lambda chosen: (-(strength[list(chosen)] ** 2).sum(), chosen),
    )
    return ranked[:number]


def _projection(
    target: Target, found: Directions, chosen: tuple[int, ...]
) -> tuple[Matrix, Matrix]:
    """Ae, Be of (3.10), (3.11) for the projection on the chosen directions."""
    chosen, p = list(chosen), len(target.matrices["C"])
    have = target.matrices | dict(Qs=target.Kq, V2s=np.eye(p))
    have |= dict(G=found.lift[:, chosen].T, Gam=found.read[chosen])
    gains = run(projection_gains, have, "Ae", "Be")
    return gains["Ae"], gains["Be"]


def minima(
    target: Target, found: Directions, order: int, number: int, seed: int
) -> tuple[list[tuple[Frame, list[str]]], list[tuple[str, str]]]:
    """Different minima [(Frame, names of starts)], the best first; and failed starts.

    `found` are the Directions of the target.
    """
    known = list[tuple[Frame, list[str]]]()
    failed = list[tuple[str, str]]()
    for name, Ae, Be in starts(target, found, order, number, seed):
        try:
            frame = descend(target, Ae, Be)
        except CertificateError as reason:
            failed.append((name, str(reason)))
            continue
        for other, names in known:
            if _same(frame, other):
                names.append(name)
                break
        else:
            known.append((frame, [name]))
    known.sort(key=lambda pair: pair[0].point.cost)
    return known, failed


def _same(one: Frame, other: Frame) -> bool:
    """Whether two minima are one, or lie in one valley of equal cost."""
    level = abs(one.point.cost - other.point.cost) <= EQUAL * one.target.scale
    if one.is_flat and other.is_flat and level:
        return True
    response = _response(one)
    gap = np.linalg.norm(response - _response(other))
    return bool(gap <= SAME * np.linalg.norm(response))


def _response(frame: Frame) -> Matrix:
    """Frequency response at three points, which coordinates do not change."""
    have = frame.point.have
    eye = np.eye(frame.r)
    points = np.exp(1j * np.array([0.3, 1.1, 2.3]))
    return np.stack(
        [
            have["Ce"] @ np.linalg.solve(z * eye - have["Ae"], have["Be"]) + have["De"]
            for z in points
        ]
    )
