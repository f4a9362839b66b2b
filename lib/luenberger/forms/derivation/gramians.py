"""The coordinates in which both Gramians are the same diagonal matrix.

One Gramian says how far inputs move the state of the observer, the other how much of it
the estimate shows.  In balanced coordinates both say the same of each state.

Source: B. C. Moore, IEEE Trans. Automat. Contr. 26 (1981) 17-32; the square roots are
of A. J. Laub, M. T. Heath, C. C. Paige and R. C. Ward, the same 32 (1987) 115-122.
"""

from sympy import eye

from matrixproof import Page, Stage, ZeroMatrix

from .letters import F_S, P_S, F, I, P, S, U, letters, m, p, r

letters = letters.here()
N = letters("N", r, m + p, "the inputs of the observer, `[G, D]`")
N_S = letters("N_S", r, m + p, "`N` in the new coordinates")
X = letters("X", r, r, "what the inputs reach, a Gramian", symmetric=True)
Y = letters("Y", r, r, "what the estimate shows, a Gramian", symmetric=True)
X_S = letters("X_S", r, r, "`X` in the new coordinates", symmetric=True)
Y_S = letters("Y_S", r, r, "`Y` in the new coordinates", symmetric=True)
R = letters("R", r, r, "a root of `X`")
M = letters("M", r, r, "a root of `Y`")
Q_1 = letters("Q_1", r, r, "left singular vectors of `M R`")
Q_2 = letters("Q_2", r, r, "right singular vectors of `M R`")
h = letters("h", r, r, "roots of its singular values, diagonal", symmetric=True)
k = letters("k", r, r, "the inverse of `h`, diagonal", symmetric=True)
Sigma = letters("Sigma", r, r, "its singular values, diagonal", symmetric=True)


SOURCE = "Moore (1981); Laub, Heath, Paige and Ward (1987)"
nothing = ZeroMatrix(r, r)
across = dict(F=F.T, N=P.T, S=U.T, U=S.T, X=Y, F_S=F_S.T, N_S=P_S.T, X_S=Y_S)

WITNESS = {
    F: [[0, -1], [1, 0]],
    X: eye(2),
    Y: eye(2),
    R: eye(2),
    M: eye(2),
    Q_1: eye(2),
    Q_2: eye(2),
    h: eye(2),
}


page = Page(letters=letters, source=SOURCE, witness=WITNESS)

page("The Gramians change with the coordinates, as do the inputs.")
inverse = page.suppose(U * S, I)
is_F = page.let(F_S, S * F * U)
is_P = page.let(P_S, P * U)
is_N = page.let(N_S, S * N)
is_X = page.let(X_S, S * X * S.T)
is_Y = page.let(Y_S, U.T * Y * U)

page("In discrete time they are what these equations say, and remain so.")
reached = page.steady(X, F * X * F.T + N * N.T, name="reached from sample to sample")
moves = page(
    letters.derive("", "what inputs reach from sample to sample", X_S)
    .put(is_X, reached)
    .by(S * F * U * S * X * S.T * (S * F * U).T + N_S * N_S.T, inverse, is_N)
    .fold(is_F, is_X)
)
shown = page.steady(Y, F.T * Y * F + P.T * P, name="shown from sample to sample")
page.at("", "what the estimate shows from sample to sample", moves, **across)

page("In continuous time they are what these say, and remain so as well.")
reached_c = page.suppose(F * X + X * F.T + N * N.T, nothing, name="reached in time")
moves_c = page(
    letters.derive(
        "", "what inputs reach in time", F_S * X_S + X_S * F_S.T + N_S * N_S.T
    )
    .put(is_F, is_X, is_N)
    .use(inverse, reached_c)
)
shown_c = page.suppose(F.T * Y + Y * F + P.T * P, nothing, name="shown in time")
page.at("", "what the estimate shows in time", moves_c, **across)

page("""Take roots of both Gramians, and the singular values of their product. No
    Gramian is inverted, and none is squared.""")
root_X = page.suppose(X, R * R.T)
root_Y = page.suppose(Y, M.T * M)
values = page.suppose(M * R, Q_1 * Sigma * Q_2.T)
orthogonal_1 = page.suppose(Q_1.T * Q_1, I)
orthogonal_2 = page.suppose(Q_2.T * Q_2, I)
roots = page.suppose(Sigma, h * h)
inverse_roots = page.suppose(k * h, I)
is_S = page.suppose(S, k * Q_1.T * M)
is_U = page.suppose(U, R * Q_2 * k)

page("These two matrices undo each other.")
page(
    letters.derive("", "one is the inverse of the other", S * U)
    .put(is_S, is_U)
    .use(values, orthogonal_1, orthogonal_2)
    .put(roots)
    .use(inverse_roots)
)

page("Both Gramians are diagonal in the new coordinates, and they are equal.")
page(
    letters.derive("", "what inputs reach is diagonal", X_S)
    .put(is_X, root_X, is_S)
    .use(values, orthogonal_1, orthogonal_2)
    .put(roots)
    .use(inverse_roots)
    .fold(roots)
)
page(
    letters.derive("", "what the estimate shows is diagonal", Y_S)
    .put(is_Y, root_Y, is_U)
    .use(values, orthogonal_1, orthogonal_2)
    .put(roots)
    .use(inverse_roots)
    .fold(roots)
)

balancing = page.program(
    "balanced coordinates and the way back",
    (R, M, Q_1, Q_2, k),
    Stage(S, k * Q_1.T * M, by=(is_S,)),
    Stage(U, R * Q_2 * k, by=(is_U,)),
)
