"""Smoothing: the states of a record from what was measured before and after.

Its `derivation` is here; `Filter.smooth` runs it on a record that was filtered.
"""
