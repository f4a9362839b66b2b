"""The letters of Kawazoe (1978), each with its size and what it stands for.

The staircase and its letters are those of Van Dooren (1984), here for the pair that
Kawazoe's coordinates make when they are sorted by level.
"""

from sympy import symbols

from matrixproof import Identity as Identity
from matrixproof import Notation
from matrixproof import ZeroMatrix as ZeroMatrix

SOURCE = "Kawazoe (1978)"

n, m, r, s, q = symbols("n m r s q", integer=True, nonnegative=True)
p_i, p_j, v_h, v_i = symbols("p_i p_j v_h v_i", integer=True, positive=True)
letters = Notation()
chain, let, steady, suppose = (
    letters.chain,
    letters.let,
    letters.steady,
    letters.suppose,
)

# -- the plant ------------------------------------------------------------------------

A = letters("A", n, n, "moves the state")
B = letters("B", n, r, "what the input does to the state")
C = letters("C", m, n, "what is measured; its rows are independent")
x = letters("x", n, 1, "state")
x_next = letters("x_next", n, 1, "state one sample on")
u = letters("u", r, 1, "input")
y = letters("y", m, 1, "measurement, less `E u` where the input feeds through")

# -- rows as coordinates --------------------------------------------------------------

e_i = letters("e_i", 1, m, "picks output `i`")
C_i = letters("C_i", 1, n, "row `i` of `C`")
C_1 = letters("C_1", 1, n, "its first row")
C_2 = letters("C_2", 1, n, "its second row")
c_k = letters("c", 1, n, "the row `C_i A^k`")
c_next = letters("c_next", 1, n, "the row after it in the table, that row times `A`")
R = letters("R", s, n, "the rows that come before it in the order of the search")
R_next = letters("R_next", s, n, "the rows that come before the next one")
a = letters("a", 1, s, "coefficients of a combination of them")
M = letters("M", s, s, "says which of them is which")
P_r = letters("P_r", n, n, "rows of the table, taken row by row")
P_q = letters("P_q", q, n, "the rows of the table that are kept")
X_q = letters("X_q", n, q, "a right inverse of them")
K_R = letters("K_R", s, q, "says which combinations of them the rows of `R` are")
J = letters("J", n, s, "a left inverse of the whole table")
P = letters("P", n, n, "the rows `C_i A^k` that are kept, sorted by output")
E_h = letters("E_h", v_h, n, "picks the blocks before block `i`, if there are any")
E_i = letters("E_i", p_i, n, "picks block `i`")
E_to = letters("E_to", v_i, n, "picks the blocks up to block `i`")
e_v = letters("e_v", 1, n, "picks the first entry of block `i`")
E_0 = letters("E_0", n - m, n, "picks the entries that are not the last of a block")
E_n = letters("E_n", n - m, n, "picks the entry after each of these")
E_p = letters("E_p", m, n, "picks the last entry of each block")
A_p = letters("A_p", m, s, "says which combinations of the table the next rows are")
K_P = letters("K_P", s, n, "says which combinations of `P` the rows of the table are")
phi = letters("phi", m, n, "what the last rows times `A` are of all rows")
alpha = letters("alpha", m, n, "with one output, the coefficients of the polynomial")
Phi = letters("Phi", n, n, "moves the state in the new coordinates")
Z = letters("Z", n, n, "ones above the diagonal, but for the last row of each block")
phi_i = letters("phi_i", 1, n, "row `i` of `phi`")
E_j = letters("E_j", p_j, n, "picks block `j`")
E_o = letters("E_o", n - p_j, n, "picks the other blocks")
phi_ij = letters("phi_ij", 1, p_j, "the entries of `phi_i` in block `j`")
phi_o = letters("phi_o", 1, n - p_j, "its other entries")
P_j = letters("P_j", p_j, n, "block `j` of `P`")
P_o = letters("P_o", n - p_j, n, "its other blocks")
G = letters("G", n, r, "what the input does in the new coordinates")
H = letters("H", m, n, "reads the first entry of each block")
w = letters("w", n, 1, "state in the new coordinates")
w_next = letters("w_next", n, 1, "the same one sample on")
A_l = letters("A_l", n, n, "`A` to the power `l`")
Phi_l = letters("Phi_l", n, n, "`Phi` to the power `l`")
Phi_next = letters("Phi_l_next", n, n, "`Phi` to the power `l + 1`")
p = letters("p", m, 1, "the indices `p_i`, one below the other")
v = letters("v", m, 1, "where the blocks end: `v_i = p_1 + ... + p_i`")
count = letters("k", n, 1, "the numbers from 1 to `n`")
ones = letters("j", m, 1, "a column of ones")

# -- later samples --------------------------------------------------------------------

w_l = letters("w_l", n, 1, "state `l` samples on")
s_l = letters("s_l", n, 1, "what the inputs have added in `l` samples")
s_next = letters("s_l_next", n, 1, "what they have added in `l + 1` samples")
y_l = letters("y_l", m, 1, "measurement `l` samples on")
Gam_l = letters("Gamma_l", n, s, "`Phi^(l-1) G`, ..., `Phi G`, `G` side by side")
Gam_next = letters("Gamma_l_next", n, s + r, "the same one sample on")
u_next = letters("u_next", s + r, 1, "the inputs of the samples, and one more")
e_l = letters("e_l", 1, n, "picks entry `l + 1` of block `i`")
e_ln = letters("e_l_next", 1, n, "picks the entry after it")
f_l = letters("f_l", 1, n - m, "says which row of `E_0` it is")
g_l = letters("g_l", 1, r, "that row of `G`")
K = letters("K", n, n, "the rows `h_i Phi^l` for `l < p_i`")
y_s = letters("y_s", n, 1, "the outputs `i` at `p_i` samples, stacked")
d_s = letters("d_s", n, 1, "what the inputs contribute to them")
y_o = letters("y_o", n - m, 1, "the outputs from the next sample on")
w_o = letters("w_o", n - m, 1, "`w` without the first entries of its blocks")
Delta = letters("Delta", n - m, s, "the blocks of (25) below each other")
u_p = letters("u_p", s, 1, "the inputs of the samples")
Y_b = letters("Y_b", p_i, 1, "output `i` at `p_i` samples")
D_b = letters("D_b", p_i, s, "what the inputs contribute to it")
w_b = letters("w_b", p_i, 1, "block `i` of `w`")
w_v = letters("w_v_i", p_i - 1, 1, "that block without its first entry")
Y_i = letters("Y_i", p_i - 1, 1, "output `i` from the next sample on")
Delta_i = letters("Delta_i", p_i - 1, s, "what the inputs contribute to it")
e_1 = letters("e_1", 1, p_i, "picks the first entry of a block")
E_v = letters("E_v", p_i - 1, p_i, "picks its other entries")
O_s = letters("O_s", s, n, "the rows `C_i A^k` of one sample less")
M_s = letters("M_s", s, n - 1, "says which combinations of kept rows they are")
E_r = letters("E_r", n - 1, n, "picks the rows of `P` but that one")
e_k = letters("e_k", 1, n, "picks the last row of the longest block")
b = letters("b", n, 1, "a state that only that row sees")

# -- the staircase --------------------------------------------------------------------

r_h, r_c, r_n = symbols("r_h r_c r_n", integer=True, positive=True)
Pi = letters("Pi", n, n, "sorts the entries of `w` by level, the highest first")
A_U = letters("A_U", n, n, "`Phi` in these coordinates: a staircase")
C_U = letters("C_U", m, n, "`H` in these coordinates: only the last columns")
T_U = letters("T_U", n - m, n, "what the observer tracks in them: a unit triangle")
S_U = letters("S_U", n, n, "`T_U` above `C_U`")
F = letters("F", n - m, n - m, "moves the observer's state")
F_l = letters("F_l", n - m, n - m, "`F` to the power `l`")
D = letters("D", n - m, m, "what the measurement does to it")
S_i = letters("S_i", p_i, n - m, "picks a row block")
S_h = letters("S_h", r_h, n - m, "picks the row block above it")
T_i = letters("T_i", p_i, n, "that row block of `T_U`")
T_h = letters("T_h", r_h, n, "the row block above it")
D_i = letters("D_i", p_i, m, "that row block of `D`")
A_i = letters("A_i", p_i, r_h, "the stair to the left of the diagonal in these rows")
N_c = letters("N_c", n, r_c, "picks a column block")
N_n = letters("N_n", n, r_n, "picks the column block after it")
N_m = letters("N_m", n, m, "picks the last column block")
K_c = letters("K_c", n, q, "picks the columns up to that block")
A_c = letters("A_c", q, r_c, "the column block of `A_U`, down to the diagonal")
A_m = letters("A_m", n, m, "its last column block")
S_c = letters("S_c", r_n, r_c, "the stair below the diagonal")
J_c = letters("J_c", r_c, r_n, "a left inverse of it")
T_c = letters("T_c", p_i, q, "the entries of the row block up to there")
T_n = letters("T_n", p_i, r_n, "the entries that come next")
T_hc = letters("T_h_c", r_h, r_c, "the row block above, in the column block")
T_hm = letters("T_h_m", r_h, m, "the row block above, in the last column block")
x_i = letters("x_i", 1, n + m - 1, "the entries of one row: of `F`, of `T_U`, of `D`")
M_i = letters("M_i", n + m - 1, n, "the matrix of Van Dooren's (18)")
a_f = letters("a_f", 1, n, "the row of `A_U`")
