"""The equations of Moore (1973) in SymPy.

In reading order: `observer`, `condition`, `recurrence`, `signs`, `errata`.

A proof or a stage list of this paper enters here; of a stage list, its `StageList`
stands below, so that nobody loads SymPy only to name it.  It uses
`matrixproof`, and `luenberger.certificate` where the residuals are proved;
no other paper.
"""

from ....stage_list import StageList

companion_row = StageList(__name__, "condition.companion_row")
observer_input = StageList(__name__, "observer.observer")
