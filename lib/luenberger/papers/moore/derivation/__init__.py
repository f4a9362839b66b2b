"""The equations of Moore (1973) in SymPy, in reading order.

`letters`
    The letters of Moore (1973), each with its size and what it stands for.
`observer`
    Moore's observer of a functional k x without feedthrough: the case V = 0.
`condition`
    When an observer without feedthrough exists: a condition on beta alone.
`recurrence`
    Moore's own route, (8)-(13): the functional as a sequence with a recurrence.
`signs`
    Moore's remark: no observer of order r < n when k has all entries of one sign.
`errata`
    What Moore's page prints and what holds, each entry tried.

A proof or a stage list of this paper enters here; of a stage list, its `StageList`
stands below, so that nobody loads SymPy only to name it.  It uses
`luenberger.symbolic`, and `luenberger.certificate` where the residuals are proved;
no other paper.
"""

from ....stage_list import StageList

companion_row = StageList(__name__, "condition.companion_row", "t_next")
observer_input = StageList(__name__, "observer.observer", "G")
