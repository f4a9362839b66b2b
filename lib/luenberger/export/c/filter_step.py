"""One step of a filter on a device beside the exact one, in sizes.

It runs the program that is exported, on matrices that bound their own rounding, and
follows export/derivation/filter_rounding.py.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...kernels import bounded, run
from ...kernels.c.module import FLOAT_TOL
from ...kernels.c.repair import negligible
from ...kernels.program import Program
from ...numeric import Matrices, Matrix, Vector
from ...numeric.factors import EPS
from ...numeric.linalg import SINGULAR_TOL
from ...numeric.power_sums import SLACK, proved
from ...numeric.rounded import Rounded, joined
from ...papers.leondes_novak.derivation import complete_sample
from ..derivation import gains, grows, known_gain, strays
from .computed import Computed, passed
from .limits import EXTENDED, LEAST, UNIT

TOL = {"float": FLOAT_TOL, "double": SINGULAR_TOL}


class Unproved(Exception):
    """Why there is no bound, in words."""


class Gain(NamedTuple):
    """A gain that is known, and what it makes of errors and readings.

    `inputs` has columns for inputs, measurements, and what depends on neither.
    """

    G: np.ndarray
    Y: Rounded
    F: Rounded
    inputs: Rounded


@dataclass(frozen=True, eq=False)
class Around:
    """Where both filters are at most, around a covariance and a gain that are known.

    Attributes
    ----------
    Omega : (n, n) ndarray
        The covariance of the prediction.
    far : (2, n, n) ndarray
        How far those of the device and of the exact filter are from it.
    seen : (2, n, p) ndarray
        Sizes of ``Y Xi C'`` of both.
    error, reach : (n, c) ndarray
        Of the prediction: error on the device, and size of the exact one.
    innovation : (p, c) ndarray
        Size of the exact innovation.
    """

    Omega: np.ndarray
    far: np.ndarray
    seen: np.ndarray
    error: np.ndarray
    reach: np.ndarray
    innovation: np.ndarray


@dataclass(frozen=True, eq=False)
class Added:
    """What a step adds to differences and errors.

    Attributes
    ----------
    moved : dict
        By the names of `Window`, but for inputs.
    Omega_next : (n, n) ndarray
        The covariance around which the next ones are.
    level : (n,) ndarray
        Variances that are no larger may be taken for rounding.
    """

    moved: dict[str, np.ndarray]
    Omega_next: np.ndarray
    level: np.ndarray


@dataclass(frozen=True, eq=False)
class Pair:
    """A filter and what a device makes of it.

    Attributes
    ----------
    program : Program
        What is exported for a sample with every output.
    exact, device : dict
        A, As, B, C, E, J, Q, R of both, and Omega and x at the first sample.
    real : str
        What the device computes in.
    """

    program: Program
    exact: Matrices
    device: Matrices
    real: str

    def sample(self, Omega: Matrix, *wanted: str) -> Matrices:
        """What an exact sample makes of a covariance, as floats have it."""
        return run(complete_sample, self.exact | dict(Omega=Omega), *wanted)

    def gain(self, Omega: Matrix) -> Gain:
        """The best gain for a covariance, as floats have it."""
        G = self.sample(Omega, "Kmv")["Kmv"]
        given = self.exact | dict(E_u=self.exact["E"], G=G)
        made = bounded(known_gain)
        found = made(**{name: Rounded.of(given[name]) for name in made.given})
        parts = found["B_u"], found["D_y"], Rounded.of(np.zeros((len(G), 1)))
        felt = np.eye(len(G)) + np.abs(G) @ np.abs(given["C"])
        Y = _where(felt, found["Y"])
        F = _where(np.abs(given["As"]) @ felt, found["F"])
        return Gain(G, Y, F, joined(*parts))

    def step(self, here: Around, G: Matrix, u: Matrix, y: Matrix, dy: Matrix) -> Added:
        """What a step adds; u, y are sizes in columns, and dy those of rounding y.

        The roundings of u are in the same places as those of y.
        """
        sizes: Matrices = {}

        def solved(N: Computed, M: Computed) -> Computed:
            sizes.update(self.gains(N, M, G, here))
            return Computed.of(G, wide=sizes["k_f"])

        m = len(u)
        given = {
            name: Computed.of(X, off=np.abs(self.device[name] - X))
            for name, X in self.exact.items()
        }
        none = np.zeros_like(here.error)
        given["Omega"] = Computed.of(here.Omega, wide=here.far[0])
        given["x_minus"] = Computed.of(none, here.reach + here.error, joint=True)
        given["u"] = Computed.of(np.zeros_like(u), u, dy[:m], joint=True)
        given["y"] = Computed.of(np.zeros_like(y), y, dy[m:], joint=True)
        names = {k: op.name for k, op in self.program.results.items() if op}
        apart = {names[k]: k for k in ("Sigma", "x")}
        have, alone = passed(self.program, given, self.real, solved, apart)
        largest = max(X.size.max(initial=0.0) for X in have.values())
        if not largest < 1 / LEAST[self.real]:
            raise Unproved(f"numbers may leave the range of {self.real}")
        Omega, ahead = (have[names[k]] for k in ("Omega_next", "x_minus_next"))
        Sigma, x = alone["Sigma"], alone["x"]
        sizes |= dict(nu_s=here.innovation, e_s=here.error, r_xs=x.off)
        sizes |= run(strays, sizes)
        one = self.exact
        parted = 2 * (len(one["C"]) + 2) * EPS * (np.abs(one["J"]) @ np.abs(one["C"]))
        moved = dict(
            squares=np.stack([Omega.off + Omega.lost, Omega.lost]),
            spreads=self.spreads(sizes, Sigma),
            errors=ahead.off + parted @ x.size,
            through=sizes["a_s"] * (1 + SLACK),
            reached=sizes["z_s"] * (1 + SLACK),
        )
        return Added(moved, Omega.value, self.level(given, Sigma))

    def level(self, given: dict[str, Computed], Sigma: Computed) -> Vector:
        """What a variance is taken for rounding beside, at most."""
        As = given.get("As", given["A"]).size
        sizes = given["Q"].size.diagonal() + As**2 @ Sigma.size.diagonal()
        return np.asarray(1.01 * negligible(len(sizes), self.real) * sizes)

    def spreads(self, sizes: Matrices, Sigma: Computed) -> Matrix:
        """What a step adds to the covariances of the device and of the exact filter."""
        device = run(grows, sizes | dict(r_ts=Sigma.off + Sigma.lost))["l_s"]
        none = np.zeros_like(sizes["k_e"])
        alone = dict(k_o=sizes["k_e"], X_K=sizes["X_e"], k_r=none, r_ts=Sigma.lost)
        return np.stack([device, run(grows, sizes | alone)["l_s"]]) * (1 + SLACK)

    def gains(self, N: Computed, M: Computed, G: Matrix, here: Around) -> Matrices:
        """Sizes of the differences of gains, and what they were found from."""
        C, p = np.abs(self.exact["C"]), len(M.value)
        V = np.linalg.inv(M.value)
        V_s, none = np.abs(V), (p + 2) * EPS
        rho = np.abs(V @ M.value - np.eye(p)) + V_s @ (M.lost + none * np.abs(M.value))
        E = M.off + self.elimination(M)
        exact = C @ here.far[1] @ C.T
        V_o, V_e, V_f = (
            self.inverse(rho + V_s @ D, V_s) for D in (M.wide, exact, M.wide + E)
        )
        self.require_pivots(M, V_f)
        g = np.abs(N.value - G @ M.value) + N.lost + np.abs(G) @ M.lost
        g += none * (np.abs(N.value) + np.abs(G) @ np.abs(M.value))
        found = dict(
            As_s=np.abs(self.exact["As"]), C_s=C, G_s=np.abs(G), g_s=g,
            X_K=here.seen[0], X_e=here.seen[1], M_s=M.most, V_o=V_o, V_f=V_f,
            N_o=N.off + self.least(M) * N.felt.max(axis=1, keepdims=True),
            E_s=E,
        )  # fmt: skip
        found |= run(gains, found)
        found["k_e"] = run(gains, found | dict(X_K=here.seen[1], V_o=V_e), "k_o")["k_o"]
        for name in ("k_o", "k_r", "k_f", "k_e"):
            found[name] = found[name] * (1 + SLACK)
        return found

    def inverse(self, T: Matrix, b: Matrix) -> Matrix:
        """Sizes of an inverse that refers to itself."""
        found = proved(T, b)
        if found is None:
            raise Unproved(
                "the covariance of the innovations is too close to singular for its "
                f"rounding in {self.real}"
            )
        return found

    def elimination(self, M: Computed) -> Matrix:
        """What a solution by elimination makes of the matrix, at most."""
        p = len(M.value)
        times = np.array([p + 2, 3 * p + 4] if p > 1 else [0, 2]) * UNIT[self.real]
        first, all_ = times * EXTENDED / (1 - times * EXTENDED)
        roots = np.sqrt(M.size.diagonal())
        return all_ / (1 - first) * np.outer(roots, roots) + self.least(M)

    def least(self, M: Computed) -> float:
        """The same whatever its size, where numbers are too small for all digits."""
        p = len(M.value)
        return float(4 * p * (p + 1) * LEAST[self.real] * (1 + M.size.max()))

    def require_pivots(self, M: Computed, V: Matrix) -> None:
        """That no pivot is so small that a step gives up."""
        if not (V.diagonal() * M.size.diagonal() * TOL[self.real] < 0.5).all():
            raise Unproved("a step may be refused, as outputs tell almost the same")


def _where(felt: Matrix, X: Rounded) -> Rounded:
    """The same, exact where nothing is added up: a zero stays one to the last bit."""
    return Rounded(X.value, np.where(felt > 0, X.off, 0.0))
