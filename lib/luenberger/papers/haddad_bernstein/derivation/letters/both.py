"""Letters: both together."""

from . import each, l, letters, n, q, r, square

both = n + r
xt = letters("x_tilde", both, 1, "states of plant and estimator")
W = square("W", n + l, "their covariance")
Bt = letters("B_tilde", both, n + l, "how the additive noise reaches both")
At = letters("A_tilde", both, both, "moves both")
says = "what the noise of a parameter does to both"
At1 = letters("A_tilde_1", both, both, says, **each("A_tilde"))
Lt = letters("L_tilde", q, both, "how the error shows both")
Wt = square("W_tilde", both, "covariance of the additive noise; the paper's `V_tilde`")
Vt = square("V_tilde", both, "covariance of all noise of both")
Rt = square("R_tilde", both, "weight of both")
Qt = square("Q_tilde", both, "second moment of both")
Qt_next = square("Q_tilde_next", both, "the same one step on")
Pt = square("P_tilde", both, "its dual, the multiplier of the moment equation")
says = "what the noise of a parameter does to both, first columns"
F1 = letters("F_1", both, n, says, **each("F"))
Q1 = square("Q1", n, "second moment of the state")
Q12 = letters("Q12", n, r, "second moment of state and estimator")
Q2 = square("Q2", r, "second moment of the estimator, positive definite")
P1 = square("P1", n, "dual of `Q_1`")
P12 = letters("P12", n, r, "dual of `Q_12`")
P2 = square("P2", r, "dual of `Q_2`, positive definite")
