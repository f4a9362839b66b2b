"""The equations of smoothing in SymPy.

In reading order: `next_state`, `adjoint`, `disturbances`, `accurate_outputs`.

A proof of smoothing enters here.  What runs is in `filtering.passes`, `backward` and
`rts`, and `filtering.back`.  It uses `matrixproof`; the filter's own pass is in
`papers/leondes_novak/derivation`.
"""
