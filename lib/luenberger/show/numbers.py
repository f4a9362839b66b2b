"""Numbers and arrays as text that is the same on every machine."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import ArrayLike

NOISE = 1e-12  # an entry this small beside the largest of its array is rounding


def number(value: complex, digits: int = 6, scale: float = 0.0) -> str:
    """One number as text; 0 where it is noise beside `scale`.

    >>> number(2 / 3), number(-0.0), number(3e-17, scale=1), number(1 - 2j, 3)
    ('0.666667', '0', '0', '1-2j')
    """
    if isinstance(value, int | np.integer):
        return str(value)
    value = complex(value)
    noise = NOISE * max(scale, abs(value)) if np.isfinite(value) else 0.0
    real, imag = (
        0.0 if abs(part) <= noise else part for part in (value.real, value.imag)
    )
    text = f"{real:.{digits}g}"
    return text if imag == 0 else f"{text}{imag:+.{digits}g}j"


def array(value: ArrayLike, digits: int = 6) -> str:
    """An array as the text that `show` prints: its rows, the columns aligned."""
    value = np.atleast_1d(np.asarray(value))
    finite = np.abs(value[np.isfinite(value)])
    scale = finite.max(initial=0.0)
    rows = value.reshape(-1, value.shape[-1]) if value.size else value.reshape(0, 0)
    cells = [[number(entry, digits, scale) for entry in row] for row in rows]
    if not cells:
        return f"empty, {' x '.join(map(str, value.shape))}"
    wide = [max(map(len, column)) for column in zip(*cells)]
    return "\n".join(
        "[" + "  ".join(cell.rjust(w) for cell, w in zip(row, wide)) + "]"
        for row in cells
    )


def unit(name: str) -> str:
    """The unit that a name ends with, "m/s" of "velocity (m/s)"; empty without one.

    >>> unit("velocity (m/s)"), unit("x1")
    ('m/s', '')
    """
    found = re.search(r"\(([^()]+)\)\s*$", name)
    return found[1] if found else ""
