"""Letters: the plant."""

from . import each, l, letters, n, q, square

x = letters("x", n, 1, "state")
y = letters("y", l, 1, "measurement")
A = letters("A", n, n, "moves the state")
C = letters("C", l, n, "what is measured")
says = "what the noise of a parameter does to the state"
A1 = letters("A1", n, n, says, **each("A"))
says = "what the noise of a parameter does to the measurement"
C1 = letters("C1", l, n, says, **each("C"))
w2 = letters("w_2", l, 1, "measurement noise")
x_nu = letters("x_nu", n, 1, "state, times the noise of a parameter", **each("x_nu"))
W1 = square("W_1", n, "covariance of `w_1`; the paper's `V_1`")
W12 = letters("W_12", n, l, "covariance of `w_1` and `w_2`; the paper's `V_12`")
W2 = square("W_2", l, "covariance of `w_2`; the paper's `V_2`")
V1 = square("V1", n, "covariance of all noise that moves the state")
V12 = letters("V12", n, l, "covariance of all noise in state and measurement")
V2 = square("V2", l, "covariance of all noise in the measurement")
L = letters("L", q, n, "what is to be estimated is `L x`")
R = square("R", q, "weight of the error, positive definite")
