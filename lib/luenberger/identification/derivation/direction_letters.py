"""The letters of a plant that moves in one direction, or in two, and of its filter."""

from .letters import *
from .letters import letters as of_the_score

letters = of_the_score.here()
chain, define, moment = letters.chain, letters.define, letters.moment

# -- one row ---------------------------------------------------------------------------

x = letters("x", n, 1, "prediction of the state")
u = letters("u", m, 1, "input")
y = letters("y", p, 1, "measurement")
nu = letters("nu", p, 1, "innovation")
e = letters("e", p, 1, "innovation, weighed by its covariance")
mean = letters("m", n, 1, "mean of the prediction")
mean_next = letters("m_next", n, 1, "the same one step on")
Omega_next = letters("Omega_next", n, n, "the next `Omega`", symmetric=True)
X = letters("X", n, n, "covariance of the prediction", symmetric=True)
X_next = letters("X_next", n, n, "the same one step on", symmetric=True)

# -- what moves ------------------------------------------------------------------------

dA = letters("dA", n, n, "change of `A`")
dB = letters("dB", n, m, "change of `B`")
dC = letters("dC", p, n, "change of `C`")
dE = letters("dE", p, m, "change of `E`")
dQ = letters("dQ", n, n, "change of `Q`", symmetric=True)
dR = letters("dR", p, p, "change of `R`", symmetric=True)
dS = letters("dS", n, p, "change of `S`")
dG = letters("dG", n, p, "change of the gain")
dM = letters("dM", p, p, "change of `M`", symmetric=True)
dOmega = letters("dOmega", n, n, "change of `Omega`", symmetric=True)
dOmega_next = letters("dOmega_next", n, n, "change of the next one", symmetric=True)
dx = letters("dx", n, 1, "change of the prediction")
dx_next = letters("dx_next", n, 1, "change of the next prediction")
dnu = letters("dnu", p, 1, "change of the innovation")
dm = letters("dm", n, 1, "mean of `dx`")
dm_next = letters("dm_next", n, 1, "the same one step on")
dn = letters("dn", p, 1, "mean of `dnu`")
H = letters("H", n, n, "what a prediction adds to the change of the next one")
b = letters("b", n, m, "what the input adds to it")
D = letters("D", n, n, "what a row adds to the change of `Omega`", symmetric=True)
T = letters("T", n, p, "change of the gain, times `M`")
U = letters("U", p, n, "what the change of the gain meets")

# -- of one direction, and of another --------------------------------------------------

dx_i = letters("dx_i", n, 1, "change of the prediction in direction `i`")
dx_j = letters("dx_j", n, 1, "the same in direction `j`")
dnu_i = letters("dnu_i", p, 1, "change of the innovation in direction `i`")
dnu_j = letters("dnu_j", p, 1, "the same in direction `j`")
dn_i = letters("dn_i", p, 1, "mean of `dnu_i`")
dn_j = letters("dn_j", p, 1, "mean of `dnu_j`")
ddnu = letters("d2nu", p, 1, "change of `dnu_i` in direction `j`")
dM_i = letters("dM_i", p, p, "change of `M` in direction `i`", symmetric=True)
dM_j = letters("dM_j", p, p, "the same in direction `j`", symmetric=True)
ddM = letters("d2M", p, p, "change of `dM_i` in direction `j`", symmetric=True)
dC_i = letters("dC_i", p, n, "change of `C` in direction `i`")
dC_j = letters("dC_j", p, n, "the same in direction `j`")
dG_i = letters("dG_i", n, p, "change of the gain in direction `i`")
dG_j = letters("dG_j", n, p, "the same in direction `j`")
H_i = letters("H_i", n, n, "`H` of direction `i`")
H_j = letters("H_j", n, n, "`H` of direction `j`")
T_i = letters("T_i", n, p, "`T` of direction `i`")
T_j = letters("T_j", n, p, "`T` of direction `j`")
X_i = letters("X_i", n, n, "covariance of `dx_i` and the prediction")
X_j = letters("X_j", n, n, "covariance of `dx_j` and the prediction")
X_i_next = letters("X_i_next", n, n, "`X_i` one step on")
D_ij = letters("D_ij", n, n, "covariance of `dx_i` and `dx_j`")
D_ij_next = letters("D_ij_next", n, n, "the same one step on")
N_ij = letters("N_ij", p, p, "covariance of `dnu_i` and `dnu_j`")
V_ij = letters("V_ij", p, p, "what a row shows that no earlier one passed on")
Y_ij = letters("Y_ij", n, n, "what a row adds to the next `D_ij`")
I_M = letters("I_M", p, p, "its trace is the information in `M`")
I_w = letters("I_w", n, n, "its trace is the information in the gain, of later rows")
I_v = letters("I_v", p, p, "its trace is the information of a row in what moves")
I_x = letters("I_x", n, n, "its trace is that of later rows in what moves")
I_n = letters("I_n", p, p, "its trace is the information in the means")
