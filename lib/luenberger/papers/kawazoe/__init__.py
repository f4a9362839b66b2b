"""Kawazoe (1978): the observability form, exact reconstruction, deadbeat observers.

`derivation` has the equations, `form` the coordinates, `reconstruction` the exact
state from p_M samples, `deadbeat` the observer that has it after so many.
"""
