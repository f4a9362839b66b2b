"""A NumPy kernel from its text, which may have been kept: no SymPy here."""

from collections.abc import Iterable
from typing import Any, Protocol

from ..numeric import Matrices, Matrix
from ..numeric.linalg import eye, solve_right, symmetrise

_NAMESPACE: dict[str, Any] = dict(
    eye=eye, solve_right=solve_right, symmetrise=symmetrise
)


class Step(Protocol):
    """A stage list as a function of arrays, by the names of the matrices."""

    source: str
    given: tuple[str, ...]

    def __call__(self, **arrays: Matrix) -> Matrices: ...


def assemble(source: str, given: Iterable[str], **others: Any) -> Step:
    """The function ``step(**arrays)`` of a text, with its text and arguments.

    What it calls can be replaced, by name.
    """
    namespace = {**_NAMESPACE, **others}
    exec("import numpy as np\n" + source, namespace)  # made by us, see `kept`
    step: Any = namespace["step"]
    step.source, step.given = source, tuple(given)
    return step
