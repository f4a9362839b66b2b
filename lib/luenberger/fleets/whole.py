"""A plant's matrices in every row of a record, as panels read them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from threading import Lock
from typing import Any

import numpy as np

from .. import kernels
from ..numeric import Matrices
from ..papers.leondes_novak.derivation import predict
from ..recursion.filter_stacks import Stacks
from ..recursion.state import State, flat, leading_on


@dataclass(frozen=True, eq=False)
class Whole:
    """The matrices of all outputs, whether they arrived or not, of any record.

    Row k has those of its own instant, and A and B lead on from there.  Threads may
    read them side by side.

    Attributes
    ----------
    stacks : Stacks
    begin : State
        Where every record begins.
    rows : int
        How many rows it has.
    """

    stacks: Stacks
    begin: State
    rows: int
    _made: dict[object, Any] = field(default_factory=dict)
    _lock: Any = field(default_factory=Lock)

    @property
    def varying(self) -> bool:
        """Whether they change from row to row."""
        return self.stacks.varying

    @property
    def matrices(self) -> Matrices:
        """By name, (N, rows * cols), or (1, ...) where they stay."""
        return self.once("matrices", self._matrices)

    @property
    def first(self) -> Matrices:
        """What is predicted for the first row, and the covariance of its error."""
        return self.once("first", self._first)

    def known(self, **names: str) -> tuple[tuple[str, Any], ...]:
        """What is known of the entries of matrices, under other names."""
        found = ((to, self.stacks.known(k, self.varying)) for to, k in names.items())
        return tuple(found)

    def once(self, name: object, make: Callable[[], Any]) -> Any:
        """What ``make()`` returns, which is asked once for a name.

        Even to look up compiled code takes as long as some records do.
        """
        with self._lock:
            if name not in self._made:
                self._made[name] = make()
            return self._made[name]

    def _matrices(self) -> Matrices:
        if self.varying:
            seen = np.ones((self.rows, self.stacks.plant.p), dtype=bool)
            *_, found = self.stacks.instants(self.begin, seen)
            found = {name: X[1:] for name, X in found.items()}
        else:
            found = self.stacks.constant()
        return {name: flat(kernels.plain_array(X)) for name, X in found.items()}

    def _first(self) -> Matrices:
        begin = self.begin
        move, A, B, J = leading_on(self.stacks.plant, None)
        found = kernels.compiled(predict)(
            A=A, As=move.A, Q=move.Q, B=B, J=J, Sigma=begin.Sigma, x=begin.x,
            rho=begin.rho, u=begin.u[:, None],
        )  # fmt: skip
        return dict(
            Omega=found["Omega_next"].flatten(), x_minus=found["x_minus_next"].flatten()
        )
