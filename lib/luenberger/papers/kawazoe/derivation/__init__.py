"""The equations of Kawazoe (1978) in SymPy, in reading order.

`letters`
    The letters of Kawazoe (1978), each with its size and what it stands for.
`definitions`
    Kawazoe's coordinates, and the state from p_M samples.
`form`
    Kawazoe's observability form, and the state from p_M samples.
`deadbeat`
    The deadbeat observer: Van Dooren's recursion with every pole at zero.

A proof or a stage list of this paper enters here.  It uses
`luenberger.symbolic`, and `luenberger.certificate` where the residuals are
proved; no other paper.
"""
