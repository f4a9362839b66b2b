"""The error covariance is a quadratic in the gain, and the Kalman filter its minimum.

A prediction has one covariance whatever the gain, and the next measurement corrects
it.  Multiplied out and completed to a square, the covariance shows which gain is best.

Source: Leondes and Novak (1974), section III, (27)-(33), in any coordinates.
"""

from sympy import Trace

from matrixproof import Identity, Page, ZeroMatrix

from .letters import SOURCE, I, letters, n, p
from .letters.accurate import L_M, W_e
from .letters.plant import A, C, Q, R, v_next, w
from .letters.step import K, Kmv, M, N, Omega, Sigma, Sigma_next, Y, e

letters = letters.here()
e_minus = letters("e_minus", n, 1, "error of the prediction")
e_next = letters("e_next", n, 1, "error of the estimate one step on")


def joseph(K, C, Omega, R):
    """Covariance of (I - K C) e + K v, for any gain."""
    Y = Identity(K.shape[0]) - K * C
    return Y * Omega * Y.T + K * R * K.T


page = Page(letters=letters, source=f"{SOURCE}, section III")

page("""A prediction errs by `A e - w`, where `e` is the error of the estimate that is
    moved on. Noise is independent of everything that was measured before it.""")
is_Sigma = page.moment(e * e.T, Sigma, "27")
is_Q = page.moment(w * w.T, Q, "4")
apart = page.moment(e * w.T, ZeroMatrix(n, n))
is_Omega = page.let(Omega, A * Sigma * A.T + Q, "44")
page(
    letters.derive(
        "28, 44", "the covariance of a prediction", (A * e - w) * (A * e - w).T
    )
    .expect(is_Sigma, is_Q, apart)
    .fold(is_Omega)
)

page("""The next measurement corrects it. For any gain `K` an unbiased estimate errs as
    follows, so its covariance has two terms.""")
is_e_next = page.let(e_next, Y * e_minus + K * v_next, "26")
is_e_minus = page.moment(e_minus * e_minus.T, Omega)
is_R = page.moment(v_next * v_next.T, R, "4")
fresh = page.moment(e_minus * v_next.T, ZeroMatrix(n, p))
is_Sigma_next = page.let(Sigma_next, Y * Omega * Y.T + K * R * K.T, "27")
page(
    letters.derive("27", "the covariance of the error, for any gain", e_next * e_next.T)
    .put(is_e_next)
    .expect(is_e_minus, is_R, fresh)
    .fold(is_Sigma_next)
)

page("Multiplied out it is a quadratic in the gain. Three composites get letters.")
is_Y = page.let(Y, I - K * C, "13")
is_M = page.let(M, C * Omega * C.T + R, "33")
is_N = page.let(N, Omega * C.T, "33")
multiplied = page(
    letters.derive(
        "27–29", "the error covariance is a quadratic in the gain", Sigma_next
    )
    .put(is_Sigma_next)
    .put(is_Y)
    .expand()
    .fold(is_M)
    .fold(is_N)
)

page("""The gradient of the weighted trace vanishes where `K M = N`: that is (32), which
    the gain `K_mv` solves.""")
slope = page(
    letters.derive("32", "the gradient in the gain", Trace(W_e * Sigma_next))
    .put(multiplied)
    .gradient(K)
)
is_Kmv = page(slope.solve(K, "33", name=Kmv))

page("""A quadratic can be completed to a square. Only the last term has `K` in it, and
    it is never negative. Without a condition on the gain `K_mv` is therefore best, for
    the trace and for every weight: that is the Kalman filter.""")
square = page(
    letters.derive("33", "the completed square", Sigma_next)
    .put(multiplied)
    .square(K, is_Kmv)
)
root_M = page.suppose(M, L_M * L_M.T)
page(
    letters.derive(
        "33", "no gain does better than the Kalman filter's", square.right
    ).drop(root_M)
)
