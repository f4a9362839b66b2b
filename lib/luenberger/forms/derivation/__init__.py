"""The equations of an observer in other coordinates in SymPy, in reading order.

`change`
    A change of coordinates keeps the estimate and the certificate.
`combinations`
    Combinations of what an observer estimates are estimated by the same observer.
`gramians`
    The coordinates in which both Gramians are the same diagonal matrix.

A proof or a stage list of a change of coordinates enters here.
"""

from ...stage_list import StageList

changed = StageList(__name__, "change.changed")
combined_estimates = StageList(__name__, "combinations.combined_estimates")
balancing = StageList(__name__, "gramians.balancing")
