"""The equations of smoothing in SymPy, in reading order.

`letters`
    The letters of smoothing, each with its size and what it stands for.
`next_state`
    The smoother of Rauch, Tung and Striebel: later rows speak through the next state.
`adjoint`
    The smoother of Bryson and Frazier: what later rows say is carried backwards.
`from_estimate`
    The same in fewer multiplications, from estimate to estimate.
`fixed_lag`
    A fixed lag: what a stretch of rows says is one map, and two stretches are one.
`disturbances`
    The noises that the record shows: estimates of both from all measurements.
`accurate_outputs`
    Smoothed estimates that treat the accurate outputs as exact.

A proof or a stage list of smoothing enters here; of a stage list, its `StageList`
stands below, so that nobody loads SymPy only to name it.  It uses
`luenberger.symbolic`; the filter's own pass is in `papers/leondes_novak/derivation`.
"""

from ...stage_list import StageList

factor_step = StageList(
    __name__, "next_state.factor_step", "x_s kept drawn passed U_next"
)
backward_step = StageList(
    __name__,
    "adjoint.backward_step",
    "theta Theta Left x_s Sigma_s U_next Ahead new lamda Theta_Y New Lambda",
)
handed_on = StageList(__name__, "from_estimate.handed_on", "Theta_Y New Lambda")
backward_loop = StageList(
    __name__,
    "from_estimate.backward_loop",
    "theta Past Theta Left x_s Sigma_s U_next Ahead new lamda",
)
rest = StageList(__name__, "adjoint.rest", "Rest")
said = StageList(__name__, "adjoint.said", "W")
said_by_root = StageList(__name__, "adjoint.said_by_root", "W")
row = StageList(__name__, "fixed_lag.row", "a F D")
joined = StageList(__name__, "fixed_lag.joined", "a F D")
residual = StageList(__name__, "disturbances.residual", "rho_s")
noises = StageList(__name__, "disturbances.noises", "w_s S_left v_s")
pushed_step = StageList(__name__, "accurate_outputs.pushed_step", "x_c Sigma_c U_c")
