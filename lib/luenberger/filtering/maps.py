"""The matrices of a filter's rows: the plant at an instant, and what arrived."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..numeric import Matrix, Vector
from ..numeric.detectability import dies_out, hidden_modes
from ..numeric.factors import factor
from ..numeric.linalg import UNIT_TOL, complete, solve_right
from ..plant import Plant
from ..recursion.settings import accurate_outputs, require_noise
from ..recursion.weight import canonical_weight, positive_weight
from .passes import Maps, gram, whiten

PATTERNS = 1000  # of outputs that arrived, kept at most: a long record has many
FIRM = 1e-8  # a pivot of R at unit diagonal; below it outputs are not told apart by it


class Settings:
    """What a filter of a plant does at each instant.

    Parameters
    ----------
    plant : Plant
        Discrete, with Q and R.
    m1 : int or sequence
        Outputs that are taken as accurate: how many leading ones, or which.
    weight : (n, n) array_like, "canonical" or None
        Whose trace is minimised where outputs are accurate.
    origin : int
        The instant of the record that is instant 0 of the plant.
    """

    def __init__(
        self,
        plant: Plant,
        m1: int | Sequence[int | str] = 0,
        weight: ArrayLike | str | None = None,
        origin: int = 0,
    ) -> None:
        require_noise(plant)
        self.plant, self.origin = plant, origin
        self.accurate = accurate_outputs(plant, m1)
        self.weight: Any = weight
        if weight is not None and not isinstance(weight, str):
            self.weight = positive_weight(weight, plant.n)
        elif weight not in (None, "canonical"):
            raise ValueError(
                f"weight must be an (n, n) matrix or 'canonical', got {weight!r}"
            )
        self.way = self._way()
        self.as_is = np.eye(plant.p)  # what mixes no outputs
        self.first: Any = None  # the state before a record, once it is asked for
        self._known: dict[Any, Any] = {}
        self._stacked: Any = (None, None, None)
        self._steady: list[Any] = []

    @cached_property
    def unseen_growth(self) -> list[complex]:
        """The unstable modes that no output shows, of a plant that does not change."""
        plant = self.plant
        if plant.steps is not None or dies_out(plant.A):
            return []
        found = hidden_modes(plant.A, plant.C, least=1 - UNIT_TOL)
        return [mode for mode in found if abs(mode) > 1]

    def steady(self, run: Callable) -> Any:
        """The settled filter of complete rows, found once by `run`; or None."""
        if not self._steady:
            from . import tail  # which needs this module

            everything = np.ones(self.plant.p, dtype=bool)
            maps = Maps(*(X[None] for X in self.at(1, everything)[0]))
            self._steady.append(tail.steady(maps, run))
        return self._steady[0]

    def _way(self) -> str:
        """What is beside the state: "nothing", the noises of "outputs", or of "all"."""
        plant = self.plant
        if plant.S is not None and np.any(plant.S):
            return "all"
        R: Any = plant.R if plant.R.ndim == 3 else plant.R[None]  # type: ignore
        pushed = self.accurate and np.any(R[:, self.accurate, self.accurate])
        if pushed or not all(map(_told_apart, R)):
            return "outputs"
        return "nothing"

    def at(self, i: int, seen: Vector) -> tuple[Maps, Matrix]:
        """The `Maps` of instant i with the outputs `seen`, and what whitens them."""
        key = self._step(i), seen.tobytes()
        found = self._known.get(key)  # once: threads may clear it
        if found is None:
            # a plant that changes passes each instant once
            if self.plant.steps is not None or len(self._known) >= PATTERNS:
                self._known.clear()
            found = self._known[key] = self._make(self.now(i), seen)
        return found

    def _step(self, i: int) -> int:
        """The step of the plant at instant i."""
        steps = self.plant.steps
        return 0 if steps is None else min(max(i - self.origin, 0), steps - 1)

    def now(self, i: int) -> Any:
        """The plant's matrices at instant i."""
        return self.plant.at(self._step(i))

    def stack(self, found: tuple[Any, ...]) -> tuple[Maps, Matrix]:
        """What `at` found as stacks, the same where they were asked for before."""
        key = tuple(map(id, found))
        known, stacks, _ = self._stacked  # at once: threads may replace it
        if known != key:
            maps, mix = zip(*found)
            stacks = Maps(*(np.stack(X) for X in zip(*maps))), np.stack(mix)
            self._stacked = key, stacks, found  # kept, so that no other has their ids
        found_: tuple[Maps, Matrix] = stacks
        return found_

    def _factor(self, X: Matrix) -> Matrix:
        """A factor; as wide at every instant, whatever the rank is there."""
        H = factor(X)
        if self.plant.steps is None:
            return H
        return np.hstack([H, np.zeros((len(X), len(X) - H.shape[1]))])

    def _triangle(self, Q: Matrix) -> Matrix:
        """A factor in which half is zero, and stays so where rows are made shorter."""
        V, D = factors(Q)
        G = V.T * np.sqrt(D)
        return G if self.plant.steps is not None else G[:, D > 0]

    def push(self, i: int, seen: Vector) -> Matrix:
        """How the accurate ones of `seen` outputs push an estimate of instant i."""
        return self._push(self.now(i).C, seen)

    def _push(self, C: Matrix, seen: Vector) -> Matrix:
        accurate = [j for j in self.accurate if seen[j]]
        canonical = isinstance(self.weight, str)
        weight = canonical_weight(C[seen]) if canonical else self.weight
        labels = [self.plant.output_names[k] for k in accurate]
        Gamma = np.zeros(C.T.shape)
        Gamma[:, accurate] = complete(C[accurate], weight, labels)[1]
        return Gamma

    def _make(self, now: Any, seen: Vector) -> tuple[Maps, Matrix]:
        A, C = now.A, np.where(seen[:, None], now.C, 0.0)
        Q, R, S = now.covariances()
        n, p = len(A), len(C)
        L, none = self.as_is, np.zeros((n, 0))
        if self.way == "nothing":
            r = np.ones(p)  # of an output that did not arrive it is not used
            some = np.flatnonzero(seen)
            mix, r[some] = _whitened(R[np.ix_(some, some)])
            if np.tril(mix, -1).any():
                L = np.eye(p)
                L[np.ix_(some, some)] = mix
            if self.accurate:
                self._push(now.C, seen)  # refuses dependent ones
            G = self._triangle(Q)
            return _one(A, A, G, none, none, L @ now.C, r, np.ones(0)), L
        joint = (
            self._factor(R)
            if self.way == "outputs"
            else self._factor(np.block([[Q, S], [S.T, R]]))
        )
        q = joint.shape[1]
        Gv = np.where(seen[:, None], joint[-p:] if p else joint[:0], 0.0)
        Gw = np.zeros((n, q)) if self.way == "outputs" else joint[:n]
        G = self._triangle(Q) if self.way == "outputs" else none
        outputs = np.hstack([C, Gv]), np.zeros(p), np.ones(q)
        if not self.accurate:
            both = np.hstack([A, Gw])
            return _one(both, both, G, none, none, *outputs), L
        J = np.zeros((n, p))
        if seen.any():
            J[:, seen] = solve_right(S[:, seen], R[np.ix_(seen, seen)])
        O = self._push(now.C, seen) @ Gv  # noqa: E741
        rest = Gv - C @ O
        M = np.hstack([A, A @ O + J @ rest])
        B = np.hstack([A - J @ C, Gw - J @ Gv])
        X = Gw - J @ Gv - (A - J @ C) @ O
        return _one(M, B, G, X, O, *outputs), L


def _one(*matrices: Matrix) -> Maps:
    return Maps(*(np.array(X, dtype=float, order="C") for X in matrices))  # to write


def _told_apart(R: Matrix) -> bool:
    """Whether outputs have noises of their own, or can be combined so that they do."""
    if not (R - np.diag(R.diagonal())).any():
        return True
    noisy = R.diagonal() > 0
    if not noisy.all():
        R = R[np.ix_(noisy, noisy)]
    scale = np.sqrt(R.diagonal())
    return np.linalg.eigvalsh(R / scale / scale[:, None])[0] > FIRM


def _whitened(R: Matrix) -> tuple[Matrix, Vector]:
    """L and r with L R L' = diag(r), L lower triangular with a unit diagonal."""
    L, r = np.eye(len(R)), R.diagonal().copy()
    if (R - np.diag(r)).any():
        whiten.on()(R.copy(), L, np.zeros(len(R)), r)
    return L, r


def factors(P: Matrix) -> tuple[Matrix, Vector]:
    """V and D of a covariance."""
    n, H = len(P), factor(P)
    H = np.hstack([H, np.zeros((n, 1))]) if not H.shape[1] else H
    V, D, ones = np.zeros((n, n)), np.zeros(n), np.ones(H.shape[1])
    gram(H, ones, P.diagonal().copy(), V, D, np.zeros((0, n)), ones.copy())
    return V, D
