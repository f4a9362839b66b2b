"""The letters of Kawazoe (1978), each with its size and what it stands for.

The staircase and its letters are those of Van Dooren (1984), here for the pair that
Kawazoe's coordinates make when they are sorted by level.
"""

from sympy import symbols

from matrixproof import Notation

n, m, r, s, q = symbols("n m r s q", integer=True, nonnegative=True)
p_i, p_j, v_h, v_i = symbols("p_i p_j v_h v_i", integer=True, positive=True)
letters = Notation()

# -- the plant ------------------------------------------------------------------------

x = letters("x", n, 1, "state")
u = letters("u", r, 1, "input")
y = letters("y", m, 1, "measurement, less `E u` where the input feeds through")

# -- rows as coordinates --------------------------------------------------------------

e_i = letters("e_i", 1, m, "picks output `i`")
P = letters("P", n, n, "the rows `C_i A^k` that are kept, sorted by output")
e_v = letters("e_v", 1, n, "picks the first entry of block `i`")
E_0 = letters("E_0", n - m, n, "picks the entries that are not the last of a block")
E_n = letters("E_n", n - m, n, "picks the entry after each of these")
Phi = letters("Phi", n, n, "moves the state in the new coordinates")
G = letters("G", n, r, "what the input does in the new coordinates")
H = letters("H", m, n, "reads the first entry of each block")
w = letters("w", n, 1, "state in the new coordinates")
Phi_l = letters("Phi_l", n, n, "`Phi` to the power `l`")


# -- the staircase --------------------------------------------------------------------

r_h, r_c, r_n = symbols("r_h r_c r_n", integer=True, positive=True)
