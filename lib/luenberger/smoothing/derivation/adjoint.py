"""The smoother of Bryson and Frazier: what later rows say is carried backwards.

Instead of smoothed estimates a vector and a matrix go from row to row, in which later
measurements say by how much an estimate is to be corrected.  Neither a covariance nor
the plant is inverted.  That it is the smoother of Rauch, Tung and Striebel is proved
row by row.

Source: Bryson and Frazier (1963) for the idea, in the form for discrete measurements;
the equations are our own.
"""

from matrixproof import Identity, Page

from .next_state import (
    As,
    I,
    Omega_next,
    Sigma,
    Sigma_s,
    Sigma_s_next,
    corrects,
    is_G,
    is_T,
    k,
    letters,
    n,
    p,
    recursion,
    x,
    x_minus_next,
    x_s,
    x_s_next,
)

letters = letters.here()
C = letters("C", p, n, "what is measured")
R = letters("R", p, p, "covariance of the measurement noise", symmetric=True)
lamda_next = letters("lamda_next", n, 1, "what later rows say of the next prediction")
x_minus = letters("x_minus", n, 1, "the filter's prediction")
innovation = letters(
    "innovation", p, 1, "what the prediction leaves of the measurement"
)
Omega = letters("Omega", n, n, "covariance of the prediction's error", symmetric=True)
M = letters("M", p, p, "covariance of the innovation", symmetric=True)
K = letters("K", n, p, "gain of minimum variance")
Y = letters("Y", n, n, "what the gain leaves of a predicted error")
lamda = letters("lamda", n, 1, "what this row and later ones say of the prediction")
Lambda = letters("Lambda", n, n, "how much they say of it", symmetric=True)
Lambda_next = letters("Lambda_next", n, n, "the same one step on", symmetric=True)
theta = letters("theta", n, 1, "what later rows say of the estimate")
Theta = letters("Theta", n, n, "how much they say of it", symmetric=True)
W = letters("W", p, p, "how much an innovation says", symmetric=True)
B = letters("B", p, k, "a root of an inverse of `M`, as far as it has one")
Left = letters("Left", n, n, "what smoothing leaves of the estimate's error")
h = letters("h", n, p, "what later rows say of what the gain brings in")
new = letters("new", p, 1, "the innovation's part, less what the gain takes off")
New = letters("New", p, p, "the same of the matrix")


page = Page(
    letters=letters,
    source="our own; Bryson and Frazier (1963), Rauch, Tung and Striebel (1965)",
)

page("""Suppose that later rows correct the next prediction by `Omega_next lamda_next`,
    and that `Lambda_next` says by how much they lessen its covariance. Then they
    correct this estimate by `Sigma theta`, and no gain has to be found.""")
page(corrects, is_T, is_G)
is_lamda_next = page.suppose(x_s_next - x_minus_next, Omega_next * lamda_next)
is_Lambda_next = page.suppose(
    Sigma_s_next - Omega_next, -Omega_next * Lambda_next * Omega_next
)
is_theta = page.let(theta, As.T * lamda_next)
is_Theta = page.let(Theta, As.T * Lambda_next * As)
estimate = page(
    letters.derive("", "later rows correct the estimate", x_s)
    .put(corrects)
    .use(is_lamda_next, is_G, is_T)
    .fold(is_theta)
)
covariance = page(
    letters.derive("", "and lessen its covariance", Sigma_s)
    .put(recursion)
    .use(is_Lambda_next, is_G, is_T)
    .fold(is_Theta)
)


page("""The row's own measurement has made the estimate from the prediction. With the
    gain of least variance the covariance is short, and symmetric.""")
updates = page.let(x, x_minus + K * innovation)
is_Y = page.let(Y, I - K * C)
is_M = page.let(M, C * Omega * C.T + R)
is_K = page.suppose(K * M, Omega * C.T)
joseph = page.suppose(Sigma, Y * Omega * Y.T + K * R * K.T)
shorter = page(
    letters.derive("", "the covariance that the gain of least variance leaves", Sigma)
    .put(joseph)
    .by(Y * Omega - (Omega * C.T - K * (C * Omega * C.T + R)) * K.T, is_Y)
    .fold(is_M)
    .use(is_K)
)

page("""An innovation says `C' W innovation` of the prediction. The matrix `W` is any
    symmetric one with `Omega C' W = K`. Where outputs have no noise there are many; all
    do the same.""")
is_W = page.suppose(Omega * C.T * W, K)
is_lamda = page.let(lamda, C.T * W * innovation + Y.T * theta)
is_Lambda = page.let(Lambda, C.T * W * C + Y.T * Theta * Y)
page(
    letters.derive("", "this row and later ones correct the prediction", x_s - x_minus)
    .put(estimate)
    .use(updates)
    .by(K * innovation + Omega * Y.T * theta, shorter)
    .fold(is_W, is_lamda)
)
left = page(
    letters.derive("", "what is left of the prediction's error", I - Omega * Lambda)
    .use(is_Lambda, is_W)
    .fold(shorter, is_Y)
)
page(
    letters.derive("", "and lessen the prediction's covariance", Sigma_s - Omega)
    .by(Y * Omega - Sigma * Theta * Y * Omega - Omega, covariance, shorter)
    .fold(left)
)

page("""Those are the suppositions again, one row earlier. Behind the last row nothing
    is said, so both begin with zero there. Where the innovation has a definite
    covariance, `W` is its inverse; elsewhere it takes a root of an inverse on the
    combinations of outputs that are not known before.""")
by_solve = page.suppose(W * M, Identity(p))
page(
    letters.derive("", "the inverse does it", Omega * C.T * W)
    .by(Omega * C.T * M.I, by_solve)
    .fold(is_K)
)
by_root = page.suppose(W, B * B.T)
gain_of_root = page.suppose(K, Omega * C.T * B * B.T)
page(
    letters.derive("", "a root does it as well", Omega * C.T * W)
    .put(by_root)
    .fold(gain_of_root)
)


page("""Readings are taken back one at a time, so `W` is one over the covariance of one
    innovation. The gain is taken off what is said on both sides.""")
is_h = page.let(h, Theta * K)
is_new = page.let(new, W * innovation - K.T * theta)
page(
    letters.derive("", "the vector that is carried", lamda)
    .put(is_lamda, is_Y)
    .fold(is_new)
)
is_New = page.let(New, W + K.T * h)
page(
    letters.derive("", "the matrix that is carried", Lambda)
    .put(is_Lambda, is_Y)
    .fold(is_h, is_New)
)
