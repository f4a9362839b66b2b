"""Letters: what the kernels call them."""

from . import l, letters, n, q, r, square
from .both import P2, P12, Q2, Q12
from .estimator import GAINS

Qxy = letters("Qxy", n, l, "second moment of state and measurement")
Qxy_next = letters("Qxy_next", n, l, "second moment of next state and measurement")
Qyy = square("Qyy", l, "second moment of the measurement")
S_e = letters("S_e", q, q, "second moment of `L x` and the estimate, `D_e v` aside")
N12 = letters("N12", n, r, "what drives `Q_12`")
N2 = square("N2", r, "what drives `Q_2`")
M_nu = square("M_nu", n, "what parameter noise adds to it")
M1 = square("M1", n, "what drives `P_1` without parameter noise")
M12 = letters("M12", n, r, "what drives `P_12`")
M2 = square("M2", r, "what drives `P_2`")
gradAe = letters("gradAe", r, r, "gradient of the cost in `A_e`")
gradBe = letters("gradBe", r, l, "gradient of the cost in `B_e`")
gradCe = letters("gradCe", q, r, "gradient of the cost in `C_e`")
gradDe = letters("gradDe", q, l, "gradient of the cost in `D_e`")

X = square("X", n, "second moment of the state, for the noise of a pair")
u = letters("u", n, 1, "all noise that moves the state")
v = letters("v", l, 1, "all noise in the measurement")
MOVING = (*GAINS, Q12, Q2, P12, P2)
dAe, dBe, dCe, dDe, dQ12, dQ2, dP12, dP2 = INCREMENTS = tuple(
    letters(f"d{X.name}", X.rows, X.cols, f"how `{X.name}` moves", X in (Q2, P2))
    for X in MOVING
)
dgradAe, dgradBe, dgradCe, dgradDe = (
    letters(f"dgrad{X.name}", X.rows, X.cols, f"how the gradient in `{X.name}` moves")
    for X in GAINS
)
