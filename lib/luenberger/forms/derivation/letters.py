"""The letters of an observer in two systems of coordinates."""

from sympy import symbols

from matrixproof import Identity, Notation

n, r, m, p, q, s = symbols("n r m p q s", integer=True, positive=True)
letters = Notation()
I = Identity(r)

# -- the plant and its observer --------------------------------------------------------

C = letters("C", p, n, "what is measured")
E = letters("E", p, m, "what the known input does to the measurement")
L = letters("L", q, n, "what is estimated")
F = letters("F", r, r, "moves the observer")
P = letters("P", q, r, "what the estimate takes from the observer")
V = letters("V", q, p, "what the estimate takes from the measurement")
W = letters("W", q, m, "what the estimate takes from the known input")
T = letters("T", r, n, "what the observer follows")
z = letters("z", r, 1, "state of the observer")
u = letters("u", m, 1, "known input")
y = letters("y", p, 1, "measurement")
w_hat = letters("w_hat", q, 1, "estimate")

# -- other coordinates -----------------------------------------------------------------

S = letters("S", r, r, "changes the coordinates")
U = letters("U", r, r, "changes them back")
F_S = letters("F_S", r, r, "`F` in the new coordinates")
P_S = letters("P_S", q, r, "`P` in the new coordinates")
