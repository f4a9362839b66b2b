"""Smoothing: the states of a record from what was measured before and after.

What uses measurements that come after an estimate's own instant enters here.  It uses
the filter's pass of `recursion` and its own `derivation`.
"""
