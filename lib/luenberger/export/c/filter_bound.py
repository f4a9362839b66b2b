"""How far the estimates of an exported filter are from exact ones, at most.

The steps until the covariance has settled are followed one by one, with windows.  Then
bounds are tried that hold at every later step: export/derivation/filter_rounding.py.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import matrix_balance

from ...numeric import Matrices, Matrix, Vector
from ...numeric.factors import EPS
from ...numeric.power_sums import SLACK
from ...numeric.rounded import Rounded
from .filter_step import Added, Around, Gain, Pair, Unproved
from .limits import EXTENDED, LEAST, UNIT
from .window import Window

MOST = 2000  # steps until the covariance has settled, and steps of a window
SETTLING = 20_000  # steps that are tried in search of the covariance that settles
FORGOTTEN = 1e-2  # of an error, that the window has moved to its end
SETTLED = 16  # of a rounding: differences that are smaller count as settled
SPARE = 1.02  # what is tried beside what was found
TRIES = 8
SHRINKS = (
    "a variance becomes so small beside what it was made of that a device may take it "
    "for rounding"
)


@dataclass(eq=False)
class Search:
    """A search for the bound of one filter on one device."""

    pair: Pair

    def __post_init__(self) -> None:
        exact = self.pair.exact
        self.n, self.m, self.p = len(exact["A"]), exact["B"].shape[1], len(exact["C"])
        signals = self.m + self.p
        s = np.eye(signals, signals + 1)
        ds = s * UNIT[self.pair.real] * EXTENDED
        ds[:, -1] = LEAST[self.pair.real]
        self.u, self.y, self.ds = s[: self.m], s[self.m :], ds
        self.whole = Rounded.of(np.eye(self.n))

    def error(self) -> Matrix:
        """Errors of the estimates, for each signal of size one alone, and for none.

        Raises
        ------
        Unproved
            If no bound was found.
        """
        with np.errstate(all="ignore"):
            try:
                found = self.found()
            except np.linalg.LinAlgError:
                raise Unproved(
                    "some covariance of the innovations is singular"
                ) from None
        if not np.isfinite(found).all():
            raise Unproved("numbers overflow where it is looked for")
        return found * (1 + SLACK)

    def found(self) -> Matrix:
        """The same, not finite where numbers overflow."""
        end, unit = self.settled()
        length = _length(self.pair.gain(end).F.value)
        window, Omega = self.start(length), self.pair.exact["Omega"]
        most = np.zeros((self.n, self.m + self.p + 1))
        small, before = UNIT[self.pair.real] / SETTLED, np.full_like(end, np.inf)
        for _ in range(MOST):
            gaps = (Omega - end) / small, (Omega - before) / EPS
            if any((np.abs(gap) <= unit * unit[:, None]).all() for gap in gaps):
                return np.maximum(most, self.stay(window, Omega))
            gain = self.pair.gain(Omega)
            added = self.step(self.around(window, Omega, gain), gain)
            most = np.maximum(most, window.error(gain.Y) + added.moved["through"])
            self.advance(window, gain, added)
            before, Omega = Omega, added.Omega_next
        raise Unproved(f"the covariance has not settled after {MOST} steps")

    # -- what is known exactly ---------------------------------------------------------

    def settled(self) -> tuple[Matrix, Vector]:
        """The covariance that stays, and units in which differences count."""
        C, Omega = self.pair.exact["C"], self.pair.exact["Omega"]
        top = Omega.diagonal()
        for _ in range(SETTLING):
            before, new = Omega, self.pair.sample(Omega, "M", "Omega_next")
            Omega = new["Omega_next"]
            top = np.maximum(top, Omega.diagonal())
            roots = np.sqrt(Omega.diagonal())
            if (np.abs(Omega - before) <= 4 * EPS * roots * roots[:, None]).all():
                break
        shown = np.einsum("ij,ij->j", C, np.linalg.solve(new["M"], C))
        told = 1 / np.maximum(shown, np.finfo(float).tiny)
        return Omega, np.sqrt(np.maximum(Omega.diagonal(), np.minimum(told, top)))

    # -- step by step ------------------------------------------------------------------

    def start(self, length: int) -> Window:
        """The window before the first sample."""
        exact, device = self.pair.exact, self.pair.device
        window = Window(exact["As"], 2, self.m + self.p + 1, length)
        squares = np.zeros((2, self.n, self.n))
        squares[0] = np.abs(device["Omega"] - exact["Omega"])
        errors, inputs = np.zeros((2, self.n, self.m + self.p + 1))
        errors[:, -1] = np.abs(device["x"] - exact["x"])
        inputs[:, -1] = exact["x"]
        window.add(squares=squares, errors=errors, inputs=inputs)
        return window

    def around(self, window: Window, Omega: Matrix, gain: Gain) -> Around:
        """Where the filters are at most, as the window has it."""
        I, C, E = self.whole, self.pair.exact["C"], self.pair.exact["E"]
        read = np.hstack([np.abs(E), np.eye(self.p), np.zeros((self.p, 1))])
        return Around(
            Omega,
            window.square(I, I),
            window.square(gain.Y, Rounded.of(C)),
            window.error(I),
            window.reach(I),
            (read + window.reach(Rounded.of(C))) * (1 + SLACK),
        )

    def step(self, here: Around, gain: Gain) -> Added:
        """What a step adds."""
        return self.pair.step(here, gain.G, self.u, self.y, self.ds)

    def advance(self, window: Window, gain: Gain, added: Added) -> None:
        """Move the window to the next instant."""
        more = window.move(gain.F)
        more["reached"] += gain.inputs.off
        window.add(**_both(added.moved, more), inputs=gain.inputs.value)
        far = window.square(self.whole, self.whole)[0]
        window.squares[0, 0] += cleared(added.Omega_next, far, added.level)

    # -- for good ----------------------------------------------------------------------

    def stay(self, window: Window, Omega: Matrix) -> Matrix:
        """Errors of the estimates from here on, with one gain and one covariance."""
        gain = self.pair.gain(Omega)
        needed = _sources(self.step(self.around(window, Omega, gain), gain), Omega)
        tried = {k: SPARE * X for k, X in needed.items()}
        for _ in range(TRIES):
            most, shown, more = self.passes(copy.copy(window), Omega, gain, tried)
            added = self.step(most, gain)
            if cleared(Omega, most.far[0], added.level).any():
                raise Unproved(SHRINKS)
            needed = _both(_sources(added, Omega), more)
            if all((X <= tried[k]).all() for k, X in needed.items()):
                return (shown + added.moved["through"]) * (1 + SLACK)
            tried = {
                k: np.where(X <= tried[k], tried[k], SPARE * X)
                for k, X in needed.items()
            }
        raise Unproved("roundings add up faster than the filter forgets them")

    def passes(
        self, window: Window, Omega: Matrix, gain: Gain, tried: Matrices
    ) -> tuple[Around, Matrix, Matrices]:
        """The window moved over itself, each step adding what was tried.

        Returns the largest sizes on the way, what errors leave in the estimate, and
        what the moves would add besides.
        """
        most, shown = self.around(window, Omega, gain), window.error(gain.Y)
        more: Matrices = {}
        for _ in range(window.length + 1):
            new = window.move(gain.F)
            more = {k: np.maximum(X, more.get(k, 0.0)) for k, X in new.items()}
            window.add(**tried, inputs=gain.inputs.value)
            most = _larger(most, self.around(window, Omega, gain))
            shown = np.maximum(shown, window.error(gain.Y))
        more["reached"] += gain.inputs.off
        return most, shown, more


def cleared(Omega: Matrix, far: Matrix, level: Vector) -> Matrix:
    """What clearing variances that look like rounding adds to a difference."""
    may = Omega.diagonal() - far.diagonal() <= level
    return np.where(may[:, None] | may, np.abs(Omega) + far, 0.0)


def _sources(added: Added, Omega: Matrix) -> Matrices:
    """What a step adds where the covariance around which filters are stays."""
    moved = added.moved
    return moved | dict(squares=moved["squares"] + np.abs(added.Omega_next - Omega))


def _both(a: Matrices, b: Matrices) -> Matrices:
    """What two add, by name."""
    return {k: X + b.get(k, 0.0) for k, X in a.items()}


def _larger(a: Around, b: Around) -> Around:
    """Whatever is larger, but for the covariance, which is the same."""
    names = ("far", "seen", "error", "reach", "innovation")
    return replace(a, **{k: np.maximum(getattr(a, k), getattr(b, k)) for k in names})


def _length(F: Matrix) -> int:
    """How many steps a window takes: until F has forgotten all but a part."""
    even = matrix_balance(F, permute=False, separate=True)[1][0]
    power, scaled = np.eye(len(F)), F / even[:, None] * even
    for k in range(1, MOST + 1):
        power = power @ scaled
        if np.abs(power).sum(axis=1).max() <= FORGOTTEN:
            return k
    raise Unproved(f"the filter has not forgotten an error after {MOST} steps")
