"""Autocovariances of the innovations of any stable gain.

A predictor with any stable gain leaves innovations that need not be white.  Their
autocovariances are linear in the covariances of the noises, so those can be found from
these by least squares.

Source: Mehra (1970), "On the identification of variances and adaptive Kalman
filtering"; Odelson, Rajamani and Rawlings (2006), "A new autocovariance least-squares
method for estimating noise covariances", (5)-(11).
"""

from sympy import symbols

from matrixproof import Notation, Page, ZeroMatrix

n, p = symbols("n p", integer=True, positive=True)
letters = Notation()
A = letters("A", n, n, "moves the state")
C = letters("C", p, n, "what is measured")
Q = letters("Q", n, n, "covariance of the process noise", symmetric=True)
S = letters("S", n, p, "covariance of the two noises, `E[w v']`")
x = letters("x", n, 1, "state")
x_next = letters("x_next", n, 1, "state one step on")
y = letters("y", p, 1, "measurement")
w = letters("w", n, 1, "process noise")
v = letters("v", p, 1, "measurement noise")
L = letters("L", n, p, "gain of the predictor, any stable one")
A_L = letters("A_L", n, n, "moves the error of the prediction")
R = letters("R", p, p, "covariance of the measurement noise", symmetric=True)
x_hat = letters("x_hat", n, 1, "prediction of the state")
x_hat_next = letters("x_hat_next", n, 1, "prediction one step on")
v_late = letters("v_k", p, 1, "measurement noise `k` steps on")
e = letters("e", n, 1, "error of the prediction")
e_late = letters("e_k", n, 1, "error `k` steps on")
e_later = letters("e_k_next", n, 1, "error `k + 1` steps on")
w_late = letters("w_k", n, 1, "process noise `k` steps on")
nu = letters("nu", p, 1, "innovation: the measurement less its prediction")
W = letters("W", n, n, "covariance of what drives the error", symmetric=True)
P = letters("P", n, n, "covariance of the error", symmetric=True)
P_next = letters("P_next", n, n, "the same one step on", symmetric=True)
Lambda_0 = letters("Lambda_0", p, p, "covariance of the innovation", symmetric=True)
Lambda_k = letters("Lambda_k", p, p, "autocovariance of the innovations at lag `k`")
N_1 = letters("N_1", n, p, "covariance of the next error and the innovation")
N_k = letters("N_k", n, p, "the same `k` steps on")
N_next = letters("N_next", n, p, "the same `k + 1` steps on")


SOURCE = "Mehra (1970); Odelson, Rajamani and Rawlings (2006)"


page = Page(letters=letters, source=SOURCE)

page("""Predict a state with any gain `L` for which the error dies out. What the inputs
    do is known and left out here.""")
plant = page.let(x_next, A * x + w)
measured = page.let(y, C * x + v)
is_e = page.let(x_hat, x - e, name="the error of the prediction")
is_nu = page.let(nu, y - C * x_hat)
predicts = page.let(x_hat_next, A * x_hat + L * nu)
is_A_L = page.let(A_L, A - L * C)
shows = page(
    letters.derive("", "what an innovation shows", nu)
    .put(is_nu, measured, is_e)
    .expand()
)
moves = page(
    letters.derive("", "how the error moves", x_next - x_hat_next)
    .put(plant)
    .use(predicts)
    .put(is_e, shows)
    .fold(is_A_L)
)

page("""Both noises are white, and independent of the error, which stems from
    earlier ones. What drives the error has a covariance that is linear in those of
    the noises.""")
is_Q = page.moment(w * w.T, Q)
is_R = page.moment(v * v.T, R)
is_S = page.moment(w * v.T, S)
is_P = page.moment(e * e.T, P)
past_w = page.moment(e * w.T, ZeroMatrix(n, n))
past_v = page.moment(e * v.T, ZeroMatrix(n, p))
is_W = page.let(W, Q - S * L.T - L * S.T + L * R * L.T)
drives = page(
    letters.derive(
        "", "the covariance of what drives the error", (w - L * v) * (w - L * v).T
    )
    .expect(is_Q, is_S, is_R)
    .fold(is_W)
)
is_P_next = page.let(P_next, A_L * P * A_L.T + W)
says = "the covariance of the error"
page(
    letters.derive("", says, (A_L * e + w - L * v) * (A_L * e + w - L * v).T)
    .expect(is_P, is_Q, is_S, is_R, past_w, past_v)
    .fold(is_W, is_P_next)
)

page("""With a constant gain it settles where `P_next` is `P`. The innovation then has
    the covariance `Lambda_0`.""")
is_Lambda_0 = page.let(Lambda_0, C * P * C.T + R)
page(
    letters.derive("", "the covariance of the innovation", (C * e + v) * (C * e + v).T)
    .expect(is_P, is_R, past_v)
    .fold(is_Lambda_0)
)

page("""The next error is correlated with this innovation: through the error before it,
    and through the noises that both contain.""")
is_N_1 = page.let(N_1, A_L * P * C.T + S - L * R)
says = "the covariance of the next error and the innovation"
page(
    letters.derive("", says, (A_L * e + w - L * v) * (C * e + v).T)
    .expect(is_P, is_S, is_R, past_w, past_v)
    .fold(is_N_1)
)

page("""From there on only the dynamics carry the correlation, because later noises are
    independent of this innovation.""")
is_N_k = page.moment(e_late * nu.T, N_k)
later_w = page.moment(w_late * nu.T, ZeroMatrix(n, p))
later_v = page.moment(v_late * nu.T, ZeroMatrix(p, p))
is_later = page.let(N_next, A_L * N_k)
later = page.let(e_later, A_L * e_late + w_late - L * v_late)
page(
    letters.derive("", "how it is carried on", e_later * nu.T)
    .put(later)
    .expect(is_N_k, later_w, later_v)
    .fold(is_later)
)
is_Lambda_k = page.let(Lambda_k, C * N_k)
page(
    letters.derive("", "the autocovariance at a lag", (C * e_late + v_late) * nu.T)
    .expect(is_N_k, later_v)
    .fold(is_Lambda_k)
)

error_noise = page.program("what drives the error of a predictor", (Q, R, S, L), is_W)

first_autocovariances = page.program(
    "the innovation with itself, and the next error with it",
    (A_L, C, L, R, S, P),
    is_Lambda_0,
    is_N_1,
)

autocovariance_step = page.program(
    "one lag, and the step to the next", (A_L, C, N_k), is_Lambda_k, is_later
)
