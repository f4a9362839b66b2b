"""The equations of Hsia (1974) in SymPy.

In reading order: `laws`, `loop`, `noise`.

A proof or a stage list of this paper enters here; of a stage list, its `StageList`
stands below, so that nobody loads SymPy only to name it.  It uses
`matrixproof` alone; no other paper.
"""

from ....stage_list import StageList

noise_block = StageList(__name__, "noise.noise_block")
noise_of_a_period = StageList(__name__, "noise.noise_of_a_period")
noise_doubled = StageList(__name__, "noise.noise_doubled")
