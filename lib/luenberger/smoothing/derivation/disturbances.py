"""The noises that the record shows: estimates of both from all measurements.

What later rows say of the next prediction, they say of the process noise in it.  The
measurement noise is what the smoothed estimate leaves of the measurement.  Outputs that
did not arrive have noise too, of which the others tell a part.

Source: our own.
"""

from sympy import symbols

from matrixproof import Page, ZeroMatrix

from ...theory import regression
from .adjoint import is_lamda_next, letters
from .next_state import (
    Omega_next,
    Q,
    apart,
    e,
    e_minus_next,
    is_Q,
    moves,
    n,
    p,
    w,
    x_minus_next,
    x_s_next,
)

pa = symbols("p_a", integer=True, nonnegative=True)
letters = letters.here()
v_seen = letters("v_seen", pa, 1, "their noise")
rho_s = letters("rho_s", pa, 1, "what the smoothed estimate leaves of them")
v = letters("v", p, 1, "measurement noise, of all outputs")
v_left = letters("v_left", p, 1, "the part of it of which the others do not tell")
R_seen = letters("R_seen", pa, pa, "covariance of `v_seen`", symmetric=True)
R_all = letters("R_all", p, pa, "covariance of `v` and `v_seen`")
J = letters("J", n, pa, "what `v_seen` tells of the process noise")
J_v = letters("J_v", p, pa, "what it tells of `v`")
w_all = letters("w_all", n, 1, "process noise")
S = letters("S", n, p, "covariance of `w_all` and `v`")
S_left = letters("S_left", n, p, "covariance of `w` and `v_left`")
G_w = letters("G_w", n, n, "gain for the process noise")
G_v = letters("G_v", p, n, "gain for the measurement noise")
w_s = letters("w_s", n, 1, "smoothed process noise")
v_s = letters("v_s", p, 1, "smoothed measurement noise")


page = Page(letters=letters, source="our own")

page("""The next prediction errs by the process noise, among others. A gain takes out of
    the noise all that the next state would show of it.""")
page(moves, is_Q, apart)
is_G_w = page.suppose(G_w * Omega_next, Q)
ahead = page.moment(e_minus_next * e_minus_next.T, Omega_next)
in_the_way = page(
    letters.derive("", "the process noise in the next prediction", w * e_minus_next.T)
    .put(moves)
    .expect(is_Q, apart)
)
common = page.moment(w * e_minus_next.T, -Q)
by_next = dict(e=w, y=e_minus_next, M=Omega_next, N=-Q, G=-G_w)
says = "what is left of it is uncorrelated with the prediction's error"
page.at("", says, regression.apart, d=w + G_w * e_minus_next, **by_next)

page("The smoothed estimate takes the place of the next state, and no gain is found.")
page(is_lamda_next)
process = page(
    letters.derive(
        "", "the process noise that is left, smoothed", G_w * (x_s_next - x_minus_next)
    ).use(is_lamda_next, is_G_w)
)


page("""The measurement's equation holds for estimates as well, so the noise of what
    arrived is what the smoothed estimate leaves of it. Of the other noises it tells a
    part, through `J` and `J_v`.""")
whole = page.let(w_all, J * v_seen + w)
parts = page.let(v, J_v * v_seen + v_left)
tells = page.suppose(J_v * R_seen, R_all)
is_R_seen = page.moment(v_seen * v_seen.T, R_seen)
is_R_all = page.moment(v * v_seen.T, R_all)
by_seen = dict(e=v, y=v_seen, M=R_seen, N=R_all, G=J_v, d=v_left)
page.at("", "the rest is uncorrelated with what arrived", regression.apart, **by_seen)
is_S = page.moment(w_all * v.T, S)
is_S_left = page.let(S_left, S - J * R_all.T)
independent = page.moment(w * v_seen.T, ZeroMatrix(n, pa))
says = "what the process noise has in common with the rest"
page(
    letters.derive("", says, (w_all - J * v_seen) * (v - J_v * v_seen).T)
    .by((w_all - J * v_seen) * v.T - w * v_seen.T * J_v.T, whole)
    .expect(is_S, is_R_all, independent)
    .fold(is_S_left)
)

page("So the rest is seen in the next prediction as the process noise is.")
is_G_v = page.suppose(G_v * Omega_next, S_left.T)
is_common = page.moment(w * v_left.T, S_left)
not_yet = page.moment(e * v_left.T, ZeroMatrix(n, p))
page(
    letters.derive("", "the rest in the next prediction", v_left * e_minus_next.T)
    .put(moves)
    .expect(is_common, not_yet)
    .fold(is_G_v)
)
rest = page(
    letters.derive("", "the rest, smoothed", G_v * (x_s_next - x_minus_next)).use(
        is_lamda_next, is_G_v
    )
)

page("Both noises are put together again.")
is_w_s = page.let(w_s, J * rho_s + G_w * (x_s_next - x_minus_next))
is_v_s = page.let(v_s, J_v * rho_s + G_v * (x_s_next - x_minus_next))
page(letters.derive("", "the process noise, smoothed", w_s).put(is_w_s).use(process))
page(letters.derive("", "the measurement noise, smoothed", v_s).put(is_v_s).use(rest))
