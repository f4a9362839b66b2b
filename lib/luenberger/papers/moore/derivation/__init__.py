"""The equations of Moore (1973) in SymPy, in reading order.

`letters`
    The letters of Moore (1973), each with its size and what it stands for.
`observer`
    Moore's observer of a functional of the state, without feedthrough.
`condition`
    When there is an observer without feedthrough: a condition on its poles alone.
`recurrence`
    Moore's own route, (8)-(13): the functional as a sequence with a recurrence.
`signs`
    Moore's remark: a functional with entries of one sign has no smaller observer.
`errata`
    What Moore's page prints and what holds, each entry tried.

A proof or a stage list of this paper enters here; of a stage list, its `StageList`
stands below, so that nobody loads SymPy only to name it.  It uses
`matrixproof`, and `luenberger.certificate` where the residuals are proved;
no other paper.
"""

from ....stage_list import StageList

companion_row = StageList(__name__, "condition.companion_row")
observer_input = StageList(__name__, "observer.observer")
