"""The equations of Van Dooren (1984) in SymPy.

In reading order: `theorem`, `staircase`, `rows`, `counts`, `pairs`, `choices`,
`errata`.

A proof or a stage list of this paper enters here.  It uses
`matrixproof`, and `luenberger.certificate` where the residuals are
proved; no other paper.
"""
