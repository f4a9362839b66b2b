"""How accurate any observer is on a plant with noise: the covariance of its error."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .. import kernels
from ..arguments import expect
from ..certificate import (
    Certificate,
    certify,
    require_match,
    require_real,
    residuals,
)
from ..errors import FIT, SAMPLE, DesignError
from ..numeric import Matrices, Matrix, Vector
from ..numeric.factors import factor, shorten
from ..numeric.linalg import lyapunov, modes
from ..numeric.validation import whole
from ..observer import Observer
from ..papers.haddad_bernstein.derivation import moment_ahead
from ..papers.leondes_novak.derivation import (
    beside_the_state,
    error_recursion,
    root_error,
    start_root,
)
from ..plant import Plant
from .mean_square import equivalent_noise, noise_at

EXACT_TOL = 1e-9  # certificate below which the error does not depend on the state


def error_covariance(
    observer: Observer, plant: Plant, *, steps: int | None = None
) -> Matrix:
    r"""Second moment E[e e'] of the error e = w^ - L x of any observer on a plant.

    For an observer that satisfies (9), (13) the error obeys (11), (26),

    .. math:: \varepsilon_{i+1} = F_i\varepsilon_i + D_i v_i - T_{i+1} w_i,
              \qquad e_i = P_i\varepsilon_i + V_i v_i .

    Where it does not (a filter of fixed order, or a wrong plant), the state drives
    the error too; then the moments of x and eps are propagated together, with u = 0.

    Multiplicative noise joins w and v: ``w + sum g_j A_j x`` and ``v + sum g_j C_j x``
    are white and uncorrelated with the past, with covariances that follow from the
    second moment E[x x'] of the state.  That depends on the input, and again u = 0.

    Parameters
    ----------
    observer : Observer
        With any gains, optimal or not.
    plant : Plant
        Discrete, with Q and R; with P0 when `steps` is given.
    steps : int, optional
        Number of steps; default the steady state of a constant observer.

    Returns
    -------
    (q, q) or (steps + 1, q, q) ndarray
        Steady value, or rows i = 0 .. steps.  For a time-varying filter row 0 is the
        initial L P0 L'; for a constant observer row 0 is its first sample, the state
        having the mean x0 and covariance P0 there.

    Raises
    ------
    DesignError
        Without noise covariances or P0, when there is no steady state (the modes at
        fault are named, or how much multiplicative noise the plant would stand), or
        when the observer depends on the input and there is one.

    References
    ----------
    Leondes and Novak (1974), equations (11), (26), (28);
    papers/leondes_novak/derivation/huddle.py. Haddad and Bernstein (1987), (4.3),
    (4.4); papers/haddad_bernstein/derivation/augmented.py.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0,
    ...                  Q=[[0.25, 0.5], [0.5, 1]], R=[[1]])
    >>> lb.error_covariance(lb.kalman_filter(plant), plant).round(12)
    array([[0.75, 0.5 ],
           [0.5 , 1.  ]])
    """
    expect(observer=observer, plant=plant)
    require_match(observer, plant)
    require_real("the error covariance", plant, observer)
    steps = None if steps is None else whole("steps", steps)
    _require_noise(plant, steps)
    if observer.steps is not None and steps is None:
        raise ValueError("give steps: a time-varying observer has no steady state")
    certificate = require_free_of_input(observer, plant)
    system = error_system(observer, plant, steps, certificate)
    return system.steady() if steps is None else system.over(steps)


def require_free_of_input(observer: Observer, plant: Plant) -> Certificate:
    """Return the certificate, or raise DesignError if the known input has a say."""
    certificate = certify(observer, plant)
    if max(certificate.input, certificate.feedthrough) > EXACT_TOL and plant.m:
        raise DesignError(
            "the estimate depends on the known input (input residual "
            f"{certificate.input:.1e}, feedthrough {certificate.feedthrough:.1e}), so "
            "its error does too. Certify the observer against the plant it is for."
        )
    return certificate


def error_system(
    observer: Observer,
    plant: Plant,
    steps: int | None,
    certificate: Certificate | None = None,
) -> ErrorSystem:
    """What the error obeys: alone, or with the state where that drives it."""
    if steps is not None and observer.steps is not None and steps > observer.steps:
        raise ValueError(
            f"steps = {steps}, but the observer covers instants 1 .. {observer.steps}"
        )
    if certificate is None:
        certificate = certify(observer, plant)
    exact = max(certificate.dynamics, certificate.output) <= EXACT_TOL
    return (ErrorSystem if exact else JointSystem)(observer, plant, steps)


def _require_noise(plant: Plant, steps: int | None) -> None:
    if plant.dt == 0:
        raise DesignError(
            f"error covariances are for discrete time, the plant has dt=0; {SAMPLE}"
        )
    if plant.Q is None or plant.R is None:
        raise DesignError(f"the plant needs both noise covariances Q and R; {FIT}")
    if steps is not None and plant.P0 is None:
        raise DesignError("the plant needs P0, the covariance of its initial state")


class ErrorSystem:
    """The error on its own: X = E[eps eps']."""

    whose = "the observer's error"

    def __init__(self, observer: Observer, plant: Plant, steps: int | None) -> None:
        self.observer, self.plant = observer, plant
        self.moments = self.of_state(steps) if plant.multiplicative else None

    def of_state(self, steps: int | None) -> list[Matrix]:
        """E[x x'] at the instants 0 .. steps, or of the steady state for all."""
        plant = self.plant
        if steps is None:
            return [equivalent_noise(plant).X]
        X = plant.P0 + np.outer(plant.x0, plant.x0)
        found, step = [X], kernels.compiled(moment_ahead)
        for i in range(steps):
            if i or self.observer.steps is None or plant.P0_is == "posterior":
                V1 = noise_at(plant, i, X)[0]
                (X,) = step(A=plant.at(i).A, Q1=X, V1=V1).values()
            found.append(X)
        return found

    def noise(self, i: int) -> Matrices:
        """Covariances of all that acts as w and v at instant i."""
        X = None if self.moments is None else self.moments[i]
        Q, S, R = noise_at(self.plant, i, X)
        return dict(Q=Q, S=S, R=R)

    def matrices(self, k: int) -> Matrices:
        """Arguments of the error recursion at row k, T_next held beyond the end."""
        o, N = self.observer, self.observer.steps
        F, _, D, P, V, _ = o.at(k)
        T_next = o.T if N is None else o.T[min(k + 1, N - 1)]
        return dict(F=F, D=D, T_next=T_next, P=P, V=V) | self.noise(self.instant(k))

    def instant(self, k: int) -> int:
        """The instant of row k."""
        return k if self.observer.steps is None else k + 1

    def first_sample(self) -> tuple[Matrix, Vector, Matrix]:
        """T, and the mean and a factor of the covariance of x, at row 0."""
        o, plant = self.observer, self.plant
        if o.steps is None:
            return o.T, plant.x0, factor(plant.P0)
        A, _, Q = plant.first_step()
        if plant.P0_is == "posterior":
            Q = self.noise(0)["Q"]
        spread = np.concatenate([A @ factor(plant.P0), factor(Q)], axis=1)
        return o.T[0], A @ plant.x0, spread

    def start(self) -> Matrix:
        """A factor of E[eps eps'] at row 0: z is fixed, x has a mean and a spread."""
        _, mean, spread = self.first_sample()
        given = dict(H_x=spread, x_bar=mean[:, None])
        return kernels.compiled(start_root)(**given, **self.followed())["H_eps"]

    def followed(self) -> Matrices:
        """What z is to follow at row 0, and z there."""
        return dict(T=self.first_sample()[0], z=self.observer.z0[:, None])

    def over(self, steps: int) -> Matrix:
        """E[e e'] at rows 0 .. steps of `error_covariance`."""
        L, varying = self.observer.L, self.observer.steps is not None
        out = [L @ self.plant.P0 @ L.T] if varying else []
        return np.stack(out + [H @ H.T for H, _ in self.factors(steps)])

    def factors(self, steps: int) -> Iterator[tuple[Matrix, Matrices]]:
        """A factor of E[e e'] at each row of the observer, and what it is made of.

        In factors what is singular needs no repair.
        """
        step, rows = kernels.compiled(root_error), steps + (self.observer.steps is None)
        H, noise = self.start(), None
        for k in range(rows):
            changing = self.plant.steps is not None or self.moments
            given, noise = self.rooted(k, None if changing else noise)
            given["H"], new = H, step(**given, H=H)
            yield np.concatenate([new["shown"], new["drawn"]], axis=1), given
            H = shorten(np.concatenate([new["moved"], new["drive"]], axis=1))

    def rooted(self, k: int, noise: Matrix | None = None) -> tuple[Matrices, Matrix]:
        """`matrices` with a factor [Nw; Nv] of the noise, which may be known."""
        given = self.matrices(k)
        Q, S, R = (given.pop(name) for name in "QSR")
        noise = factor(np.block([[Q, S], [S.T, R]])) if noise is None else noise
        return given | dict(Nw=noise[: len(Q)], Nv=noise[len(Q) :]), noise

    def steady(self) -> Matrix:
        """E[e e'] of the steady state: in factors no variance is below zero."""
        given, _ = self.rooted(0)
        F, step = given["F"], kernels.compiled(root_error)
        _require_decay(F, self.whose)
        drive = step(**given, H=np.zeros((len(F), 0)))["drive"]
        new = step(**given, H=factor(lyapunov(F, drive @ drive.T)))
        H = np.concatenate([new["shown"], new["drawn"]], axis=1)
        return H @ H.T


def settled(F: Matrix, **given: Matrix) -> Matrix:
    """cov(z - T x) of a constant observer after a long time: (11) with X_next = X."""
    step = kernels.compiled(error_recursion, "X_next")
    return lyapunov(F, step(F=F, X=np.zeros_like(F), **given)["X_next"])


class JointSystem(ErrorSystem):
    """State and error together, for an observer whose error depends on the state.

    Both are the error of an observer of order n + r that satisfies its conditions; see
    papers/leondes_novak/derivation/any_observer.py.
    """

    whose = "the observer does not fit this plant, and its error"

    def matrices(self, k: int) -> Matrices:
        given = super().matrices(k)
        names = dict(F="F_both", D="D_both", T_next="T_ahead", P="P_both")
        found = self.both(k, given, *names.values())
        return given | {name: found[both] for name, both in names.items()}

    def followed(self) -> Matrices:
        found = self.both(0, super().matrices(0), "T_both", "z_both")
        return dict(T=found["T_both"], z=found["z_both"])

    def both(self, k: int, given: Matrices, *wanted: str) -> Matrices:
        """Matrices of the observer of state and error, from those of the error's."""
        o, i = self.observer, self.plant.at(self.instant(k))
        F, G, D, P, V, W = o.at(k)
        T, T_next = o.T if o.steps is None else o.T[k], given["T_next"]
        N_1, _, N_3, _ = residuals(i.A, i.B, i.C, i.E, o.L, F, G, D, P, V, W, T, T_next)
        have = dict(A=i.A, F=F, D=D, P_any=P, T=T, T_next=T_next, N_1=N_1, N_3=N_3)
        return kernels.run(beside_the_state, have | dict(z=o.z0[:, None]), *wanted)


def _require_decay(F: Matrix, whose: str) -> None:
    poles = np.linalg.eigvals(F)
    bad = poles[np.abs(poles) >= 1]
    if bad.size:
        raise DesignError(
            f"no steady state: {whose} has the mode {modes(bad)} on or outside the "
            "unit circle. Give steps, or use another observer."
        )
