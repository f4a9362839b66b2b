"""The letters of Leondes and Novak (1974), each with its size and what it stands for.

Theirs and ours differ in a few: their H_i is C, their n x m gain has p columns here,
because p counts outputs and m counts inputs.  A plus below is the next instant, where
the paper writes i + 1; what has no mark is at instant i.
"""

from sympy import symbols

from ....symbolic import Identity, Notation

SOURCE = "Leondes and Novak (1974)"

n, p, m, m1 = symbols("n p m m_1", integer=True, nonnegative=True)
r = symbols("r", integer=True, nonnegative=True)
letters = Notation()
chain, define, moment = letters.chain, letters.define, letters.moment
I = Identity(n)

# -- the plant ---------------------------------------------------------------------

A = letters("A", n, n, "moves the state")
B = letters("B", n, m, "what the input does to the state")
C = letters("C", p, n, "what is measured")
E = letters("E", p, m, "what the input does to the measurement; zero in the paper")
Q = letters("Q", n, n, "covariance of the process noise", symmetric=True)
R = letters("R", p, p, "covariance of the measurement noise", symmetric=True)
S = letters("S", n, p, "covariance of the two noises, `E[w v']`; zero in the paper")
x = letters("x", n, 1, "state")
x_next = letters("x_next", n, 1, "state one step on")
u = letters("u", m, 1, "input")
u_next = letters("u_next", m, 1, "input one step on")
y = letters("y", p, 1, "measurement")
y_next = letters("y_next", p, 1, "measurement one step on")
w = letters("w", n, 1, "process noise")
v = letters("v", p, 1, "measurement noise")
v_next = letters("v_next", p, 1, "measurement noise one step on")

# -- the step from one instant to the next ------------------------------------------

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

# -- accurate outputs ----------------------------------------------------------------

S1 = letters("S_1", m1, p, "rows of the identity that pick the accurate outputs")
Gamma_1 = letters("Gamma_1", n, m1, "the direction in which accurate outputs push")
Gamma = letters("Gamma", n, p, "the same beside zeros for the other outputs")
Phat = letters("Phat", n, r, "basis of what the accurate outputs do not show")
That = letters("That", r, n, "reads the coordinates in that basis")
Z = letters("Z", r, p, "what is left free")
Delta = letters("Delta", m1, p, "what the Kalman filter leaves of the accurate outputs")
W_e = letters("W_e", n, n, "weight of the error, positive definite", symmetric=True)
G_1 = letters("G_1", m1, m1, "inverse weight seen by accurate outputs", symmetric=True)
L_W = letters("L_W", n, n, "a root of the weight")
L_M = letters("L_M", p, p, "a root of `M`")
