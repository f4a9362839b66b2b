"""What the covariances and the multiplicative noises of a plant have to be."""

from typing import Any

import numpy as np

from ..errors import short
from ..numeric import Matrix
from ..numeric.covariances import require_semidefinite
from ..numeric.validation import matrix, text


def check_joint(Q: Matrix | None, R: Matrix | None, S: Matrix | None) -> None:
    """S needs Q and R, and the three together must be a covariance."""
    if S is None:
        return
    if Q is None or R is None:
        raise ValueError("S = E[w v'] is given but Q or R is not; give all three")
    lead = np.broadcast_shapes(*(X.shape[:-2] for X in (Q, R, S)))
    Q, R, S = (np.broadcast_to(X, lead + X.shape[-2:]) for X in (Q, R, S))
    require_semidefinite("[[Q, S], [S', R]]", np.block([[Q, S], [S.mT, R]]))


def noise_pairs(given: Any, n: int, p: int) -> tuple[tuple[Matrix, Matrix], ...]:
    """The pairs (A1, C1) of `multiplicative`, as matrices."""
    if not isinstance(given, (list, tuple)) or not all(
        isinstance(pair, (list, tuple)) and len(pair) == 2 for pair in given
    ):
        raise ValueError("multiplicative must be a list of pairs (A1, C1) of matrices")
    return tuple(
        (
            matrix(f"multiplicative[{k}] A", A1, n, n),
            matrix(f"multiplicative[{k}] C", C1, p, n),
        )
        for k, (A1, C1) in enumerate(given)
    )


def check_words(at_first: Any, name: Any, description: Any) -> None:
    """P0 is at the first sample or not; a name is a line, a description any text."""
    if not isinstance(at_first, bool):
        raise ValueError(
            "at_first must be True or False: whether x0, P0 are those of the first "
            f"sample, got {short(at_first)}"
        )
    if name is not None:
        text("name", name)
    if not isinstance(description, str | None):
        raise ValueError(f"description must be text, got {short(description)}")
