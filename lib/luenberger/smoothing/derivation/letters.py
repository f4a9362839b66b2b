"""The letters of smoothing, each with its size and what it stands for.

A plus below is the next instant; what has no mark is at one instant, i.  An `s` below
is an estimate from the whole record, or its error.  Errors are estimate less truth.
Process noise and its covariance are what is left once the measurement noise has told
its part; the two are then independent.
"""

from sympy import symbols

from matrixproof import Identity, Notation

SOURCE = "our own; Rauch, Tung and Striebel (1965)"

n, p, m, k, q = symbols("n p m k q", integer=True, nonnegative=True)
letters = Notation()
I = Identity(n)

# -- the plant, and the filter's pass over it ------------------------------------------

As = letters("As", n, n, "moves the error of an estimate to the next instant")
C = letters("C", p, n, "what is measured")
Q = letters("Q", n, n, "covariance of the process noise that is left", symmetric=True)
R = letters("R", p, p, "covariance of the measurement noise", symmetric=True)
w = letters("w", n, 1, "process noise that is left")
x = letters("x", n, 1, "the filter's estimate")
x_minus_next = letters("x_minus_next", n, 1, "its prediction one step on")
e = letters("e", n, 1, "error of the filter's estimate")
e_minus_next = letters("e_minus_next", n, 1, "error of its prediction one step on")
Sigma = letters("Sigma", n, n, "covariance of the estimate's error", symmetric=True)
Omega_next = letters("Omega_next", n, n, "the same one step on", symmetric=True)

# -- what the rest of the record adds --------------------------------------------------

x_s = letters("x_s", n, 1, "smoothed estimate")
x_s_next = letters("x_s_next", n, 1, "smoothed estimate one step on")
e_s_next = letters("e_s_next", n, 1, "its error one step on")
Sigma_s = letters("Sigma_s", n, n, "covariance of its error", symmetric=True)
Sigma_s_next = letters("Sigma_s_next", n, n, "the same one step on", symmetric=True)
U_next = letters("U_next", n, n, "covariance of both errors, `E[e_s_next e_s']`")
G = letters("G", n, n, "gain of a smoother")
T = letters("T", n, n, "covariance of the next prediction's error and the estimate's")
lamda_next = letters("lamda_next", n, 1, "the same one step on")
