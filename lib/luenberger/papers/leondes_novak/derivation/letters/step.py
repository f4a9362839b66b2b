"""Letters: the step from one instant to the next."""

from . import letters, n, p

e = letters("e", n, 1, "error of the estimate")
Sigma = letters("Sigma", n, n, "covariance of the error", symmetric=True)
Sigma_next = letters("Sigma_next", n, n, "the same one step on", symmetric=True)
Omega = letters("Omega", n, n, "covariance of the predicted error", symmetric=True)
M = letters("M", p, p, "covariance of the innovation", symmetric=True)
N = letters("N", n, p, "covariance of the predicted error and the innovation")
K = letters("K", n, p, "any gain")
Kmv = letters("Kmv", n, p, "gain of minimum variance: the Kalman filter's")
Y = letters("Y", n, n, "what the gain leaves of a predicted error")
