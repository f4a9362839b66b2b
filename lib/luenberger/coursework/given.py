"""What was given in place of an answer, in a few words."""

from fractions import Fraction
from typing import Any

import numpy as np
import sympy as sp


def require(condition: bool, message: str) -> None:
    """An AssertionError without what pytest would add to it."""
    if not condition:
        raise AssertionError(message)


def alone(answer: Any) -> Any:
    """What stands alone in a list, an array or a matrix."""
    while isinstance(answer, list | tuple | np.ndarray | sp.MatrixBase):
        if np.size(answer) != 1:
            return answer
        answer = answer[0] if isinstance(answer, list | tuple) else np.ravel(answer)[0]
    return answer.item() if isinstance(answer, np.generic) else answer


def described(answer: Any) -> str:
    """What was given, in a few words."""
    if answer is None:
        return "None"
    if isinstance(answer, str):
        return f"the text {answer[:40]!r}"
    if isinstance(answer, list | tuple | dict | set):
        return f"a {type(answer).__name__} of {len(answer)}"
    if isinstance(answer, np.ndarray | sp.MatrixBase):
        return f"an array of shape {tuple(answer.shape)}"
    if isinstance(answer, bool | int | float | Fraction | np.generic):
        kind = type(answer).__name__
        return f"{kind.rstrip('0123456789')} {answer}"
    if isinstance(answer, sp.Basic):
        return f"the expression {str(answer)[:60]}"
    kind = type(answer).__name__
    return f"a{'n' if kind[0] in 'aeiouAEIOU' else ''} {kind}"
