"""The letters of a predictor with any stable gain, and of its innovations."""

from sympy import symbols

from matrixproof import Identity, Notation
from matrixproof import ZeroMatrix as ZeroMatrix

n, p = symbols("n p", integer=True, positive=True)
r = symbols("r", integer=True, positive=True)  # rows of an observability matrix
q = symbols("q", integer=True, positive=True)  # how much of the state the outputs show
letters = Notation()
chain, derive, let, moment, steady, suppose = (
    letters.chain,
    letters.derive,
    letters.let,
    letters.moment,
    letters.steady,
    letters.suppose,
)
I = Identity(n)

# -- the plant and the predictor -------------------------------------------------------

A = letters("A", n, n, "moves the state")
C = letters("C", p, n, "what is measured")
Q = letters("Q", n, n, "covariance of the process noise", symmetric=True)
R = letters("R", p, p, "covariance of the measurement noise", symmetric=True)
S = letters("S", n, p, "covariance of the two noises, `E[w v']`")
x = letters("x", n, 1, "state")
x_next = letters("x_next", n, 1, "state one step on")
x_hat = letters("x_hat", n, 1, "prediction of the state")
x_hat_next = letters("x_hat_next", n, 1, "prediction one step on")
y = letters("y", p, 1, "measurement")
w = letters("w", n, 1, "process noise")
v = letters("v", p, 1, "measurement noise")
v_next = letters("v_next", p, 1, "measurement noise one step on")
v_late = letters("v_k", p, 1, "measurement noise `k` steps on")
L = letters("L", n, p, "gain of the predictor, any stable one")
A_L = letters("A_L", n, n, "moves the error of the prediction")
e = letters("e", n, 1, "error of the prediction")
e_next = letters("e_next", n, 1, "error one step on")
e_late = letters("e_k", n, 1, "error `k` steps on")
e_later = letters("e_k_next", n, 1, "error `k + 1` steps on")
w_late = letters("w_k", n, 1, "process noise `k` steps on")
nu = letters("nu", p, 1, "innovation: the measurement less its prediction")

# -- covariances -----------------------------------------------------------------------

W = letters("W", n, n, "covariance of what drives the error", symmetric=True)
P = letters("P", n, n, "covariance of the error", symmetric=True)
P_next = letters("P_next", n, n, "the same one step on", symmetric=True)
Lambda_0 = letters("Lambda_0", p, p, "covariance of the innovation", symmetric=True)
Lambda_k = letters("Lambda_k", p, p, "autocovariance of the innovations at lag `k`")
N_1 = letters("N_1", n, p, "covariance of the next error and the innovation")
N_k = letters("N_k", n, p, "the same `k` steps on")
N_next = letters("N_next", n, p, "the same `k + 1` steps on")

# -- changes of the noise --------------------------------------------------------------

dQ = letters("dQ", n, n, "change of `Q`", symmetric=True)
dR = letters("dR", p, p, "change of `R`", symmetric=True)
dS = letters("dS", n, p, "change of `S`")
dW = letters("dW", n, n, "change of `W`", symmetric=True)
X = letters("X", n, n, "change of `P`", symmetric=True)
X_next = letters("X_next", n, n, "the same one step on", symmetric=True)
dLambda_0 = letters("dLambda_0", p, p, "change of `Lambda_0`", symmetric=True)
dN_1 = letters("dN_1", n, p, "change of `N_1`")
O = letters("O", r, n, "rows `C A_L^k`: what the errors to come show of one")
J = letters("J", n, r, "a left inverse of it")
a = letters("a", n, 1, "a motion of the plant")
T = letters("T", q, n, "rows that span all that outputs show of a state")
A_T = letters("A_T", q, q, "moves what they show")
C_T = letters("C_T", p, q, "what is measured of what they show")
mode = letters.scalar("mu", "its eigenvalue")
