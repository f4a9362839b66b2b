"""What is known of every record once a panel is through; see `panel_rows`."""

from collections.abc import Sequence

from .panel_copies import lane
from .python import Python
from .statements import Entry


class Watch:
    """Whether a lane has failed, and of a covariance the extremes and the last one.

    `covariance` are its entries by rows, or none.
    """

    def __init__(self, tests: bool, covariance: Sequence[Sequence[Entry]]) -> None:
        self.tests = tests
        self.flat = [entry for row in covariance for entry in row]
        self.diagonal = [row[i] for i, row in enumerate(covariance)]
        self.last = {entry: k for k, entry in enumerate(dict.fromkeys(self.flat))}

    @property
    def rooms(self) -> dict[str, int]:
        """The local arrays, and how many numbers a lane has in each."""
        rooms = {"bad": 1} if self.tests else {}
        if self.flat:
            rooms |= {"low": len(self.diagonal), "top": len(self.diagonal)}
            rooms["last"] = len(self.last)
        return rooms

    def start(self, to: Python) -> None:
        """Before the first row of lane l."""
        if self.tests:
            to.set("bad[l]", "0.0")
        for k in range(len(self.diagonal)):
            to.set(lane("low", k), "np.inf")
            to.set(lane("top", k), "0.0")

    def row(self, to: Python) -> None:
        """Behind a row of lane l."""
        if self.tests:
            to.set("bad[l]", "bad_")
        for k, entry in enumerate(self.diagonal):
            for kept, sign in (("low", "<"), ("top", ">")):
                at = lane(kept, k)
                to.set(at, f"{entry} if {entry} {sign} {at} else {at}")
        for entry, k in self.last.items():
            to.set(lane("last", k), entry)

    def leave(self, to: Python) -> None:
        """Behind the last row of all lanes that have a record."""
        if not self.tests:
            return
        to.loop("l", 0, "here")
        to.let("s", "who_[begin + l]")
        to.set("failed_[s]", "bad[l] > 0.0")
        for k in range(len(self.diagonal)):
            to.set(f"least_[s, {k}]", lane("low", k))
            to.set(f"most_[s, {k}]", lane("top", k))
        for k, entry in enumerate(self.flat):
            to.set(f"last_[s, {k}]", lane("last", self.last[entry]))
        to.end()
