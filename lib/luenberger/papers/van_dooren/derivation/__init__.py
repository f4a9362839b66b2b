"""The equations of Van Dooren (1984) in SymPy, in reading order.

`theorem`
    Theorem 1, the change of coordinates, and the least norm: for every size.
`rows`
    Van Dooren's rows of T A - F T = D C, and what is true of a conjugate pair.
`pairs`
    The pair a +- jb as the page writes it, and the counts (22)-(25), (34).
`errata`
    What Van Dooren's pages print and what holds, each entry tried.

A proof or a stage list of this paper enters here.  It uses
`luenberger.symbolic`, and `luenberger.certificate` where the residuals are
proved; no other paper.
"""
