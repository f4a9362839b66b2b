"""The equations of an observer in other coordinates in SymPy.

In reading order: `change`, `combinations`, `gramians`.

A proof or a stage list of a change of coordinates enters here.
"""

from ...stage_list import StageList

changed = StageList(__name__, "change.changed")
combined_estimates = StageList(__name__, "combinations.combined_estimates")
balancing = StageList(__name__, "gramians.balancing")
