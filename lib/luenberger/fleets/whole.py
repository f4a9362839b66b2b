"""A plant's matrices in every row of a record, as panels read them."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from .. import kernels
from ..numeric import Matrices, Matrix, Vector
from ..papers.leondes_novak.derivation import predict
from ..recursion.filter_stacks import Stacks
from ..recursion.state import flat, leading_on
from .records import Records

Run = Callable[[Vector], object]  # over the records with these numbers
Over = Callable[[Run, Vector], object]


def here(run: Run, who: Vector) -> None:
    """All of them, one after the other."""
    run(who)


@dataclass(frozen=True, eq=False)
class Whole:
    """The matrices of all outputs, whether they arrived or not.

    Row k has those of its own instant, and A and B lead on from there.  ``over(run,
    who)`` runs records `who`, perhaps in parts side by side.
    """

    records: Records
    stacks: Stacks
    over: Over = here

    @property
    def varying(self) -> bool:
        """Whether they change from row to row."""
        return self.stacks.varying

    @cached_property
    def matrices(self) -> Matrices:
        """By name, (N, rows * cols), or (1, ...) where they stay."""
        if self.varying:
            seen = np.ones(self.records.y.shape[1:], dtype=bool)
            *_, stacks = self.stacks.instants(self.records.begin, seen)
            stacks = {name: X[1:] for name, X in stacks.items()}
        else:
            stacks = self.stacks.constant()
        return {name: flat(kernels.plain_array(X)) for name, X in stacks.items()}

    def told(self, s: int) -> Matrix:
        """J in every row of record s, zero for what did not arrive; or (1, ...)."""
        if not self.stacks.cross:
            return self.matrices["J"][:1]
        records = self.records
        given, *_ = self.stacks.given(records.begin, records.y[s], records.u[s])
        J, now = given["J"], given["now"]
        return J if len(J) == 1 else np.ascontiguousarray(J[now])

    def known(self, **names: str) -> tuple[tuple[str, Any], ...]:
        """What is known of the entries of matrices, under other names."""
        found = ((to, self.stacks.known(k, self.varying)) for to, k in names.items())
        return tuple(found)

    @cached_property
    def first(self) -> Matrices:
        """What is predicted for the first row, and the covariance of its error."""
        begin, plant = self.records.begin, self.records.settings.plant
        move, A, B, J = leading_on(plant, None)
        found = kernels.compiled(predict)(
            A=A, As=move.A, Q=move.Q, B=B, J=J, Sigma=begin.Sigma, x=begin.x,
            rho=begin.rho, u=begin.u[:, None],
        )  # fmt: skip
        return dict(
            Omega=found["Omega_next"].flatten(), x_minus=found["x_minus_next"].flatten()
        )

    @cached_property
    def read(self) -> Matrices:
        """Measurements and inputs, a row for each record, and which row is whose."""
        y, u = self.records.y, self.records.u
        M, N, p = y.shape
        every = np.arange(M)
        same = M > 0 and u.strides[0] == 0  # one input for all
        u = u[:1] if same else u
        return dict(
            y=kernels.plain_array(y.reshape(M, N * p)), which_y=every,
            u=kernels.plain_array(u.reshape(len(u), N * u.shape[2])),
            which_u=np.zeros_like(every) if same else every,
        )  # fmt: skip
