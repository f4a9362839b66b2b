"""The letters of Moore (1973), each with its size and what it stands for.

    letter of the paper   F  g  h'  k'  A  b  d  l'  T'  p
    letter here           A  B  C   k   F  D  G  P   T   r

A plus below is the next instant, or the derivative in continuous time.
"""

from sympy import symbols

from matrixproof import Identity as Identity
from matrixproof import Notation
from matrixproof import ZeroMatrix as ZeroMatrix

SOURCE = "Moore (1973)"

n, p, m, r, o = symbols("n p m r o", integer=True, nonnegative=True)
letters = Notation()
chain, let, steady, suppose = (
    letters.chain,
    letters.let,
    letters.steady,
    letters.suppose,
)

# -- the plant and the observer -------------------------------------------------------

A = letters("A", n, n, "moves the state")
B = letters("B", n, m, "what the input does to the state")
C = letters("C", p, n, "what is measured")
E = letters("E", p, m, "what the input does to the measurement; zero in the paper")
k = letters("k", 1, n, "the functional: `k x` is wanted; in a factor, its first row")
F = letters("F", r, r, "moves the observer's state")
G = letters("G", r, m, "what the input does to it")
D = letters("D", r, p, "what the measurement does to it")
P = letters("P", 1, r, "reads the estimate off it")
T = letters("T", r, n, "what the observer's state tracks")
x = letters("x", n, 1, "state")
x_next = letters("x_next", n, 1, "state one step on, or its derivative")
u = letters("u", m, 1, "input")
y = letters("y", p, 1, "measurement")
z = letters("z", r, 1, "state of the observer")
z_next = letters("z_next", r, 1, "the same one step on, or its derivative")
w = letters("w", 1, 1, "estimate of `k x`")
eps = letters("varepsilon", r, 1, "error of the observer's state")
eps_next = letters("varepsilon_next", r, 1, "error one step on, or its derivative")
J = letters("J", r, m, "what the input does to the error")
Delta = letters("Delta", r, n, "difference of two `T`")
A_j = letters("A_j", n, n, "`A` to the power `j`")
F_j = letters("F_j", r, r, "`F` to the power `j`")
P_0 = letters("P_0", 1, r, "a row with `P_0 T = k`")
M = letters("M", r, r, "`T T'`, which has an inverse", symmetric=True)

# -- companion form, row by row -------------------------------------------------------

N = letters("N", r, r, "moves the rows of a matrix up by one; the last becomes zero")
L = letters("L", r, r, "coefficients, each in the column of its factor's first row")
e_i = letters("e_i", 1, r, "picks row `i`")
e_next = letters("e_next", 1, r, "picks row `i + 1`; zero behind the last row")
e_f = letters("e_f", 1, r, "picks the first row of the factor")
t = letters("t", 1, n, "row `i` of `T`")
h_f = letters("h_f", 1, n, "`h` at the first row of the factor")
s_f = letters("s_f", 1, n, "`s` at the first row of the factor")
t_next = letters("t_next", 1, n, "row `i + 1` of `T`")
b = letters("b", 1, 1, "coefficient of the polynomial beside row `i`")
d = letters("d", 1, p, "row `i` of `D`")
h = letters("h", 1, n, "`k` times the polynomial down to row `i`, at `A`")
h_next = letters("h_next", 1, n, "the same down to row `i + 1`")
s = letters("s", 1, n, "combination of the rows of `C`, `C A`, ...")
s_next = letters("s_next", 1, n, "the same down to row `i + 1`")
O = letters("O", o, n, "the rows of `C`, `C A`, ..., one below the other")  # noqa: E741
d_all = letters("d_all", 1, o, "the rows of `D` side by side")
X = letters("X", n, 1, "a state that these rows do not see")
Q = letters("Q", r, r, "change of coordinates to companion form")
q = letters("q", 1, r, "row `i` of it: `P` times the polynomial so far, at `F`")
q_next = letters("q_next", 1, r, "row `i + 1` of it; `P beta(F)` behind the last")

# -- one output: the functional as a sequence -----------------------------------------

c = letters("c", 1, n, "the last row of the identity")
alpha = letters("alpha", n, 1, "coefficients of the plant's polynomial, from `alpha_0`")
Z = letters("Z", n, n, "moves entries down by one, and columns to the left")
D_1 = letters("D_1", r, 1, "`D` for one output")
f = letters("f", r, 1, "`F^n t_1`, which would be the next column of `T`")
f_r = letters("f_r", r, 1, "`F^r t_1`, the column behind `T_1`")
i_1 = letters("i_1", n - r, 1, "picks the first row of `S`")
c_r = letters("c_r", 1, r, "the last row of the identity of the observer's order")
Z_r = letters("Z_r", r, r, "moves entries down by one")
F_c = letters("F_c", r, r, "`F` in companion form")
N_b = letters("N_b", n - r, n - r, "what `S_2` has beside the ones of its diagonal")
X_j = letters("X_j", n - r, n - r, "the first `j` terms of the inverse of `S_2`")
X_jn = letters("X_j_next", n - r, n - r, "one term more")
W_j = letters("W_j", n - r, n - r, "`-N_b` to the power `j`")
W_jn = letters("W_j_next", n - r, n - r, "`-N_b` to the power `j + 1`")
S = letters("S", n - r, n, "rows `beta_0`, ..., `beta_r`, each one place further on")
s_i = letters("s_i", n, 1, "row `i` of `S`, as a column")
s_in = letters("s_i_next", n, 1, "row `i + 1` of `S`, as a column")
S_1 = letters("S_1", n - r, r, "the first columns of `S`")
S_2 = letters("S_2", n - r, n - r, "the other columns of `S`")
T_1 = letters("T_1", r, r, "the first columns of `T`, a controllability matrix")
T_2 = letters("T_2", r, n - r, "the other columns of `T`")
k_1 = letters("k_1", 1, r, "the first entries of `k`")
k_2 = letters("k_2", 1, n - r, "the other entries of `k`")
g_i = letters("g_i", n, 1, "`A^i g`; `C` does not see it for `i < n - 1`")
g_in = letters("g_i_next", n, 1, "`A^(i+1) g`")
g_n = letters("g_n", n, 1, "`A^n g`")
c_1 = letters("c_1", 1, n, "the row of `C`, for one output, in any coordinates")
A_o = letters("A_o", n, n, "`A` in observable companion form")
K = letters("K", n, n, "the columns `g`, `A g`, ..., `A^(n-1) g`")
s_T = letters("s_tau", n, 1, "row `i` of `S` in another unit of time, as a column")
s_Tn = letters("s_tau_next", n, 1, "row `i + 1` of it, as a column")
k_T = letters("kappa_tau", n, 1, "the sequence in another unit of time")
tau = letters.scalar("tau", "the unit of time", positive=True)
lam = letters.scalar("lambda", "a power of `1/tau`", positive=True)
kappa = letters("kappa", n, 1, "the sequence `k A^i g`")
Lam = letters("Lambda", n, n, "the powers 0, 1, ... of `1/tau`, on the diagonal", True)
ones = letters("j", 1, n - r, "ones")
last = letters("l", n - r, 1, "the last column of the identity")
beta = letters("beta", 1, r, "coefficients of the observer's polynomial")
