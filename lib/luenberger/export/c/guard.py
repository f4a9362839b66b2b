"""What a filter in C tests of its own rounding, and what it may do for the test.

A covariance that could run away is tested to be definite.  The short form of the
covariance is used where its bound on rounding is small beside every variance.
"""

import numpy as np

from ...errors import DesignError
from ...kernels.c.numbers import representable
from ...kernels.program import Guard, Magnitudes, Roots, Within
from ...numeric import Matrices, Matrix
from ...numeric.detectability import require_detectable
from ...plant import Plant

WAYS = ("joseph", "guarded")
ROUNDOFF = {"double": 2.0**-53, "float": 2.0**-24}
TOLERANCE = {"double": 1e-8, "float": 1e-4}  # half the digits of a variance
LEAST = {"double": 1e-200, "float": 1e-25}  # variance beside which no digit is lost
MORE = 1.01  # roots are some more than they are, for covariances that are rounded
SECOND = 4.1  # 4, and more than all that is of second order


def undriven(As: Matrix, Q: Matrix, Omega: Matrix) -> bool:
    """Whether a mode that does not decay has no noise to drive it.

    A Kalman filter without such a mode forgets what rounding did to its covariance.
    With one, a negative variance may run away, so definiteness is then tested at
    every sample; for accurate outputs it always is.  States that are known for good
    have no part in it: their variances are zero to the last bit.
    """
    rest = ~known_for_good(As, Q, Omega)
    if not rest.any():
        return False
    kept = np.ix_(rest, rest)
    try:
        require_detectable(As[kept].T, Q[kept])
    except DesignError:
        return True
    return False


def known_for_good(As: Matrix, Q: Matrix, Omega: Matrix) -> Matrix:
    """Which states begin known, have no noise, and are moved by such states alone."""
    known: Matrix = ~np.any([Q != 0, Omega != 0], axis=(0, 2))
    while (lost := known & As[:, ~known].any(axis=1)).any():
        known &= ~lost
    return known


def guards(n: int, p: int, real: str) -> tuple[Guard, ...]:
    """What gives up where the bound on rounding is too large."""
    part = bound(n, p, real) / TOLERANCE[real]
    return (
        Roots("w", "Omega", MORE),
        Magnitudes("K_s", "K"),
        Within("Sigma", "b", part, LEAST[real]),
    )


def bound(n: int, p: int, real: str) -> float:
    """g of the page on the short form: rounding is at most `g b b'`."""
    return SECOND * (n + p + 2) * ROUNDOFF[real]


def sizes(plant: Plant, full: Matrices, real: str) -> Matrices:
    """Sizes of C and R, which the bound takes; refuses R that is next to nothing."""
    variances = full["R"].diagonal()
    small = [plant.output_names[k] for k in np.flatnonzero(variances < LEAST[real])]
    if small:
        raise DesignError(
            f"update='guarded' needs variances in R of at least {LEAST[real]!r}, and "
            f"those of {small} are less: choose a smaller unit for them, or leave "
            "update at 'joseph'"
        )
    r_s = representable("R", MORE * np.sqrt(variances)[:, None], real)
    return {"C_s": np.abs(full["C"]), "r_s": r_s}


def notes(n: int, p: int, real: str) -> list[str]:
    """What the header says of it."""
    tolerance, g = TOLERANCE[real], bound(n, p, real)
    return [
        "",
        "Guarded: where every output arrived, Sigma is Omega - K C Omega, if rounding",
        f"moves no entry of it by more than {tolerance!r} of the root of its two",
        "variances; else it is (27).  In a step it moves entry (i, j) by less than",
        f"{g:.2g} b[i] b[j] from the covariance that the gain leaves exactly, where",
        f"b = w + |K| (|C| w + r), w[i] = {MORE} sqrt(Omega[i][i]) and",
        f"r[j] = {MORE} sqrt(R[j][j]), as proved in",
        "papers/leondes_novak/derivation/short_form.py.",
    ]
