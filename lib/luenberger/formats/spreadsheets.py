"""What a spreadsheet that opens a CSV file would take for a formula, and may run.

A cell is one if it begins with = or @, or with a sign and is no number, time or
duration.  Some spreadsheets also cut at semicolons, tabs or bars, quoted or not, so
what follows one is judged as a cell.
"""

import re
from collections.abc import Sequence

from ..errors import short

SIGNED = r"[-+](?:\d+ days?,? ?[-+]?)?[\d:]*(?:\.\d*)?(?:[eE][-+]?\d+)?"
CUT = r"[;\t|]"
FORMULA = re.compile(
    rf'(?:^|{CUT})[" ]*(?!{SIGNED}[" ]*(?:$|{CUT}))[-+=@\uff0b\uff0d\uff1d\uff20]',
    re.M,
)


def first_formula(cells: Sequence[str]) -> int | None:
    """The index of the first cell that is a formula, or None.

    >>> first_formula(["=1+1"]), first_formula(["-7.5", "+00:30", "-1 days +23:59"])
    (0, None)
    """
    if not FORMULA.search("\n".join(cells)):
        return None
    return next((k for k, cell in enumerate(cells) if FORMULA.search(cell)), None)


def require_plain_names(plant: object) -> None:
    """Raise ValueError if a name of the plant's signals would be a formula."""
    for kind in ("state", "input", "output"):
        require_plain(kind, getattr(plant, f"{kind}_names"))
    require_plain("estimate", [*getattr(plant, "estimates", ())])


def require_plain(kind: str, names: Sequence[str]) -> None:
    """Raise ValueError if one of the names would be a formula."""
    if (k := first_formula(names)) is not None:
        raise ValueError(
            f"the {kind} name {short(names[k])} would be a formula in a spreadsheet "
            "that opens the CSV file; rename it"
        )
