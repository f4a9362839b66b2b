"""Why there is no observer of a functional: the messages."""

import numpy as np

from ...errors import DesignError
from ...numeric import Vector
from ...numeric.detectability import hidden_modes
from ...numeric.linalg import decaying, modes
from ...plant import Plant
from .recurrences import OverRationals, Polynomials

SHOWN = 3  # recurrence rows in a message
VIOLATED = 1e-10  # a recurrence row this small beside its terms is met


def out_of_range(plant: Plant, order: int) -> DesignError:
    return DesignError(
        f"an observer of one functional without feedthrough has 1 to n = {plant.n} "
        f"states, got order {order}. For k = 0 leave order and poles out."
    )


def no_order(
    admissible: Polynomials, order: int | None, error: float | None
) -> DesignError:
    """No stable observer of this order, or of any; or one that rounding spoils."""
    if error is not None:
        return DesignError(
            f"rounding would put an error of {error:.0e} k x into the estimate: the "
            "outputs hardly see k x, or the poles are far from those of the plant. "
            "Add a sensor, allow a higher order, or ask for other poles."
        )
    if order is None:
        return DesignError(_hidden(admissible))
    recurrence, _ = admissible.answer(order)
    text = f"no stable observer of order {order} without feedthrough: "
    text += recurrence.reason
    if recurrence.dimension == 0:
        text += f", its poles are {modes(recurrence.poles)}"
    text += f". {_remark(admissible)}" if _applies(admissible, order) else "."
    least = _least(admissible, order)
    more = f" The least order found is {least}." if least else " " + _hidden(admissible)
    return DesignError(text + more)


def poles(admissible: Polynomials, wanted: Vector) -> DesignError:
    """The poles asked for are not admissible."""
    r = len(wanted)
    recurrence, _ = admissible.answer(r)
    text = f"no observer of order {r} has the poles {modes(wanted)}: "
    text += _violated(admissible, wanted)
    if recurrence.dimension == 0:
        text += f" Of order {r} the only poles are {modes(recurrence.poles)}."
    elif recurrence.dimension is None:
        text += f" Of order {r} {recurrence.reason}."
    else:
        text += f" Of order {r} {recurrence.reason}: leave poles out."
    if _applies(admissible, r):
        text += f" {_remark(admissible)}"
    return DesignError(f"{text} {_any_poles(admissible)}")


def _violated(admissible: Polynomials, wanted: Vector) -> str:
    """Which rows of S_r kappa = 0, or how far off the row space."""
    beta = np.poly(wanted / admissible.sigma).real[::-1]
    r, kappa = len(wanted), admissible.kappa
    if kappa is None:
        rows = admissible.powers[: r + 1].astype(float)
        return (
            "k beta(A) is not a combination of the rows of C, CA, .., CA^(r-1)"
            f"{_outside(admissible, beta @ rows, r)}."
        )
    terms = [beta * kappa[i : i + r + 1].astype(float) for i in range(len(kappa) - r)]
    sizes = [abs(row.sum()) / max(np.abs(row).sum(), 1e-300) for row in terms]
    bad = [
        f"row {i} comes to {size:.2g} of its terms"
        for i, size in enumerate(sizes)
        if size > min(VIOLATED, 0.99 * max(sizes))
    ]
    more = f", and {len(bad) - SHOWN} more rows" if len(bad) > SHOWN else ""
    return (
        "the recurrence sum_j beta_j kappa_(i+j) = 0, i = 0 .. n - r - 1, is violated: "
        f"{', '.join(bad[:SHOWN])}{more}."
    )


def _outside(admissible: Polynomials, row: Vector, r: int) -> str:
    if isinstance(admissible, OverRationals):
        return ""
    part = np.linalg.norm(row @ admissible.unseen(r)) / np.linalg.norm(row)
    return f", {part:.2g} of it is left"


def _any_poles(admissible: Polynomials) -> str:
    n = len(admissible.A)
    for r in range(1, n + 1):
        basis = admissible.basis(r)
        if basis is not None and basis.shape[1] == r + 1:
            return f"Any poles are possible from order {r} on."
    return "No order admits any poles: k sees a mode that no output shows."


def _least(admissible: Polynomials, order: int) -> int | None:
    for r in range(1, len(admissible.A) + 1):
        if r != order and admissible.answer(r)[0].stable:
            return r
    return None


def _applies(admissible: Polynomials, order: int) -> bool:
    return order < len(admissible.A) and admissible.kappa_has_one_sign()


def _remark(admissible: Polynomials) -> str:
    n = len(admissible.A)
    return (
        f"In Moore's coordinates all entries of k have one sign, and a sum of terms of "
        f"one sign, beta_j kappa_(i+j) with every beta_j > 0, cannot vanish: in "
        f"continuous time such a k needs all n = {n} states."
    )


def _hidden(admissible: Polynomials) -> str:
    """Modes that k sees, no output shows and that do not decay.

    Where rounding has moved them all to the stable side, the slowest.
    """
    values = np.array(hidden_modes(admissible.plant.A, admissible.plant.C))
    if not len(values):
        return (
            "No stable observer of any order was found, though every mode reaches the "
            "outputs: rounding decides. Scale the states to similar sizes, or give "
            "the plant and k as Fractions."
        )
    left = ~decaying(values, admissible.discrete)
    if not left.any():
        slow = np.abs(values) if admissible.discrete else values.real
        left = slow == slow.max()
    return (
        f"No observer of any order is stable: the plant mode(s) {modes(values[left])} "
        "do not decay and do not reach the outputs, but k sees them. Add a sensor."
    )
