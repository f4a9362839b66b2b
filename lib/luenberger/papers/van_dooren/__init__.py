"""Van Dooren (1984): the observer of order n - rank C with prescribed poles.

`derivation` has the equations and `design` the observer; `rows_of_T` solves
T A - F T = D C row by row, `free_entries` from entries that are chosen, and
`best_conditioned` chooses them.  The staircase form itself is
`luenberger.numeric.staircase_form`.
"""
