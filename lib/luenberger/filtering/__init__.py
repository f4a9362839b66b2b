"""The filter of a noisy plant: one form, U D U', one output at a time.

`passes` has the recursion and the way back, `maps` the matrices of a row, `pack` a
record in these terms.
"""
