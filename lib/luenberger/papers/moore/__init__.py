"""Moore (1973): observers of a functional k x without feedthrough, of least order.

`derivation` has the equations and `design` the observer.  `recurrences` says which
polynomials there are, `companion_chain` and `orthonormal` realise one, `refusals`
explains when there is none.
"""
