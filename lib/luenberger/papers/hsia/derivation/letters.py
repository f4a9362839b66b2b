"""The letters of Hsia (1974): of the laws, and of the plant between two samples."""

import sympy as sp

from matrixproof import Notation
from matrixproof import ZeroMatrix as ZeroMatrix

SOURCE = "Hsia (1974)"

# -- the laws -------------------------------------------------------------------------

periods = Notation()
T = periods.scalar("T", "period: the time to the next sample", positive=True)
T_max = periods.scalar("T_max", "the longest period", positive=True)
rho = periods.scalar("rho", "rate of the error, without its sign", positive=True)
alpha = periods.scalar("alpha", "coefficient of laws 1 and 2", positive=True)
C = periods.scalar("C", "coefficient of law 3", positive=True)
K = periods.scalar("K", "coefficient of law 4", positive=True)
lam = periods.scalar("lambda", "price of a sample", positive=True)
g = periods.scalar("g", "what accuracy costs: `rho^a`", positive=True)
a = periods.scalar("a", "power of the rate", positive=True)
b = periods.scalar("b", "how fast the saving falls", real=True, nonzero=True)
s = periods.scalar("s", "the saving in the longest period is `(1 - s)/b`", real=True)
k = periods.scalar("k", "weight of a period, a power", nonnegative=True)
q = periods.scalar("q", "`s + b g/lambda`, where it is positive", positive=True)
c = periods.scalar("c", "a period is `c` times that of the law", positive=True)
beta = periods.scalar("beta", "size of `b`", positive=True)
sigma = periods.scalar("sigma", "size of it, where it is not", nonnegative=True)
T_s = periods.scalar("T_s", "the period of a law", positive=True)
kappa = periods.scalar("kappa", "how steep the cost is beside it", positive=True)
J, h = (sp.Function(name)(T) for name in "Jh")  # cost of a period, saving per second

# -- the plant ------------------------------------------------------------------------

n, m = sp.symbols("n m", integer=True, positive=True)
t, S = sp.Symbol("t", nonnegative=True), sp.Symbol("s")
letters = Notation()
chain, let, steady, suppose = (
    letters.chain,
    letters.let,
    letters.steady,
    letters.suppose,
)

A = letters("A", n, n, "moves the state")
B = letters("B", n, m, "what the input does to it")
C_p = letters("C", m, n, "what is measured")
G = letters("G", m, m, "the transfer function, at the frequency `s`")
x = letters("x", n, 1, "state of the loop that is closed all the time")
x_0 = letters("x_0", n, 1, "where it starts")
x_dot = letters("x_next", n, 1, "its rate")
y_star = letters("y*", m, 1, "output of that loop")
step = letters("r", m, 1, "the reference, a step")
jump = letters("j", m, m, "by how much the rate of the output jumps with the input")

# -- noise between two samples --------------------------------------------------------

Q = letters("Q", n, n, "intensity of the noise of the plant", symmetric=True)
Phi = letters("Phi", n, n, "`e^(A t)`: what a state becomes in the time `t`")
dPhi = letters("dPhi", n, n, "its rate")
Block = letters("Block", 2 * n, 2 * n, "what Van Loan takes the exponential of")
E = letters("E", 2 * n, 2 * n, "its exponential at the time `t`")
dE = letters("dE", 2 * n, 2 * n, "its rate")
U = letters("U", n, n, "upper left block of that")
dU = letters("dU", n, n, "its rate")
X = letters("X", n, n, "upper right block of the exponential of `[-A, Q; 0, A'] t`")
dX = letters("dX", n, n, "its rate")
Phi_0 = letters("Phi_0", n, n, "`Phi` at `t = 0`")
X_0 = letters("X_0", n, n, "`X` at `t = 0`")
P = letters("P", n, n, "covariance that the noise adds in the time `t`", symmetric=True)
dP = letters("dP", n, n, "its rate", symmetric=True)
H = letters("H", n, n, "what a state becomes in a first period")
P_h = letters("P_h", n, n, "covariance that the noise adds in it", symmetric=True)
P_2 = letters("P_2", n, n, "covariance of a period twice as long", symmetric=True)
