"""Kawazoe's coordinates: rows C_i A^k, chosen so that each output starts a chain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...arguments import expect
from ...errors import SAMPLE, DesignError
from ...numeric import Matrix, rationals
from ...numeric.balance import evened
from ...numeric.independent_rows import choose
from ...plant import Plant


@dataclass(frozen=True, eq=False)
class ObservabilityForm:
    """Kawazoe's coordinates w = P x: w+ = Phi w + G u, y = H w + E u.

    Attributes
    ----------
    P : (n, n) ndarray
        Row by row C_1, C_1 A, ..., C_1 A^(p_1 - 1), C_2, ... (6).
    Phi, G, H : (n, n), (n, m), (p, n) ndarray
        The plant in these coordinates, (11), (13), (14).
    indices : tuple of int
        The observability subindices p_1 .. p_p (7); the largest is the number of
        samples that determine the state.
    selection : str
        How the rows of P were chosen.
    tol, margin : float
        A row is called dependent when its distance from the rows before it, with
        states and outputs scaled, is below tol; margin is the smallest distance of
        a row that was kept.  Both are 0 in exact arithmetic.

    All matrices are object arrays of Fractions when the plant is exact.
    """

    P: np.ndarray
    Phi: np.ndarray
    G: np.ndarray
    H: np.ndarray
    indices: tuple[int, ...]
    selection: str = "interleaved"
    tol: float = 0.0
    margin: float = 0.0

    @property
    def samples(self) -> int:
        """The largest index p_M, how many samples determine the state (21)."""
        return max(self.indices)

    @property
    def cond(self) -> float:
        """2-norm condition number of P, the digits that (26) can lose."""
        return float(np.linalg.cond(self.as_float().P))

    @property
    def exact(self) -> bool:
        """Whether the entries are Fractions."""
        return self.P.dtype == object

    def as_float(self) -> ObservabilityForm:
        """The same form rounded to floats; itself if it is not exact."""
        if not self.exact:
            return self
        names = ("P", "Phi", "G", "H")
        rounded: Any = {name: getattr(self, name).astype(float) for name in names}
        return replace(self, **rounded)


def observability_form(
    plant: Plant, *, selection: str = "interleaved", tol: float | None = None
) -> ObservabilityForm:
    r"""Kawazoe's observability form: rows C_i A^k as coordinates.

    >>> import luenberger as lb
    >>> plant = lb.Plant([[0, 1, 0], [0, 0, 1], [2, 3, 4]], [[0], [0], [1]],
    ...                  [[1, 0, 0], [0, 1, 0]], dt=1.0)
    >>> form = observability_form(plant)
    >>> form.indices, form.samples
    ((1, 2), 2)
    >>> [str(entry) for entry in form.Phi[2]]
    ['2', '3', '4']

    .. math:: w = P x, \qquad w_+ = \Phi w + G u, \qquad y = H w + E u .

    The rows are searched in the order C_1 .. C_p, C_1 A .. C_p A, ...; each row is
    kept if it is independent of the rows kept before, until there are n.

    Parameters
    ----------
    plant : Plant
        Constant, discrete or continuous, observable, with independent outputs.
    selection : "interleaved" or "largest"
        "interleaved" takes the outputs in the user's order, as in the paper.
        "largest" takes at each power of A first the row that is farthest from those
        already kept: the same indices up to their order, often a far better
        conditioned P.  Distances do not depend on the units of the outputs.
    tol : float, optional
        Relative distance below which a row is called dependent; default 50 n eps.
        Ignored for an exact plant, where nothing needs to be judged.

    Returns
    -------
    ObservabilityForm
        Fractions in, Fractions out: exact when A, B, C are given with ints,
        Fractions or SymPy Rationals.  (Digits accumulate: dense plants of 60 states
        take seconds, of 100 minutes.  Floats do not.)

    Raises
    ------
    DesignError
        For a time-varying plant, for outputs that are combinations of others (they
        are named), for an unobservable plant (its hidden modes are named) and when
        P is singular to working accuracy.  Short of that, look at `cond`.

    See Also
    --------
    reconstruct_state : the state from a record, through these coordinates.
    deadbeat_observer : the same as an observer, in better coordinates.

    References
    ----------
    Kawazoe (1978), equations (5)-(14); papers/kawazoe/derivation/form.py.
    """
    expect(plant=plant)
    form, outputs = find_form(plant, selection, tol, plant.exact is not None)
    spare = sorted(set(range(plant.p)) - set(outputs))
    if spare:
        names = [plant.output_names[i] for i in spare]
        raise DesignError(
            f"the outputs {names} are linear combinations of the others, so they have "
            "no subindex of their own and (14) cannot hold. Leave them out; "
            "deadbeat_observer and reconstruct_state accept them."
        )
    return form


def find_form(
    plant: Plant, selection: str, tol: float | None, exactly: bool
) -> tuple[ObservabilityForm, list[int]]:
    """The form on a set of independent outputs, and their numbers."""
    require_constant(plant)
    if selection not in ("interleaved", "largest"):
        raise ValueError(
            f"selection must be 'interleaved' or 'largest', got {selection!r}"
        )
    A, B, C = (plant.exact[k] if exactly else getattr(plant, k) for k in "ABC")
    pair = (A, C) if exactly else None
    chosen = choose(plant.A, plant.C, plant.dt, selection, tol, pair)
    outputs = [i for i, size in enumerate(chosen.indices) if size]
    indices = tuple(chosen.indices[i] for i in outputs)
    P, last = rows(A, C[outputs], indices)
    Phi, H = structure(indices, solve_left(last, P))
    form = ObservabilityForm(
        P, Phi, P @ B, H, indices, selection, chosen.tol, chosen.margin
    )
    return form, outputs


def require_constant(plant: Plant) -> None:
    if plant.steps is not None:
        raise DesignError(
            "a time-varying plant has no observability form; give a constant one"
        )


def require_discrete(plant: Plant) -> None:
    require_constant(plant)
    if plant.dt == 0:
        raise DesignError(
            "the plant is continuous (dt = 0): its state follows from samples only "
            f"once it is sampled; {SAMPLE}"
        )


def rows(A: Matrix, C: Matrix, indices: Sequence[int]) -> tuple[Matrix, Matrix]:
    """P of (6), and the next power of each output, C_i A^(p_i)."""
    P, last = [], []
    for row, size in zip(C, indices):
        for _ in range(size):
            P.append(row)
            row = row @ A
        last.append(row)
    return np.array(P), np.array(last)


def solve_left(N: Matrix, P: Matrix) -> Matrix:
    """X with X P = N.  Rows and columns are scaled first: units cost no digits."""
    if P.dtype == object:
        return rationals.solve(P.T, N.T).T
    even, row, column = evened(P)
    try:
        return np.linalg.solve(even.T, (N * column).T).T / row
    except np.linalg.LinAlgError:
        raise DesignError(
            "the rows C_i A^k are independent but singular to working accuracy. Give "
            "the plant in ints or Fractions, or use deadbeat_observer, whose "
            "coordinates are orthogonal."
        ) from None


def structure(indices: Sequence[int], phi: Matrix) -> tuple[Matrix, Matrix]:
    """Phi of (11) with the given last rows, and H of (14)."""
    n, p = sum(indices), len(indices)
    first = np.cumsum([0, *indices[:-1]])
    Phi, H = (
        rationals.zeros(*shape) if phi.dtype == object else np.zeros(shape, phi.dtype)
        for shape in ((n, n), (p, n))
    )
    for i, (start, size) in enumerate(zip(first, indices)):
        H[i, start] += 1
        for k in range(start, start + size - 1):
            Phi[k, k + 1] += 1
        Phi[start + size - 1] = phi[i]
    return Phi, H
