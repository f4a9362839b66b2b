"""Letters: the estimator."""

from . import l, letters, q, r, square

xe = letters("x_e", r, 1, "state of the estimator")
xe_next = letters("x_e_next", r, 1, "state of the estimator one step on")
ye = letters("y_e", q, 1, "estimate of `L x`")
e = letters("e", q, 1, "error of the estimate")
Ae = letters("Ae", r, r, "moves the estimator")
Be = letters("Be", r, l, "what a measurement does to the estimator")
Ce = letters("Ce", q, r, "what the estimator says")
De = letters("De", q, l, "static gain from measurement to estimate")
GAINS = (Ae, Be, Ce, De)
Sigma = square("Sigma", q, "covariance of the error")
J = letters("J", q, q, "its product with the weight; the trace is the cost")
