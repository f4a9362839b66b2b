"""The observer: z+ = F z + G u + D y, w^ = P z + V y + W u, an estimate of L x."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from .at_work import LiveObserver, at_work
from .formats import json_records
from .formats.json_records import JsonFile
from .forms import Forms
from .forms.combinations import combined
from .numeric import Matrices, Matrix
from .numeric.combinations import combinations
from .numeric.linalg import eigenvalues
from .numeric.validation import (
    ReadOnly,
    exact,
    matrix,
    names,
    sample_time,
    vector,
    zeros,
)
from .show.blocks import clock, counted, html, listed, matrices, text
from .show.numbers import number

LATER: Any = None  # a field that is filled in once the others are known
varying = partial(matrix, steps=True, field=complex)


@dataclass(frozen=True, eq=False, repr=False)
class Observer(Forms, ReadOnly):
    """What every design function returns: z+ = F z + G u + D y, w^ = P z + V y + W u.

    >>> import luenberger as lb
    >>> observer = lb.Observer([[0.5]], [[1]], [[2]], [[1]], [[1]], T=[[1]],
    ...                        L=[[1]], dt=1.0)
    >>> observer.order, observer.poles.real
    (1, array([0.5]))

    Real or complex.  Either every matrix F, G, D, P, V, T, W is constant, or every
    one carries a leading time axis (N, ., .).  Row k of a time-varying observer
    belongs to instant i = k + 1, the first sample after the initial condition.

    Attributes
    ----------
    F, G, D : (r, r), (r, m), (r, p) ndarray
        State, known-input and measurement matrices of z.
    P, V, W : (q, r), (q, p), (q, m) ndarray
        Output map: w^ = P z + V y + W u.  W (default zero) removes the plant's
        feedthrough from y.
    T : (r, n) ndarray
        What z tracks: z -> T x.
    L : (q, n) ndarray
        What w^ estimates: w = L x.  Constant.
    z0 : (r,) ndarray
        The state the observer starts from at its first sample, default zero; a
        time-varying one starts from z0 + G0 u0.
    dt : float
        0 for continuous time, else the sampling period in seconds.
    T0, G0 : (r, n), (r, m) ndarray or None
        Of a time-varying filter: how its first state follows from the mean x0 of
        x[0] and from the input u0 between instants 0 and 1, z = T0 x0 + G0 u0.
        For a constant observer T0 is T: a guess of x at the first sample is T x.
    state_names, input_names, output_names : tuple of str or None
        Of the plant's x, u and y.  Every design fills them in from its plant; None
        where they are not known.
    estimates : tuple of str or None
        What the rows of w^ are called, with units, where they were given names.
    """

    F: np.ndarray
    G: np.ndarray
    D: np.ndarray
    P: np.ndarray
    V: np.ndarray
    T: np.ndarray
    L: np.ndarray
    W: np.ndarray = LATER
    z0: np.ndarray = LATER
    dt: float = 0.0
    _: dataclasses.KW_ONLY
    T0: np.ndarray = LATER
    G0: np.ndarray | None = None
    state_names: tuple[str, ...] | None = None
    input_names: tuple[str, ...] | None = None
    output_names: tuple[str, ...] | None = None
    estimates: tuple[str, ...] | None = None

    if TYPE_CHECKING:  # lists go in, arrays come out

        def __init__(self, *matrices: ArrayLike | None, **more: Any) -> None: ...

    def __post_init__(self) -> None:
        L = matrix("L", self.L, field=complex)
        T = varying("T", self.T, cols=L.shape[1])
        D = varying("D", self.D, rows=T.shape[-2])
        G = varying("G", self.G, rows=T.shape[-2])
        r, n = T.shape[-2:]
        q, p, m = L.shape[0], D.shape[-1], G.shape[-1]
        lead = T.shape[:-2]
        W = zeros("W", (*lead, q, m)) if self.W is None else self.W
        rational = self._rational()
        given = dict(
            F=varying("F", self.F, r, r),
            G=G,
            D=D,
            P=varying("P", self.P, q, r),
            V=varying("V", self.V, q, p),
            T=T,
            W=varying("W", W, q, m),
        )
        _require_one_lead(given, lead)
        T0 = self.T0 if lead else T
        if lead and (T0 is None or self.G0 is None):
            raise ValueError(
                "a time-varying observer needs T0 and G0, which say how it starts"
            )
        self._fill(
            **given,
            L=L,
            z0=vector("z0", np.zeros(r) if self.z0 is None else self.z0, r),
            dt=sample_time(self.dt),
            T0=matrix("T0", T0, r, n, field=complex),
            G0=None if self.G0 is None else matrix("G0", self.G0, r, m, field=complex),
            _exact=rational,
        )
        self._name(self)
        if self.estimates is not None:
            self._fill(estimates=names("w estimate", self.estimates, L.shape[0]))

    def _said(self) -> tuple[str, dict[str, str]]:
        """What it is, and what it is made of, in words."""
        over = "" if self.steps is None else f", over {counted(self.steps, 'row')}"
        outputs, inputs = self._signals()
        poles = [] if self.steps else [number(pole, 4) for pole in self.poles]
        about = dict(
            estimates=listed(self.estimate_names),
            outputs=listed(outputs),
            inputs=listed(inputs),
            poles=listed(poles),
        )
        size = f"{counted(self.order, 'state')} for {self.L.shape[1]} of the plant"
        return f"Observer: {size}, {clock(self.dt)}{over}", about

    def _signals(self) -> tuple[Sequence[str], Sequence[str]]:
        """Names of y and u."""
        sizes = self.D.shape[-1], self.G.shape[-1]
        return (
            names("y output", self.output_names, sizes[0]),
            names("u input", self.input_names, sizes[1]),
        )

    def __repr__(self) -> str:
        return text(*self._said())

    def _repr_html_(self) -> str:
        z, ahead = names("z state", None, self.order), "+" if self.dt else "'"
        table = None
        if self.steps is None:
            X = np.block([[self.F, self.D, self.G], [self.P, self.V, self.W]])
            outputs, inputs = self._signals()
            rows = [*(f"{one}{ahead}" for one in z), *self.estimate_names]
            table = matrices(rows, [*z, *outputs, *inputs], X)
        return html(*self._said(), table)

    def _name(self, source: Any) -> None:
        """Take the names of x, u and y from a record that has them."""
        sizes = {
            "x state": self.L.shape[1],
            "u input": self.G.shape[-1],
            "y output": self.D.shape[-1],
        }
        for kind, size in sizes.items():
            field = f"{kind[2:]}_names"
            value = getattr(source, field)
            known = value is not None or size == 0
            self._fill(**{field: names(kind, value, size) if known else None})

    def named(self, plant: ReadOnly) -> Observer:
        """The same observer, with the names of a plant's states, inputs and outputs.

        >>> import luenberger as lb
        >>> plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, output_names=["radar"])
        >>> observer = lb.Observer([[0.25]], [[]], [[0.25]], [[1]], [[0]], T=[[1]],
        ...                        L=[[1]], dt=1.0)
        >>> observer.output_names, observer.named(plant).output_names
        (None, ('radar',))
        """
        same = copy.copy(self)
        same._name(plant)
        return same

    def combined(self, H: ArrayLike | Mapping[str, ArrayLike]) -> Observer:
        """The same observer, of the combinations H w^ of what it estimates.

        The torque of a spring, 120 Nm/rad, between two shafts.

        >>> import luenberger as lb
        >>> plant = lb.Plant([[0.9, 0.05], [0.1, 0.8]], None, [[1, 0]], dt=0.1,
        ...                  Q=[[1, 0], [0, 1]], R=[[0.1]])
        >>> observer = lb.kalman_filter(plant)
        >>> torque = observer.combined({"torque (Nm)": [120, -120]})
        >>> torque.L, torque.estimate_names
        (array([[ 120., -120.]]), ('torque (Nm)',))
        >>> bool(np.allclose(torque.P, 120 * (observer.P[:1] - observer.P[1:])))
        True
        >>> lb.certify(torque, plant).worst < 1e-14
        True

        Its state and its motion stay; P, V, W and L become H P, H V, H W and H L.  Of
        an observer of the state, H x.

        Parameters
        ----------
        H : (q,) or (s, q) array_like, or dict of str to (q,) array_like
            A row for each combination, perhaps with its name.  That of a row of zeros
            is 0.

        Raises
        ------
        ValueError
            If H does not have q columns, or no row.
        """
        called = tuple(H) if isinstance(H, Mapping) else None
        given = list(H.values()) if isinstance(H, Mapping) else H
        rows = combinations("H", given, len(self.L), field=complex)
        changed: Any = combined(self, rows, given)
        return dataclasses.replace(self, **changed, estimates=called)

    def _rational(self) -> Matrices | None:
        """The constant matrices as Fractions, or None if any entry is a float."""
        given = {name: exact(getattr(self, name)) for name in "FGDPVTL"}
        found = {k: X for k, X in given.items() if X is not None and X.ndim == 2}
        if len(found) < len(given):
            return None
        zero = np.zeros((len(found["L"]), found["G"].shape[1]), int)
        W = exact(zero if self.W is None else self.W)
        return None if W is None else found | {"W": W}

    @property
    def exact(self) -> Matrices | None:
        """{"F", "G", "D", "P", "V", "W", "T", "L"} as Fractions, beside the floats.

        None unless the observer is constant and every entry was given as an int, a
        Fraction or a rational of computer algebra.
        """
        found = vars(self)["_exact"]
        return None if found is None else dict(found)

    @property
    def order(self) -> int:
        """Number of observer states r."""
        return self.F.shape[-1]

    @property
    def estimate_names(self) -> tuple[str, ...]:
        """Names of w^, which are `estimates`, or of the state L picks, or w1, ..."""
        if self.estimates is not None:
            return self.estimates
        L, states = self.L, names("x state", self.state_names, self.L.shape[1])
        picks = ((L != 0).sum(axis=1) == 1) & (L == 1).any(axis=1)
        numbered = names("w estimate", None, len(L))
        found = tuple(
            states[int(np.argmax(L[k] != 0))] if picks[k] else numbered[k]
            for k in range(len(L))
        )
        return found if len(set(found)) == len(found) else numbered

    @property
    def steps(self) -> int | None:
        """Number of rows N of a time-varying observer, None if it is constant."""
        return len(self.F) if self.F.ndim == 3 else None

    @property
    def poles(self) -> Matrix:
        """Eigenvalues of F, sorted; exactly its diagonal when F is triangular.

        Of a time-varying observer (N, r), row by row; such rows alone do not
        decide stability, `certify` looks at their product.
        """
        if self.F.ndim == 3:
            return np.sort_complex(np.linalg.eigvals(self.F))
        return np.sort_complex(eigenvalues(self.F))

    @property
    def is_complex(self) -> bool:
        """Whether a matrix has a complex entry."""
        return any(np.iscomplexobj(getattr(self, name)) for name in "FGDPVTWL")

    def at(self, k: int) -> tuple[Matrix, ...]:
        """(F, G, D, P, V, W) of row k; the same for every k when constant."""
        matrices = (self.F, self.G, self.D, self.P, self.V, self.W)
        return matrices if self.steps is None else tuple(X[k] for X in matrices)

    def live(self, u0: Any = None, z0: Any = None, x0: Any = None) -> LiveObserver:
        """The observer at work, which gets readings as they come.

        >>> import luenberger as lb
        >>> observer = lb.Observer([[0.5]], [[1]], [[2]], [[1]], [[1]], T=[[1]],
        ...                        L=[[1]], dt=1.0)
        >>> now = observer.live()
        >>> now.measure([1.0])
        array([1.])
        >>> now.advance([0.0])
        >>> now.measure([1.0])
        array([3.])

        Parameters
        ----------
        u0, z0, x0 : optional
            Where it starts, as in `estimate`.
        """
        return at_work(self, u0, z0, x0)

    def to_json(self, path: str | Path) -> None:
        """Write the observer as JSON; numbers come back bit for bit."""
        json_records.write(path, json_records.as_data("observer", self))

    @classmethod
    def from_json(cls, path: str | Path | JsonFile) -> Observer:
        """Read an observer from JSON.  The file is data: nothing is evaluated.

        Files of every earlier version are read.  A key that is not known is refused,
        and so is a file of a later "format".
        """
        return json_records.read(path, "observer", cls, "FGDPVTL")


def _require_one_lead(given: Matrices, lead: tuple[int, ...]) -> None:
    """Raise unless all the matrices are constant or all have the same rows."""
    leads = {name: X.shape[:-2] for name, X in given.items()}
    if set(leads.values()) != {lead}:
        raise ValueError(
            "an observer is constant or time-varying in all its matrices; the "
            f"leading axes are {leads}"
        )
