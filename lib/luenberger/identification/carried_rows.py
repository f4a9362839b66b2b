"""What rows of an information carry on, in compiled code, a direction at a time."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, Protocol

import numpy as np

from .. import kernels
from ..numeric import Matrices, Matrix
from ..recursion.state import flat
from ..stage_list import StageList
from .derivation import told_back

ENOUGH = 256  # rows that pay for compiled code

BACK = kernels.Recursion(
    told_back,
    carried=(("Pi", "Pi_next"),),
    rows=(),
    written=(("Pis", "Pi", "vector"),),
    symmetric=("W", "Pi_next"),
    backward=True,
)


class Each(Protocol):
    """What is carried, before each row as stacks, and after the last."""

    def __call__(
        self, stages: StageList, have: Matrices, rows: int, **carried: Matrix
    ) -> tuple[Matrices, Matrices]: ...


@cache
def _forward(stages: StageList, names: tuple[str, ...]) -> kernels.Recursion:
    """A stage list that carries what has these names."""
    return kernels.Recursion(
        stages,
        carried=tuple((f"{name}_next", name) for name in names),
        rows=(),
        written=tuple((f"{name}s", f"{name}_next", "vector") for name in names),
    )


def compiled_back(given: Matrices, rows: int, Pi: Matrix) -> tuple[Matrix, Matrix]:
    """What the rows after each row tell, (rows, n, n), and all rows together."""
    found, Pi = np.empty((rows + 1, Pi.size)), Pi.copy()
    found[rows] = Pi.ravel()
    stacks = {name: _plain(given[name][:, 0]) for name in "ACGW"}
    _kernel(BACK, given, stacks)(
        **stacks, Pi_next=Pi.reshape(-1), Pis=found[:rows], last=rows - 1, start=0,
        stop=rows, keep=False,
    )  # fmt: skip
    found = found.reshape(rows + 1, *Pi.shape)
    return found[1:], found[0]


def compiled_each(
    stages: StageList, have: Matrices, rows: int, **carried: Matrix
) -> tuple[Matrices, Matrices]:
    """What is carried, before each row as stacks, and after the last."""
    recursion = _forward(stages, tuple(carried))
    wanted = kernels.compiled(stages, *(f"{name}_next" for name in carried)).given
    given = {name: have[name] for name in wanted if name not in carried}
    count = max(len(X) for X in carried.values())
    found = {
        name: np.empty((len(X), rows + 1, X[0].size)) for name, X in carried.items()
    }
    index, good = np.arange(rows), np.ones(rows, dtype=bool)
    for k in range(count):
        stacks = {name: _plain(_of(X, k)) for name, X in given.items()}
        kernel = _kernel(recursion, have, stacks)
        now, out = dict[str, np.ndarray](), dict[str, np.ndarray]()
        for name, X in carried.items():
            at = min(k, len(X) - 1)
            now[name] = X[at].flatten()
            found[name][at, 0] = now[name]
            out[f"{name}s"] = found[name][at, 1:]
        kernel(
            **stacks, **now, **out, now=index, before=index, good=good, start=0,
            stop=rows, keep=False,
        )  # fmt: skip
    shaped = {
        name: X.reshape(len(X), rows + 1, *carried[name].shape[1:]).swapaxes(0, 1)
        for name, X in found.items()
    }
    before = {name: X[:-1] for name, X in shaped.items()}
    return before, {name: X[-1] for name, X in shaped.items()}


def _of(X: Matrix, k: int) -> Matrix:
    """The stack of one direction."""
    return X[:, k if X.shape[1] > 1 else 0]


def _plain(X: Matrix) -> Matrix:
    return flat(kernels.plain_array(X))


def _kernel(
    recursion: kernels.Recursion, have: Matrices, stacks: Matrices
) -> Callable[..., Any]:
    """The loop over rows; what has more than one matrix has one for each row."""
    p, n = have["C"].shape[-2:]
    changing = frozenset(name for name, X in stacks.items() if len(X) > 1)
    return kernels.over_record(recursion, (("n", n), ("p", p)), (), changing)
