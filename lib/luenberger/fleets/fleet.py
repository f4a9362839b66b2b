"""What all records of one plant share, found once for all parts of them."""

from __future__ import annotations

from functools import cached_property
from threading import RLock
from typing import TYPE_CHECKING, Any

from ..numeric import Vector
from ..recursion.progress import Progress
from ..recursion.settings import Settings
from ..recursion.settled_pass import SettledPass
from ..recursion.state import History, State, start
from .whole import Whole

if TYPE_CHECKING:
    from .records import Records


class Fleet:
    """Any number of records of one plant, which begin alike and have as many rows.

    Threads may work on parts of it side by side: the first that needs something finds
    it, and the others wait.

    Parameters
    ----------
    way : SettledPass
        The way of a filter over a record, in full.
    u0 : (m,) ndarray
        Input from instant 0 to 1.
    rows : int
        N, of each record.
    compile : bool
        Whether compiled code is asked for.
    """

    def __init__(
        self, way: SettledPass, u0: Vector, rows: int, compile: bool = False
    ) -> None:
        self.way, self.u0, self.rows, self.compile = way, u0, rows, compile
        self.begin: State = start(way, way.plant.x0, u0)
        self._lock = RLock()

    def __reduce__(self) -> tuple[Any, ...]:
        """Another process finds by itself what is shared there."""
        way = SettledPass(self.settings, None)
        return Fleet, (way, self.u0, self.rows, self.compile)

    @property
    def settings(self) -> Settings:
        """Those of the filter."""
        return self.way.settings

    @property
    def whole(self) -> Whole | None:
        """The plant in every row; None where not all outputs can arrive together."""
        with self._lock:
            return self._whole

    @cached_property
    def _whole(self) -> Whole | None:
        stacks = self.way.run.stacks
        return None if stacks is None else Whole(stacks, self.begin, self.rows)

    def alone(self, records: Records, s: int) -> tuple[Progress, History]:
        """Record s by itself, with its gains; of all without gaps the first one.

        What it says of covariances is that of all with the same gaps.
        """
        if not records.complete and records.gaps[s].any():
            return records.one(s, True)
        with self._lock:
            if "_complete" not in self.__dict__:
                self._complete = records.one(s, True, self.way)
            return self._complete
