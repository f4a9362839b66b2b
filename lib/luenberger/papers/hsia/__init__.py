"""Hsia (1974): laws that say when to sample next, and the loop that does so.

`derivation` has the laws as minima of a cost, `laws` the laws, `loop` the loop
between samples, solved in `system`; `references` are inputs to follow.
`luenberger.sampling` is the public door.
"""
