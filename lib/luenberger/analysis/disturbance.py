"""Whether the known input of a plant disturbs an estimate."""

import numpy as np

from ..certificate import Certificate, residuals
from ..errors import DesignError
from ..numeric import Matrix
from ..observer import Observer
from ..plant import Plant

EXACT_TOL = 1e-9  # relative; an answer to the input below it is rounding
HOW_TO_SAY = (
    "Say what it is like, plant.with_input(U): a level for each input such as [12.0], "
    "constant for ever (an input that switches is not that), the covariance of white "
    "inputs such as [[144.0]], or a Plant without input whose outputs they are. U=0 "
    "stands for an input that is always zero."
)
NO_INPUT = (
    "The known input disturbs this estimate, and nothing was said of it: u = 0 here. "
    "error_covariance of plant.with_input(U) counts what it does."
)


def require_undisturbed(
    observer: Observer, plant: Plant, certificate: Certificate
) -> None:
    """Raise DesignError if the known input has a say in the error."""
    if disturbed(observer, plant, certificate):
        raise DesignError(
            "the error depends on the known input "
            f"(dynamics residual {certificate.dynamics:.1e}, input residual "
            f"{certificate.input:.1e}, feedthrough {certificate.feedthrough:.1e}), of "
            f"which nothing is known. {HOW_TO_SAY}"
        )


def disturbed(observer: Observer, plant: Plant, certificate: Certificate) -> bool:
    """Whether the known input moves the error at all.

    It does not where Luenberger's conditions hold.  Elsewhere the answer of the error
    to the input is what counts, which may still be zero.
    """
    if plant.m == 0 or certificate.worst <= EXACT_TOL:
        return False
    if max(certificate.input, certificate.feedthrough) > EXACT_TOL:
        return True
    if observer.steps is not None:
        return bool(plant.B.any() or plant.E.any())
    return _answers(observer, plant)


def _answers(observer: Observer, plant: Plant) -> bool:
    """Whether any response of plant and observer side by side is not rounding.

    Each is compared with that of the magnitudes, so that units play no part.
    """
    o, A, B, C, E = observer, plant.A, plant.B, plant.C, plant.E
    none = np.zeros((plant.n, o.order))
    moves = np.block([[A, none], [o.D @ C, o.F]])
    rows = np.hstack([o.V @ C - o.L, o.P])
    drive = np.vstack([B, o.G + o.D @ E])
    size_of_rows = np.hstack([np.abs(o.V) @ np.abs(C) + np.abs(o.L), np.abs(o.P)])
    size_of_drive = np.vstack([np.abs(B), np.abs(o.G) + np.abs(o.D) @ np.abs(E)])
    sizes = np.block([[np.abs(A), none], [np.abs(o.D) @ np.abs(C), np.abs(o.F)]])
    for _ in range(len(moves)):
        if (np.abs(rows @ drive) > EXACT_TOL * (size_of_rows @ size_of_drive)).any():
            return True
        drive, size_of_drive = moves @ drive, sizes @ size_of_drive
    return False


def magnitudes(
    observer: Observer, plant: Plant, follows: tuple[Matrix, Matrix]
) -> tuple[Matrix, ...]:
    """The sums of magnitudes that the four residuals of a constant pair are made of."""
    o = observer
    A, B, C, E, L, F, G, D, P, V, W, T, T_next = map(
        np.abs, (*plant.at(0)[:4], o.L, *o.at(0), *follows)
    )
    return residuals(A, B, C, E, -L, -F, -G, -D, P, V, W, T, T_next)
