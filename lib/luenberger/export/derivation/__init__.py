"""How far an observer that a device computes is from the exact one, in SymPy.

`letters`
    The letters of an observer and of what a device makes of it.
`rounding`
    What rounding does to state and estimate, step by step and in the long run.

A proof or a stage list about the arithmetic of a device enters here.
"""

from ...stage_list import StageList

added = StageList(__name__, "rounding.added", "M_z M_s c N_z N_s c_w")
errs = StageList(__name__, "rounding.errs", "a_e a_w")
