"""Letters: the observer."""

from . import letters, m, n, p, r

F = letters("F", r, r, "moves the observer")
G = letters("G", r, m, "what the input does to the observer")
D = letters("D", r, p, "what the measurement does to the observer")
T = letters("T", r, n, "what the observer follows")
T_next = letters("T_next", r, n, "what the observer follows one step on")
P = letters("P", n, r, "weight of the observer in the estimate")
V = letters("V", n, p, "weight of the measurement in the estimate")
W = letters("W", n, m, "weight of the input in the estimate; zero in the paper")
z = letters("z", r, 1, "observer")
z_next = letters("z_next", r, 1, "observer one step on")
eps = letters("varepsilon", r, 1, "error of the observer")
eps_next = letters("varepsilon_next", r, 1, "error of the observer one step on")
x_hat = letters("x_hat", n, 1, "estimate")
x_hat_next = letters("x_hat_next", n, 1, "estimate one step on")
X = letters("X", r, r, "covariance of the observer's error", symmetric=True)
X_next = letters("X_next", r, r, "the same one step on", symmetric=True)
