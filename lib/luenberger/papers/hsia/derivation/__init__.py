"""The equations of Hsia (1974) in SymPy, in reading order.

`laws`
    Adaptive sampling: every law of Table II is the minimum of a cost per period.
`loop`
    Hsia's plant, and the loop that is closed all the time.
`noise`
    What noise on the plant becomes at instants that are not evenly spaced.

A proof or a stage list of this paper enters here; of a stage list, its `StageList`
stands below, so that nobody loads SymPy only to name it.  It uses
`matrixproof` alone; no other paper.
"""

from ....stage_list import StageList

noise_block = StageList(__name__, "noise.noise_block")
noise_of_a_period = StageList(__name__, "noise.noise_of_a_period")
noise_doubled = StageList(__name__, "noise.noise_doubled")
