"""The letters of Moore (1973), each with its size and what it stands for.

    letter of the paper   F  g  h'  k'  A  b  d  l'  T'  p
    letter here           A  B  C   k   F  D  G  P   T   r

A plus below is the next instant, or the derivative in continuous time.
"""

from sympy import symbols

from matrixproof import Notation

n, p, m, r, o = symbols("n p m r o", integer=True, nonnegative=True)
letters = Notation()

# -- the plant and the observer -------------------------------------------------------

A = letters("A", n, n, "moves the state")
C = letters("C", p, n, "what is measured")
k = letters("k", 1, n, "the functional: `k x` is wanted; in a factor, its first row")
F = letters("F", r, r, "moves the observer's state")
D = letters("D", r, p, "what the measurement does to it")
P = letters("P", 1, r, "reads the estimate off it")
T = letters("T", r, n, "what the observer's state tracks")
x = letters("x", n, 1, "state")
eps = letters("varepsilon", r, 1, "error of the observer's state")

# -- companion form, row by row -------------------------------------------------------

t = letters("t", 1, n, "row `i` of `T`")
# -- one output: the functional as a sequence -----------------------------------------

c = letters("c", 1, n, "the last row of the identity")
D_1 = letters("D_1", r, 1, "`D` for one output")
S = letters("S", n - r, n, "rows `beta_0`, ..., `beta_r`, each one place further on")
kappa = letters("kappa", n, 1, "the sequence `k A^i g`")
beta = letters("beta", 1, r, "coefficients of the observer's polynomial")
