"""Five ways to get an observer and one to sample, a room for each paper.

In a room, `derivation` holds the mathematics in SymPy and `design` (or what the paper
calls it) the numerical design, with its helpers beside it.

What all designs go through enters here: `certified`, the only way out, and the poles
that were asked for.  A paper uses the rooms below and never another paper; what two
papers share moves down.
"""
