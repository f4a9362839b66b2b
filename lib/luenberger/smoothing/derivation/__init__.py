"""The equations of smoothing in SymPy, in reading order.

`letters`
    The letters of smoothing, each with its size and what it stands for.
`next_state`
    The smoother of Rauch, Tung and Striebel: later rows speak through the next state.
`adjoint`
    The smoother of Bryson and Frazier: what later rows say is carried backwards.
`disturbances`
    The noises that the record shows: estimates of both from all measurements.
`accurate_outputs`
    Smoothed estimates that treat the accurate outputs as exact.

A proof of smoothing enters here.  What runs is in `filtering.passes`, `backward` and
`rts`, and `filtering.back`.  It uses `matrixproof`; the filter's own pass is in
`papers/leondes_novak/derivation`.
"""
