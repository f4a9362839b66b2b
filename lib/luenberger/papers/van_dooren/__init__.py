"""Van Dooren (1984): the observer of order n - rank C with prescribed poles.

`derivation` has the equations and `design` the observer; `rows_of_T` solves
T A - F T = D C row by row, and `best_conditioned` chooses entries that are free.  The
staircase form itself is `luenberger.numeric.staircase_form`.
"""
