"""Letters: the theorem."""

from . import l, letters, n, q, r, square

xh = letters("xhat", n, 1, "what the estimator says of the state, `G' x_e`")
G = letters("G", r, n, "`G'` lifts the state of the estimator")
Gam = letters("Gam", r, n, "the estimator tracks `Gamma x`")
tau = letters("tau", n, n, "the optimal projection")
tau_perp = letters("tau_perp", n, n, "what it leaves, `I - tau`")
Q = square("Q", n, "covariance of the error of `xhat`")
Q_e = square("Q_e", n, "second moment of `xhat`; the hat of section 4")
P_e = square("P_e", n, "its dual; the hat of section 4")
Qh = square("Qh", n, "the theorem's; in script in section 4")
Ph = square("Ph", n, "its dual; in script in section 4")
Qs = letters("Qs", n, l, "covariance of next state and innovation")
V2s = square("V2s", l, "covariance of the innovation, positive definite")
Kq = letters("Kq", n, l, "gain of the innovation")
Aq = letters("Aq", n, n, "moves the error of `xhat`")
Lq = letters("Lq", q, n, "what the static gain leaves of `L`")
