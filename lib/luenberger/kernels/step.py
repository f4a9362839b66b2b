"""A NumPy kernel from its text, which may have been kept: no SymPy here."""

from collections.abc import Iterable
from typing import Any, Protocol

from ..numeric import Matrices, Matrix, columns
from ..numeric.linalg import eye, solve_right, symmetrise

_NAMESPACE: dict[str, Any] = dict(
    eye=eye, solve_right=solve_right, symmetrise=symmetrise
)


class Step(Protocol):
    """A stage list as a function of arrays, by the names of the matrices."""

    source: str
    given: tuple[str, ...]

    def __call__(self, **arrays: Matrix) -> Matrices: ...


class Beside(Protocol):
    """The same of many matrices side by side."""

    given: tuple[str, ...]

    def __call__(self, **arrays: columns.Columns) -> dict[str, columns.Columns]: ...


def assemble(source: str, given: Iterable[str], **others: Any) -> Step:
    """The function ``step(**arrays)`` of a text, with its text and arguments.

    What it calls can be replaced, by name.
    """
    step: Any = _made(source, {**_NAMESPACE, **others})
    step.source, step.given = source, tuple(given)
    return step


def assemble_columns(like: Step) -> Beside:
    """The same function of many matrices side by side."""
    step: Any = _made(like.source, columns.NAMESPACE)
    step.given = like.given
    return step


def _made(source: str, names: dict[str, Any]) -> Any:
    namespace = dict(names)
    exec("import numpy as np\n" + source, namespace)  # made by us, see `kept`
    return namespace["step"]
