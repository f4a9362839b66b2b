"""The smoother of Bryson and Frazier: what later rows say is carried backwards.

Instead of smoothed estimates a vector and a matrix go from row to row, in which later
measurements say by how much an estimate is to be corrected.  Neither a covariance nor
the plant is inverted.  That it is the smoother of Rauch, Tung and Striebel is proved
row by row.

Source: Bryson and Frazier (1963) for the idea, in the form for discrete measurements;
the equations are our own.
"""

from matrixproof import Identity, Line, Page

from .letters import *
from .next_state import corrects, is_G, is_T, recursion

letters = letters.here()
let, suppose = letters.let, letters.suppose
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
is_lamda_next = page(suppose(x_s_next - x_minus_next, Omega_next * lamda_next))
is_Lambda_next = page(
    suppose(Sigma_s_next - Omega_next, -Omega_next * Lambda_next * Omega_next)
)
is_theta = page(let(theta, As.T * lamda_next))
is_Theta = page(let(Theta, As.T * Lambda_next * As))
estimate = page.chain(
    "",
    "later rows correct the estimate",
    x_s,
    Line(x + G * (x_s_next - x_minus_next), by=(corrects,)),
    Line(x + G * Omega_next * lamda_next, by=(is_lamda_next,)),
    Line(x + T.T * lamda_next, by=(is_G,)),
    Line(x + Sigma * As.T * lamda_next, by=(is_T,)),
    Line(x + Sigma * theta, by=(is_theta,)),
)
covariance = page.chain(
    "",
    "and lessen its covariance",
    Sigma_s,
    Line(Sigma + G * (Sigma_s_next - Omega_next) * G.T, by=(recursion,)),
    Line(
        Sigma - G * Omega_next * Lambda_next * Omega_next * G.T,
        by=(is_Lambda_next,),
    ),
    Line(Sigma - T.T * Lambda_next * T, by=(is_G,)),
    Line(Sigma - Sigma * As.T * Lambda_next * As * Sigma, by=(is_T,)),
    Line(Sigma - Sigma * Theta * Sigma, by=(is_Theta,)),
)


page("""The row's own measurement has made the estimate from the prediction. With the
    gain of least variance the covariance is short, and symmetric.""")
updates = page(let(x, x_minus + K * innovation))
is_Y = page(let(Y, I - K * C))
is_M = page(let(M, C * Omega * C.T + R))
is_K = page(suppose(K * M, Omega * C.T))
joseph = page(suppose(Sigma, Y * Omega * Y.T + K * R * K.T))
shorter = page.chain(
    "",
    "the covariance that the gain of least variance leaves",
    Sigma,
    Line(Y * Omega * Y.T + K * R * K.T, by=(joseph,)),
    Line(Y * Omega - (Omega * C.T - K * (C * Omega * C.T + R)) * K.T, by=(is_Y,)),
    Line(Y * Omega - (Omega * C.T - K * M) * K.T, by=(is_M,)),
    Line(Y * Omega, by=(is_K,)),
)

page("""An innovation says `C' W innovation` of the prediction. The matrix `W` is any
    symmetric one with `Omega C' W = K`. Where outputs have no noise there are many; all
    do the same.""")
is_W = page(suppose(Omega * C.T * W, K))
is_lamda = page(let(lamda, C.T * W * innovation + Y.T * theta))
is_Lambda = page(let(Lambda, C.T * W * C + Y.T * Theta * Y))
page.chain(
    "",
    "this row and later ones correct the prediction",
    x_s - x_minus,
    Line(x + Sigma * theta - x_minus, by=(estimate,)),
    Line(K * innovation + Sigma * theta, by=(updates,)),
    Line(K * innovation + Omega * Y.T * theta, by=(shorter,)),
    Line(Omega * C.T * W * innovation + Omega * Y.T * theta, by=(is_W,)),
    Line(Omega * lamda, by=(is_lamda,)),
)
left = page.chain(
    "",
    "what is left of the prediction's error",
    I - Omega * Lambda,
    Line(I - Omega * C.T * W * C - Omega * Y.T * Theta * Y, by=(is_Lambda,)),
    Line(I - K * C - Omega * Y.T * Theta * Y, by=(is_W,)),
    Line(I - K * C - Sigma * Theta * Y, by=(shorter,)),
    Line(Y - Sigma * Theta * Y, by=(is_Y,)),
)
page.chain(
    "",
    "and lessen the prediction's covariance",
    Sigma_s - Omega,
    Line(Y * Omega - Sigma * Theta * Y * Omega - Omega, by=(covariance, shorter)),
    Line((I - Omega * Lambda) * Omega - Omega, by=(left,)),
    Line(-Omega * Lambda * Omega, why="multiply out"),
)

page("""Those are the suppositions again, one row earlier. Behind the last row nothing
    is said, so both begin with zero there. Where the innovation has a definite
    covariance, `W` is its inverse; elsewhere it takes a root of an inverse on the
    combinations of outputs that are not known before.""")
by_solve = page(suppose(W * M, Identity(p)))
page.chain(
    "",
    "the inverse does it",
    Omega * C.T * W,
    Line(Omega * C.T * W * M * M.I, why="the covariance has an inverse"),
    Line(Omega * C.T * M.I, by=(by_solve,)),
    Line(K * M * M.I, by=(is_K,)),
    Line(K, why="cancel"),
)
by_root = page(suppose(W, B * B.T))
gain_of_root = page(suppose(K, Omega * C.T * B * B.T))
page.chain(
    "",
    "a root does it as well",
    Omega * C.T * W,
    Line(Omega * C.T * B * B.T, by=(by_root,)),
    Line(K, by=(gain_of_root,)),
)


page("""Readings are taken back one at a time, so `W` is one over the covariance of one
    innovation. The gain is taken off what is said on both sides.""")
is_h = page(let(h, Theta * K))
is_new = page(let(new, W * innovation - K.T * theta))
page.chain(
    "",
    "the vector that is carried",
    lamda,
    Line(C.T * W * innovation + (I - K * C).T * theta, by=(is_lamda, is_Y)),
    Line(theta + C.T * (W * innovation - K.T * theta), why="factor"),
    Line(theta + C.T * new, by=(is_new,)),
)
is_New = page(let(New, W + K.T * h))
page.chain(
    "",
    "the matrix that is carried",
    Lambda,
    Line(C.T * W * C + Y.T * Theta * Y, by=(is_Lambda,)),
    Line(C.T * W * C + (I - K * C).T * Theta * (I - K * C), by=(is_Y,)),
    Line(
        Theta - Theta * K * C - C.T * K.T * Theta + C.T * (W + K.T * Theta * K) * C,
        why="multiply out",
    ),
    Line(Theta - h * C - C.T * h.T + C.T * New * C, by=(is_h, is_New)),
)
