"""The equation ledger: every equation of the papers, our theorems, and their evidence.

What an entry says, how well it is established and what vouches for it is found on the
pages of the derivations: in what carries the number of the equation.  Kept by hand, in
`entries/`, is what no page knows: the order of the numbers, what uses an equation,
where a notebook shows it, and what the paper misprints.

>>> from luenberger import ledger
>>> entry, = ledger.entries("leondes", number="(37)")
>>> entry.says[0]
the gain of least order: K₁ = Ω₂₁ (Ω₁₁ + R₁₁)⁻¹
>>> entry.level
'proved at symbolic sizes, and at n = 3, p = 2'

What asks or prints the entries enters here; an entry is a row of a file in
`entries/`.  It uses `matrixproof`, `formats` and `show`, and loads a page when
something is asked that only this page knows.
"""

from pathlib import Path
from typing import Any

from .records import KINDS as KINDS
from .records import OURS as OURS
from .records import PAPERS as PAPERS
from .records import PARTS as PARTS
from .records import Entry as Entry
from .records import Misprint as Misprint
from .records import count as count
from .records import entries as entries
from .records import find_paper as find_paper
from .records import misprints as misprints
from .records import title as title
from .tables import by_paper as by_paper
from .tables import levels as levels
from .tables import misprint_table as misprint_table
from .tables import summary as summary
from .tables import table as table


def write_page(
    path: str | Path, paper: str | None = None, *, formulas: bool = True
) -> None:
    """Write the ledger as one HTML page that needs no network and runs no script.

    Parameters
    ----------
    path : str or Path
        Written beside and renamed, so that an interrupted run leaves the old file.
    paper : str, optional
        One paper, or "ours", instead of all.
    formulas : bool
        With formulas and proofs as MathML; this checks all that is proved, which takes
        half a minute, and says what is not.  Without them it is plain text.

    Raises
    ------
    ValueError
        If there is no such paper.
    ModuleNotFoundError
        If `latex2mathml`, is not installed and formulas are
        wanted.
    """
    from .page import write

    write(path, paper, formulas)


def carried(derivation: Any, number: str) -> tuple[Any, ...]:
    """What a page of a derivation says under a number.

    Parameters
    ----------
    derivation : Derivation
    number : str
        As the page writes it, "33" or "section 2".

    Returns
    -------
    tuple of Statement
        Definitions and suppositions, and what is proved.

    Examples
    --------
    >>> from luenberger.papers.leondes_novak.derivation import start
    >>> carried(start.page, "34")
    (let z₊ = T₊ (A x̄ + B u), the error at the start: ε₊ = - T₊ A d - T₊ w)
    """
    from .statements import carried

    return carried(derivation, number)
