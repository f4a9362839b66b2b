"""The equations of Hsia (1974) in SymPy, in reading order.

`laws`
    Adaptive sampling: every law of Table II is the minimum of a cost per period.

A proof or a stage list of this paper enters here; of a stage list, its `StageList`
stands below, so that nobody loads SymPy only to name it.  It uses
`luenberger.symbolic`, and `luenberger.certificate` where the residuals are proved;
no other paper.
"""

from ....stage_list import StageList

noise_of_a_period = StageList(__name__, "laws.noise_of_a_period", "P")
noise_doubled = StageList(__name__, "laws.noise_doubled", "P_2")
