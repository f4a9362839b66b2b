"""Letters: canonical coordinates."""

from . import letters, m1, n, p, p2, r

C_1 = letters("C_1", m1, n, "rows of the accurate outputs")
L = letters("L", n - p, n, "rows that complete them")
H = letters("H", p, n, "what is measured, in canonical coordinates")
H_2 = letters("H_2", p2, r, "what the other outputs measure of the lower states")
q = letters("q", n, 1, "state in canonical coordinates")
v_1 = letters("v_1", m1, 1, "noise of the accurate outputs")
v_2 = letters("v_2", p2, 1, "noise of the other outputs")
K_1 = letters("K_1", r, m1, "gain of the accurate outputs")
K_2 = letters("K_2", r, p2, "gain of the other outputs")
K_low = letters("K_low", r, p, "both gains side by side")
N_low = letters("N_low", r, p, "lower rows of `N`")
Omega_11 = letters("Omega_11", m1, m1, "block of `Omega`", symmetric=True)
Omega_21 = letters("Omega_21", r, m1, "block of `Omega`")
Omega_22 = letters("Omega_22", r, r, "block of `Omega`", symmetric=True)
R_11 = letters("R_11", m1, m1, "block of `R`", symmetric=True)
R_21 = letters("R_21", p2, m1, "block of `R`")
R_22 = letters("R_22", p2, p2, "block of `R`", symmetric=True)
