"""The rows of a likelihood, from prediction to prediction where need be."""

from __future__ import annotations

from .. import kernels
from ..kernels.program import Factor
from ..numeric import Matrix
from ..numeric.factors import SAFE
from ..papers.leondes_novak.derivation import prediction_step
from ..recursion.filter_pass import Pass
from ..recursion.growth import Gap, passed, require_digits
from ..recursion.predicted import FIRM, PREDICTED, Loops
from ..recursion.settings import Settings
from ..recursion.state import State
from .trail import LIKELIHOOD, Trail

PREDICTIONS = kernels.Recursion(
    prediction_step,
    carried=PREDICTED.carried,
    rows=PREDICTED.rows,
    written=(
        ("innovations", "innovation", "vector"),
        ("Ms", "M", "vector"),
        ("variances", "Omega", "diagonal"),
        ("predictions", "x_minus", "matrix"),
        ("es", "e", "matrix"),
        ("Omegas", "Omega", "matrix"),
        ("Ws", "W", "matrix"),
    ),
    symmetric=PREDICTED.symmetric,
    definite=(Factor("Omega_next", SAFE, "X"), Factor("M", FIRM)),
    each=True,
)


def filtered(
    settings: Settings, out: Trail, state: State, y: Matrix, u: Matrix, fast: bool
) -> State:
    """Filter the rows of y into a trail, from `state` on; the state after them."""
    loops = Loops(LIKELIHOOD, PREDICTIONS)
    return Pass(settings).into(out, state, y, u, fast, loops)


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
