"""Haddad and Bernstein (1987): the filter of least error at a given order.

`derivation` has the equations and `design` the filter.  `target` is the problem that
is solved, `search` looks for minima, `descent` goes down to one, `stein` solves the
equations on the way.
"""
