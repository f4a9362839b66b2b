"""What the error obeys: alone, or with the state where that drives it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from .. import kernels
from ..certificate import Certificate, certify, residuals
from ..errors import DesignError
from ..numeric import Matrices, Matrix, Vector
from ..numeric.factors import factor, shorten
from ..numeric.independent_rows import default_tol, in_even_units
from ..numeric.linalg import decaying, eigenvalues, lyapunov, modes
from ..observer import Observer
from ..papers.haddad_bernstein.derivation import moment_ahead
from ..papers.leondes_novak.derivation import (
    beside_the_state,
    driven_beside_the_state,
    error_of_input,
    error_recursion,
    root_error,
    start_root,
)
from ..plant import Plant
from .disturbance import EXACT_TOL, magnitudes
from .mean_square import equivalent_noise, noise_at

DUST = 1e-12  # of the terms that a residual is the sum of: below it is rounding
ADVICE = " Give steps, or use another observer."


def error_system(
    observer: Observer,
    plant: Plant,
    steps: int | None,
    certificate: Certificate | None = None,
    known: Matrix | None = None,
) -> ErrorSystem:
    """What the error obeys: alone, or with the state where that drives it.

    `known` is what the start of the observer takes of the outputs of instant 0.
    """
    if steps is not None and observer.steps is not None and steps > observer.steps:
        raise ValueError(
            f"steps = {steps}, but the observer covers instants 1 .. {observer.steps}"
        )
    if certificate is None:
        certificate = certify(observer, plant)
    exact = max(certificate.dynamics, certificate.output) <= EXACT_TOL
    return (ErrorSystem if exact else JointSystem)(observer, plant, steps, known)


class ErrorSystem:
    """The error on its own: X = E[eps eps']."""

    whose = "the observer's error"

    def __init__(
        self,
        observer: Observer,
        plant: Plant,
        steps: int | None,
        known: Matrix | None = None,
    ) -> None:
        self.observer, self.plant, self.known = observer, plant, known
        self.moments = self.of_state(steps) if plant.multiplicative else None

    def of_state(self, steps: int | None) -> list[Matrix]:
        """E[x x'] at the instants 0 .. steps, or of the steady state for all."""
        plant = self.plant
        if steps is None:
            return [equivalent_noise(plant).X]
        X = plant.P0 + np.outer(plant.x0, plant.x0)
        found, step = [X], kernels.compiled(moment_ahead)
        for i in range(steps):
            if i or self.observer.steps is None or not plant.at_first:
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
        F, _, D, P, V, _ = self.observer.at(k)
        _, T_next = self.follows(k)
        return dict(F=F, D=D, T_next=T_next, P=P, V=V) | self.noise(self.instant(k))

    def follows(self, k: int) -> tuple[Matrix, Matrix]:
        """T at row k and the one after, held beyond the end."""
        T, N = self.observer.T, self.observer.steps
        return (T, T) if N is None else (T[k], T[min(k + 1, N - 1)])

    def instant(self, k: int) -> int:
        """The instant of row k."""
        return k if self.observer.steps is None else k + 1

    def first_sample(self) -> tuple[Matrix, Vector, Matrix]:
        """T, and the mean and a factor of the covariance of x, at row 0."""
        o, plant = self.observer, self.plant
        if o.steps is None:
            return o.T, plant.x0, factor(plant.P0)
        A, _, Q = plant.first_step()
        if not plant.at_first:
            Q = self.noise(0)["Q"]
        spread = np.concatenate([A @ factor(plant.P0), factor(Q)], axis=1)
        return o.T[0], A @ plant.x0, spread

    def start(self) -> Matrix:
        """A factor of E[eps eps'] at row 0: z has a mean, x a mean and a spread."""
        _, mean, spread = self.first_sample()
        z, spread_z = self.observer.z0, np.zeros((self.observer.order, 0))
        if self.known is not None:
            z, spread_z, spread = self.informed()
        width = ((0, 0), (0, spread.shape[1] - spread_z.shape[1]))
        given = self.followed(z[:, None], np.pad(spread_z, width))
        given |= dict(H_x=spread, x_bar=mean[:, None])
        return kernels.compiled(start_root)(**given)["H_eps"]

    def informed(self) -> tuple[Vector, Matrix, Matrix]:
        """Mean of a z that knows outputs of instant 0; factors of its spread and x's.

        Noise of that instant acts on both, so the two factors are rows of one.
        """
        plant, now, root = self.plant, self.plant.at(0), factor(self.plant.P0)
        noise = _root(self.noise(0))
        reading = now.C @ plant.x0
        z = self.observer.z0 + self.known @ reading
        seen = np.concatenate([now.C @ root, noise[plant.n :]], axis=1)
        spread = np.concatenate([now.A @ root, noise[: plant.n]], axis=1)
        return z, self.known @ seen, spread

    def followed(self, z: Matrix, spread: Matrix) -> Matrices:
        """What z is to follow at row 0, and what z is there."""
        return dict(T=self.first_sample()[0], z_bar=z, H_z=spread)

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
        found = {name: given.pop(name) for name in "QSR"}
        noise, n = _root(found) if noise is None else noise, self.plant.n
        return given | dict(Nw=noise[:n], Nv=noise[n:]), noise

    def steady(self) -> Matrix:
        """E[e e'] of the steady state: in factors no variance is below zero."""
        given, _ = self.rooted(0)
        F, step = given["F"], kernels.compiled(root_error)
        rows, back = self.shown(F, given["P"])
        drive = rows @ step(**given, H=np.zeros((len(F), 0)))["drive"]
        X = lyapunov(rows @ F @ back, drive @ drive.T)
        new = step(**given, H=back @ factor(X))
        H = np.concatenate([new["shown"], new["drawn"]], axis=1)
        return H @ H.T

    def of_tone(self, mode: complex, u: Matrix) -> Matrix:
        """What inputs u mode^i leave in the error.

        Columns of u are inputs of their own; for mode 1 they are levels.
        """
        F, drive, P = (self.tone_matrices()[name] for name in ("F", "drive", "P"))
        rows, back = self.shown(F, P)
        F = rows @ F @ back
        eps = back @ np.linalg.solve(mode * np.eye(len(F)) - F, rows @ drive @ u)
        given = dict(P_both=P, N_4=self.left()[3], eps_bar=eps, u=u)
        return kernels.compiled(error_of_input)(**given)["e_bar"]

    def tone_matrices(self) -> Matrices:
        """F and P of the error, and what the known input does to it."""
        return dict(F=self.observer.F, P=self.observer.P, drive=-self.left()[1])

    def left(self, k: int = 0) -> tuple[Matrix, ...]:
        """What Luenberger's four conditions leave at row k."""
        o, now = self.observer, self.plant.at(self.instant(k))
        F, G, D, P, V, W = o.at(k)
        T, T_next = self.follows(k)
        return residuals(now.A, now.B, now.C, now.E, o.L, F, G, D, P, V, W, T, T_next)

    def shown(self, F: Matrix, P: Matrix) -> tuple[Matrix, Matrix]:
        """Rows that pick what the error shows, and columns that give it back.

        Everything where all of it decays.  What does not decay may be hidden from the
        error, such as the angle of a shaft from the error of its speed.
        """
        if decaying(eigenvalues(F), discrete=True).all():
            return np.eye(len(F)), np.eye(len(F))
        pair, levels = in_even_units(F, P, 1.0, default_tol(len(F)))
        seen = np.vstack([np.zeros((0, len(F))), *levels])
        rows, back = seen / pair.states, pair.states[:, None] * seen.T
        _require_decay(rows @ F @ back, self.whose)
        return rows, back


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

    def followed(self, z: Matrix, spread: Matrix) -> Matrices:
        given = super().matrices(0)
        found = self.both(0, given, "T_both", "z_both", z=z)
        none = np.zeros((self.plant.n, spread.shape[1]))
        H_z = np.concatenate([none, spread])
        return dict(T=found["T_both"], z_bar=found["z_both"], H_z=H_z)

    def tone_matrices(self) -> Matrices:
        given = self.matrices(0)
        have = dict(B=self.plant.at(0).B, N_2=self.left()[1])
        drive = kernels.compiled(driven_beside_the_state)(**have)["B_both"]
        return dict(F=given["F"], P=given["P"], drive=drive)

    def left(self, k: int = 0) -> tuple[Matrix, ...]:
        """The same, without rounding where that would feed a state that stays."""
        found = super().left(k)
        if not self.stays:
            return found
        given = zip(found, magnitudes(self.observer, self.plant, self.follows(0)))
        return tuple(np.where(np.abs(X) > DUST * size, X, 0.0) for X, size in given)

    @cached_property
    def stays(self) -> bool:
        """Whether a state of a constant plant and observer does not decay."""
        constant = self.observer.steps is None and self.plant.steps is None
        return constant and not decaying(eigenvalues(self.plant.A), True).all()

    def both(
        self, k: int, given: Matrices, *wanted: str, z: Matrix | None = None
    ) -> Matrices:
        """Matrices of the observer of state and error, from those of the error's."""
        N_1, _, N_3, _ = self.left(k)
        have = dict(A=self.plant.at(self.instant(k)).A, N_1=N_1, N_3=N_3, z=z)
        have |= dict(P_any=given["P"], T=self.follows(k)[0])
        return kernels.run(beside_the_state, given | have, *wanted)


def _root(noise: Matrices) -> Matrix:
    """A factor [Nw; Nv] of [[Q, S], [S', R]]."""
    Q, S, R = (noise[name] for name in "QSR")
    return factor(np.block([[Q, S], [S.T, R]]))


def _require_decay(F: Matrix, whose: str) -> None:
    poles = eigenvalues(F)
    bad = poles[~decaying(poles, discrete=True)]
    if bad.size:
        raise DesignError(
            f"no steady state: {whose} has the mode {modes(bad)} on or outside the "
            f"unit circle.{ADVICE}"
        )
