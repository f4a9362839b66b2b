"""The smoother's pass over a record, from the last row to the first.

What later rows say is carried back (Bryson and Frazier): no inverse is needed, and
compiled code can do it.  Where later rows say so much more than earlier ones that the
difference of covariances would lose its digits, the rest of the way goes through
smoothed estimates of the next state (Rauch, Tung and Striebel), in factors.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from .. import kernels
from ..kernels.program import Factor
from ..numeric import Matrix, Vector
from ..numeric.factors import EPS, SAFE, lengths, safe, shorten
from ..recursion.root_step import Move, Read, Spread, ahead, visible
from ..recursion.state import flat
from .derivation import backward_step, factor_step, rest
from .forward import Kept, inverse_root

LEFT = 1e-3  # of a variance: what a difference may leave
TURNS = 4096  # rows that compiled code does before they are looked at

BACKWARD = kernels.Recursion(
    backward_step,
    carried=(
        ("lamda", "lamda_next"),
        ("Lambda", "Lambda_next"),
    ),
    rows=(("innovation", "innovations", 0), ("x", "xs", 0)),
    written=(
        ("smoothed", "x_s", "vector"),
        ("variances", "Sigma_s", "diagonal"),
        ("covariances", "Sigma_s", "matrix"),
        ("sayings", "lamda", "vector"),
    ),
    symmetric=("Sigma", "Lambda_next"),
    definite=(Factor("Sigma_s", SAFE, "Sigma"),),
    backward=True,
)
NEIGHBOURS = replace(  # takes half as long again
    BACKWARD,
    carried=(*BACKWARD.carried, ("Ahead", "Ahead_next")),
    written=(*BACKWARD.written, ("neighbours", "U_next", "matrix")),
)
ROW = ("Theta", "x_s", "Sigma_s", "lamda", "Lambda")


class Carried(NamedTuple):
    """What later rows leave to a row: by what they say, or by the next state.

    ``lamda`` (n, 1), ``Lambda``, ``Ahead`` are of the next row's prediction.  Once
    ``half`` is there, it is a factor of the next row's smoothed covariance, and
    ``x`` (n, 1) its estimate: then what they say is not carried any more.
    """

    lamda: np.ndarray
    Lambda: np.ndarray
    Ahead: np.ndarray
    x: np.ndarray
    half: np.ndarray | None


@dataclass(frozen=True, eq=False)
class Back:
    """What the pass finds, row by row.

    Attributes
    ----------
    x : (N, n) ndarray
        Smoothed estimates.
    Sigma : (N, n, n) ndarray
        Covariances of their errors.
    U : (N + 1, n, n) ndarray or None
        E[e_k e_{k-1}'], in row k, if it was asked for.  The first row is for what was
        before the record, the last has no meaning.
    lamda : (N + 1, n) ndarray
        What rows from k on say of the prediction of row k.
    """

    x: np.ndarray
    Sigma: np.ndarray
    U: np.ndarray | None
    lamda: np.ndarray


class Ways(NamedTuple):
    """How rows lead on: for row k, C (p, n) and the `Move` to the next row.

    ``As`` and ``C`` are those of all rows, or stacks with one for each.
    """

    As: np.ndarray
    C: np.ndarray
    move: Callable[[int], Move]

    def at(self, k: int) -> tuple[Matrix, Matrix]:
        """As and C of row k."""
        As, C = (X if X.ndim == 2 else X[k] for X in (self.As, self.C))
        return As, C


def smoothed(kept: Kept, ways: Ways, compile: bool, neighbours: bool) -> Back:
    """Smooth all rows of a record, given the filter's pass over it."""
    N, n = kept.x.shape
    U = np.zeros((N + 1, n, n)) if neighbours else None
    out = Back(np.empty((N, n)), np.empty((N, n, n)), U, np.zeros((N + 1, n)))
    zero = np.zeros((n, n))
    carried = Carried(zero[:, :1], zero, np.eye(n), zero[:, :1], None)
    kernel = _Compiled(kept, ways, out) if compile and N else None
    turn = 0
    while turn < N:
        if kernel is not None and carried.half is None:
            carried, turn = kernel.run(carried, turn)
        if turn < N:
            carried = _row(kept, ways, N - 1 - turn, carried, out)
            turn += 1
    return out


def _row(kept: Kept, ways: Ways, k: int, carried: Carried, out: Back) -> Carried:
    """Row k in NumPy."""
    if carried.half is None:
        As, C = ways.at(k)
        have = dict(
            As=As, C=C, K=kept.K[k], W=kept.W[k], Sigma=kept.Sigma[k],
            innovation=kept.innovation[k][:, None], x=kept.x[k][:, None],
            lamda_next=carried.lamda, Lambda_next=carried.Lambda,
        )  # fmt: skip
        wanted = ROW
        if out.U is not None:
            have["Ahead_next"], wanted = carried.Ahead, (*ROW, "Ahead", "U_next")
        found = kernels.compiled(backward_step, *wanted)(**have)
        Sigma_s = clear(kept.spread(k), found)
        if Sigma_s is not None:
            out.x[k], out.Sigma[k] = found["x_s"][:, 0], Sigma_s
            out.lamda[k] = found["lamda"][:, 0]
            if out.U is not None:
                out.U[k + 1] = found["U_next"]
            own = (found["lamda"], found["Lambda"], found.get("Ahead", carried.Ahead))
            return Carried(*own, found["x_s"], None)
        carried = carried._replace(x=out.x[k + 1][:, None], half=root(out.Sigma[k + 1]))
    carried, found, out.lamda[k + 1] = through_next(kept, ways.move(k), k, carried)
    assert carried.half is not None
    out.x[k], out.Sigma[k] = carried.x[:, 0], carried.half @ carried.half.T
    if out.U is not None:
        out.U[k + 1] = found["U_next"]
    return carried


def clear(spread: Spread, found: dict[str, Any]) -> Matrix | None:
    """The smoothed covariance, or None where too few of its digits are left."""
    Sigma_s = found["Sigma_s"]
    if spread.half is None and enough(Sigma_s, spread.Sigma):
        return Sigma_s
    H = root(spread.Sigma) if spread.half is None else spread.half
    Rest = kernels.compiled(rest)(Theta=found["Theta"], H=H)["Rest"]
    values, vectors = np.linalg.eigh(Rest)
    if values.size and not values[0] > LEFT:
        return None
    half = H @ (vectors * np.sqrt(values))
    return half @ half.T


def enough(Sigma_s: Matrix, Sigma: Matrix) -> bool:
    """Whether the difference of covariances has kept its digits."""
    size = Sigma.diagonal()
    return safe(Sigma_s, size) and bool((Sigma_s.diagonal() > LEFT * size).all())


def root(Sigma: Matrix) -> Matrix:
    """A factor of a covariance."""
    return Spread.of(Sigma).factored()[0]


def known(x: Vector, half: Matrix) -> Carried:
    """From a row that is smoothed: its estimate, and a factor of its covariance."""
    zero = np.zeros((len(x), len(x)))
    return Carried(zero[:, :1], zero, np.eye(len(x)), x[:, None], half)


def through_next(
    kept: Kept, move: Move, k: int, carried: Carried
) -> tuple[Carried, dict[str, Any], Vector]:
    """Row k from the smoothed estimate of the next row.

    Returns what is carried on, the matrices of the step, and what later rows say of
    the next prediction.
    """
    before = kept.x[k + 1] - kept.K[k + 1] @ kept.innovation[k + 1]
    return by_next_state(move, kept.spread(k), kept.x[k], before, carried)


def by_next_state(
    move: Move, spread: Spread, x: Vector, x_minus_next: Vector, carried: Carried
) -> tuple[Carried, dict[str, Any], Vector]:
    """The same for an estimate x (n,) with its `Spread`, wherever it comes from.

    The next state is a measurement of this one through As, and its process noise is
    that measurement's noise.
    """
    assert carried.half is not None
    H, rounding = spread.factored()
    H_minus, rounding = ahead(move, H, rounding)
    unit = np.sqrt(np.maximum(rounding.diagonal(), (EPS * lengths(H_minus)) ** 2))
    gain, _ = visible(Read(move.A, move.G), H, unit)
    B = inverse_root(H_minus, unit)
    found = kernels.compiled(factor_step)(
        As=move.A, L_Q=move.G, H=H, G=gain["Kmv"], x=x[:, None],
        x_minus_next=x_minus_next[:, None], x_s_next=carried.x, H_s_next=carried.half,
    )  # fmt: skip
    parts = [found[name] for name in ("kept", "drawn", "passed")]
    after = carried._replace(
        x=found["x_s"], half=shorten(np.concatenate(parts, axis=1))
    )
    return after, found, B @ (B.T @ (carried.x[:, 0] - x_minus_next))


class _Compiled:
    """The pass in compiled code, which gives up where digits would be lost."""

    def __init__(self, kept: Kept, ways: Ways, out: Back) -> None:
        self.kept, self.out, (N, n) = kept, out, kept.x.shape
        self.last, self.variances = N - 1, np.empty((N, n))
        stacked = {"Sigma", "K", "W"} | {
            name for name in ("As", "C") if getattr(ways, name).ndim == 3
        }
        sizes = (("n", n), ("p", kept.K.shape[2]))
        known = tuple((name, _known(getattr(ways, name))) for name in ("As", "C"))
        recursion = BACKWARD if out.U is None else NEIGHBOURS
        self.kernel = kernels.over_record(recursion, sizes, known, frozenset(stacked))
        given = {name: _stack(getattr(ways, name)) for name in ("As", "C")}
        given |= dict(Sigma=flat(kept.Sigma), K=flat(kept.K), W=flat(kept.W))
        given |= dict(innovations=kept.innovation, xs=kept.x)
        self.given = given

    def run(self, carried: Carried, turn: int) -> tuple[Carried, int]:
        """From what is carried to a row: what is carried on, and the row not done."""
        N = self.last + 1
        while turn < N:
            stop = min(turn + TURNS, N)
            after, done = self._rows(carried, turn, stop)
            good = self._good(turn, done)
            if good < done:
                after, done = self._rows(carried, turn, good)
            carried, turn = after, done
            if done < stop:
                break
        return carried, turn

    def _good(self, turn: int, done: int) -> int:
        """The first turn whose covariance has lost too many digits, or `done`."""
        rows = slice(self.last - done + 1, self.last - turn + 1)
        few = self.kept.variances[rows] * LEFT >= self.variances[rows]
        if not np.any(few):
            return done
        return turn + int(np.flatnonzero(np.any(few, axis=1)[::-1])[0])

    def _rows(self, carried: Carried, turn: int, stop: int) -> tuple[Carried, int]:
        out, N = self.out, len(self.variances)
        now = dict(lamda_next=carried.lamda, Lambda_next=carried.Lambda)
        found = dict(
            smoothed=out.x, variances=self.variances, covariances=flat(out.Sigma),
            sayings=out.lamda[:N],
        )  # fmt: skip
        if out.U is not None:
            now["Ahead_next"], found["neighbours"] = carried.Ahead, flat(out.U[1:])
        after = {name: X.flatten() for name, X in now.items()}
        done = self.kernel(
            last=self.last, start=turn, stop=stop, keep=True,
            **self.given, **after, **found,
        )  # fmt: skip
        shaped = {name: after[name].reshape(X.shape) for name, X in now.items()}
        return Carried(
            shaped["lamda_next"], shaped["Lambda_next"],
            shaped.get("Ahead_next", carried.Ahead), carried.x, None,
        ), done  # fmt: skip


def _known(X: Matrix) -> Any:
    every = X if X.ndim == 3 else X[None]
    return kernels.entries_known((every == 0).all(axis=0), (every == 1).all(axis=0))


def _stack(X: Matrix) -> Matrix:
    return flat(kernels.plain_array(X if X.ndim == 3 else X[None]))
