"""Which changes of the noise covariances leave no trace in a record.

All that a record of normal noises tells of their covariances is in the autocovariances
of its innovations.  A change of Q, R and S moves none of them exactly when it is made
of one symmetric matrix, and this does not hang on the gain that made the innovations.
This is so of an observable plant, and of the part of any plant that its outputs show.

Source: our own; Mehra (1970) and Odelson, Rajamani and Rawlings (2006) have the rank
of the map for one gain, and Faurre (1976), "Stochastic realization algorithms", the
matrices that realise the same autocovariances.
"""

from sympy import symbols

from matrixproof import Identity, Page, Stage, ZeroMatrix

from .autocovariances import (
    A_L,
    A,
    C,
    L,
    Q,
    S,
    is_A_L,
    letters,
    n,
    p,
    v,
    w,
    x,
    x_next,
    y,
)

r = symbols("r", integer=True, positive=True)  # rows of an observability matrix
q = symbols("q", integer=True, positive=True)  # how much of the state the outputs show
I = Identity(n)
letters = letters.here()
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


SOURCE = "Mehra (1970); Faurre (1976)"


page = Page(letters=letters, source=SOURCE)

page("""Outputs may not show all of a state. Let the rows of `T` span what they show,
    now or later: those of `C`, of `C A` and so on. So the rows of `C` and of `T A` are
    combinations of them.""")
plant = page.let(x_next, A * x + w)
measured = page.let(y, C * x + v)
is_A_T = page.suppose(T * A, A_T * T)
is_C_T = page.suppose(C, C_T * T)
page(
    letters.derive("", "what is shown moves by itself", T * x_next)
    .put(plant)
    .use(is_A_T)
)
page(letters.derive("", "and alone is measured", y).put(measured, is_C_T))

page("""So a record is one of the plant `A_T, C_T`, which is observable, whose process
    noise is `T w`.""")
is_Q = page.moment(w * w.T, Q)
is_S = page.moment(w * v.T, S)
page(
    letters.derive(
        "", "the covariance of its process noise", (T * w) * (T * w).T
    ).expect(is_Q)
)
page(
    letters.derive("", "and of this and the measurement noise", (T * w) * v.T).expect(
        is_S
    )
)

page("""What `T Q T'` and `T S` leave out of `Q` and `S` no record shows. From here on
    the plant is that one, so it is observable, and its letters are `A` and `C` again.
    The innovations of a stable gain come from the record by a filter that can be
    undone, so they tell as much as the record. Their autocovariances are linear in `Q`,
    `R` and `S`. So are changes of these and of those.""")
page(is_A_L)
is_dW = page.let(dW, dQ - dS * L.T - L * dS.T + L * dR * L.T)
is_X_next = page.suppose(A_L * X * A_L.T + dW, X_next, name="how `P` changes")
is_dLambda = page.let(dLambda_0, C * X * C.T + dR)
is_dN = page.let(dN_1, A_L * X * C.T + dS - L * dR)

page("""Take any symmetric `X` at every instant, and change the noises as follows. In a
    constant plant `X_next` is `X`.""")
is_dQ = page.let(dQ, X_next - A * X * A.T)
is_dR = page.let(dR, -C * X * C.T)
is_dS = page.let(dS, -A * X * C.T)
says = "such a change drives the error as the matrix moves"
page(
    letters.derive("", says, A_L * X * A_L.T + dQ - dS * L.T - L * dS.T + L * dR * L.T)
    .put(is_A_L, is_dQ, is_dR, is_dS)
    .expand()
)

page("""So `X` is the change of the error's covariance: it satisfies the same
    equation, and the gain is stable, so there is no other solution. No
    autocovariance changes.""")
page(
    letters.derive("", "the covariance of the innovation stays", dLambda_0)
    .put(is_dLambda)
    .use(is_dR)
)
page(
    letters.derive("", "and so does what all other lags are made of", dN_1)
    .put(is_dN, is_A_L, is_dR, is_dS)
    .expand()
)

page("""Conversely, let a change leave all autocovariances as they are. The lags after
    the first are `C A_L^k` times the change of `N_1`. Put below each other these rows
    have a left inverse, because the plant is observable and a gain hides no motion:
    what `C` does not see moves with `A_L` as it does with `A`.""")
motion = page.suppose(A * a, mode * a)
unseen = page.suppose(C * a, ZeroMatrix(p, 1))
page(
    letters.derive("", "a gain hides no motion and shows none", A_L * a)
    .put(is_A_L)
    .use(motion, unseen)
)
inverse = page.suppose(J * O, I)
no_lag = page.suppose(O * dN_1, ZeroMatrix(r, p))
nothing = page(
    letters.derive("", "no lag changes, so this does not either", dN_1)
    .by(J * O * dN_1, inverse)
    .use(no_lag)
)

page("""Then the change of `R` is that of some `X`: the change of the error's
    covariance.""")
stays = page.suppose(dLambda_0, ZeroMatrix(p, p))
found_dR = page(
    letters.derive("", "the change of R is made of it", dR)
    .by(dLambda_0 - C * X * C.T, is_dLambda)
    .put(stays)
)

page("And so is that of `S`,")
found_dS = page(
    letters.derive("", "the change of S is made of it", dS)
    .by(dN_1 - A_L * X * C.T + L * dR, is_dN)
    .put(nothing, found_dR, is_A_L)
    .expand()
)

page("and that of `Q`.")
page(
    letters.derive("", "the change of Q is made of it", dQ)
    .by(dW + dS * L.T + L * dS.T - L * dR * L.T, is_dW)
    .use(is_X_next)
    .put(found_dR)
    .use(found_dS)
    .put(is_A_L)
    .expand()
)

page("""The gain is gone. So the noises of an observable plant can be told apart exactly
    if, of the changes that one allows, none but zero is made of an `X`. Of any plant
    that is asked of what becomes of the changes: `T dQ T'`, `dR` and `T dS`.""")

silent_change = page.program(
    "a change of the noises that no record shows",
    (A, C, X, X_next),
    is_dQ,
    is_dR,
    is_dS,
)

change_step = page.program(
    "what an instant shows of a change of the noises",
    (A_L, C, L, dQ, dR, dS, X),
    is_dW,
    Stage(X_next, A_L * X * A_L.T + dW, symmetric=True, by=(is_X_next,)),
    is_dLambda,
    is_dN,
)
