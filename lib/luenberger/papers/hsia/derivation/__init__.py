"""The equations of Hsia (1974) in SymPy, in reading order.

`laws`
    Adaptive sampling: every law of Table II is the minimum of a cost per period.

A proof or a stage list of this paper enters here.  It uses
`luenberger.symbolic`, and `luenberger.certificate` where the residuals are
proved; no other paper.
"""
