"""What Kawazoe's page prints and what comes out of it, each entry tried.

Source: Kawazoe (1978), as scanned; the order of the search is our own finding.
"""

import sympy as sp

from .form import Pattern
from .reconstruction import INPUTS, Delta, u_p, w_o, window, y_o


def printed_25(good, size):
    """(25) as printed: the rows between the first and the last are diagonal."""
    Delta_ = good.copy()
    for j in range(1, size - 2):
        Delta_[j, :] = sp.zeros(1, good.cols)
        first = good[j, :INPUTS]
        Delta_[j, j * INPUTS : (j + 1) * INPUTS] = first
    return Delta_


def misprints():
    """(place, what is printed, what comes out of it): each tried, not remembered."""
    values = window(Pattern((4, 1)))
    outputs, good, past, states = (values[letter] for letter in (y_o, Delta, u_p, w_o))

    def wrong(Delta_, sign=-1):
        left = (outputs + sign * Delta_ * past - states).expand()
        return ", ".join(f"w_{k + 2}" for k, entry in enumerate(left) if entry != 0)

    assert not wrong(good)
    return [
        (
            "(5), (6)",
            "the order of the search is left open",
            "row by row gives p = (3, 0) on a plant with p = (1, 2)",
        ),
        (
            "(17), (20)",
            "= between the outputs and the input term",
            f"must be minus; plus spoils {wrong(good, 1)}",
        ),
        (
            "(25)",
            "second row [0, g_(v+2), 0]",
            f"lower block Toeplitz; as printed it spoils {wrong(printed_25(good, 4))}",
        ),
    ]
