"""The letters of Van Dooren (1984), each with its size and what it stands for.

The paper's P, G, H are G, P, V here.  A star is the conjugate transpose; only that
U U* = U* U = I is used of it, so the plant may be complex.
"""

from sympy import symbols

from matrixproof import Identity, Notation

n, m, r, i, s, q = symbols("n m r i s q", integer=True, nonnegative=True)
letters = Notation()
I = Identity(n)  # noqa: E741

# -- the plant and the observer -------------------------------------------------------

A = letters("A", n, n, "moves the state")
C = letters("C", r, n, "what is measured; its rows are independent")
F = letters("F", n - r, n - r, "moves the observer's state; its spectrum is chosen")
D = letters("D", n - r, r, "what the measurement does to it")
x = letters("x", n, 1, "state")

# -- unitary coordinates --------------------------------------------------------------

A_U = letters("A_U", n, n, "`A` in these coordinates: a staircase")
C_U = letters("C_U", r, n, "`C` in these coordinates: only the last columns")
T_U = letters("T_U", n - r, n, "`T` in these coordinates: a unit triangle")
W = letters("W", n - r, n - r, "unitary: coordinates of the observer's state")

# -- one row at a time ----------------------------------------------------------------

t = letters("t", 1, n, "row of `T_U`: zeros, a one, and what is unknown")
f = letters("f", 1, n - r, "row of `F`: what is unknown, a pole, and zeros")
f_i = letters("f_i", 1, i, "the unknown entries of that row")
d = letters("d", 1, r, "row of `D`")
T_i = letters("T_i", i, n, "the rows of `T_U` above it, which are known")
a_f = letters("a_f", 1, n, "that row of `A_U - f_ii I`")
x_i = letters("x_i", 1, n + r - 1, "the unknowns: `f_i`, `t_i` and `d`")
M = letters("M", n + r - 1, n, "the rows `-T_i`, `A_f` and `-C_U`")
S = letters("S", n, n + r - 1, "picks the rows of `M` that lead its columns")
X = letters("X", n, n, "their triangle, the entries of the stairs on its diagonal")
L = letters("L", n, n + r - 1, "a left inverse of `M`")
both = letters("Theta", n, n, "`T_U` above `C_U`")

# -- a pair a +- jb -------------------------------------------------------------------

w = letters("w", 1, 2, "the row `1`, `j`")
N = letters("N", 1, 1, "the pole `a + j b`")
