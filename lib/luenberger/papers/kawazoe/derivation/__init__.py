"""The equations of Kawazoe (1978) in SymPy.

In reading order: `form`, `reconstruction`, `deadbeat`, `errata`.

A proof or a stage list of this paper enters here; of a stage list, its `StageList`
stands below, so that nobody loads SymPy only to name it.  It uses
`matrixproof` alone; no other paper.
"""

from ....stage_list import StageList

next_entries = StageList(__name__, "deadbeat.next_entries")
measured_gain = StageList(__name__, "deadbeat.measured_gain")
