"""How far a pass over a record has come that stops where its filter has settled."""

from __future__ import annotations

from typing import NamedTuple

from ..numeric import Matrix
from .growth import Gap
from .held import Behind
from .looks import Looks
from .settled_rows import Stretch
from .state import State


class Progress(NamedTuple):
    """A pass between two rows: its `State`, and how long outputs have been the same.

    ``alike`` is the number of rows with the outputs of the last one, ``look`` how many
    there must be before the next look, and ``stretch`` the rows with one gain, if these
    are such.  ``settled`` has the rows of the last chunk from which on there was one
    gain, and ``bound`` how far these rows can be from the full recursion.  ``still`` is
    the row from which on there was one to the last, whose variances alone are written
    there, and ``gap`` the one that it is in.  ``looks`` has what looks have cost.
    """

    state: State
    alike: int = 0
    look: int = 0
    stretch: Stretch | None = None
    behind: Behind | None = None
    near: tuple[int, float] | None = None
    settled: tuple[int, ...] = ()
    bound: float = 0.0
    still: int | None = None
    gap: Gap | None = None
    looks: Looks | None = None

    @property
    def instant(self) -> int:
        """That of the last row."""
        return self.state.instant

    @property
    def Sigma(self) -> Matrix:
        """Error covariance there."""
        return self.state.Sigma
