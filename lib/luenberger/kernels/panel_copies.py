"""Lines that copy rows of some records into panels, and back; see `panel_rows`.

A panel holds so many rows of an array, entry by entry, each in all lanes.
"""

from .python import Python
from .turning import SIDE

LANES = 16  # records side by side
HIGH = 16  # rows that are read and written at once


def lane(array: str, entry: int) -> str:
    """An entry of a local array, in lane l."""
    return f"{array}[{entry * LANES} + l]"


def copy_in(to: Python, array: str, long: int) -> None:
    """Some rows of all lanes; the last record stands in for lanes without one."""
    turned(to, "to_lanes", array, f"{array}_of", long, f"high == {HIGH}")
    to.loop("i", f"{HIGH * long} if high == {HIGH} else 0", f"high * {long}")
    to.loop("l", 0, LANES)
    to.set(
        f"{array}_high[i * {LANES} + l]", f"{array}_[{array}_of[l], base * {long} + i]"
    )
    to.end()
    to.end()


def copy_out(to: Python, array: str, long: int) -> None:
    """Some rows of all lanes that have a record."""
    full = f"high == {HIGH} and here == {LANES}"
    turned(to, "to_rows", array, "written", long, full)
    to.loop("l", f"{LANES} if {full} else 0", "here")
    rows = f"base * {long}:(base + high) * {long}"
    to.let("line", f"{array}_[who_[begin + l], {rows}]")
    to.fill("line[i]", f"{array}_high[i * {LANES} + l]", f"high * {long}")
    to.end()


def turned(to: Python, how: str, array: str, rows: str, long: int, full: str) -> None:
    """A panel that is full, by `turning`."""
    to.loop("l", "0", f"{LANES} if {full} else 0, {SIDE}")
    to.loop("i", "0", f"{HIGH * long}, {SIDE}")
    to.line(
        f"{how}({array}_, {rows}, l, base * {long} + i, {array}_high, "
        f"i * {LANES} + l, {LANES})"
    )
    to.end()
    to.end()
