"""How far two filters are apart behind rows that they filter alike.

After rows with one gain other outputs arrive, or none do, and the recursion runs again.
It begins at a covariance that differs a little from that of the full recursion.  If
each is at most `1 + g` times the other, it stays so in every row, whatever arrives.
The estimates then drift apart slowly.

Source: our own.
"""

from matrixproof import Identity, Page

from .letters import I, letters, n, p
from .letters.accurate import Gamma
from .letters.plant import As, C, Qs, R
from .letters.step import K, Kmv, M, N, Omega, Sigma, Sigma_next
from .quadratic import is_Kmv, is_M, is_N

ratio = letters.here(
    Omega="covariance of the prediction",
    Sigma="covariance of the estimate",
    Sigma_next="covariance of the next estimate",
    K="the gain",
)
Sigma_f = ratio("Sigma_f", n, n, "that of the full recursion", symmetric=True)
Omega_f = ratio("Omega_f", n, n, "the same of its prediction", symmetric=True)
M_f = ratio("M_f", p, p, "the same of its innovation", symmetric=True)
N_f = ratio("N_f", n, p, "the same of its prediction and innovation")
Kmv_f = ratio("Kmv_f", n, p, "its gain of minimum variance")
W_a = ratio("W_a", n, p, "what accurate outputs add to the gain")
W_f = ratio("W_f", n, p, "the same in the full recursion")
R_s = ratio("R_s", n, n, "a root of `(1 + g) Sigma - Sigma_f`")
R_o = ratio("R_o", n, n, "a root of `(1 + g) Omega - Omega_f`")
R_u = ratio("R_u", n, n, "a root of `(1 + g) Omega_f - Omega`")
R_m = ratio("R_m", p, p, "a root of `(1 + g) M_f - M`")
R_Q = ratio("R_Q", n, n, "a root of `Qs`")
R_R = ratio("R_R", p, p, "a root of `R`")
R_M = ratio("R_M", p, p, "a root of `M`")
R_f = ratio("R_f", p, p, "a root of `M_f`")
g = ratio.scalar("g", "by how much the ratio is more than one", positive=True)


def joseph(X, covariance):
    """The covariance that a gain X leaves."""
    Y = I - X * C
    return Y * covariance * Y.T + X * R * X.T


page = Page(letters=ratio, source="our own")

page("""Let `Sigma_f` be at most `(1 + g) Sigma`. Noise is the same in both, so a
    prediction keeps the ratio.""")
is_Omega = page.let(Omega, As * Sigma * As.T + Qs, "44")
is_Omega_f = page.let(Omega_f, As * Sigma_f * As.T + Qs, "44")
is_R_Q = page.suppose(Qs, R_Q * R_Q.T)
is_R_s = page.suppose((1 + g) * Sigma, Sigma_f + R_s * R_s.T)
page(
    ratio.derive("", "a prediction keeps the ratio", (1 + g) * Omega)
    .put(is_Omega)
    .by(As * Sigma_f * As.T + As * R_s * (As * R_s).T + Qs + g * Qs, is_R_s)
    .drop(of=R_s)
    .drop(is_R_Q, of=g)
    .fold(is_Omega_f)
)

page("""So does a reading: any gain makes of both covariances what keeps the ratio, and
    no gain leaves less than the gain of minimum variance.""")
page(is_N, is_M, is_Kmv)
is_N_f = page.let(N_f, Omega_f * C.T)
is_M_f = page.let(M_f, C * Omega_f * C.T + R)
is_Kmv_f = page.suppose(Kmv_f * M_f, N_f)
is_R_f = page.suppose(M_f, R_f * R_f.T)
is_R_R = page.suppose(R, R_R * R_R.T)
is_R_o = page.suppose((1 + g) * Omega, Omega_f + R_o * R_o.T)
page(
    ratio.derive("", "a reading keeps the ratio", (1 + g) * (Omega - N * Kmv.T))
    .by((1 + g) * joseph(Kmv, Omega), is_N, is_M, is_Kmv)
    .insert(joseph(Kmv, Omega_f + R_o * R_o.T) + g * Kmv * R * Kmv.T, is_R_o)
    .drop(is_R_R, of=g)
    .by(joseph(Kmv, Omega_f) + (I - Kmv * C) * R_o * ((I - Kmv * C) * R_o).T)
    .drop(of=R_o)
    .expand()
    .fold(is_M_f, is_N_f)
    .square(Kmv, is_Kmv_f)
    .drop(is_R_f)
)

page("""Accurate outputs cost `W_a M W_a'` beside that, where `W_a M = Gamma R`. It
    grows where `M` shrinks; but `M` keeps the ratio too, in either direction.""")
noise = page(
    ratio.derive("", "what is left of accurate outputs", (Identity(p) - C * Kmv) * M)
    .use(is_Kmv)
    .put(is_M, is_N)
    .expand()
)
is_W_a = page.let(W_a, Gamma - Gamma * C * Kmv)
cost = page(
    ratio.derive("", "what accurate outputs add to the gain", W_a * M)
    .put(is_W_a)
    .use(noise)
)
is_W_f = page.suppose(W_f * M_f, Gamma * R)
is_R_M = page.suppose(M, R_M * R_M.T)
is_R_m = page.suppose((1 + g) * M_f, M + R_m * R_m.T)
more = W_f - (1 + g) * W_a
says = "what accurate outputs cost keeps the ratio"
parts = more * M * more.T + W_f * R_m * R_m.T * W_f.T
page(
    ratio.derive("", says, (1 + g) ** 2 * W_a * M * W_a.T)
    .by((1 + g) * W_f * M_f * W_f.T + parts, cost, is_W_f, is_R_m)
    .drop(is_R_M, of=W_a)
    .drop(of=R_m)
)

page("""With `Sigma` and `Sigma_f` in each other's place the same holds in the other
    direction. So the predictions differ by no more than `g Omega`. A difference of
    estimates does not grow, measured by the covariances: not from a prediction to its
    estimate, and not from there to the next prediction.""")
is_R_u = page.suppose((1 + g) * Omega_f, Omega + R_u * R_u.T)
page(
    ratio.derive("", "how far the predictions differ from below", g * Omega)
    .by((1 + g) * (Omega - Omega_f) + R_u * R_u.T, is_R_u)
    .drop(of=R_u)
)
is_Joseph = page.let(Sigma_next, joseph(K, Omega), "27")
says = "a reading makes no difference larger"
page(ratio.derive("", says, Sigma_next).put(is_Joseph).drop(is_R_R))
page(ratio.derive("", "nor does a prediction", Omega).put(is_Omega).drop(is_R_Q))
