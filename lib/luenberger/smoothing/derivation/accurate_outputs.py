"""Smoothed estimates that treat the accurate outputs as exact.

Of all estimates from the whole record that show what the accurate outputs show, the
best one is the smoothed estimate, pushed.  The push is that of the filter.

Source: our own; the push is that of the filter of Leondes and Novak (1974), (30)-(33).
"""

from sympy import Trace, symbols

from matrixproof import Identity, Page, ZeroMatrix

from .next_state import Sigma_s, U_next, e_s_next, letters, n, p, x_s

m1, r = symbols("m_1 r", integer=True, nonnegative=True)
letters = letters.here()
C = letters("C", p, n, "what is measured")
R = letters("R", p, p, "covariance of the measurement noise", symmetric=True)
e_s = letters("e_s", n, 1, "its error")
S_1 = letters("S_1", m1, p, "rows of the identity that pick the accurate outputs")
Gamma_1 = letters("Gamma_1", n, m1, "the direction in which accurate outputs push")
Gamma = letters("Gamma", n, p, "the same beside zeros for the other outputs")
Gamma_next = letters("Gamma_next", n, p, "the same one step on")
C_next = letters("C_next", p, n, "what is measured one step on")
Phat = letters("Phat", n, r, "basis of what the accurate outputs do not show")
W_e = letters("W_e", n, n, "weight of the error, positive definite", symmetric=True)
L_W = letters("L_W", n, n, "a root of the weight")
rho_s = letters("rho_s", p, 1, "what the smoothed estimate leaves of the measurement")
rho_s_next = letters("rho_s_next", p, 1, "the same one step on")
R_s = letters("R_s", p, p, "covariance of that", symmetric=True)
R_u = letters("R_u", p, p, "covariance of it and of the same one step on")
v = letters("v", p, 1, "measurement noise")
v_next = letters("v_next", p, 1, "measurement noise one step on")
z = letters("z", r, 1, "what is left free, made of the record")
Z_z = letters("Z_z", p, r, "covariance of the residual and the free part")
L_z = letters("L_z", r, r, "a root of the covariance of the free part")
x_c = letters("x_c", n, 1, "smoothed estimate that meets the accurate outputs")
Sigma_c = letters("Sigma_c", n, n, "covariance of its error", symmetric=True)
U_c = letters("U_c", n, n, "covariance of its errors at neighbours")

WITNESS = {Sigma_s: 0, Sigma_c: 2, U_next: 0, x_s: -1, x_c: 0}


page = Page(letters=letters, source="our own", witness=WITNESS)

page("""The residual of the smoothed estimate is the estimate of the measurement noise.
    It is made of the record, so it is uncorrelated with the smoothed error.""")
is_v = page.let(v, rho_s + C * e_s)
is_R = page.moment(v * v.T, R)
is_Sigma_s = page.moment(e_s * e_s.T, Sigma_s)
is_R_s = page.moment(rho_s * rho_s.T, R_s)
made = page.moment(rho_s * e_s.T, ZeroMatrix(p, n))
halves = page.suppose(R, R_s + C * Sigma_s * C.T)
page(
    letters.derive(
        "", "the covariance of the noise", (rho_s + C * e_s) * (rho_s + C * e_s).T
    )
    .fold(is_v)
    .expect(is_R)
)
says = "is that of what was found of it, and of the rest"
page(
    letters.derive("", says, (rho_s + C * e_s) * (rho_s + C * e_s).T)
    .expect(is_R_s, is_Sigma_s, made)
    .fold(halves)
)

page("""An estimate from the record that meets the accurate outputs differs from the
    smoothed one by the push, and by a part that they do not show. If the push is
    orthogonal to that part in the weight, nothing is gained by it.""")
is_Gamma = page.let(Gamma, Gamma_1 * S_1)
push = page.suppose(S_1 * C * Gamma_1, Identity(m1))
unseen = page.suppose(S_1 * C * Phat, ZeroMatrix(m1, r))
shortest = page.suppose(Gamma_1.T * W_e * Phat, ZeroMatrix(m1, r))
root_W = page.suppose(W_e, L_W * L_W.T)
is_Z = page.moment(rho_s * z.T, Z_z)
is_z = page.moment(z * z.T, L_z * L_z.T)
says = "such an estimate shows what the accurate outputs show"
page(
    letters.derive(
        "", says, S_1 * rho_s - S_1 * C * (Gamma_1 * S_1 * rho_s + Phat * z)
    ).use(push, unseen)
)
spread = page(
    letters.derive(
        "",
        "what it differs by has a covariance",
        (Gamma_1 * S_1 * rho_s + Phat * z) * (Gamma_1 * S_1 * rho_s + Phat * z).T,
    ).expect(is_R_s, is_Z, is_z)
)
says = "and costs least without the free part"
page(
    letters.derive("", says, Trace(W_e * spread.right))
    .use(shortest)
    .drop(root_W, of=L_z)
)

page("So the estimate is pushed, and its covariance grows by what the push lets in.")
pushed = page.let(x_c, x_s + Gamma_1 * S_1 * rho_s)
is_Sigma_c = page.let(Sigma_c, Sigma_s + Gamma * R_s * Gamma.T)
estimate = page(
    letters.derive("", "the estimate that meets the accurate outputs", x_c)
    .put(pushed)
    .fold(is_Gamma)
)
says = "the covariance of the pushed error"
page(
    letters.derive("", says, (e_s + Gamma * rho_s) * (e_s + Gamma * rho_s).T)
    .expect(is_Sigma_s, is_R_s, made)
    .fold(is_Sigma_c)
)
covariance = page(
    letters.derive("", "the same by the covariances that are there", Sigma_c)
    .put(is_Sigma_c)
    .by(Sigma_s + Gamma * (R - C * Sigma_s * C.T) * Gamma.T, halves)
)

page("""Neighbours are pushed by residuals that have something in common: the noises are
    white, so it is what the errors have in common, with the other sign.""")
is_v_next = page.let(v_next, rho_s_next + C_next * e_s_next)
white = page.moment(v_next * v.T, ZeroMatrix(p, p))
is_U = page.moment(e_s_next * e_s.T, U_next)
is_R_u = page.moment(rho_s_next * rho_s.T, R_u)
made_before = page.moment(e_s_next * rho_s.T, ZeroMatrix(n, p))
made_behind = page.moment(rho_s_next * e_s.T, ZeroMatrix(p, n))
says = "the noises of neighbours have nothing in common"
page(
    letters.derive("", says, (rho_s_next + C_next * e_s_next) * (rho_s + C * e_s).T)
    .fold(is_v, is_v_next)
    .expect(white)
)
opposite = page.suppose(R_u, -C_next * U_next * C.T)
says = "so the residuals have what the errors have, with the other sign"
page(
    letters.derive("", says, (rho_s_next + C_next * e_s_next) * (rho_s + C * e_s).T)
    .expect(is_R_u, is_U, made_before, made_behind)
    .use(opposite)
)
is_U_c = page.let(U_c, U_next + Gamma_next * R_u * Gamma.T)
page(
    letters.derive(
        "",
        "the covariance of pushed neighbours",
        (e_s_next + Gamma_next * rho_s_next) * (e_s + Gamma * rho_s).T,
    )
    .expect(is_U, is_R_u, made_before, made_behind)
    .fold(is_U_c)
)
neighbours = page(
    letters.derive("", "the same by what is there", U_c).put(is_U_c, opposite)
)
