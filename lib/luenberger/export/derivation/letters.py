"""The letters of an observer on a device: what is exact, what is computed, sizes."""

from sympy import symbols

from ...symbolic import Notation

r, k, q = symbols("r k q", integer=True, positive=True)
letters = Notation()
chain, define = letters.chain, letters.define

# -- the observer ----------------------------------------------------------------------

F = letters("F", r, r, "moves the observer")
B = letters("B", r, k, "what inputs and measurements do to it, `[G, D]`")
P = letters("P", q, r, "what the estimate takes from the observer")
V = letters("V", q, k, "what it takes from inputs and measurements, `[W, V]`")
z = letters("z", r, 1, "state of the observer")
z_next = letters("z_next", r, 1, "the same one step on")
s = letters("s", k, 1, "inputs and measurements, one below the other")
w_hat = letters("w_hat", q, 1, "estimate")

# -- what a device makes of it ---------------------------------------------------------

F_f = letters("F_f", r, r, "`F` in the numbers of the device")
B_f = letters("B_f", r, k, "`B` in them")
P_f = letters("P_f", q, r, "`P` in them")
V_f = letters("V_f", q, k, "`V` in them")
z_f = letters("z_f", r, 1, "state that the device computes")
z_f_next = letters("z_f_next", r, 1, "the same one step on")
s_f = letters("s_f", k, 1, "`s` in the numbers of the device")
w_f = letters("w_f", q, 1, "estimate that the device computes")
l_z = letters("l_z", r, 1, "rounding of the sums of a state")
l_w = letters("l_w", q, 1, "rounding of the sums of an estimate")
dF = letters("dF", r, r, "`F_f` less `F`")
dB = letters("dB", r, k, "`B_f` less `B`")
dP = letters("dP", q, r, "`P_f` less `P`")
dV = letters("dV", q, k, "`V_f` less `V`")
ds = letters("ds", k, 1, "`s_f` less `s`")
e = letters("e", r, 1, "error of the computed state")
e_next = letters("e_next", r, 1, "the same one step on")
e_w = letters("e_w", q, 1, "error of the computed estimate")
d = letters("d", r, 1, "what one step adds to the error of the state")
d_w = letters("d_w", q, 1, "what one step adds to that of the estimate")

# -- sizes -----------------------------------------------------------------------------

F_p = letters("F_p", r, r, "entries of `F` that are positive")
F_m = letters("F_m", r, r, "those that are negative, without their sign")
F_s = letters("F_s", r, r, "sizes of the entries of `F`")
z_p = letters("z_p", r, 1, "entries of `z` that are positive")
z_m = letters("z_m", r, 1, "those that are negative, without their sign")
z_s = letters("z_s", r, 1, "sizes of the entries of `z`")
B_s = letters("B_s", r, k, "sizes of `B`")
V_s = letters("V_s", q, k, "sizes of `V`")
dF_s = letters("dF_s", r, r, "sizes of `dF`")
dB_s = letters("dB_s", r, k, "sizes of `dB`")
dP_s = letters("dP_s", q, r, "sizes of `dP`")
dV_s = letters("dV_s", q, k, "sizes of `dV`")
ds_s = letters("ds_s", k, 1, "sizes of `ds`, at most")
F_fs = letters("F_fs", r, r, "sizes of `F_f`")
B_fs = letters("B_fs", r, k, "sizes of `B_f`")
P_fs = letters("P_fs", q, r, "sizes of `P_f`")
V_fs = letters("V_fs", q, k, "sizes of `V_f`")
s_fs = letters("s_fs", k, 1, "sizes of `s_f`, at most")
z_fs = letters("z_fs", r, 1, "sizes of `z_f`, at most")
e_s = letters("e_s", r, 1, "sizes of `e`, at most")
reach = letters("Z", r, 1, "sizes of `z`, at most")
l_zs = letters("l_zs", r, 1, "sizes of `l_z`, at most")
l_ws = letters("l_ws", q, 1, "sizes of `l_w`, at most")
d_s = letters("d_s", r, 1, "sizes of `d`, at most")
d_ws = letters("d_ws", q, 1, "sizes of `d_w`, at most")
gamma_z = letters("gamma_z", r, r, "part of a sum that its roundings are, diagonal")
gamma_w = letters("gamma_w", q, q, "the same of estimates, diagonal")
eta_z = letters("eta_z", r, 1, "rounding of a state whatever its size")
eta_w = letters("eta_w", q, 1, "rounding of an estimate whatever its size")
M_z = letters("M_z", r, r, "what a state adds to the error of the next")
M_s = letters("M_s", r, k, "what inputs and measurements add to it")
N_z = letters("N_z", q, r, "what a state adds to the error of the estimate")
N_s = letters("N_s", q, k, "what inputs and measurements add to it")
c = letters("c", r, 1, "what a step adds where there is no error yet")
c_w = letters("c_w", q, 1, "the same of the estimate")

# -- sums of powers --------------------------------------------------------------------

F_less = letters("F_less", r, r, "a power of `F`")
F_more = letters("F_more", r, r, "the next one")
C = letters("C", r, r, "a power of `F` as it was computed")
C_next = letters("C_next", r, r, "the next one as it was computed")
R_C = letters("R_C", r, r, "rounding in `C_next`")
S = letters("S", r, r, "sum of the sizes of all powers of `F`, at most")
S_P = letters("S_P", q, r, "sum of the sizes of `P` times these, at most")
T = letters("T", r, r, "a matrix without a negative entry")
a = letters("a", r, 1, "a bound up to one instant")
a_next = letters("a_next", r, 1, "the same up to the next")
b = letters("b", r, 1, "what is there without the bound before")
x = letters("x", r, 1, "a bound that was tried")
g = letters("g", r, 1, "what it has to spare")
h = letters("h", r, 1, "what `a_next` has to spare")
a_0 = letters("a_0", r, 1, "what the first error becomes, at most")
a_0w = letters("a_0w", q, 1, "what it does to an estimate, at most")
a_e = letters("a_e", r, 1, "bound of `e_s` from the one before")
a_w = letters("a_w", q, 1, "sizes of `e_w`, at most")

# -- numbers ---------------------------------------------------------------------------

u = letters.scalar("u", "rounding of one operation, of its result", positive=True)
j = letters.scalar("j", "how many roundings there were", positive=True)
gamma_j = letters.scalar("gamma_j", "how far `j` roundings move a term", positive=True)
gamma_more = letters.scalar("gamma_more", "the same of one more", positive=True)
