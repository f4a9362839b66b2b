"""Letters: accurate outputs."""

from . import letters, m1, n, p, r

S1 = letters("S_1", m1, p, "rows of the identity that pick the accurate outputs")
Gamma_1 = letters("Gamma_1", n, m1, "the direction in which accurate outputs push")
Gamma = letters("Gamma", n, p, "the same beside zeros for the other outputs")
Phat = letters("Phat", n, r, "basis of what the accurate outputs do not show")
That = letters("That", r, n, "reads the coordinates in that basis")
Z = letters("Z", r, p, "what is left free")
Delta = letters("Delta", m1, p, "what the Kalman filter leaves of the accurate outputs")
W_e = letters("W_e", n, n, "weight of the error", symmetric=True)
L_M = letters("L_M", p, p, "a root of `M`")
