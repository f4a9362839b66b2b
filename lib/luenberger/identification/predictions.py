"""The rows of a likelihood in compiled code, where outputs have no noise.

A filter's covariance is singular after an exact reading, and that of a prediction is
not, where noise drives the state.  So these rows go from prediction to prediction.
NumPy does the rows in which that covariance, or the innovation's, is close to singular.
"""

from __future__ import annotations

import numpy as np

from .. import kernels
from ..kernels.program import Factor
from ..numeric import Matrices, Matrix, Vector
from ..numeric.factors import SAFE, safe
from ..plant import Plant
from ..recursion.filter_pass import Pass
from ..recursion.filter_stacks import patterns
from ..recursion.growth import Gap, passed, require_digits
from ..recursion.root_step import Move, Spread
from ..recursion.settings import Setting, Settings
from ..recursion.state import State, flat, leading_on, step
from .derivation import likelihood_step, prediction_step
from .settled import FIRM
from .trail import LIKELIHOOD, Trail

PREDICTIONS = kernels.Recursion(
    prediction_step,
    carried=(("Omega_next", "Omega"), ("x_next", "x")),
    rows=(("y", "y", 0), ("u", "u", 0)),
    written=(
        ("innovations", "nu", "vector"),
        ("Ms", "M", "vector"),
        ("variances", "Omega", "diagonal"),
        ("predictions", "x", "matrix"),
        ("es", "e", "matrix"),
        ("Omegas", "Omega", "matrix"),
        ("Ws", "W", "matrix"),
    ),
    symmetric=("Q", "R", "Omega"),
    definite=(Factor("Omega_next", SAFE, "X"), Factor("M", FIRM)),
)


def filtered(
    settings: Settings, out: Trail, state: State, y: Matrix, u: Matrix, fast: bool
) -> State:
    """Filter the rows of y into a trail, from `state` on; the state after them."""
    if not fast or not settings.noise_free or not len(y):
        return Pass(settings).into(out, state, y, u, fast, LIKELIHOOD)
    block, k = Block(settings.plant, y, u, state.instant + 1), 0
    while k < len(y):
        if state.instant >= state.turn.instant:
            found = predicted(settings, state)
            done = k if found is None else block.run(*found, k, out)
            if found is not None and done > k:
                at = state.instant + done - k
                state, k = begins(settings, at, *found), done
            else:
                state = state._replace(turn=state.turn.later(state.instant))
        if k < len(y):
            row = step(settings, state, y[k], u[k])
            out.put(k, row)
            state, k = row.state, k + 1
    return state


def trail_of(
    settings: Settings, state: State, y: Matrix, u: Matrix, fast: bool, score: bool,
    gap: Gap | None = None,
) -> Trail:  # fmt: skip
    """The trail of the rows of y from `state` on, with what the score needs or without.

    `gap` is the one in which the row before them is.

    Raises
    ------
    DesignError
        As `filter_data`; if digits are lost where states grow in a gap.
    """
    trail, run = Trail.empty(settings.plant, y, score), Pass(settings)
    filtered(settings, trail, state, y, u, fast)
    rows = passed(run, state, y, u, trail.variances, fast)
    require_digits(gap, rows)
    return trail


def predicted(settings: Settings, state: State) -> tuple[Matrix, Vector] | None:
    """Covariance and mean of the next prediction; None where it is close to singular.

    Both are flat.
    """
    move, A, B, J = leading_on(settings.plant, state.setting)
    found = kernels.compiled(likelihood_step, "Omega", "x_minus")(
        A=A, As=move.A, Q=move.Q, B=B, J=J, Sigma=state.Sigma, x=state.x,
        rho=state.rho, u=state.u[:, None],
    )  # fmt: skip
    Omega = found["Omega"]
    if not safe(Omega, Omega.diagonal()):
        return None
    return Omega.flatten(), found["x_minus"].flatten()


def begins(settings: Settings, instant: int, Omega: Vector, x: Vector) -> State:
    """The state from which the next row begins with this prediction; both are flat."""
    n, m, p = settings.plant.n, settings.plant.m, settings.plant.p
    still = Move(np.eye(n), np.zeros((n, n)), np.zeros((n, 0)), np.eye(n))
    setting: Setting = settings.at(max(instant, 1))._replace(
        A=np.eye(n), B=np.zeros((n, m)), J=np.zeros((n, 0)), move=still
    )
    return State(
        instant, x[:, None], Spread(Omega.reshape(n, n)), None, np.zeros(m),
        seen=np.zeros(p, dtype=bool), rho=np.zeros((0, 1)), setting=setting,
    )  # fmt: skip


class Block:
    """Rows that compiled code can do, with all it needs to know of them."""

    def __init__(self, plant: Plant, y: Matrix, u: Matrix, first: int) -> None:
        seen = ~np.isnan(y)
        stacks, index = _stacks(plant, seen, first)
        changing = frozenset(name for name, X in stacks.items() if len(X) > 1)
        known = tuple((name, _known(name, X)) for name, X in stacks.items())
        sizes = tuple((name, getattr(plant, name)) for name in "mnp")
        self.kernel = kernels.over_record(PREDICTIONS, sizes, known, changing)
        self.given = {name: flat(kernels.plain_array(X)) for name, X in stacks.items()}
        self.given |= dict(now=index, before=index, good=np.ones(len(y), dtype=bool))
        self.given |= dict(
            y=kernels.plain_array(np.where(seen, y, 0.0)), u=kernels.plain_array(u)
        )

    def run(self, Omega: Vector, x: Vector, k: int, out: Trail) -> int:
        """From row k on: the first row that was not done, whose prediction is left."""
        return self.kernel(
            **self.given, Omega=Omega, x=x, start=k, stop=len(out.free), keep=out.kept,
            **out.arrays,
        )  # fmt: skip


def _stacks(plant: Plant, seen: Matrix, first: int) -> tuple[Matrices, Vector]:
    """The plant's matrices, and which of them a row has where there are several.

    Outputs that did not arrive keep their places; see derivation/predictions.py.
    """
    S = np.zeros((plant.n, plant.p)) if plant.S is None else plant.S
    whole = {name: getattr(plant, name) for name in "ABCEQR"} | {"S": S}
    here = slice(first, first + len(seen))
    stacks = {k: X[here] if X.ndim == 3 else X[None] for k, X in whole.items()}
    kinds = index = np.arange(len(seen))
    if plant.steps is None:
        kinds, index = patterns(seen)
    if not seen.all():
        some = seen[kinds]
        both = some[:, :, None] & some[:, None, :]
        for name in "CE":
            stacks[name] = stacks[name] * some[:, :, None]
        stacks["S"] = stacks["S"] * some[:, None, :]
        stacks["R"] = np.where(both, stacks["R"], np.eye(plant.p))
    return stacks, np.ascontiguousarray(index, dtype=np.int64)


def _known(name: str, X: Matrix) -> tuple:
    """Entries that are 0, or 1; of covariances only those off the diagonal.

    A search may move a variance to zero, and back.
    """
    zero, one = np.asarray((X == 0).all(axis=0)), np.asarray((X == 1).all(axis=0))
    if name in "QR":
        np.fill_diagonal(zero, False)
        one[:] = False
    return kernels.entries_known(zero, one)
