"""The residuals that make (F, G, D, P, V, W, T) an observer of w = L x.

For the plant   x+ = A x + B u,          y  = C x + E u
and the system  z+ = F z + G u + D y,    w^ = P z + V y + W u,

the error eps = z - T x obeys
    eps+ = F eps - (T+ A - F T - D C) x - (T+ B - G - D E) u
and w^ - w = P eps + (P T + V C - L) x + (W + V E) u.  If the four brackets vanish
and F is stable, w^ -> w for every x(0), z(0) and u.  (Luenberger; Leondes and
Novak (9)-(13).)  T+ is T at the next instant; it is T itself when T is constant.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg

from .arguments import expect
from .errors import CertificateError, DesignError
from .numeric import Matrix, Vector
from .numeric.balance import balanced, even_rate, power_of_two
from .observer import Observer
from .plant import Plant


def residuals(
    A: Any, B: Any, C: Any, E: Any, L: Any, F: Any, G: Any, D: Any, P: Any, V: Any,
    W: Any, T: Any, T_next: Any
) -> tuple[Any, Any, Any, Any]:  # fmt: skip
    """Return (T+ A - F T - D C, T+ B - G - D E, P T + V C - L, W + V E).

    Written once and used twice: derivations pass SymPy matrices and prove the
    result zero; `certify` passes NumPy arrays and measures it.
    """
    return (
        T_next @ A - F @ T - D @ C,
        T_next @ B - G - D @ E,
        P @ T + V @ C - L,
        W + V @ E,
    )


@dataclass(frozen=True, eq=False)
class Certificate:
    """How far an observer is from its claim on one plant.

    Attributes
    ----------
    dynamics, input, output, feedthrough : float
        Frobenius norms of the four residuals, each divided by the norms of the
        terms it is made of (in discrete time of T x too, so that A = 0 does not
        measure rounding by rounding); the largest over time when there are rows.
        Dimensionless; a good design gives about 1e-15.
    poles : (r,) or (N, r) complex ndarray
        Eigenvalues of F, sorted; they set the decay of the error.
    stable : bool
        All poles in Re s < 0 (dt == 0) or |z| < 1 (dt > 0).  For a time-varying
        observer: its transition matrix over all N rows contracts, that is, has
        norm below 1.
    cond : float or None
        Condition of [T; C], computed when first asked for: digits lost when the
        state is recovered from z and y.  None when T or C varies in time.
    sensitivity : (r,) ndarray or None
        How far each of `poles` moves per unit change of F: 1 / |y'x| of its left
        and right unit eigenvectors, 1 at best and huge for a defective pole.
        Computed when first asked for; None for a time-varying observer.
    """

    dynamics: float
    input: float
    output: float
    feedthrough: float
    poles: np.ndarray
    stable: bool
    given: tuple[Matrix, ...] = field(default=(), repr=False)  # T, C, F, for the rest

    @cached_property
    def cond(self) -> float | None:
        if not self.given or any(X.ndim != 2 for X in self.given):
            return None
        T, C, _ = self.given
        values = np.linalg.svd(np.vstack([T, C]), compute_uv=False)
        return float(values[0] / values[-1]) if values[-1] > 0 else np.inf

    @cached_property
    def sensitivity(self) -> Vector | None:
        if not self.given or self.given[2].ndim != 2:
            return None
        return _sensitivity(self.given[2], self.poles)

    @property
    def worst(self) -> float:
        """The largest of the four residuals."""
        return max(self.dynamics, self.input, self.output, self.feedthrough)

    def require(self, tol: float = 1e-9, stable: bool = True) -> Certificate:
        """Return self, or raise CertificateError naming what failed and why.

        ``stable=False`` asks for the residuals only, as for a filter over so few
        steps that it cannot have settled.
        """
        for name, cause in _LIKELY_CAUSE.items():
            value = getattr(self, name)
            if not value <= tol:  # also catches NaN
                raise CertificateError(
                    f"the {name} residual is {value:.1e}, above {tol:.0e}. {cause}"
                )
        if stable and not self.stable:
            raise CertificateError(
                f"the error dynamics are not stable: poles {self.poles}. Poles must "
                "lie in Re s < 0 (dt == 0) or inside the unit circle (dt > 0)."
            )
        return self


_LIKELY_CAUSE = {
    "dynamics": "T+ A = F T + D C does not hold: an observer pole is probably equal "
    "or close to a plant pole, T is badly scaled, or the plant is another one.",
    "input": "G must equal T+ B - D E; was the observer designed for another plant?",
    "output": "L is not a combination of the rows of T and C; raise the observer's "
    "order or estimate fewer functionals.",
    "feedthrough": "W must equal -V E, or the known input leaks into the estimate.",
}


def certify(observer: Observer, plant: Plant) -> Certificate:
    """Measure an observer's claim (T, L) against a plant, passing no judgement.

    >>> import luenberger as lb
    >>> plant = lb.Plant([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]])
    >>> observer = lb.Observer([[-5]], [[1]], [[-12]], [[0], [1]], [[1], [2]],
    ...                        T=[[-2, 1]], L=[[1, 0], [0, 1]])
    >>> certificate = lb.certify(observer, plant)
    >>> certificate.worst, certificate.stable
    (0.0, True)

    Parameters
    ----------
    observer : Observer
    plant : Plant
        The plant it was designed for, or another one.

    Returns
    -------
    Certificate

    Raises
    ------
    ValueError
        If the two do not have the same sizes or sampling period.
    """
    expect(observer=observer, plant=plant)
    require_match(observer, plant)
    o = observer
    A, B, C, E, L, F, G, D, P, V, W, T = _evenly(observer, plant)
    after = slice(1, 1 + len(T))  # row k of the observer is of instant k + 1
    A, B, C, E = (X[after] if len(X) > 1 else X for X in (A, B, C, E))
    T_next = np.concatenate([T[1:], T[-1:]])  # beyond the last row T is held
    found = residuals(A, B, C, E, L, F, G, D, P, V, W, T, T_next)
    unit = 1.0 if plant.dt else 0.0  # x+ is measured against x
    terms = (
        _size(T_next) * (_size(A) + unit) + _size(F) * _size(T) + _size(D) * _size(C),
        _size(T_next) * _size(B) + _size(G) + _size(D) * _size(E),
        _size(P) * _size(T) + _size(V) * _size(C) + _size(L),
        _size(W) + _size(V) * _size(E),
    )
    relative: Any = dict(zip(_LIKELY_CAUSE, map(_ratio, found, terms)))
    given = (o.T, plant.C, o.F)
    return Certificate(**relative, poles=o.poles, stable=_stable(o), given=given)


def _evenly(o: Observer, plant: Plant) -> list[Matrix]:
    """A, B, C, E, L, F, G, D, P, V, W, T in units that make all of like size.

    In the user's units a row of small numbers hides behind the others of a norm.
    """
    now = plant.at(0)
    noise, sensor = (0 if X is None else X.diagonal() for X in (now.Q, now.R))
    s = even_rate(now.A, now.C, plant.dt, np.abs(o.poles).max(initial=0), noise, sensor)
    x, _ = balanced(now.A / s, now.C, noise / s, sensor * s)
    y, w = (_unit(_top(X * x)) for X in (plant.C, o.L))
    moves, shows = (plant.B / x[:, None]).mT, (plant.E / y[:, None]).mT
    u = 1 / _unit(np.maximum(_top(moves), _top(shows)))
    Y = y * (_top(plant.C) + _top(plant.E) > 0)  # a gain on 0 weighs nothing
    rate = _top(plant.A / x[:, None] * x).max() + (plant.dt > 0)
    z = _unit(np.maximum(_top(o.T * x), _felt(o, w, rate)))
    maps = (
        (plant.A, x, x), (plant.B, x, u), (plant.C, y, x), (plant.E, y, u),
        (o.L, w, x), (o.F, z, z), (o.G, z, u), (o.D, z, Y),
        (o.P, w, z), (o.V, w, Y), (o.W, w, u), (o.T, z, x),
    )  # fmt: skip
    moved = (X / left[:, None] * right for X, left, right in maps)
    return [X if X.ndim == 3 else X[None] for X in moved]  # a row for each instant


def _felt(o: Observer, w: Vector, rate: float) -> Vector:
    """How large z has to be for the estimate to move by its own size w; 0 for never.

    A row of T may be nothing but rounding: beside this it stays small.
    """
    share = _top((o.P / w[:, None]).mT)  # of each z in the estimate
    between = np.abs(o.F).max(axis=0) if o.F.ndim == 3 else np.abs(o.F)
    rate = max(rate, between.diagonal().max(initial=0.0)) or 1.0
    with np.errstate(over="ignore"):  # where it has no end, every row is felt
        for _ in range(o.order):
            share = np.maximum(share, _top((between / rate).T * share))
    return np.divide(1.0, share, out=np.zeros_like(share), where=share > 0)


def _top(rows: Matrix) -> Vector:
    """The largest entry of each row, at any time."""
    return np.abs(rows).max(axis=(0, 2) if rows.ndim == 3 else 1, initial=0.0)


def _unit(top: Vector) -> Vector:
    """The nearest power of two; 1 for what is zero."""
    return power_of_two(np.where(top > 0, top, 1.0))


def require_match(observer: Observer, plant: Plant) -> None:
    """Raise unless observer and plant agree in n, m, p, dt and covered instants."""
    o, p = observer, plant
    if o.dt != p.dt:
        raise ValueError(
            f"the observer has dt={o.dt:g} but the plant dt={p.dt:g}; of a continuous "
            f"plant, plant.sampled({o.dt or p.dt:g}) is the one of that period"
        )
    mine = (o.L.shape[1], o.G.shape[-1], o.D.shape[-1])
    if mine != (p.n, p.m, p.p):
        raise ValueError(
            f"the observer is for n, m, p = {mine}, the plant has {(p.n, p.m, p.p)}"
        )
    if p.steps is not None and o.steps is None:
        raise ValueError(
            "a constant observer cannot be measured against a time-varying plant; "
            "design one over steps, such as kalman_filter(plant, steps=N)"
        )
    if p.steps is not None and o.steps is not None and o.steps >= p.steps:
        raise ValueError(
            f"the observer covers instants 1 .. {o.steps}, the plant only "
            f"0 .. {p.steps - 1}"
        )


def require_real(what: str, *records: Plant | Observer) -> None:
    """Raise DesignError if a plant or observer among `records` is complex."""
    for one in records:
        if one.is_complex:
            raise DesignError(
                f"{what} is for real matrices, but the {type(one).__name__.lower()} is "
                "complex. Separate real and imaginary parts into a real one of twice "
                "the size."
            )


def _size(X: Matrix) -> np.ndarray | np.floating:
    """Frobenius norm, of each of a stack; no square overflows."""
    top = np.abs(X).max(axis=(-2, -1), initial=0.0)
    unit = np.where((top > 0) & np.isfinite(top), top, 1.0)
    return unit * np.linalg.norm(X / unit[..., None, None], axis=(-2, -1))


def _ratio(residual: Matrix, scale: np.ndarray | np.floating) -> float:
    """Largest relative size over the rows; an empty residual is exactly met.

    NaN where the terms overflow: what is lost there cannot be told.
    """
    size = _size(residual)
    scale = np.where(np.isfinite(scale), np.where(scale > 0, scale, 1), np.nan)
    return float(np.max(np.where(size == 0, 0.0, size / scale)))


def _sensitivity(F: Matrix, poles: Vector) -> Vector:
    """1 / |y'x| of every eigenvalue, in the order of `poles`."""
    if len(F) == 0:
        return np.zeros(0)
    found, left, right = scipy.linalg.eig(F, left=True, right=True)
    overlap = np.abs(np.sum(left.conj() * right, axis=0))
    with np.errstate(divide="ignore"):
        size = 1 / overlap
    _, order = scipy.optimize.linear_sum_assignment(np.abs(poles[:, None] - found))
    return np.maximum(size[order], 1.0)


def _stable(observer: Observer) -> bool:
    if observer.order == 0:
        return True
    if observer.steps is not None:
        product = np.eye(observer.order)
        for F in observer.F:
            product = F @ product
        return bool(np.linalg.norm(product, 2) < 1)
    poles = observer.poles
    return bool(np.all(poles.real < 0 if observer.dt == 0 else np.abs(poles) < 1))
