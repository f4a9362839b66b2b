"""Leondes and Novak (1974): the reduced-order filter of least error trace.

`derivation` has the equations, `design` the filters; the recursion that they run is
`luenberger.recursion`, which other papers use too.
"""
