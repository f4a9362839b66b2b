"""What changes with the coordinates of an observer, and what is measured of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from .. import kernels
from ..errors import CertificateError
from ..numeric import Matrix, Vector
from ..numeric.balance import power_of_two
from ..numeric.linalg import eigenvalues
from .derivation import changed

Entry = tuple[Any, Any]  # a place in a matrix, and what stands there

TOL = 1e-9  # of what is measured, as of a certificate


class System(NamedTuple):
    """F, N = [G, D] and P of an observer, in even units of its states."""

    F: Matrix
    N: Matrix
    P: Matrix
    units: Vector

    @classmethod
    def of(cls, F: Matrix, N: Matrix, P: Matrix) -> System:
        """The system in units in which inputs move a state as far as it is shown.

        Units are powers of two, so no form depends on those of the states.
        """
        units = _units(F, N, P)
        return cls(F / units[:, None] * units, N / units[:, None], P * units, units)


def _units(F: Matrix, N: Matrix, P: Matrix) -> Vector:
    """Root of how far inputs move each state, over how far the estimate shows it.

    Inputs and estimates are seen beside the responses between them.
    """
    rate = np.abs(eigenvalues(F)).max(initial=0.0) or 1.0
    moved, shows = [N], [P]
    for _ in F[1:]:
        moved.append(F @ moved[-1] / rate)
        shows.append(shows[-1] @ F / rate)
    between = np.abs(P @ np.array(moved)).max(axis=0, initial=0.0)  # (q, inputs)
    column = _positive(between.max(axis=0, initial=0.0))
    row = _positive((between / column).max(axis=1, initial=0.0))
    reach = (np.abs(moved).max(axis=0) / column).max(axis=1, initial=0.0)
    share = (np.abs(shows).max(axis=0) / row[:, None]).max(axis=0, initial=0.0)
    return power_of_two(np.sqrt(_positive(reach)) / np.sqrt(_positive(share)))


def _positive(size: Vector) -> Vector:
    return np.where((size > 0) & np.isfinite(size), size, 1.0)


@dataclass
class Change:
    """Coordinates S z of a `System`, U back, and what is known of its matrices there.

    Where a form makes zeros and ones, they are set, not computed: `F` is the whole
    matrix, or None where the form leaves it to S F U; `N` and `P` list entries with
    their places.
    """

    S: Matrix
    U: Matrix
    F: Matrix | None = None
    N: list[Entry] = field(default_factory=list)
    P: list[Entry] = field(default_factory=list)


def carried_out(
    change: Change, system: System, given: dict[str, Matrix]
) -> dict[str, Matrix]:
    """F, G, D, P, T and z0 in the new coordinates, once what they are is measured."""
    units, inputs = system.units, given["G"].shape[1]
    S, U = change.S / units, change.U * units[:, None]
    z = given["z0"][:, None]
    old = {name: given[name] for name in "FGDPT"}
    found = kernels.compiled(changed)(**old, z=z, S=S, U=U)
    F = found["F_S"] if change.F is None else change.F
    N, P = np.hstack([found["G_S"], found["D_S"]]), found["P_S"]
    for matrix, entries in ((N, change.N), (P, change.P)):
        for place, value in entries:
            matrix[place] = value
    _require_same(system, change.S, F, N, P)
    new = dict(F=F, G=N[:, :inputs], D=N[:, inputs:], P=P, T=found["T_S"])
    return {name: X + 0.0 for name, X in new.items()} | {"z0": found["z_S"][:, 0]}


def _require_same(old: System, S: Matrix, F: Matrix, N: Matrix, P: Matrix) -> None:
    """Raise unless F S = S F, N = S N and P S = P hold, each beside its own terms."""
    unit = power_of_two(np.abs(S).max(axis=1))
    S, F, N, P = (
        S / unit[:, None],
        F / unit[:, None] * unit,
        N / unit[:, None],
        P * unit,
    )
    size = np.linalg.norm(S)
    terms = (np.linalg.norm(F) + np.linalg.norm(old.F)) * size
    motion = float(np.linalg.norm(F @ S - S @ old.F) / (terms or 1.0))
    entering = _share(
        np.linalg.norm(N - S @ old.N, axis=0),
        np.linalg.norm(N, axis=0) + size * np.linalg.norm(old.N, axis=0),
    )
    shown = _share(
        np.linalg.norm(P @ S - old.P, axis=1),
        np.linalg.norm(P, axis=1) * size + np.linalg.norm(old.P, axis=1),
    )
    worst = max(motion, entering, shown)
    if not worst <= TOL:
        raise CertificateError(
            f"rounding spoils this form: a residual of {worst:.1e} is above "
            f"{TOL:.0e}. Keep the coordinates of the design, or try another form."
        )


def _share(left: Vector, terms: Vector) -> float:
    return float(np.max(left / np.where(terms > 0, terms, 1.0), initial=0.0))
