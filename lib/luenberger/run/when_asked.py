"""A long array of a result whose end is one row, written when somebody asks for it.

Where a filter has settled, deviations are the same in nearly all rows.  To write them
takes longer than to find the estimates, and many never look at them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import numpy as np

from ..numeric import Matrix, Vector
from ..recursion.state import fill

Result = TypeVar("Result")


class Ending(NamedTuple):
    """So many rows, the first of which are `early`, and all others `row`."""

    early: Matrix
    row: Vector
    rows: int

    def written(self) -> Matrix:
        """All rows.  Two threads that ask at once write the same."""
        all_, first = np.empty((self.rows, len(self.row))), len(self.early)
        all_[:first] = self.early
        fill(all_[first:], self.row)
        return all_


class _Field:
    """A field: an array, or an `Ending` that becomes one when it is read."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __get__(self, result: Any, owner: type | None = None) -> Any:
        if result is None:
            raise AttributeError(self.name)  # a field without a default
        found = vars(result)[self.name]
        if isinstance(found, Ending):
            found = vars(result)[self.name] = found.written()
        return found

    def __set__(self, result: Any, found: Any) -> None:
        vars(result)[self.name] = found


def when_asked(name: str) -> Callable[[type[Result]], type[Result]]:
    """A dataclass whose field of that name may be an `Ending`."""

    def over(made: type[Result]) -> type[Result]:
        setattr(made, name, _Field(name))
        return made

    return over
