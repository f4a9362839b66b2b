"""Words with formulas in them, shown wherever an entry of the ledger is."""

import html
from dataclasses import dataclass


@dataclass(frozen=True, repr=False)
class Words:
    r"""A sentence; what stands between backquotes in its source is a formula.

    A terminal shows it in Unicode, a notebook typeset.

    >>> says = Words("The gain satisfies `K M = Omega C'`.")
    >>> says
    The gain satisfies K M = Ω C'.
    >>> print(says._repr_markdown_())
    The gain satisfies $K M = \Omega C'$.
    """

    source: str

    def __str__(self) -> str:
        from matrixproof.prose import plain

        return plain(self.source)

    __repr__ = __str__

    def unbroken(self) -> str:
        """The same with no-break spaces where a line must not end."""
        from matrixproof.prose import unbroken

        return unbroken(self.source)

    def _repr_markdown_(self) -> str:
        from matrixproof.prose import markdown

        return markdown(self.source)

    def _repr_html_(self) -> str:
        r"""Formulas as MathJax finds them, `\(...\)`."""
        from matrixproof.prose import typeset

        return "".join(
            rf'<span class="math">\({html.escape(piece)}\)</span>'
            if is_latex
            else html.escape(piece)
            for is_latex, piece in typeset(self.source)
        )
