"""The smoother of Rauch, Tung and Striebel: later rows speak through the next state.

If the next state were known, it would be a measurement of this one.  What later rows
say of this state they say of the next one, so the same gain serves.  Nothing in it is
inverted: a gain is any solution of its equation.

A plus below is the next instant; what has no mark is at one instant, i.  An `s` below
is an estimate from the whole record, or its error.  Errors are estimate less truth.
Process noise and its covariance are what is left once the measurement noise has told
its part; the two are then independent.

Source: Rauch, Tung and Striebel (1965) for the smoother; the equations are our own.
"""

from sympy import symbols

from matrixproof import Identity, Notation, Page, ZeroMatrix

from ...theory import regression

n, p, k, q = symbols("n p k q", integer=True, nonnegative=True)
letters = Notation()
As = letters("As", n, n, "moves the error of an estimate to the next instant")
Q = letters("Q", n, n, "covariance of the process noise that is left", symmetric=True)
w = letters("w", n, 1, "process noise that is left")
x = letters("x", n, 1, "the filter's estimate")
x_minus_next = letters("x_minus_next", n, 1, "its prediction one step on")
e = letters("e", n, 1, "error of the filter's estimate")
e_minus_next = letters("e_minus_next", n, 1, "error of its prediction one step on")
Sigma = letters("Sigma", n, n, "covariance of the estimate's error", symmetric=True)
Omega_next = letters("Omega_next", n, n, "the same one step on", symmetric=True)
x_s = letters("x_s", n, 1, "smoothed estimate")
x_s_next = letters("x_s_next", n, 1, "smoothed estimate one step on")
e_s_next = letters("e_s_next", n, 1, "its error one step on")
Sigma_s = letters("Sigma_s", n, n, "covariance of its error", symmetric=True)
Sigma_s_next = letters("Sigma_s_next", n, n, "the same one step on", symmetric=True)
U_next = letters("U_next", n, n, "covariance of both errors, `E[e_s_next e_s']`")
G = letters("G", n, n, "gain of a smoother")
T = letters("T", n, n, "covariance of the next prediction's error and the estimate's")
xt = letters("xt", n, 1, "state")
xt_next = letters("xt_next", n, 1, "state one step on")
X = letters("X", n, n, "any gain")
d = letters("d", n, 1, "error left if the next state were known")
D = letters("D", n, n, "covariance of that error", symmetric=True)
Psi = letters("Psi", n, n, "what the smoother leaves of a predicted error")
r = letters("r", n, 1, "what noises of later rows add to its error")
L_O = letters("L_O", n, n, "a root of the next prediction's covariance")
H = letters("H", n, k, "a factor of `Sigma`")
L_Q = letters("L_Q", n, q, "a factor of `Q`")
H_s_next = letters("H_s_next", n, k, "a factor of `Sigma_s_next`")
kept = letters("kept", n, k, "what the gain leaves of `H`")
drawn = letters("drawn", n, q, "what it lets in of the process noise")
passed = letters("passed", n, k, "what it passes on from the next state")
I, gone = Identity(n), ZeroMatrix(n, n)


page = Page(letters=letters, source="our own; Rauch, Tung and Striebel (1965)")

page("""The filter's estimate errs by `e`. Its prediction of the next state errs by what
    the plant makes of `e`, less the process noise. Both errors are correlated.""")
moves = page.let(e_minus_next, As * e - w)
is_Sigma = page.moment(e * e.T, Sigma)
is_Q = page.moment(w * w.T, Q)
apart = page.moment(e * w.T, gone)
is_Omega = page.let(Omega_next, As * Sigma * As.T + Q)
is_T = page.let(T, As * Sigma)
page(
    letters.derive(
        "", "the covariance of the next prediction", e_minus_next * e_minus_next.T
    )
    .put(moves)
    .expect(is_Sigma, is_Q, apart)
    .fold(is_Omega)
)
says = "what the next prediction has in common with the estimate"
page(
    letters.derive("", says, e_minus_next * e.T)
    .put(moves)
    .expect(is_Sigma, apart)
    .fold(is_T)
)

page("""Were the next state known, so would be `e_minus_next`, and any gain `X` could
    take its share out of `e`. The best one solves an equation that is solvable also
    where `Omega_next` is singular.""")
both = page.moment(e_minus_next * e.T, T)
ahead = page.moment(e_minus_next * e_minus_next.T, Omega_next)
by_next = dict(y=e_minus_next, Omega=Sigma, M=Omega_next, N=T.T, K=X, L_M=L_O)
page.at("", "the covariance of what any gain leaves", regression.any_gain, **by_next)
is_G = page.suppose(G * Omega_next, T.T)
root = page.suppose(Omega_next, L_O * L_O.T)
says = "no gain does better if the next state is known"
page.at("", says, regression.least, **by_next)

page("""What is left is uncorrelated with the predicted error, and so with all that
    later rows can show, because they speak of the next state and of noises to come.""")
is_d = page.let(d, e - G * e_minus_next)
seen_later = page.let(e_s_next, Psi * e_minus_next + r)
new = page.moment(e * r.T, gone)
new_ahead = page.moment(e_minus_next * r.T, gone)
says = "what is left is uncorrelated with the smoothed error one step on"
page(
    letters.derive("", says, d * e_s_next.T)
    .put(is_d, seen_later)
    .expect(both, ahead, new, new_ahead)
    .use(is_G)
)


page("""The next state is not known, but its smoothed estimate is. It takes the place of
    the state.""")
corrects = page.let(x_s, x + G * (x_s_next - x_minus_next))
is_e = page.suppose(e, x - xt)
is_e_minus = page.suppose(e_minus_next, x_minus_next - xt_next)
is_e_s_next = page.suppose(e_s_next, x_s_next - xt_next)
error = page(
    letters.derive("", "the error of the smoothed estimate", x_s - xt)
    .put(corrects)
    .by(e - G * e_minus_next + G * e_s_next, is_e, is_e_minus, is_e_s_next)
    .by(d + G * e_s_next, is_d)
)
is_D = page.moment(d * d.T, D)
is_Sigma_s_next = page.moment(e_s_next * e_s_next.T, Sigma_s_next)
unrelated = page.moment(d * e_s_next.T, gone)
is_Sigma_s = page.let(Sigma_s, D + G * Sigma_s_next * G.T)
page(
    letters.derive(
        "", "the covariance of the smoothed estimate", (x_s - xt) * (x_s - xt).T
    )
    .use(error)
    .expect(is_D, is_Sigma_s_next, unrelated)
    .fold(is_Sigma_s)
)

page("""It is a sum of squares for any gain. With the best gain the first one is
    shorter, and the recursion is that of Rauch, Tung and Striebel.""")
page(
    letters.derive("", "the covariance if the next state were known", d * d.T)
    .put(is_d, moves)
    .expect(is_Sigma, is_Q, apart)
    .by((I - G * As) * Sigma * (I - G * As).T + G * Q * G.T)
)
squares = page.suppose(D, (I - G * As) * Sigma * (I - G * As).T + G * Q * G.T)
short = page(
    letters.derive("", "the same with the best gain", D)
    .put(squares)
    .expand()
    .fold(is_Omega)
    .fold(is_T)
    .fold(is_G)
)
recursion = page(
    letters.derive("", "the recursion of Rauch, Tung and Striebel", Sigma_s)
    .put(is_Sigma_s)
    .put(short)
    .factor()
)

page("The errors of neighbours have in common what the gain passes on.")
is_U = page.let(U_next, Sigma_s_next * G.T)
lag_one = page(
    letters.derive("", "the covariance of neighbours", e_s_next * (x_s - xt).T)
    .use(error)
    .expect(is_Sigma_s_next, unrelated)
    .fold(is_U)
)

page("""A sum of squares has a factor. Where later rows leave a small part of a large
    variance, this form keeps the digits that the difference loses.""")
is_H = page.suppose(Sigma, H * H.T)
is_L_Q = page.suppose(Q, L_Q * L_Q.T)
is_H_s_next = page.suppose(Sigma_s_next, H_s_next * H_s_next.T)
is_kept = page.let(kept, (I - G * As) * H)
is_drawn = page.let(drawn, G * L_Q)
is_passed = page.let(passed, G * H_s_next)
factors = kept * kept.T + drawn * drawn.T + passed * passed.T
page(
    letters.derive("", "a factor of the smoothed covariance", factors)
    .put(is_kept, is_drawn, is_passed)
    .by(squares.right + G * Sigma_s_next * G.T, is_H, is_L_Q, is_H_s_next)
    .fold(squares)
    .fold(is_Sigma_s)
)
