"""The gradient of the likelihood: one pass back over a filter's rows."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from .. import kernels
from ..numeric import Matrices, Matrix
from ..plant import Plant
from ..recursion.state import flat
from .derivation import score_pass, score_step, start_score
from .trail import Trail

TOGETHER = 1024  # rows whose gradients are added up before they join the others


class Adjoint(NamedTuple):
    """What the pass back carries: of rows to come, what a prediction means to them.

    ``eta`` (n, c) is the gradient in the prediction, and the one in its covariance is
    1/2 (eta eta' - Pi).
    """

    eta: np.ndarray
    Pi: np.ndarray

    @classmethod
    def after(cls, n: int, columns: int = 1) -> Adjoint:
        """After the last row."""
        return cls(np.zeros((n, columns)), np.zeros((n, n)))


def names(plant: Plant) -> tuple[str, ...]:
    """The matrices in which a likelihood of the plant has a gradient."""
    parts = ["A", "B", "C", "E"] if plant.m else ["A", "C"]
    parts += [name for name in ("Q", "R", "S") if getattr(plant, name) is not None]
    return (*parts, *(() if plant.P0 is None else ("x0", "P0")))


class Sums:
    """The gradients so far, in the shapes of the plant's matrices.

    Those in the matrices of `wanted`, or in all.
    """

    def __init__(self, plant: Plant, wanted: tuple[str, ...] | None = None) -> None:
        self.plant = plant
        self.found = {
            name: np.zeros(getattr(plant, name).shape)
            for name in names(plant)
            if name not in ("x0", "P0") and (wanted is None or name in wanted)
        }

    def add(self, instant: int, found: Matrices) -> None:
        """Add the gradients "gA", ... of one instant."""
        for name, total in self.found.items():
            here = total if total.ndim == 2 else total[instant]
            here += found[f"g{name}"]


@cache
def _backward(kinds: tuple[tuple[str, str], ...]) -> kernels.Recursion:
    """The pass back, which writes the gradients in the matrices of these names."""
    return kernels.Recursion(
        score_pass,
        carried=(("eta", "eta_next"), ("Pi", "Pi_next")),
        rows=(("x", "predictions", 0), ("e", "es", 0), ("u", "us", 0)),
        written=tuple((f"g{name}s", f"g{name}", kind) for name, kind in kinds),
        symmetric=("Omega", "W", "Pi_next"),
        backward=True,
    )


def back(
    trail: Trail, plant: Plant, u: Matrix, sums: Sums, now: Adjoint, first: int = 1
) -> Adjoint:
    """Over the rows of a trail, from the last to the first, of the instant `first`.

    Rows that compiled code did are done by it again, and the others in NumPy.
    """
    by_hand = np.flatnonzero(~trail.compiled)
    some = len(by_hand) < len(u)
    block = Block(trail, plant, u, sums, first) if some else None
    k = len(u)
    while k > 0:
        before = by_hand[: np.searchsorted(by_hand, k)]
        start = int(before[-1]) + 1 if len(before) else 0
        if block is not None and start < k:
            start = max(start, k - TOGETHER)
            now, k = block.run(start, k, now), start
            continue
        k -= 1
        at = plant.at(first + k)
        found = row(trail, k, dict(A=at.A, C=at.C, u=u[k][:, None]), now)
        now = Adjoint(found["eta"], found["Pi"])
        sums.add(first + k, found)
    return now


def row(trail: Trail, k: int, given: Matrices, now: Adjoint) -> Matrices:
    """`score_step` in one row; `given` has A, C and u, and x and e of more columns."""
    have = dict(
        Omega=trail.Omega[k], G=trail.G[k], W=trail.W[k],
        x=trail.x[k][:, None], e=trail.e[k][:, None],
        eta_next=now.eta, Pi_next=now.Pi,
    )  # fmt: skip
    return kernels.compiled(score_step)(**(have | given))


class Block:
    """Rows that compiled code can do, with all it needs to know of them."""

    def __init__(
        self, trail: Trail, plant: Plant, u: Matrix, sums: Sums, first: int
    ) -> None:
        self.sums, self.first = sums, first
        sizes = tuple((k, getattr(plant, k)) for k in "mnp")
        stacks, known = _stacks(trail, plant, first)
        self.changing = {name for name, X in stacks.items() if len(X) > 1}
        self.changing |= {"Omega", "W"}
        kinds = ("sum" if X.ndim == 2 else "vector" for X in sums.found.values())
        self.kernel = kernels.over_record(
            _backward(tuple(zip(sums.found, kinds))),
            (*sizes, ("c", 1)),
            known,
            frozenset(self.changing),
        )
        self.given = {name: flat(kernels.plain_array(X)) for name, X in stacks.items()}
        self.rows = dict(predictions=trail.x, es=trail.e, us=kernels.plain_array(u))

    def run(self, start: int, stop: int, now: Adjoint) -> Adjoint:
        """The rows from stop - 1 down to `start`."""
        here, size = slice(start, stop), stop - start
        given = {k: X[here] if k in self.changing else X for k, X in self.given.items()}
        given |= {name: X[here] for name, X in self.rows.items()}
        found = {k: self.room(X, start, size) for k, X in self.sums.found.items()}
        given |= {f"g{name}s": flat(X) for name, X in found.items()}
        eta, Pi = now.eta[:, 0].copy(), now.Pi.flatten()
        self.kernel(
            **given, eta_next=eta, Pi_next=Pi, last=size - 1, start=0, stop=size,
            keep=True,
        )  # fmt: skip
        for name, X in self.sums.found.items():
            if X.ndim == 2:
                X += found[name][0]
        return Adjoint(eta[:, None], Pi.reshape(now.Pi.shape))

    def room(self, total: Matrix, start: int, size: int) -> Matrix:
        """Where `size` rows from `start` on put their gradients: one sum, or each."""
        at = self.first + start
        return np.zeros((1, *total.shape)) if total.ndim == 2 else total[at : at + size]


def _stacks(trail: Trail, plant: Plant, first: int) -> tuple[Matrices, tuple]:
    """Stacks by name, of one matrix or one for each row, and what entries are known."""
    S = np.zeros((plant.n, plant.p)) if plant.S is None else plant.S
    given = dict(A=plant.A, C=plant.C, S=S)
    stacks, known = dict[str, np.ndarray](), []
    for name, X in given.items():
        varies = X.ndim == 3
        stacks[name] = X[first : first + len(trail.free)] if varies else X[None]
        if not varies:
            known.append((name, kernels.entries_known(X == 0, X == 1)))
    return stacks | dict(Omega=trail.Omega, W=trail.W), tuple(known)


def at_start(plant: Plant, now: Adjoint, u0: Matrix, sums: Sums) -> Matrices:
    """The gradients in x0 and P0; what leads to the first row is added to the sums."""
    assert plant.P0 is not None
    if not plant.at_first:
        n, p = plant.n, plant.p
        given = dict(
            A=plant.at(0).A, C=np.zeros((p, n)), Omega=plant.P0, G=np.zeros((n, p)),
            W=np.zeros((p, p)), e=np.zeros((p, 1)), x=plant.x0[:, None],
            u=u0[:, None], eta_next=now.eta, Pi_next=now.Pi,
        )  # fmt: skip
        found = kernels.compiled(score_step)(**given)
        sums.add(0, found)
        now = Adjoint(found["eta"], found["Pi"])
    gP = kernels.compiled(start_score)(eta=now.eta, Pi=now.Pi)["gP"]
    return dict(x0=now.eta[:, 0], P0=gP)
