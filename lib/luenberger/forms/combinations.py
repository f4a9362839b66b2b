"""An observer of combinations of what another one estimates."""

from __future__ import annotations

from typing import Any

from .. import kernels
from ..numeric import Matrices, Matrix
from ..numeric.validation import exact
from .derivation import combined_estimates

NAMES = "PVWL"


def combined(o: Any, H: Matrix, given: object) -> Matrices:
    """What changes of an observer that is to estimate H w^: P, V, W and L.

    Where the observer and H, as it was given, are exact, all its matrices in Fractions.
    """
    have: Matrices = {name: getattr(o, name) for name in NAMES}
    rows, kept = exact(given), {}
    if rows is not None and o.exact is not None:
        have, H = o.exact, rows.reshape(H.shape)
        kept = have
    found = kernels.run(combined_estimates, have | {"H": H}, stacks=True)
    return kept | {name: found[f"{name}_H"] + 0 for name in NAMES}
