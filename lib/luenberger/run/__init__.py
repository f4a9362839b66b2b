"""Any plant and observer at work: simulated, many times, on records and files.

What steps a plant or an observer through time enters here.  It uses `recursion`,
`analysis`, `formats` and what is below them; no kernel and no paper.
"""
