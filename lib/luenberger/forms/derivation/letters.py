"""The letters of an observer in two systems of coordinates."""

from sympy import symbols

from matrixproof import Identity, Notation

n, r, m, p, q, s = symbols("n r m p q s", integer=True, positive=True)
letters = Notation()
chain, derive, let, steady, suppose = (
    letters.chain,
    letters.derive,
    letters.let,
    letters.steady,
    letters.suppose,
)
I = Identity(r)

# -- the plant and its observer --------------------------------------------------------

A = letters("A", n, n, "moves the state of the plant")
B = letters("B", n, m, "what the known input does to it")
C = letters("C", p, n, "what is measured")
E = letters("E", p, m, "what the known input does to the measurement")
L = letters("L", q, n, "what is estimated")
F = letters("F", r, r, "moves the observer")
G = letters("G", r, m, "what the known input does to the observer")
D = letters("D", r, p, "what the measurement does to the observer")
P = letters("P", q, r, "what the estimate takes from the observer")
V = letters("V", q, p, "what the estimate takes from the measurement")
W = letters("W", q, m, "what the estimate takes from the known input")
T = letters("T", r, n, "what the observer follows")
z = letters("z", r, 1, "state of the observer")
z_next = letters("z_next", r, 1, "the same one step on, or its rate")
u = letters("u", m, 1, "known input")
y = letters("y", p, 1, "measurement")
w_hat = letters("w_hat", q, 1, "estimate")

# -- other coordinates -----------------------------------------------------------------

S = letters("S", r, r, "changes the coordinates")
U = letters("U", r, r, "changes them back")
F_S = letters("F_S", r, r, "`F` in the new coordinates")
G_S = letters("G_S", r, m, "`G` in the new coordinates")
D_S = letters("D_S", r, p, "`D` in the new coordinates")
P_S = letters("P_S", q, r, "`P` in the new coordinates")
T_S = letters("T_S", r, n, "`T` in the new coordinates")
z_S = letters("z_S", r, 1, "state of the observer in the new coordinates")

# -- combinations of what is estimated -------------------------------------------------

H = letters("H", s, q, "which combinations of the estimates, a row for each")
w_H = letters("w_H", s, 1, "estimate of the combinations")
L_H = letters("L_H", s, n, "what is estimated of the state")
P_H = letters("P_H", s, r, "what the combinations take from the observer")
V_H = letters("V_H", s, p, "what they take from the measurement")
W_H = letters("W_H", s, m, "what they take from the known input")

# -- Gramians --------------------------------------------------------------------------

N = letters("N", r, m + p, "the inputs of the observer, `[G, D]`")
N_S = letters("N_S", r, m + p, "`N` in the new coordinates")
X = letters("X", r, r, "what the inputs reach, a Gramian", symmetric=True)
Y = letters("Y", r, r, "what the estimate shows, a Gramian", symmetric=True)
X_S = letters("X_S", r, r, "`X` in the new coordinates", symmetric=True)
Y_S = letters("Y_S", r, r, "`Y` in the new coordinates", symmetric=True)
R = letters("R", r, r, "a root of `X`")
M = letters("M", r, r, "a root of `Y`")
Q_1 = letters("Q_1", r, r, "left singular vectors of `M R`")
Q_2 = letters("Q_2", r, r, "right singular vectors of `M R`")
h = letters("h", r, r, "roots of its singular values, diagonal", symmetric=True)
k = letters("k", r, r, "the inverse of `h`, diagonal", symmetric=True)
Sigma = letters("Sigma", r, r, "its singular values, diagonal", symmetric=True)
