"""What every filter of Leondes and Novak needs to know of a plant at one instant."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .. import kernels
from ..certificate import require_real
from ..errors import FIT, SAMPLE, DesignError
from ..numeric import Matrices, Matrix
from ..numeric.factors import clear, factor, firm, lengths
from ..numeric.linalg import complete, null_directions, solve_right
from ..papers.leondes_novak.derivation import (
    closed_loop,
    decorrelation,
    gain_step,
    observer_matrices,
    root_decorrelation,
)
from ..plant import Plant
from .root_step import Move, Spread, root_step
from .weight import canonical_weight


class Setting(NamedTuple):
    """One instant: the decorrelated plant and the split of the outputs.

    ``As, Qs, J`` describe x+ = As x + B u + J (y - E u) + w~ with w~ independent of
    v; As, Qs and a factor of Qs are in ``move``, which leads to the next instant.
    ``Gamma`` (n, p) makes C1 x^ = y1; ``Phat, That`` are the rest of (47).
    ``blind`` (p, .) are the combinations of outputs that carry no noise; ``V`` (p, .)
    and ``deviation`` (p,) are a factor of R and the roots of its diagonal.
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

    def step(self, move: Move, spread: Spread) -> tuple[Matrices, Spread]:
        """From the `Spread` of the instant before to the gain and Sigma of this one."""
        if spread.half is None and not self.blind.size:
            new = kernels.compiled(gain_step)(
                A=move.A, Q=move.Q, C=self.C, R=self.R, Gamma=self.Gamma,
                Sigma=spread.Sigma,
            )  # fmt: skip
            if firm(new["Sigma_next"], new["Omega"].diagonal()):
                return new, Spread(new["Sigma_next"])
        return root_step(self, move, spread)

    def closed(self, K: Matrix, *wanted: str) -> Matrices:
        """What a constant gain makes of errors and noises: Y, Phi, Q_c, F."""
        have = dict(A=self.As, Q=self.Qs, C=self.C, R=self.R, K=K)
        have |= dict(Phat=self.Phat, That=self.That)
        return kernels.run(closed_loop, have, *wanted)

    def predictor(self, K: Matrix) -> Matrix:
        """The gain As K + J of the prediction of the next instant from this one's."""
        have = self._asdict() | dict(As=self.As, K=K, T_next=np.eye(len(K)))
        return kernels.run(observer_matrices, have, "D")["D"]


def setting(
    plant: Plant,
    accurate: Sequence[int] = (),
    weight: Matrix | str | None = None,
    i: int = 0,
) -> Setting:
    """The setting at instant i: the accurate outputs' indices, and whose trace."""
    now = plant.at(0 if plant.steps is None else min(i, plant.steps - 1))
    A, B, C, E = now.A, now.B, now.C, now.E
    Q, R, S = now.covariances()
    weight = canonical_weight(C) if isinstance(weight, str) else weight
    labels = [plant.output_names[k] for k in accurate]
    exact = np.isin(np.arange(plant.p), accurate)
    Phat, Gamma1, That = complete(C[exact], weight, labels)
    Gamma = np.zeros(C.T.shape)
    Gamma[:, exact] = Gamma1
    J = solve_right(S, R)
    move = _decorrelated(A, C, Q, R, S, J)
    blind, V, deviation = null_directions(R), factor(R), np.sqrt(R.diagonal())
    return Setting(
        A, B, C, E, Q, R, J, Gamma, Phat, That, weight, blind, V, deviation, move
    )


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


def require_noise(plant: Plant) -> None:
    """Raise unless a filter can be made of what the plant says of its noise."""
    require_real("the filter", plant)
    if plant.dt == 0:
        raise DesignError(
            f"the filter is for discrete time but the plant has dt = 0; {SAMPLE}"
        )
    for name, meaning in ("Q", "process"), ("R", "measurement"):
        if getattr(plant, name) is None:
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


def require_start(plant: Plant) -> None:
    """Raise unless the plant has P0."""
    if plant.P0 is None:
        raise DesignError(
            "a time-varying filter starts from the covariance P0 of the initial "
            "state; give Plant(..., P0=...), zeros if the state is known exactly"
        )


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
