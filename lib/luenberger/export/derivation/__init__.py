"""How far an observer that a device computes is from the exact one, in SymPy.

`letters`
    The letters of an observer and of what a device makes of it.
`rounding`
    What rounding does to state and estimate, step by step and in the long run.
`filter_letters`
    The letters of a filter that computes its covariance on a device.
`filter_covariance`
    What rounding does to its covariance and its gain, in one step.
`filter_rounding`
    What that does to its estimate, step by step and in the long run.

A proof or a stage list about the arithmetic of a device enters here.
"""

from ...stage_list import StageList

added = StageList(__name__, "rounding.added", "M_z M_s c N_z N_s c_w")
errs = StageList(__name__, "rounding.errs", "a_e a_w")
known_gain = StageList(__name__, "filter_rounding.known_gain", "Y F D_y B_u")
gains = StageList(__name__, "filter_rounding.gains", "k_o k_r k_f")
grows = StageList(__name__, "filter_rounding.grows", "l_s")
strays = StageList(__name__, "filter_rounding.strays", "k_d a_s z_s")
