"""The equations of Van Dooren (1984) in SymPy, in reading order.

`letters`
    The letters of Van Dooren (1984), each with its size and what it stands for.
`theorem`
    Theorem 1, the change of coordinates, and why the stairs can be triangles.
`staircase`
    The staircase exists: every observable pair is brought to it, by induction.
`rows`
    The rows of the observer, one after the other: each solves a linear system.
`counts`
    What it costs: multiply-adds, counted loop by loop.
`pairs`
    A conjugate pair of poles in a real observer, where the paper is wrong.
`choices`
    All observers with the same poles: what is free in a row, and slopes in it.
`errata`
    What Van Dooren's pages print and what holds, each entry tried.

A proof or a stage list of this paper enters here.  It uses
`matrixproof`, and `luenberger.certificate` where the residuals are
proved; no other paper.
"""
