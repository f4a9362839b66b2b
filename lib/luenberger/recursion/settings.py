"""What every filter of Leondes and Novak needs to know of a plant at one instant."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .. import kernels
from ..certificate import require_real
from ..errors import FIT, SAMPLE, DesignError
from ..numeric import Matrices, Matrix, Vector
from ..numeric.detectability import dies_out, hidden_modes
from ..numeric.factors import clear, factor, firm, lengths, safe
from ..numeric.linalg import (
    UNIT_TOL,
    complete,
    nonsingular,
    null_directions,
    solve_right,
)
from ..papers.leondes_novak.derivation import (
    closed_loop,
    decorrelation,
    gain_step,
    observer_matrices,
    root_decorrelation,
)
from ..plant import Plant
from .root_step import Move, Spread, root_step
from .weight import canonical_weight, positive_weight

PATTERNS = 1000  # of outputs that arrived, kept at most: a long record has many


class Setting(NamedTuple):
    """One instant: the decorrelated plant and the split of the outputs.

    ``As, Qs, J`` describe x+ = As x + B u + J (y - E u) + w~ with w~ independent of
    v; As, Qs and a factor of Qs are in ``move``, which leads to the next instant.
    ``Gamma`` (n, p) makes C1 x^ = y1; ``Phat, That`` are the rest of (47).
    ``blind`` (p, .) are the combinations of outputs that carry no noise; ``V`` (p, .)
    and ``deviation`` (p,) are a factor of R and the roots of its diagonal.
    ``noise_free`` says whether there is an instant at which some outputs carry no
    noise: rounding is then followed in states that are known exactly.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    E: np.ndarray
    Q: np.ndarray
    R: np.ndarray
    J: np.ndarray
    Gamma: np.ndarray
    Phat: np.ndarray
    That: np.ndarray
    weight: np.ndarray | None
    blind: np.ndarray
    V: np.ndarray
    deviation: np.ndarray
    move: Move
    noise_free: bool

    @property
    def As(self) -> Matrix:
        """Dynamics of the decorrelated plant."""
        return self.move.A

    @property
    def Qs(self) -> Matrix:
        """Covariance of the part of w that v does not show."""
        return self.move.Q

    @property
    def whole_weight(self) -> Matrix:
        """The weight, the identity where none is given."""
        return np.eye(len(self.A)) if self.weight is None else self.weight

    def step(
        self, move: Move, spread: Spread
    ) -> tuple[Matrices, Spread, Matrix | None]:
        """From the `Spread` of the instant before to the gain and Sigma of this one.

        Returns the matrices by name, the `Spread`, and the combinations of outputs
        that were known before they were read (None if there can be none).
        """
        if spread.half is None and not self.blind.size:
            new = kernels.compiled(gain_step)(
                A=move.A, Q=move.Q, C=self.C, R=self.R, Gamma=self.Gamma,
                Sigma=spread.Sigma,
            )  # fmt: skip
            if self.clear(new["Sigma_next"], new["Omega"].diagonal()):
                return new, Spread(new["Sigma_next"]), None
        return root_step(self, move, spread)

    def clear(self, Sigma: Matrix, size: Vector) -> bool:
        """Whether Sigma needs no factor, beside variances of `size`."""
        return (safe if self.noise_free else firm)(Sigma, size)

    def closed(self, K: Matrix, *wanted: str) -> Matrices:
        """What a constant gain makes of errors and noises: Y, Phi, Q_c, F."""
        have = dict(A=self.As, Q=self.Qs, C=self.C, R=self.R, K=K)
        have |= dict(Phat=self.Phat, That=self.That)
        return kernels.run(closed_loop, have, *wanted)

    def predictor(self, K: Matrix) -> Matrix:
        """The gain As K + J of the prediction of the next instant from this one's."""
        have = self._asdict() | dict(As=self.As, K=K, T_next=np.eye(len(K)))
        return kernels.run(observer_matrices, have, "D")["D"]


class Settings:
    """The settings of a plant over time, for a choice of accurate outputs.

    Parameters
    ----------
    plant : Plant
    m1 : int or sequence
        How many leading outputs are accurate, or which (indices or names).
    weight : (n, n) array_like, "canonical" or None
        Whose trace is minimised: tr(weight Sigma).
    origin : int, default 0
        The instant of the record that is instant 0 of the plant: a plant over a window
        of a longer record has its own.
    """

    def __init__(
        self,
        plant: Plant,
        m1: int | Sequence[int | str],
        weight: ArrayLike | str | None = None,
        origin: int = 0,
    ) -> None:
        _, self.R = require_noise(plant)
        self.plant, self.origin = plant, origin
        self.accurate = accurate_outputs(plant, m1)
        self.weight: Matrix | str | None = None
        if isinstance(weight, str):
            if weight != "canonical":
                raise ValueError(
                    f"weight must be an (n, n) matrix or 'canonical', got {weight!r}"
                )
            self.weight = weight
        elif weight is not None:
            self.weight = positive_weight(weight, plant.n)
        self.steps = plant.steps
        self._known: dict[tuple[int, bytes | None], Setting] = {}

    @cached_property
    def noise_free(self) -> bool:
        """Whether there is an instant at which some outputs carry no noise."""
        return not np.all(nonsingular(self.R))

    @cached_property
    def unseen_lasting(self) -> list[complex]:
        """The modes that last and no output shows, of a plant that does not change."""
        if self.steps is not None or dies_out(self.plant.A):
            return []
        return hidden_modes(self.plant.A, self.plant.C, least=1 - UNIT_TOL)

    @property
    def unseen_growth(self) -> list[complex]:
        """Those of them that are not stable."""
        return [mode for mode in self.unseen_lasting if abs(mode) > 1]

    @property
    def order(self) -> int:
        return self.plant.n - len(self.accurate)

    def at(self, i: int, seen: Vector | None = None) -> Setting:
        """The setting at instant i; `seen` (p,) bool tells which outputs arrived."""
        i = 0 if self.steps is None else min(i - self.origin, self.steps - 1)
        key = i, None if seen is None else seen.tobytes()
        found = self._known.get(key)  # another thread may clear all
        if found is None:
            # a time-varying plant passes each instant once
            if self.steps is not None or len(self._known) >= PATTERNS:
                self._known.clear()
            found = self._known[key] = self._make(i, seen)
        return found

    def _make(self, i: int, seen: Vector | None) -> Setting:
        now = self.plant.at(i)
        A, B, C, E = now.A, now.B, now.C, now.E
        Q, R, S = now.covariances()
        accurate = np.isin(np.arange(self.plant.p), self.accurate)
        if seen is not None:
            C, E, R, accurate = C[seen], E[seen], R[np.ix_(seen, seen)], accurate[seen]
            S = S[:, seen]
        weight = canonical_weight(C) if isinstance(self.weight, str) else self.weight
        labels = [self.plant.output_names[k] for k in self.accurate]
        Phat, Gamma1, That = complete(C[accurate], weight, labels)
        Gamma = np.zeros(C.T.shape)
        Gamma[:, accurate] = Gamma1
        J = solve_right(S, R)
        move = _decorrelated(A, C, Q, R, S, J)
        blind, V, deviation = null_directions(R), factor(R), np.sqrt(R.diagonal())
        return Setting(
            A, B, C, E, Q, R, J, Gamma, Phat, That, weight, blind, V, deviation, move,
            self.noise_free,
        )  # fmt: skip


def _decorrelated(
    A: Matrix, C: Matrix, Q: Matrix, R: Matrix, S: Matrix, J: Matrix
) -> Move:
    """What leads to the next instant, driven by the part of w that v does not show."""
    if not S.any():
        return Move(A, Q, factor(Q), np.abs(A))
    As = kernels.compiled(decorrelation, "As")(A=A, C=C, J=J)["As"]
    joint = factor(np.block([[Q, S], [S.T, R]]))
    Nw, Nv = joint[: len(A)], joint[len(A) :]
    G = kernels.compiled(root_decorrelation)(Nw=Nw, Nv=Nv, J=J)["G"]
    G = clear(G, lengths(Nw) + np.abs(J) @ lengths(Nv))
    return Move(As, G @ G.T, G, np.abs(A) + np.abs(J) @ np.abs(C))


def require_noise(plant: Plant) -> tuple[Matrix, Matrix]:
    """Q and R, or DesignError unless a filter can be made of what the plant says."""
    require_real("the filter", plant)
    if plant.dt == 0:
        raise DesignError(
            f"the filter is for discrete time but the plant has dt = 0; {SAMPLE}"
        )
    Q, R = plant.Q, plant.R
    if Q is None or R is None:
        name, meaning = ("Q", "process") if Q is None else ("R", "measurement")
        raise DesignError(
            f"the plant has no {name}, the covariance of the {meaning} noise; "
            f"give Plant(..., {name}=...), zeros if there is none; {FIT}"
        )
    if plant.multiplicative:
        raise DesignError(
            "the plant has multiplicative noise, which this filter does not model and "
            "whose error covariance would come out too small. Use fixed_order_filter, "
            "or leave it out knowingly, with Plant(..., multiplicative=())."
        )
    return Q, R


def require_start(plant: Plant) -> Matrix:
    """P0, or DesignError if the plant has none."""
    if plant.P0 is None:
        raise DesignError(
            "a time-varying filter starts from the covariance P0 of the initial "
            "state; give Plant(..., P0=...), zeros if the state is known exactly"
        )
    return plant.P0


def accurate_outputs(plant: Plant, m1: int | Sequence[int | str]) -> tuple[int, ...]:
    """Indices of the accurate outputs, from a number, indices or names."""
    p = plant.p
    if isinstance(m1, (int, np.integer)) and not isinstance(m1, bool):
        if not 0 <= m1 <= p:
            raise DesignError(f"m1 must be between 0 and p = {p}, got {m1}")
        return tuple(range(m1))
    if isinstance(m1, (str, bool, float)) or not np.iterable(m1):
        raise DesignError(
            f"m1 must be a number of outputs or a list of outputs, got {m1!r}"
        )
    chosen = []
    for one in m1:
        if isinstance(one, str) and one in plant.output_names:
            one = plant.output_names.index(one)
        if not isinstance(one, (int, np.integer)) or not 0 <= one < p:
            raise DesignError(
                f"{one!r} is not an output: use indices 0 .. {p - 1} or names among "
                f"{list(plant.output_names)}"
            )
        chosen.append(int(one))
    if len(set(chosen)) != len(chosen):
        raise DesignError(f"the accurate outputs {list(m1)} name one output twice")
    return tuple(sorted(chosen))
