"""The gradient of the likelihood: one pass back over a filter's rows."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from .. import kernels
from ..numeric import Matrices, Matrix
from ..plant import Plant
from ..recursion.state import flat
from .derivation import score_step, start_score
from .trail import Trail

TOGETHER = 1024  # rows whose gradients are kept before they are added up


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


class Sums:
    """The gradients so far, in the shapes of the plant's matrices."""

    def __init__(self, plant: Plant) -> None:
        names = "A B C E" if plant.m else "A C"
        given = {name: getattr(plant, name) for name in names.split()}
        given |= {name: getattr(plant, name) for name in ("Q", "R", "S")}
        given = {name: X for name, X in given.items() if X is not None}
        self.plant = plant
        self.found = {name: np.zeros(X.shape) for name, X in given.items()}

    def add(self, first: int, rows: Matrices) -> None:
        """Add the gradients "gA", ... of the instants from `first` on, as stacks."""
        for name, total in self.found.items():
            part = rows[f"g{name}"]
            if total.ndim == 2:
                total += part.sum(axis=0)
            else:
                total[first : first + len(part)] += part


@cache
def _backward(names: tuple[str, ...]) -> kernels.Recursion:
    """The pass back, which writes the gradients in the matrices of these names."""
    return kernels.Recursion(
        score_step,
        carried=(("eta", "eta_next"), ("Pi", "Pi_next")),
        rows=(("x", "predictions", 0), ("e", "es", 0), ("u", "us", 0)),
        written=tuple((f"g{name}s", f"g{name}", "vector") for name in names),
        symmetric=("Omega", "W", "Pi_next"),
        backward=True,
    )


def back(
    trail: Trail, plant: Plant, u: Matrix, sums: Sums, first: int, fast: bool
) -> Adjoint:
    """Over all rows of a trail, which begins at the instant `first`."""
    over = _compiled if fast and len(u) else _plain
    return over(trail, plant, u, sums, first)


def _plain(trail: Trail, plant: Plant, u: Matrix, sums: Sums, first: int) -> Adjoint:
    """Row by row in NumPy."""
    now = Adjoint.after(plant.n)
    for k in reversed(range(len(u))):
        at = plant.at(first + k)
        C = at.C * trail.free[k][:, None]
        found = row(trail, k, dict(A=at.A, C=C, u=u[k][:, None]), now)
        now = Adjoint(found["eta"], found["Pi"])
        sums.add(first + k, {name: X[None] for name, X in found.items()})
    return now


def row(trail: Trail, k: int, given: Matrices, now: Adjoint) -> Matrices:
    """`score_step` in one row; `given` has A, C and u, and x and e of more columns."""
    have = dict(
        Omega=trail.Omega[k], G=trail.G[k], W=trail.W[k],
        x=trail.x[k][:, None], e=trail.e[k][:, None],
        eta_next=now.eta, Pi_next=now.Pi,
    )  # fmt: skip
    return kernels.compiled(score_step)(**(have | given))


def _compiled(trail: Trail, plant: Plant, u: Matrix, sums: Sums, first: int) -> Adjoint:
    """The same in compiled code, some rows at a time."""
    N, names = len(u), tuple(sums.found)
    stacks, changing, known = _matrices(trail, plant, first)
    sizes = tuple((k, getattr(plant, k)) for k in "mnp") + (("c", 1),)
    changing |= {"Omega", "G", "W"}
    kernel = kernels.over_record(_backward(names), sizes, known, frozenset(changing))
    eta, Pi = np.zeros(plant.n), np.zeros(plant.n**2)
    rooms = {name: np.empty((TOGETHER, *X.shape[-2:])) for name, X in sums.found.items()}
    for stop in range(N, 0, -TOGETHER):
        start = max(stop - TOGETHER, 0)
        here, size = slice(start, stop), stop - start
        given = {
            name: flat(X[here] if name in changing else X) for name, X in stacks.items()
        }
        given |= dict(predictions=trail.x[here], es=trail.e[here], us=u[here])
        written = {f"g{name}s": flat(X) for name, X in rooms.items()}
        given = {name: X for name, X in given.items() if name in kernel.names}
        kernel(
            **given, **written, eta_next=eta, Pi_next=Pi,
            last=size - 1, start=0, stop=size, keep=True,
        )  # fmt: skip
        sums.add(first + start, {f"g{name}": X[:size] for name, X in rooms.items()})
    return Adjoint(eta[:, None], Pi.reshape(plant.n, plant.n))


def _matrices(
    trail: Trail, plant: Plant, first: int
) -> tuple[Matrices, set[str], tuple]:
    """Stacks by name, the names of those that change, and what entries are known."""
    N = len(trail.free)
    A, C = (
        X[first : first + N] if X.ndim == 3 else X[None] for X in (plant.A, plant.C)
    )
    changing = {name for name, X in (("A", A), ("C", C)) if len(X) > 1}
    if not trail.free.all():
        C = C * trail.free[:, :, None]
        changing.add("C")
    known = tuple(
        (name, kernels.entries_known(X[0] == 0, X[0] == 1))
        for name, X in (("A", A), ("C", C))
        if name not in changing
    )
    A, C = kernels.plain_array(A), kernels.plain_array(C)
    return dict(A=A, C=C, Omega=trail.Omega, G=trail.G, W=trail.W), changing, known


def at_start(plant: Plant, now: Adjoint, u0: Matrix, sums: Sums) -> Matrices:
    """The gradients in x0 and P0; what leads to the first row is added to the sums."""
    assert plant.P0 is not None
    if plant.P0_is == "posterior":
        n, p = plant.n, plant.p
        given = dict(
            A=plant.at(0).A, C=np.zeros((p, n)), Omega=plant.P0, G=np.zeros((n, p)),
            W=np.zeros((p, p)), e=np.zeros((p, 1)), x=plant.x0[:, None],
            u=u0[:, None], eta_next=now.eta, Pi_next=now.Pi,
        )  # fmt: skip
        found = kernels.compiled(score_step)(**given)
        sums.add(0, {name: X[None] for name, X in found.items()})
        now = Adjoint(found["eta"], found["Pi"])
    gP = kernels.compiled(start_score)(eta=now.eta, Pi=now.Pi)["gP"]
    return dict(x0=now.eta[:, 0], P0=gP)
