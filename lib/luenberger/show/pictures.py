"""A figure as a picture, with the words that stand for it."""

from __future__ import annotations

import base64
import io
import sys
from typing import Any

from .figures import describe

WIDE = 90  # points of the page for an inch of a picture


class Picture:
    """A figure as PNG, with words for those who do not see it.

    The words are in the file, too: a picture that was put in its place is noticed.
    The figure is closed, so that a notebook shows it once.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    says : str, optional
        What is seen, in a sentence or two.  What `describe` reads off the figure
        follows.
    digits : int, default 3
        Of the numbers of that description.
    """

    def __init__(self, figure: Any, says: str = "", digits: int = 3) -> None:
        self.alt = "\n".join(filter(None, [says, describe(figure, digits)]))
        file = io.BytesIO()
        says_so = {"Software": None, "Description": self.alt}
        look: Any = dict(format="png", dpi=2 * WIDE, metadata=says_so)
        figure.savefig(file, **look)
        self.png = base64.b64encode(file.getvalue()).decode()
        self.width = round(WIDE * figure.get_figwidth())
        if "matplotlib.pyplot" in sys.modules:
            sys.modules["matplotlib.pyplot"].close(figure)

    def __repr__(self) -> str:
        return self.alt

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> Any:
        look = {"alt": self.alt, "width": self.width}
        return {"image/png": self.png, "text/plain": self.alt}, {"image/png": look}
