"""The equation ledger: every equation of the papers, our theorems, and their evidence.

The entries are data, one file for each paper in `entries/` and one for the theorems
that are in no paper, `entries/ours.toml`; they point at code.  An entry's evidence is a
proved step of a derivation, or a test; `ledger.evidence` finds it.  The tests run every
piece of evidence, damage it, and see it fail.

>>> from luenberger import ledger
>>> entry, = ledger.entries("leondes", number="(37)")
>>> entry.says
With every output accurate the gain is K₁ = Ω₂₁ (Ω₁₁ + R₁₁)⁻¹.

What asks or prints the entries enters here; an entry is a row of a file in
`entries/`.  It uses `matrixproof`, `formats` and `show`, and loads a derivation by the
pointer "room.module" of an entry.
"""

from pathlib import Path

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
from .tables import misprint_table as misprint_table
from .tables import summary as summary
from .tables import table as table
from .words import Words as Words


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
        With the proved claims, as MathML; this runs the derivations, which takes half
        a minute.  Without them the page is written at once.

    Raises
    ------
    ValueError
        If there is no such paper.
    ModuleNotFoundError
        If `latex2mathml`, of luenberger[report], is not installed and formulas are
        wanted.
    """
    from .page import write

    write(path, paper, formulas)
