"""The equations of Kawazoe (1978) in SymPy, in reading order.

`letters`
    The letters of Kawazoe (1978), each with its size and what it stands for.
`form`
    Kawazoe's coordinates, and the form that they give the plant.
`reconstruction`
    The state from the fewest samples: outputs, less what the inputs contribute.
`deadbeat`
    The deadbeat observer: Van Dooren's recursion with every pole at zero.
`errata`
    What Kawazoe's page prints and what comes out of it, each entry tried.

A proof or a stage list of this paper enters here; of a stage list, its `StageList`
stands below, so that nobody loads SymPy only to name it.  It uses
`matrixproof` alone; no other paper.
"""

from ....stage_list import StageList

next_entries = StageList(__name__, "deadbeat.next_entries")
measured_gain = StageList(__name__, "deadbeat.measured_gain")
