"""A few lines and a table for what a person looks at: a plant, an observer, a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from .numbers import number
from .tables import Prose, Table

MOST = 12  # rows, and columns, that a table of matrices shows
NAMED = 6  # names that a line lists


def counted(many: int, noun: str) -> str:
    """How many there are: no input, 1 state, 2 outputs."""
    return f"{many or 'no'} {noun}{'' if many == 1 else 's'}"


def listed(names: Sequence[str]) -> str:
    """The names, or the first of them and how many more there are."""
    rest = len(names) - NAMED
    shown = ", ".join(names[:NAMED])
    return shown if rest <= 0 else f"{shown} and {rest} more"


def clock(dt: float) -> str:
    """A sampling period in words."""
    return f"one sample every {number(dt)} s" if dt else "in continuous time"


def matrices(
    rows: Sequence[str], columns: Sequence[str], X: np.ndarray
) -> Table | None:
    """The numbers with what they multiply above and what they make beside them.

    None where there are too many to look at, or none.

    >>> matrices(["speed+"], ["speed", "voltage"], np.array([[0.9, 0.05]]))
            speed  voltage
    speed+    0.9     0.05
    """
    if not X.size or max(X.shape) > MOST:
        return None
    size = np.abs(X).max()
    cells = [[number(one, 4, size) for one in row] for row in X]
    return Table(["", *columns], [[name, *row] for name, row in zip(rows, cells)])


def text(head: str, about: Mapping[str, str]) -> str:
    """A line, and a line for each thing that there is to say of it."""
    wide = max(map(len, about), default=0)
    lines = (f"  {key:{wide}}  {said}" for key, said in about.items() if said)
    return "\n".join([head, *lines])


def html(head: str, about: Mapping[str, str], table: Table | None) -> str:
    """The same for a notebook, with a table below."""
    said = Prose(head, *(f"{key}: {one}" for key, one in about.items() if one))
    return said._repr_html_() + ("" if table is None else f"\n{table._repr_html_()}")
