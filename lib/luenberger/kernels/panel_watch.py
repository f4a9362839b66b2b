"""What is known of every record once a panel is through; see `panel_rows`."""

from collections.abc import Sequence

from .panel_copies import LANES, lane
from .python import Python
from .statements import Entry


class Watch:
    """Whether a lane has failed, and of a covariance the extremes and the last one.

    `covariance` are its entries by rows, or none.  Where the vector `variances` is
    written, some rows at once, it is looked at there: a row has less to store then.
    """

    def __init__(
        self, tests: bool, covariance: Sequence[Sequence[Entry]], variances: str = ""
    ) -> None:
        self.tests, self.variances = tests, variances
        self.flat = [entry for row in covariance for entry in row]
        self.diagonal = [row[i] for i, row in enumerate(covariance)]
        seen = set(self.diagonal) if variances else ()
        others = dict.fromkeys(entry for entry in self.flat if entry not in seen)
        self.last = {entry: k for k, entry in enumerate(others)}

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
        if not self.variances:
            for k, entry in enumerate(self.diagonal):
                _extremes(to, lane("low", k), lane("top", k), entry)
        for entry, k in self.last.items():
            to.set(lane("last", k), entry)

    def rows(self, to: Python) -> None:
        """Behind some rows of all lanes, which are row t in 0 ... high - 1."""
        if not self.variances:
            return
        many = len(self.diagonal) * LANES
        to.loop("t", 0, "high")
        rows = f"t * {many}:(t + 1) * {many}"
        to.let(f"{self.variances}_lanes", f"{self.variances}_high[{rows}]")
        to.loop("l", 0, many)
        to.let("v", f"{self.variances}_lanes[l]")
        _extremes(to, "low[l]", "top[l]", "v")
        to.end()
        to.end()

    def leave(self, to: Python) -> None:
        """Behind the last row of all lanes that have a record."""
        if not self.tests:
            return
        to.loop("l", 0, "here")
        to.let("s", "who_[begin + l]")
        to.set("failed_[s]", "bad[l] > 0.0")
        n = len(self.diagonal)
        for k in range(n):
            to.set(f"least_[s, {k}]", lane("low", k))
            to.set(f"most_[s, {k}]", lane("top", k))
        for k, entry in enumerate(self.flat):
            if entry in self.last:
                to.set(f"last_[s, {k}]", lane("last", self.last[entry]))
                continue
            at = f"((high - 1) * {n} + {self.diagonal.index(entry)}) * {LANES} + l"
            to.set(f"last_[s, {k}]", f"{self.variances}_high[{at}]")
        to.end()


def _extremes(to: Python, low: str, top: str, entry: Entry) -> None:
    to.set(low, f"{entry} if {entry} < {low} else {low}")
    to.set(top, f"{entry} if {entry} > {top} else {top}")
