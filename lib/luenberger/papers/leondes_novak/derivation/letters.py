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
chain, derive, let, moment, steady, suppose = (
    letters.chain,
    letters.derive,
    letters.let,
    letters.moment,
    letters.steady,
    letters.suppose,
)
I = Identity(n)


# -- the plant -------------------------------------------------------------------------

A = letters("A", n, n, "moves the state")
B = letters("B", n, m, "what the input does to the state")
C = letters("C", p, n, "what is measured")
E = letters("E", p, m, "what the input does to the measurement; zero in the paper")
Q = letters("Q", n, n, "covariance of the process noise", symmetric=True)
R = letters("R", p, p, "covariance of the measurement noise", symmetric=True)
S = letters("S", n, p, "covariance of the two noises, `E[w v']`; zero in the paper")
J = letters("J", n, p, "what the measurement noise tells of the process noise")
As = letters("As", n, n, "moves the state once that is told")
Qs = letters("Qs", n, n, "covariance of the process noise that is left", symmetric=True)
x = letters("x", n, 1, "state")
x_next = letters("x_next", n, 1, "state one step on")
x_bar = letters("x_bar", n, 1, "mean of the state")
u = letters("u", m, 1, "input")
u_next = letters("u_next", m, 1, "input one step on")
y = letters("y", p, 1, "measurement")
y_next = letters("y_next", p, 1, "measurement one step on")
w = letters("w", n, 1, "process noise")
v = letters("v", p, 1, "measurement noise")
v_next = letters("v_next", p, 1, "measurement noise one step on")
a = letters("a", p, 1, "a combination of outputs")
b = letters("b", n, 1, "a combination of states")
d = letters("d", n, 1, "deviation of the state from its mean")

# -- the observer ----------------------------------------------------------------------

F = letters("F", r, r, "moves the observer")
G = letters("G", r, m, "what the input does to the observer")
D = letters("D", r, p, "what the measurement does to the observer")
T = letters("T", r, n, "what the observer follows")
T_next = letters("T_next", r, n, "what the observer follows one step on")
P = letters("P", n, r, "weight of the observer in the estimate")
V = letters("V", n, p, "weight of the measurement in the estimate")
W = letters("W", n, m, "weight of the input in the estimate; zero in the paper")
z = letters("z", r, 1, "observer")
z_next = letters("z_next", r, 1, "observer one step on")
eps = letters("varepsilon", r, 1, "error of the observer")
eps_next = letters("varepsilon_next", r, 1, "error of the observer one step on")
x_hat = letters("x_hat", n, 1, "estimate")
x_hat_next = letters("x_hat_next", n, 1, "estimate one step on")
X = letters("X", r, r, "covariance of the observer's error", symmetric=True)
X_next = letters("X_next", r, r, "the same one step on", symmetric=True)

# -- the step from one instant to the next ---------------------------------------------

e = letters("e", n, 1, "error of the estimate")
e_minus = letters("e_minus", n, 1, "error of the prediction")
e_next = letters("e_next", n, 1, "error of the estimate one step on")
Sigma = letters("Sigma", n, n, "covariance of the error", symmetric=True)
Sigma_next = letters("Sigma_next", n, n, "the same one step on", symmetric=True)
Omega = letters("Omega", n, n, "covariance of the predicted error", symmetric=True)
M = letters("M", p, p, "covariance of the innovation", symmetric=True)
N = letters("N", n, p, "covariance of the predicted error and the innovation")
K = letters("K", n, p, "any gain")
Kmv = letters("Kmv", n, p, "gain of minimum variance: the Kalman filter's")
Y = letters("Y", n, n, "what the gain leaves of a predicted error")

# -- accurate outputs ------------------------------------------------------------------

S1 = letters("S_1", m1, p, "rows of the identity that pick the accurate outputs")
Gamma_1 = letters("Gamma_1", n, m1, "the direction in which accurate outputs push")
Gamma_0 = letters("Gamma_0", n, m1, "any direction in which they could push")
X_0 = letters("X_0", r, n, "a pseudoinverse of `L_W' Phat`")
Gamma = letters("Gamma", n, p, "the same beside zeros for the other outputs")
Phat = letters("Phat", n, r, "basis of what the accurate outputs do not show")
That = letters("That", r, n, "reads the coordinates in that basis")
Z = letters("Z", r, p, "what is left free")
Delta = letters("Delta", m1, p, "what the Kalman filter leaves of the accurate outputs")
W_e = letters("W_e", n, n, "weight of the error", symmetric=True)
G_1 = letters("G_1", m1, m1, "inverse weight seen by accurate outputs", symmetric=True)
L_W = letters("L_W", n, n, "a root of the weight")
L_M = letters("L_M", p, p, "a root of `M`")

# -- canonical coordinates -------------------------------------------------------------

Mbar = letters("Mbar", n, n, "rows of `C`, and rows that complete them; the paper's M")
Mbar_next = letters("Mbar_next", n, n, "the same one step on")
Mbar_2 = letters("Mbar_2", r, n, "its rows below the accurate outputs")
C_1 = letters("C_1", m1, n, "rows of the accurate outputs")
C_2 = letters("C_2", p2, n, "rows of the other outputs")
L = letters("L", n - p, n, "rows that complete them")
H = letters("H", p, n, "what is measured, in canonical coordinates")
H_2 = letters("H_2", p2, r, "what the other outputs measure of the lower states")
q = letters("q", n, 1, "state in canonical coordinates")
q_next = letters("q_next", n, 1, "the same one step on")
q_1 = letters("q_1", m1, 1, "states that the accurate outputs measure")
q_2 = letters("q_2", r, 1, "the other states")
y_1 = letters("y_1", m1, 1, "accurate outputs")
y_2 = letters("y_2", p2, 1, "other outputs")
v_1 = letters("v_1", m1, 1, "noise of the accurate outputs")
v_2 = letters("v_2", p2, 1, "noise of the other outputs")
K_1 = letters("K_1", r, m1, "gain of the accurate outputs")
K_2 = letters("K_2", r, p2, "gain of the other outputs")
K_low = letters("K_low", r, p, "both gains side by side")
N_low = letters("N_low", r, p, "lower rows of `N`")
K_star = letters("K_star", r, p, "the gains of least trace")
Omega_11 = letters("Omega_11", m1, m1, "block of `Omega`", symmetric=True)
Omega_21 = letters("Omega_21", r, m1, "block of `Omega`")
Omega_22 = letters("Omega_22", r, r, "block of `Omega`", symmetric=True)
R_11 = letters("R_11", m1, m1, "block of `R`", symmetric=True)
R_21 = letters("R_21", p2, m1, "block of `R`")
R_22 = letters("R_22", p2, p2, "block of `R`", symmetric=True)
