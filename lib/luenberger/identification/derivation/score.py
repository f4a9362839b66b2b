"""The score: how the likelihood changes with the covariances of the noises.

One pass back over the record gives it.  What it carries is what a smoother carries: the
gradient in a prediction, and what the record to come tells of it.

Source: our own; that the score is made of what a smoother finds is due to Koopman and
Shephard (1992), "Exact score for time series models in state space form".
"""

from sympy import Determinant, Rational, Trace, log, symbols

from matrixproof import BlockMatrix, Notation, Page, ZeroMatrix
from matrixproof.symbols import plus

n, p, m = symbols("n p m", integer=True, nonnegative=True)
c = symbols("c", integer=True, positive=True)  # one column, or one more for each state
letters = Notation()
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
W = letters("W", p, p, "inverse of `M`", symmetric=True)
e = letters("e", p, c, "innovation, weighed by its covariance")
Z = letters("Z", n + p, n, "`A` above `C`")
b = letters("b", n + p, m, "`B` above `E`")
d = letters("d", n + p, c, "zeros above the measurement")
J = letters("J", n + p, n + p, "joint covariance of both noises", symmetric=True)
k = letters("k", n + p, c, "`eta_next` above `h`")
Pi_J = letters("Pi_J", n + p, n + p, "what the record tells of both", symmetric=True)
gJ = letters("gJ", n + p, n + p, "gradient in `J`", symmetric=True)
X = letters("X", n, n, "covariance of the next state, before `y`", symmetric=True)
eta = letters("eta", n, c, "gradient of the likelihood in `x`")
eta_next = letters("eta_next", n, c, "the same one step on")
Pi = letters("Pi", n, n, "what the record to come tells of `x`", symmetric=True)
Pi_next = letters("Pi_next", n, n, "the same one step on", symmetric=True)
h = letters("h", p, c, "gradient of the likelihood in the measurement, turned")


SOURCE = "our own; Koopman and Shephard (1992)"
half = Rational(1, 2)
of_one_row = plus(
    Trace(k.T * (Z * x + b * u - d)),
    half * Trace((k * k.T - Pi_J) * (Z * Omega * Z.T + J)),
)


page = Page(letters=letters, source=SOURCE)

page("""Suppose that the likelihood of the rows to come has the gradient `eta_next` in
    the next prediction, and `1/2 (eta_next eta_next' - Pi_next)` in its covariance.
    After the last row both are zero. A row adds its own density, and passes on what the
    next prediction and its covariance are made of. Both are stationary: in `e`, of
    which the exponent is the least value, and in `G`, because no gain leaves a smaller
    covariance. So neither needs to be differentiated.""")
is_e = page.suppose(M * e, nu)
is_G = page.suppose(G * M, N)
is_h = page.suppose(e, h + G.T * eta_next)

page("""In terms of `h`, which takes the place of `e`, a row gives the following. Here
    `X` is the covariance of the next state before the measurement is used.""")
passed = X - G * N.T - N * G.T + G * M * G.T
row = plus(
    half * Trace(e.T * M * e) - Trace(e.T * nu) + Trace(eta_next.T * G * nu),
    Trace(eta_next.T * (N - G * M) * e) + half * Trace(eta_next.T * passed * eta_next),
)
of_h = half * Trace(h.T * M * h) - Trace(h.T * nu) + Trace(eta_next.T * N * h)
page(
    letters.derive("", "what a row gives, in terms of one unknown", row).by(
        of_h + half * Trace(eta_next.T * X * eta_next), is_h
    )
)
page(
    letters.derive("", "it is stationary in that unknown", of_h)
    .gradient(h, held=(M, N, nu))
    .fold(is_e, is_G)
    .use(is_h)
)
says = "it is stationary in the gain"
page(
    letters.derive("", says, Trace(Pi_next * passed)).gradient(G, held=(M, N)).use(is_G)
)

page("""Now put the next state above the measurement. Before the measurement is used,
    the two have the mean `Z x + b u` and the covariance `Z Omega Z' + J`. The logarithm
    of the determinant of `M` has the gradient `W`, its inverse.""")
is_W = page.let(W, M.I)
page(
    letters.derive("", "what a logarithm gives", log(Determinant(M)))
    .gradient(M)
    .fold(is_W)
)
is_Z = page.let(Z, BlockMatrix([[A], [C]]))
is_b = page.let(b, BlockMatrix([[B], [E]]))
is_d = page.let(d, BlockMatrix([[ZeroMatrix(n, c)], [y]]))
is_J = page.let(J, BlockMatrix([[Q, S], [S.T, R]]))
is_k = page.let(k, BlockMatrix([[eta_next], [h]]))
is_Pi_J = page.let(
    Pi_J,
    BlockMatrix([[Pi_next, -Pi_next * G], [-G.T * Pi_next, W + G.T * Pi_next * G]]),
)
is_X = page.let(X, A * Omega * A.T + Q)
is_N = page.suppose(N, A * Omega * C.T + S)
is_M = page.suppose(M, C * Omega * C.T + R)
is_nu = page.suppose(nu, y - E * u - C * x)
says = "what the covariances give, in both together"
rest = Trace(eta_next.T * X * eta_next) - Trace(W * M) - Trace(Pi_next * passed)
page(
    letters.derive("", says, Trace((k * k.T - Pi_J) * (Z * Omega * Z.T + J))).by(
        Trace(h.T * M * h) + 2 * Trace(eta_next.T * N * h) + rest,
        *(is_k, is_Pi_J, is_Z, is_J, is_X, is_N, is_M),
    )
)
says = "what the means give, in both together"
page(
    letters.derive("", says, Trace(k.T * (Z * x + b * u - d)))
    .multiply(is_k, is_Z, is_b, is_d)
    .fold(is_nu)
)


page("""So the whole is one line, and each gradient of it is one line as well. That in
    the prediction, and that in its covariance, have the form that was supposed of those
    of the next row.""")
by_both = page.let(eta, Z.T * k)
Pi_of_both = page.let(Pi, Z.T * Pi_J * Z)
page(
    letters.derive("", "the gradient in the prediction", of_one_row)
    .gradient(x, held=(Pi_J,))
    .fold(by_both)
)
page(
    letters.derive("", "the gradient in its covariance", of_one_row)
    .gradient(Omega, held=(Pi_J,))
    .fold(by_both, Pi_of_both)
    .factor()
)
is_gJ = page.let(gJ, half * (k * k.T - Pi_J))
page(
    letters.derive("", "the gradient in the covariance of the noises", of_one_row)
    .gradient(J, held=(Pi_J,))
    .fold(is_gJ)
)
