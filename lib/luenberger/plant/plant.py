"""The plant: x+ = A x + B u + w, y = C x + E u + v."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from ..errors import short
from ..formats import json_records, statespace
from ..formats.json_records import JsonFile
from ..numeric import Matrices, Matrix
from ..numeric.covariances import covariance, require_semidefinite
from ..numeric.validation import (
    ReadOnly,
    exact,
    matrix,
    names,
    sample_time,
    text,
    vector,
    zeros,
)
from .estimates import Estimates
from .input import stated
from .sampled import one_period
from .shown import as_html, as_text


def check_joint(Q: Matrix | None, R: Matrix | None, S: Matrix | None) -> None:
    """S needs Q and R, and the three together must be a covariance."""
    if S is None:
        return
    if Q is None or R is None:
        raise ValueError("S = E[w v'] is given but Q or R is not; give all three")
    lead = np.broadcast_shapes(*(X.shape[:-2] for X in (Q, R, S)))
    Q, R, S = (np.broadcast_to(X, lead + X.shape[-2:]) for X in (Q, R, S))
    require_semidefinite("[[Q, S], [S', R]]", np.block([[Q, S], [S.mT, R]]))


def noise_pairs(given: Any, n: int, p: int) -> tuple[tuple[Matrix, Matrix], ...]:
    """The pairs (A1, C1) of `multiplicative`, as matrices."""
    if not isinstance(given, (list, tuple)) or not all(
        isinstance(pair, (list, tuple)) and len(pair) == 2 for pair in given
    ):
        raise ValueError("multiplicative must be a list of pairs (A1, C1) of matrices")
    return tuple(
        (
            matrix(f"multiplicative[{k}] A", A1, n, n),
            matrix(f"multiplicative[{k}] C", C1, p, n),
        )
        for k, (A1, C1) in enumerate(given)
    )


def check_words(at_first: Any, name: Any, description: Any) -> None:
    """P0 is at the first sample or not; a name is a line, a description any text."""
    if not isinstance(at_first, bool):
        raise ValueError(
            "at_first must be True or False: whether x0, P0 are those of the first "
            f"sample, got {short(at_first)}"
        )
    if name is not None:
        text("name", name)
    if not isinstance(description, str | None):
        raise ValueError(f"description must be text, got {short(description)}")


class Instant(NamedTuple):
    """The plant's matrices at one instant, all two-dimensional."""

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    E: np.ndarray
    Q: np.ndarray | None
    R: np.ndarray | None
    S: np.ndarray | None

    def covariances(self) -> tuple[Matrix, ...]:
        """Q, R and S; zeros for those that are not given."""
        n, p = self.A.shape[0], self.C.shape[0]
        given = (self.Q, (n, n)), (self.R, (p, p)), (self.S, (n, p))
        return tuple(np.zeros(size) if X is None else X for X, size in given)


LATER: Any = None  # a field that is filled in once the others are known


@dataclass(frozen=True, eq=False, repr=False)
class Plant(ReadOnly):
    """Linear plant with known inputs, measurements and white noise.

    >>> import luenberger as lb
    >>> plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0,
    ...                  Q=[[0.25, 0.5], [0.5, 1]], R=[[1]])
    >>> plant.n, plant.m, plant.p
    (2, 0, 1)

    In discrete time ``x[i+1] = A x[i] + B u[i] + w[i]``,
    ``y[i] = C x[i] + E u[i] + v[i]``; in continuous time (``dt == 0``) the first
    is a differential equation.  Any matrix may carry a leading time axis
    ``(N, ., .)``: row i is its value at instant i = 0 .. N - 1.  A, B, C, E may be
    complex; noise is for real plants.

    Parameters
    ----------
    A : (n, n) or (N, n, n) array_like
        Dynamics.
    B : (n, m) array_like or None
        Known inputs; None when there are none (m = 0).
    C : (p, n) array_like
        Measurements.
    E : (p, m) array_like, optional
        Feedthrough, default zero.  (`D` is the observer's.)
    dt : float, default 0
        0 for continuous time, or the sampling period in seconds.
    Q, R : (n, n), (p, p) array_like, optional
        Covariances of w and v, symmetric and positive semi-definite, in the squared
        units of the states and outputs.  In continuous time Q is the intensity of w,
        per second, and R the covariance of the noise in one sample (`sampled`).
    S : (n, p) array_like, optional
        E[w v'], default zero; [[Q, S], [S', R]] must be positive semi-definite.
    x0, P0 : (n,), (n, n) array_like, optional
        Mean (default zero) and covariance of the state before the first sample.
    U : (m,) or (m, m) array_like, Plant or 0, optional
        What is known of the known input, for errors that it moves: a level for each,
        constant for ever (an input that switches is not that), the covariance of white
        inputs, a plant without input whose outputs they are (a periodic one has modes
        on the unit circle), or 0, always zero.
    multiplicative : sequence of (A1, C1), optional
        Noises that multiply the state: A + sum g_k A_k, C + sum g_k C_k with white
        g_k of mean 0 and variance 1, independent of each other and of w, v.
    at_first : bool
        Whether x0, P0 describe the state at the first sample y[1], before that is used;
        default False, as in Leondes and Novak: they describe x[0], one step earlier.
    name, description : str, optional
        The plant in a line, for titles, and a remark of any length, for readers.
    estimates : dict of str to (n,) array_like, optional
        Combinations of the states by name, ``{"torque (Nm)": [0, 0, 120]}``: what
        `compare` and `design` ask for, and what ``L="torque (Nm)"`` means.
    state_names, input_names, output_names : sequences of str, optional
        Used in tables and plots; default x1, x2, ..., u1, ..., y1, ...

    Raises
    ------
    ValueError
        If a shape, a covariance, dt or an entry (masked, a time, text) is not what it
        should be; the message names the matrix, what it is and what it should be.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    E: np.ndarray = LATER
    _: KW_ONLY
    dt: float = 0.0
    Q: np.ndarray | None = None
    R: np.ndarray | None = None
    S: np.ndarray | None = None
    U: np.ndarray | Plant | None = None
    x0: np.ndarray = LATER
    P0: np.ndarray | None = None
    multiplicative: tuple[tuple[np.ndarray, np.ndarray], ...] = ()
    at_first: bool = False
    name: str | None = None
    description: str | None = None
    estimates: Estimates = LATER
    state_names: tuple[str, ...] = LATER
    input_names: tuple[str, ...] = LATER
    output_names: tuple[str, ...] = LATER

    if TYPE_CHECKING:  # lists go in, arrays come out

        def __init__(self, *ABCE: ArrayLike | None, **more: Any) -> None: ...

    def __post_init__(self) -> None:
        given = {name: getattr(self, name) for name in "ABCE"}
        A = matrix("A", self.A, steps=True, field=complex)
        n = A.shape[-1]
        if A.shape[-2] != n or n == 0:
            raise ValueError(f"A must be square and not empty, got {A.shape[-2]} x {n}")
        B = np.zeros((n, 0)) if self.B is None else self.B
        B = matrix("B", B, rows=n, steps=True, field=complex)
        C = matrix("C", self.C, cols=n, steps=True, field=complex)
        m, p = B.shape[-1], C.shape[-2]
        E = zeros("E", (p, m)) if self.E is None else self.E
        E = matrix("E", E, p, m, steps=True, field=complex)
        Q = None if self.Q is None else covariance("Q", self.Q, n, steps=True)
        R = None if self.R is None else covariance("R", self.R, p, steps=True)
        S = None if self.S is None else matrix("S", self.S, n, p, steps=True)
        x0 = vector("x0", np.zeros(n) if self.x0 is None else self.x0, n)
        P0 = None if self.P0 is None else covariance("P0", self.P0, n)
        self._fill(A=A, B=B, C=C, E=E, Q=Q, R=R, S=S, x0=x0, P0=P0)
        self._fill(_exact=self._rational(given))
        check_joint(Q, R, S)
        self._fill(
            dt=(dt := sample_time(self.dt)),
            U=stated(self.U, m, dt, Plant),
            multiplicative=noise_pairs(self.multiplicative, n, p),
            estimates=Estimates(self.estimates, n),
            state_names=names("x state", self.state_names, n),
            input_names=names("u input", self.input_names, m),
            output_names=names("y output", self.output_names, p),
        )
        self._check_rest()

    def _rational(self, given: dict[str, Any]) -> Matrices | None:
        """A, B, C, E as Fractions, zeros for an absent one, or None if any is not."""
        found = {}
        for name, X in given.items():
            X = exact(np.zeros(getattr(self, name).shape, int) if X is None else X)
            if X is None:
                return None
            found[name] = X
        return found

    def _check_rest(self) -> None:
        lengths = self._lengths()
        if len(set(lengths.values())) > 1:
            raise ValueError(
                f"time-varying matrices must have equally many rows, got {lengths}"
            )
        check_words(self.at_first, self.name, self.description)

    def __repr__(self) -> str:
        return as_text(self)

    def _repr_html_(self) -> str:
        return as_html(self)

    @property
    def n(self) -> int:
        """Number of states."""
        return self.A.shape[-1]

    @property
    def m(self) -> int:
        """Number of known inputs."""
        return self.B.shape[-1]

    @property
    def p(self) -> int:
        """Number of measurements."""
        return self.C.shape[-2]

    @property
    def exact(self) -> Matrices | None:
        """{"A", "B", "C", "E"} as object arrays of Fractions, beside the floats.

        None unless every entry was given as an int, a Fraction or a rational of
        computer algebra.
        """
        return (found := vars(self)["_exact"]) and dict(found)

    @property
    def is_complex(self) -> bool:
        """Whether A, B, C or E has a complex entry."""
        return any(np.iscomplexobj(getattr(self, name)) for name in "ABCE")

    def __getstate__(self) -> dict[str, Any]:
        """All but what a filter keeps here, which another process finds again."""
        return {name: X for name, X in vars(self).items() if name != "_filter"}

    @cached_property
    def steps(self) -> int | None:
        """Number of rows N of the time-varying matrices; None if there are none."""
        return next(iter(self._lengths().values()), None)

    def _lengths(self) -> dict[str, int]:
        """The rows of each matrix that varies."""
        found = {name: getattr(self, name) for name in Instant._fields}
        return {k: len(X) for k, X in found.items() if X is not None and X.ndim == 3}

    def at(self, i: int) -> Instant:
        """The matrices at instant i; beyond the last row the last one is held."""
        given = (getattr(self, name) for name in Instant._fields)
        held = (X if X is None or X.ndim == 2 else X[min(i, len(X) - 1)] for X in given)
        return Instant(*held)

    def first_step(self) -> tuple[Matrix, Matrix, Matrix]:
        """A, B, Q that carry x0 and P0 to the first sample.

        Those of instant 0; or I, 0, 0 when x0, P0 are at that sample.
        """
        now = self.at(0)
        if self.at_first:
            return np.eye(self.n), np.zeros_like(now.B), np.zeros((self.n, self.n))
        return now.A, now.B, now.covariances()[0]

    def at_first_sample(self) -> Self:
        """The plant with x0 and P0 carried to the first sample, before that is used.

        >>> import luenberger as lb
        >>> plant = lb.Plant([[2]], None, [[1]], dt=1.0, Q=[[1]], x0=[3], P0=[[1]])
        >>> ahead = plant.at_first_sample()
        >>> ahead.x0, ahead.P0, ahead.at_first
        (array([6.]), array([[5.]]), True)

        No input acts on the way.
        """
        A, _, Q = self.first_step()
        P0 = None if self.P0 is None or self.Q is None else A @ self.P0 @ A.T + Q
        if P0 is not None and not np.isfinite(P0).all():
            raise ValueError(
                "the numbers are too large or too unlike to compute with: P0 overflows "
                "on the way to the first sample. Scale the states."
            )
        P0 = P0 if P0 is None else 0.5 * (P0 + P0.T)
        return replace(self, x0=A @ self.x0, P0=P0, at_first=True)

    def sampled(self, dt: float) -> Self:
        r"""The discrete plant of this continuous one, sampled every `dt` seconds.

        >>> import luenberger as lb
        >>> ball = lb.Plant([[0, 1], [0, 0]], [[0], [2]], [[1, 0]],
        ...                 Q=[[0, 0], [0, 3]], R=[[1]])
        >>> plant = ball.sampled(1.0)
        >>> plant.B[:, 0], plant.Q[0, 0], plant.R[0, 0]
        (array([1., 2.]), np.float64(1.0), np.float64(1.0))

        With u held from each sample to the next,

        .. math:: A_d = e^{A\,dt}, \quad B_d = \int_0^{dt} e^{A t} B\,dt, \quad
                  Q_d = \int_0^{dt} e^{A t} Q e^{A' t}\,dt ,

        exactly; at uneven instants, see `sampling.discretise`.  C, E and R stay: R is
        the covariance of what one reading is off by, not an intensity.

        Parameters
        ----------
        dt : float
            Seconds from each sample to the next.

        Raises
        ------
        DesignError
            If the plant is discrete already, varies, is complex, has S or
            multiplicative noise, or grows beyond what floats hold within dt.
        ValueError
            If dt is no positive number of seconds.

        References
        ----------
        Van Loan (1978), "Computing integrals involving the matrix exponential".
        """
        return replace(self, **one_period(self, dt))

    def with_input(self, U: ArrayLike | Plant | None) -> Self:
        """The plant, and what is known of its known input; None for nothing.

        A filter believes in a gain that is wrong by a tenth, and the input is 3:

        >>> import luenberger as lb
        >>> plant = lb.Plant([[0.5]], [[1]], [[1]], dt=1.0, Q=[[0]], R=[[0]])
        >>> believed = lb.Plant([[0.5]], [[0.9]], [[1]], dt=1.0, Q=[[0]], R=[[1]])
        >>> observer = lb.kalman_filter(believed)
        >>> lb.error_covariance(observer, plant.with_input([3])).round(12)
        array([[0.36]])

        Errors count it, and designs that can are the best for it.

        Parameters
        ----------
        U : (m,) or (m, m) array_like, Plant or 0, optional
            As of `Plant`.
        """
        given: Any = U
        return replace(self, U=given)

    @classmethod
    def from_statespace(cls, sys: object, **options: Any) -> Self:
        """Read A, B, C, D, dt and names from a python-control or scipy.signal system.

        >>> import scipy.signal, luenberger as lb
        >>> sys = scipy.signal.dlti([[0.5]], [[1]], [[2]], [[0]], dt=0.1)
        >>> lb.Plant.from_statespace(sys, R=[[1]]).dt
        0.1

        Parameters
        ----------
        sys : control.StateSpace, scipy.signal.StateSpace, lti or dlti
            Its D is the plant's E.  What it calls its states, inputs and outputs is
            kept.  `export.to_control` and `export.to_scipy` are the way back.
        **options
            Those of `Plant`: Q, R, P0, names, ...  ``dt=`` in seconds is needed where
            the system does not say it (its dt is True, or None in python-control).
            R is the covariance of one reading.  The RN of a continuous system is an
            intensity: readings every dt seconds have R = RN / dt; of a discrete system
            R is RN.  Q is G QN G' in both.

        Raises
        ------
        TypeError
            If QN, RN or NN is given: it says what to give in its place.
        """
        return cls(**statespace.read(sys, **options))

    def to_json(self, path: str | Path) -> None:
        """Write the plant as JSON; numbers come back bit for bit."""
        json_records.write(path, json_records.as_data("plant", self))

    @classmethod
    def from_json(cls, path: str | Path | JsonFile) -> Self:
        """Read a plant from JSON.  The file is data: nothing in it is evaluated.

        Keys are the parameters of `Plant`, with "P0_is": "prior" for `at_first`.  A, C
        and, when there are known inputs, B are required.  A key that is not known is
        refused, and so is a file of a later "format".
        """
        return json_records.read(path, "plant", cls, "AC", B=None)
