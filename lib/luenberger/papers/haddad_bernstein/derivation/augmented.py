"""Plant and estimator as one system, and its second moment.

An estimator of any order moves with the plant.  Both together have a second moment.
The noise in the plant's parameters adds to the additive noise.

Source: Haddad and Bernstein (1987), sections 2 to 4, (3.1)-(3.3), (4.1)-(4.4).
"""

from functools import cache

from matrixproof import (
    BlockMatrix,
    Page,
    ZeroMatrix,
)

from .letters import SOURCE, I, assign, each, l, letters, listed, n, r, sum_i
from .letters.both import F1, Q1, Q2, Q12, At, At1, Bt, Qt, Qt_next, Vt, W, Wt, both, xt
from .letters.estimator import Ae, Be, xe, xe_next
from .letters.kernels import N2, N12, Qxy, Qxy_next, Qyy, X, u, v
from .letters.plant import A1, C1, V1, V2, V12, W1, W2, W12, A, C, w2, x, x_nu, y

letters = letters.here()
x_next = letters("x_next", n, 1, "state one step on")
w1 = letters("w_1", n, 1, "process noise")
says = "state of the estimator, times the noise of a parameter"
xe_nu = letters("x_e_nu", r, 1, says, **each("x_e_nu"))
xt_next = letters("x_tilde_next", both, 1, "the same one step on")
says = "states of both, times the noise of a parameter"
xt_nu = letters("x_tilde_nu", both, 1, says, **each("x_tilde_nu"))
w = letters("w", n + l, 1, "`w_1` and `w_2`, one under the other")
wt = letters("w_tilde", both, 1, "additive noise of both")
Q1_next = letters(
    "Q1_next", n, n, "second moment of the state one step on", symmetric=True
)
says = "what the pair adds to `V_1`"
dV1 = letters("dV1", n, n, says, symmetric=True, **each("dV_1"))
says = "what the pair adds to `V_12`"
dV12 = letters("dV12", n, l, says, **each("dV_12"))
says = "what the pair adds to `V_2`"
dV2 = letters("dV2", l, l, says, symmetric=True, **each("dV_2"))


def average(number, says, left, moments, named):
    """The expectation of a product, and the letter that it has."""
    return page(letters.derive(number, says, left).expect(*moments).fold(named))


page = Page(letters=letters, source=SOURCE)

page("""The parameters of the plant are noisy: white noises of unit variance multiply
    the pairs `A_i`, `C_i`, of which there may be any number. A sum over i has a term
    for each of them; an equation between such sums is proved for one member that stands
    for each. The product of such a noise with the state has a letter of its own,
    `x_nu`, with the index i. The estimator sees the measurement alone.""")
is_x_next = page.let(x_next, A * x + sum_i * A1 * x_nu + w1, "3.1")
is_y = page.let(y, C * x + sum_i * C1 * x_nu + w2, "3.2")
is_xe_next = page.let(xe_next, Ae * xe + Be * y, "3.3")

page("Plant and estimator together move as one system.")
is_xt = page.let(xt, BlockMatrix([[x], [xe]]), "4.1")
is_xt_next = page.let(xt_next, BlockMatrix([[x_next], [xe_next]]), "4.1")
is_xt_nu = page.let(xt_nu, BlockMatrix([[x_nu], [xe_nu]]))
is_w = page.let(w, BlockMatrix([[w1], [w2]]))
is_Bt = page.let(Bt, BlockMatrix([[I, ZeroMatrix(n, l)], [ZeroMatrix(r, n), Be]]))
is_wt = page.let(wt, Bt * w, "section 2")
is_At = page.let(At, BlockMatrix([[A, ZeroMatrix(n, r)], [Be * C, Ae]]), "section 2")
is_At1 = page.let(
    At1,
    BlockMatrix([[A1, ZeroMatrix(n, r)], [Be * C1, ZeroMatrix(r, r)]]),
    "section 2",
)
together = page(
    letters.derive("4.1", "plant and estimator as one system", is_xt_next)
    .put(is_xe_next, is_y, is_x_next)
    .by(
        At * xt + sum_i * At1 * xt_nu + wt,
        *(is_At, is_At1, is_xt, is_xt_nu, is_wt, is_Bt, is_w),
    )
)

page("""The noises of the parameters are independent of each other and of the state that
    they multiply, and all noise is white. So all terms are uncorrelated, and what such
    a noise multiplies has the second moment of the state. The product of two sums is a
    sum over two members, and those terms of it are left in which the two are one.""")
is_Q = page.moment(xt * xt.T, Qt, "4.2")
is_Q_nu = page.moment(xt_nu * xt_nu.T, Qt)
alone = page.moment(xt_nu * xt_nu.other.T, ZeroMatrix(both, both))
apart = page.moment(xt * xt_nu.T, ZeroMatrix(both, both))
white = page.moment(xt * wt.T, ZeroMatrix(both, both))
white_nu = page.moment(xt_nu * wt.T, ZeroMatrix(both, both))
is_wwt = page.moment(wt * wt.T, Wt, "section 2")
page(
    letters.derive("4.3", "the second moment one step on", xt_next * xt_next.T)
    .put(together)
    .expect(is_Q, is_Q_nu, alone, apart, white, white_nu, is_wwt)
)

page("""In the steady state the moment is the same one step on. It exists if both
    systems are stable in mean square; lemma 4.1 says when they are.""")
is_steady = page.steady(Qt, At * Qt * At.T + sum_i * At1 * Qt * At1.T + Wt, "4.4")

page("""Block by block, the parameters' noise only adds to the covariances of the
    additive noise. What it adds depends on `Q_1`, which no estimator changes. From here
    on `V_1`, `V_12` and `V_2` are these sums.""")
is_Qt = page.suppose(Qt, BlockMatrix([[Q1, Q12], [Q12.T, Q2]]))
is_ww = page.moment(w * w.T, W)
is_W = page.suppose(W, BlockMatrix([[W1, W12], [W12.T, W2]]))
is_Wt = page.suppose(
    Wt,
    BlockMatrix([[W1, W12 * Be.T], [Be * W12.T, Be * W2 * Be.T]]),
    "section 2",
)
page(
    letters.derive("section 2", "the covariance of the additive noise", wt * wt.T)
    .use(is_wt)
    .expect(is_ww)
    .by(Wt, is_Wt, is_Bt, is_W)
)
is_F = page.let(F1, BlockMatrix([[A1], [Be * C1]]))
is_Vt = page.let(Vt, BlockMatrix([[V1, V12 * Be.T], [Be * V12.T, Be * V2 * Be.T]]))
is_V1 = page.let(V1, W1 + sum_i * A1 * Q1 * A1.T)
is_V12 = page.let(V12, W12 + sum_i * A1 * Q1 * C1.T)
is_V2 = page.let(V2, W2 + sum_i * C1 * Q1 * C1.T)
says = "the noise of the parameters is additive noise"
noise = page(
    letters.derive("4.4", says, sum_i * At1 * Qt * At1.T + Wt)
    .by(sum_i * F1 * Q1 * F1.T + Wt, is_At1, is_Qt, is_F, is_Wt)
    .by(Vt, is_F, is_Wt, is_Vt, is_V1, is_V12, is_V2)
)

page("""Each pair `A_i`, `C_i` adds the covariance of what it does to the state and the
    measurement.""")
is_X = page.moment(x_nu * x_nu.T, X)
is_dV1 = page.let(dV1, A1 * X * A1.T)
is_dV12 = page.let(dV12, A1 * X * C1.T)
is_dV2 = page.let(dV2, C1 * X * C1.T)
says = "a pair adds noise to the state"
adds_1 = average("4.4", says, A1 * x_nu * (A1 * x_nu).T, [is_X], is_dV1)
says = "and noise that state and measurement have in common"
adds_12 = average("4.4", says, A1 * x_nu * (C1 * x_nu).T, [is_X], is_dV12)
says = "and noise to the measurement"
adds_2 = average("4.4", says, C1 * x_nu * (C1 * x_nu).T, [is_X], is_dV2)

page("""With all noise in `u` and `v`, the measurement has these second moments. No
    estimator changes them.""")
is_xx = page.moment(x * x.T, Q1)
is_uv = page.moment(u * v.T, V12)
is_vv = page.moment(v * v.T, V2)
fresh = page.moment(x * v.T, ZeroMatrix(n, l))
past = page.moment(u * x.T, ZeroMatrix(n, n))
is_Qxy = page.let(Qxy, Q1 * C.T)
is_Qxy_next = page.let(Qxy_next, A * Q1 * C.T + V12)
is_Qyy = page.let(Qyy, C * Q1 * C.T + V2)
seen = C * x + v
says = "state and measurement"
with_now = average("3.2", says, x * seen.T, [is_xx, fresh], is_Qxy)
says = "next state and measurement"
moving = [is_xx, is_uv, fresh, past]
with_next = average("3.2", says, (A * x + u) * seen.T, moving, is_Qxy_next)
says = "the measurement with itself"
with_itself = average("3.2", says, seen * seen.T, [is_xx, is_vv, fresh], is_Qyy)

page("The state has a second moment of its own, whatever the estimator.")
is_uu = page.moment(u * u.T, V1)
is_Q1_next = page.let(Q1_next, A * Q1 * A.T + V1, "4.3")
says = "the state one step on"
moving = [is_xx, is_uu, past]
moves = average("4.3", says, (A * x + u) * (A * x + u).T, moving, is_Q1_next)

page("So (4.4) has three blocks, the first of them the plant's own.")
is_N12 = page.let(N12, Qxy_next * Be.T)
is_N2 = page.let(N2, Be * C * Q12 * Ae.T + (Be * C * Q12 * Ae.T).T + Be * Qyy * Be.T)
is_Qt_next = page.let(
    Qt_next,
    BlockMatrix(
        [
            [A * Q1 * A.T + V1, A * Q12 * Ae.T + N12],
            [Ae * Q12.T * A.T + N12.T, Ae * Q2 * Ae.T + N2],
        ]
    ),
)
step = page(
    letters.derive("4.3", "one step of the moment by blocks", At * Qt * At.T + Vt).by(
        Qt_next, is_Qt_next, is_At, is_Qt, is_Vt, is_Qxy_next, is_Qyy, is_N12, is_N2
    )
)
moments = page(
    letters.derive("4.6", "the moment equation by blocks", is_Qt.right)
    .fold(is_Qt)
    .put(is_steady)
    .use(noise)
    .use(step)
    .put(is_Qt_next)
)
own = page(letters.derive("4.4", "the moment of the plant is its own", Q1).put(moments))


@cache
def equivalent_noise():
    """What one pair (A1, C1) adds to V1, V12 and V2; X is the second moment of x."""
    stages = [assign(letters, r, "(4.4)") for r in (is_dV1, is_dV12, is_dV2)]
    return listed(
        letters,
        (A1, C1, X),
        stages,
        "what a pair adds to the noise",
        adds_1,
        adds_12,
        adds_2,
    )


page(equivalent_noise())


@cache
def moment_ahead():
    """The second moment of the state one step on; V1 is the covariance of all noise."""
    stages = [assign(letters, is_Q1_next, "(4.3)")]
    return listed(
        letters, (A, Q1, V1), stages, "the moment of the state, one step", moves
    )


page(moment_ahead())


@cache
def both_systems():
    """Plant and estimator as one system, and the additive noise that drives it."""
    stages = [assign(letters, r, "section 2") for r in (is_At, is_At1, is_Wt)]
    given = (A, C, A1, C1, W1, W12, W2, Ae, Be)
    return listed(letters, given, stages, "plant and estimator as one system", together)


page(both_systems())


@cache
def output_moments():
    """E[x y'], E[x+ y'] and E[y y'], which no estimator changes."""
    stages = [assign(letters, r) for r in (is_Qxy, is_Qxy_next, is_Qyy)]
    return listed(
        letters,
        (A, C, V12, V2, Q1),
        stages,
        "second moments with the measurement",
        with_now,
        with_next,
        with_itself,
    )


page(output_moments())


@cache
def estimator_moments():
    """Right sides of Q12 = A Q12 Ae' + N12 and of Q2 = Ae Q2 Ae' + N2."""
    stages = [assign(letters, r, "(4.6)") for r in (is_N12, is_N2)]
    given = (C, Qyy, Qxy_next, Ae, Be, Q12)
    return listed(
        letters,
        given,
        stages,
        "what drives the moments of an estimator",
        step,
        moments,
    )


page(estimator_moments())
