"""The letters of Leondes and Novak (1974), each with its size and what it stands for.

Theirs and ours differ in a few: their H_i is C, their n x m gain has p columns here,
because p counts outputs and m counts inputs.  A plus below is the next instant, where
the paper writes i + 1; what has no mark is at instant i.  The order of the observer is
r = n - m1, so that m1 is not a size of its own.
"""

from sympy import symbols

from matrixproof import Identity, Notation

SOURCE = "Leondes and Novak (1974)"

n, p, m, r = symbols("n p m r", integer=True, nonnegative=True)
m1 = n - r  # accurate outputs
p2 = p - m1  # the others
named_m1 = symbols("m_1")
letters = Notation({m1: named_m1, p2: p - named_m1})
I = Identity(n)
