"""The letters of a predictor, of its likelihood and of how that changes."""

from sympy import symbols

from matrixproof import Identity as Identity
from matrixproof import Notation
from matrixproof import ZeroMatrix as ZeroMatrix

n, p, m = symbols("n p m", integer=True, nonnegative=True)
c = symbols(
    "c", integer=True, positive=True
)  # columns: one, or one more for each state
letters = Notation()
chain, derive, let, moment, steady, suppose = (
    letters.chain,
    letters.derive,
    letters.let,
    letters.moment,
    letters.steady,
    letters.suppose,
)

# -- the plant and its prediction ------------------------------------------------------

A = letters("A", n, n, "moves the state")
B = letters("B", n, m, "what the input does to the state")
C = letters("C", p, n, "what is measured")
E = letters("E", p, m, "what the input does to the measurement")
Q = letters("Q", n, n, "covariance of the process noise", symmetric=True)
R = letters("R", p, p, "covariance of the measurement noise", symmetric=True)
S = letters("S", n, p, "covariance of the two noises, `E[w v']`")
x = letters("x", n, c, "prediction of the state")
u = letters("u", m, c, "input")
y = letters("y", p, c, "measurement")
nu = letters("nu", p, c, "innovation")
Omega = letters("Omega", n, n, "covariance of the prediction's error", symmetric=True)
M = letters("M", p, p, "covariance of the innovation", symmetric=True)
N = letters("N", n, p, "covariance of the next state and the innovation")
G = letters("G", n, p, "gain of the next prediction")
F = letters("F", n, n, "moves the error of the prediction")
W = letters("W", p, p, "inverse of `M`", symmetric=True)
e = letters("e", p, c, "innovation, weighed by its covariance")

# -- the next state above the measurement ----------------------------------------------

Z = letters("Z", n + p, n, "`A` above `C`")
b = letters("b", n + p, m, "`B` above `E`")
d = letters("d", n + p, c, "zeros above the measurement")
J = letters("J", n + p, n + p, "joint covariance of both noises", symmetric=True)
k = letters("k", n + p, c, "`eta_next` above `h`")
Pi_J = letters("Pi_J", n + p, n + p, "what the record tells of both", symmetric=True)
gJ = letters("gJ", n + p, n + p, "gradient in `J`", symmetric=True)
X = letters("X", n, n, "covariance of the next state, before `y`", symmetric=True)

# -- how the likelihood changes --------------------------------------------------------

eta = letters("eta", n, c, "gradient of the likelihood in `x`")
eta_next = letters("eta_next", n, c, "the same one step on")
Pi = letters("Pi", n, n, "what the record to come tells of `x`", symmetric=True)
Pi_next = letters("Pi_next", n, n, "the same one step on", symmetric=True)
h = letters("h", p, c, "gradient of the likelihood in the measurement, turned")
