"""Numbers, tables, sentences and figures in words that are the same everywhere.

Strict notebook tests compare text.  Everything a notebook prints therefore goes
through here: six significant digits at most, rounding noise and -0 shown as 0, and
with each figure what can be read off it, in words.

What turns a value into words for a person enters here.  It uses no other room.
"""

from __future__ import annotations

import sys
from typing import Any

from .blocks import counted as counted
from .numbers import array as array
from .numbers import number as number
from .numbers import unit as unit
from .pictures import Picture as Picture
from .pictures import describe as describe
from .tables import Prose as Prose
from .tables import Table as Table


def show(value: Any, label: str | None = None, digits: int | None = None) -> None:
    """Print an array row by row, or show a figure with what can be read off it.

    Parameters
    ----------
    value : array_like, or a Figure of matplotlib
        A notebook shows a figure as a picture.  The text of that output, which strict
        notebook tests compare, is `describe(figure)`; so is what a screen reader
        reads.  A terminal gets the text alone.
    label : str, optional
        The name of the array; of a figure its caption, a sentence that says what is
        seen.
    digits : int, optional
        Significant digits, 6 of an array and 3 of a figure.

    Examples
    --------
    >>> show([[1, 1e-20], [-0.0, 1 / 3]], "K")
    K =
    [1         0]
    [0  0.333333]
    """
    if not hasattr(value, "savefig"):
        head = "" if label is None else f"{label} =\n"
        print(head, array(value, digits or 6), sep="")
        return
    picture, shell = (
        Picture(value, label or "", digits or 3),
        sys.modules.get("IPython"),
    )
    if shell is not None and shell.get_ipython() is not None:
        shell.display.display(picture)
        if label:
            caption = {"text/markdown": f"*{label}*", "text/plain": label}
            shell.display.display(caption, raw=True)
    else:
        print(picture)
