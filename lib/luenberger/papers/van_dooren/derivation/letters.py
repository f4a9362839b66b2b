"""The letters of Van Dooren (1984), each with its size and what it stands for.

The paper's P, G, H are G, P, V here.  A star is the conjugate transpose; only that
U U* = U* U = I is used of it, so the plant may be complex.
"""

from sympy import symbols

from matrixproof import Identity as Identity
from matrixproof import Notation
from matrixproof import ZeroMatrix as ZeroMatrix

SOURCE = "Van Dooren (1984)"

n, m, r, i, s, q = symbols("n m r i s q", integer=True, nonnegative=True)
letters = Notation()
chain, let, steady, suppose = (
    letters.chain,
    letters.let,
    letters.steady,
    letters.suppose,
)
I = Identity(n)  # noqa: E741

# -- the plant and the observer -------------------------------------------------------

A = letters("A", n, n, "moves the state")
B = letters("B", n, m, "what the input does to the state")
C = letters("C", r, n, "what is measured; its rows are independent")
F = letters("F", n - r, n - r, "moves the observer's state; its spectrum is chosen")
D = letters("D", n - r, r, "what the measurement does to it")
G = letters("G", n - r, m, "what the input does to it")
P = letters("P", n, n - r, "what the estimate takes of the observer's state")
V = letters("V", n, r, "what the estimate takes of the measurement")
T = letters("T", n - r, n, "what the observer's state tracks")
x = letters("x", n, 1, "state")
x_next = letters("x_next", n, 1, "state one step on, or its derivative")
x_hat = letters("x_hat", n, 1, "estimate of the state")
u = letters("u", m, 1, "input")
y = letters("y", r, 1, "measurement")
z = letters("z", n - r, 1, "state of the observer")
z_next = letters("z_next", n - r, 1, "the same one step on, or its derivative")
eps = letters("varepsilon", n - r, 1, "error of the observer's state")
eps_0 = letters("varepsilon_0", n - r, 1, "the error at the start")
eps_next = letters("varepsilon_next", n - r, 1, "error one step on, or its derivative")
Phi = letters("Phi", n - r, n - r, "`F^t`; in continuous time `e^(F t)`")
Phi_next = letters("Phi_next", n - r, n - r, "the same one step on, or its derivative")

# -- unitary coordinates --------------------------------------------------------------

U = letters("U", n, n, "unitary: the coordinates of the staircase")
Us = letters("U^*", n, n, "its conjugate transpose")
A_U = letters("A_U", n, n, "`A` in these coordinates: a staircase")
C_U = letters("C_U", r, n, "`C` in these coordinates: only the last columns")
T_U = letters("T_U", n - r, n, "`T` in these coordinates: a unit triangle")
W = letters("W", n - r, n - r, "unitary: coordinates of the observer's state")
Ws = letters("W^*", n - r, n - r, "its conjugate transpose")
X_1 = letters("X_1", n, n - r, "the first columns of the inverse of `T_U` over `C_U`")
X_2 = letters("X_2", n, r, "its other columns")
a_s = letters("a_s", n, 1, "a column")
b_s = letters("b_s", n, 1, "a column of the same length with one entry")
as_s = letters("a_s^*", 1, n, "the conjugate transpose of `a_s`")
bs_s = letters("b_s^*", 1, n, "the conjugate transpose of `b_s`")
v = letters("v", n, 1, "their difference")
vs = letters("v^*", 1, n, "its conjugate transpose")
beta = letters("beta", 1, 1, "two over `v^* v`")
rho_s = letters("rho_s", 1, 1, "that entry")
h_s = letters("h_s", 1, s - 1, "the rest of its row")
A_r = letters("A_r", r - 1, s - 1, "what is left of a stair behind its first column")
Qs_r = letters("Q_r^*", r - 1, r - 1, "unitary: makes a triangle of what is left")
R_r = letters("R_r", r - 1, s - 1, "that triangle, above zeros")
A_s = letters("A_s", r, s, "a stair; its columns are independent")
W_s = letters("W_s", s, s, "unitary: turns the states of the stair before")
Q_s = letters("Q_s", r, r, "unitary: a product of reflectors")
Qs_s = letters("Q_s^*", r, r, "its conjugate transpose")
R_s = letters("R_s", s, s, "an upper triangle with an inverse")
J_s = letters("J_s", r, s, "the identity above zeros")

# -- that the staircase exists --------------------------------------------------------

v_0 = letters("v_0", n, 1, "a column of length one that `C` does not see")
Q_0 = letters("Q_0", n, n, "unitary, with that column first")
Q_1 = letters("Q_1", n, n - 1, "its other columns")
W_a = letters("W_a", n - 1, n - q - 1, "of a unitary matrix, columns that are not seen")
W_b = letters("W_b", n - 1, q, "its last columns, which are seen")
U_0 = letters("U_0", n, n, "both unitary matrices, one after the other")
C_1 = letters("C_1", r, q, "what `C` becomes; its columns are independent")
U_C = letters("U_C", n, n, "unitary: the coordinates in which `C` has become that")
Us_C = letters("U_C^*", n, n, "its conjugate transpose")
A_b = letters("A_b", n, n, "`A` in these coordinates")
C_b = letters("C_b", r, n, "`C` in these coordinates")
U_a = letters("U_a", n, n - q, "its columns that `C` does not see")
U_as = letters("U_a^*", n - q, n, "their conjugate transpose")
U_b = letters("U_b", n, q, "its other columns")
U_bs = letters("U_b^*", q, n, "their conjugate transpose")
A_1 = letters("A_1", n - q, n - q, "moves the states that `C` does not see")
A_2 = letters("A_2", n - q, q, "what the other states do to them")
A_3 = letters("A_3", q, n - q, "what they do to the other states")
A_4 = letters("A_4", q, q, "moves the other states")
V_0 = letters("V_0", n - q, s, "columns that the smaller pair hides")
M_0 = letters("M_0", s, s, "which combinations of themselves they are taken to")
U_2 = letters("U_2", n - q, n - q, "unitary: the staircase of the smaller pair")
Us_2 = letters("U_2^*", n - q, n - q, "its conjugate transpose")
D_2 = letters("D_2", n, n, "`U_2` beside the identity")
Ds_2 = letters("D_2^*", n, n, "its conjugate transpose")
A_t = letters("A_t", n - q, n - q, "the staircase of the smaller pair")
A_l = letters("A_l", q, n - q, "its outputs: zero but for the last columns")

# -- one row at a time ----------------------------------------------------------------

t = letters("t", 1, n, "row of `T_U`: zeros, a one, and what is unknown")
t_i = letters("t_i", 1, n - i - 1, "the unknown entries of that row")
f = letters("f", 1, n - r, "row of `F`: what is unknown, a pole, and zeros")
f_i = letters("f_i", 1, i, "the unknown entries of that row")
d = letters("d", 1, r, "row of `D`")
e = letters("e", 1, n, "picks the row")
E = letters("E", n - i - 1, n, "picks the rows below it")
L_f = letters("L_f", n, n, "the identity times the pole `f_ii`")
T_i = letters("T_i", i, n, "the rows of `T_U` above it, which are known")
A_f = letters("A_f", n - i - 1, n, "the rows of `A_U - f_ii I` below it")
a_f = letters("a_f", 1, n, "that row of `A_U - f_ii I`")
x_i = letters("x_i", 1, n + r - 1, "the unknowns: `f_i`, `t_i` and `d`")
M = letters("M", n + r - 1, n, "the rows `-T_i`, `A_f` and `-C_U`")
S = letters("S", n, n + r - 1, "picks the rows of `M` that lead its columns")
X = letters("X", n, n, "their triangle, the entries of the stairs on its diagonal")
R = letters("R", n, n, "the triangle of the factorisation, which has an inverse")
L = letters("L", n, n + r - 1, "a left inverse of `M`")
Q = letters("Q", n + r - 1, n, "orthonormal columns, which span those of `M`")
Qs = letters("Q^*", n, n + r - 1, "its conjugate transpose")
Rs = letters("R^*", n, n, "the conjugate transpose of `R`")
a_star = letters("a_f^*", n, 1, "the conjugate transpose of `a_f`")
h = letters("h", 1, n + r - 1, "what can be added to a solution")
h_star = letters("h^*", n + r - 1, 1, "its conjugate transpose")
C_k = letters("C_k", r, r, "the columns of `C_U` that are not zero")
both = letters("Theta", n, n, "`T_U` above `C_U`")

# -- what is free in a row ------------------------------------------------------------

y_i = letters("y_i", 1, n + r - 1, "any row of the same length")
S_t = letters("S^T", n + r - 1, n, "puts the leading entries in their places")
E_r = letters("E_r", r - 1, n + r - 1, "picks the rows of `M` that lead no column")
E_rt = letters("E_r^T", n + r - 1, r - 1, "puts the free entries in their places")
x_l = letters("x_l", 1, n, "the entries of `x_i` that meet the leading rows")
x_r = letters("x_r", 1, r - 1, "the other entries of `x_i`, which are free")
M_r = letters("M_r", r - 1, n, "the rows of `M` that lead no column")
dM = letters("dM", n + r - 1, n, "how `M` moves when the rows above do")
dT_i = letters("dT_i", i, n, "how the rows above move")
dx_i = letters("dx_i", 1, n + r - 1, "how the solution moves")
dx_l = letters("dx_l", 1, n, "its entries that meet the leading rows")
dx_r = letters("dx_r", 1, r - 1, "its free entries")
dJ = letters("dJ", 1, 1, "how a function of the rows moves")
g_l = letters("g_l", n, 1, "its gradient in the leading entries")
g_r = letters("g_r", r - 1, 1, "its gradient in the free entries, the others held")
z_l = letters("z_l", n, 1, "what `X` turns into `g_l`")
W_1 = letters("W_1", s, s, "the first columns of any solution `T U`")
N_1 = letters("N_1", s, s, "a lower triangle that eliminates")
U_1 = letters("U_1", s, s, "a unit upper triangle")
N_T = letters("N_T", n - r, n - r, "a lower triangle with an inverse")
F_N = letters("F_N", n - r, n - r, "`F` in the coordinates that it makes")
F_1 = letters("F_1", s, s, "a lower triangle with poles on its diagonal")
F_2 = letters("F_2", s, s, "the same in other coordinates")
back = letters("Psi", n, n, "the inverse of `Theta`")
dTheta = letters("dTheta", n, n, "how `Theta` moves")
dback = letters("dPsi", n, n, "how its inverse moves")

# -- a pair a +- jb -------------------------------------------------------------------

Lam = letters("Lambda", 2, 2, "the block of the pair")
Y = letters("Y", 2, 2, "its eigenvectors")
Delta = letters("Delta", 2, 2, "its eigenvalues on the diagonal")
T_p = letters("T_p", 2, n, "the two rows of `T_U`")
F_p = letters("F_p", 2, n - r, "the two rows of `F`")
f_p = letters("f_p", 2, i, "the unknown entries of these rows before the block")
d_p = letters("d_p", 2, r, "the two rows of `D`")
w = letters("w", 1, 2, "the row `1`, `j`")
N = letters("N", 1, 1, "the pole `a + j b`")
t_b = letters("t_b", 1, 2 * n, "the two rows of `T_U` in the order of (31)")
K_b = letters("K_b", 2 * n, 2 * n, "the Kronecker products of (33)")
rho = letters("rho", 1, 2 * n, "the two rows of the equation in the order of (31)")
x_b = letters("x_b", 1, 2 * (n + r - 1), "the unknowns, `tau` among them")
M_b = letters("M_b", 2 * (n + r - 1), 2 * n, "the system for the pair, `tau` unknown")
a_b = letters("a_b", 1, 2 * n, "what is known of it")
S_b = letters("S_b", 2 * n, 2 * (n + r - 1), "picks rows that lead columns of `M_b`")
X_b = letters("X_b", 2 * n, 2 * n, "their triangle, each stair entry twice on it")
M_c = letters("M_c", 2 * (n + r) - 3, 2 * n, "the printed system, `tau` put in as one")
S_c = letters("S_c", 2 * n, 2 * (n + r) - 3, "picks rows that lead its columns")
v_i = letters("v_i", n, 1, "a column that `M` sends to one entry")
v_b = letters("v_b", 2 * n, 1, "the same column with zeros in between")
e_i = letters("e_i", n + r - 1, 1, "that entry: the place of `t_(i,i+1)`")
tau = letters("tau", 1, 1, "the entry `t_(i+1,i+1)`, which the paper takes for one")
a_0 = letters("a_0", 1, n, "the row `a_f` for `b = 0`")

# -- what it costs --------------------------------------------------------------------

c_M = letters("c_M", 1, 1, "what (21) allows for one matrix, and one more")
k_M = letters("k_M", 1, n, "entries of each column of `M` on the diagonal and below")
d_M = letters("d_M", n, 1, "columns from each on: `n`, ..., `1`")

# -- fewer independent outputs --------------------------------------------------------

C_all = letters("C_a", s, n, "all outputs, dependent or not")
Y_1 = letters("Y_1", s, r, "orthonormal columns, which span those of `C_a`")
Y_1s = letters("Y_1^*", r, s, "its conjugate transpose")
D_all = letters("D_a", n - r, s, "what all outputs do to the observer's state")
