"""The letters of Haddad and Bernstein (1987), each with its size and what it means.

Theirs, with those of the library behind them: V_1, V_2, V_12 (Q, R, S of a plant),
A_e, B_e, C_e, D_e (F, D, P, V of an observer), the weight R (`weight`), the order n_e.
What G and P stand for here has no letter there.  A plus below is the next instant.
The paper writes Q and P with hats in theorem 3.1 and in script in section 4.

Each pair (A_i, C_i) is multiplied by a white noise of unit variance.  One pair stands
for any number: their noises are independent, so each adds terms like its own.
"""

from sympy import symbols

from matrixproof import Derivation, Identity, Notation, Stage
from matrixproof.derivation import title

SOURCE = "Haddad and Bernstein (1987)"

n, l, r, q = symbols("n l n_e q", integer=True, nonnegative=True)
nu = symbols("nu_1")
letters = Notation()
chain, derive, let, moment, steady, suppose = (
    letters.chain,
    letters.derive,
    letters.let,
    letters.moment,
    letters.steady,
    letters.suppose,
)
I = Identity(n)


def assign(relation, equation="", also=()):
    """The stage that a definition is: it assigns the left side."""
    target = relation.left
    stored = target in letters.symmetric
    by = (relation, *also)
    return Stage(target, relation.right, equation, symmetric=stored, by=by)


def listed(given, stages, says, *chains, source=SOURCE):
    """A stage list, and the chains that say what its letters are good for."""
    found = {"stages": tuple(stages), "steps": {title(c): c for c in chains}}
    return Derivation(given, **found, source=source, letters=letters, says=says)


def square(name, size, meaning):
    """A symmetric letter."""
    return letters(name, size, size, meaning, symmetric=True)


# -- the plant ---------------------------------------------------------------------

x = letters("x", n, 1, "state")
x_next = letters("x_next", n, 1, "state one step on")
y = letters("y", l, 1, "measurement")
A = letters("A", n, n, "moves the state")
C = letters("C", l, n, "what is measured")
A1 = letters("A1", n, n, "what parameter noise does to the state")
C1 = letters("C1", l, n, "what parameter noise does to the measurement")
w1 = letters("w_1", n, 1, "process noise")
w2 = letters("w_2", l, 1, "measurement noise")
x_nu = letters("x_nu", n, 1, "state, times the noise of the parameters")
W1 = square("W_1", n, "covariance of `w_1`; the paper's `V_1`")
W12 = letters("W_12", n, l, "covariance of `w_1` and `w_2`; the paper's `V_12`")
W2 = square("W_2", l, "covariance of `w_2`; the paper's `V_2`")
V1 = square("V1", n, "covariance of all noise that moves the state")
V12 = letters("V12", n, l, "covariance of all noise in state and measurement")
V2 = square("V2", l, "covariance of all noise in the measurement")
L = letters("L", q, n, "what is to be estimated is `L x`")
R = square("R", q, "weight of the error, positive definite")

# -- the estimator -----------------------------------------------------------------

xe = letters("x_e", r, 1, "state of the estimator")
xe_next = letters("x_e_next", r, 1, "state of the estimator one step on")
xe_nu = letters("x_e_nu", r, 1, "state of the estimator, times the parameter noise")
ye = letters("y_e", q, 1, "estimate of `L x`")
e = letters("e", q, 1, "error of the estimate")
Ae = letters("Ae", r, r, "moves the estimator")
Be = letters("Be", r, l, "what a measurement does to the estimator")
Ce = letters("Ce", q, r, "what the estimator says")
De = letters("De", q, l, "static gain from measurement to estimate")
GAINS = (Ae, Be, Ce, De)
Sigma = square("Sigma", q, "covariance of the error")
J = letters("J", q, q, "its product with the weight; the trace is the cost")

# -- both together -------------------------------------------------------------------

both = n + r
xt = letters("x_tilde", both, 1, "states of plant and estimator")
xt_next = letters("x_tilde_next", both, 1, "the same one step on")
xt_nu = letters("x_tilde_nu", both, 1, "the same, times the noise of the parameters")
w = letters("w", n + l, 1, "`w_1` and `w_2`, one under the other")
W = square("W", n + l, "their covariance")
Bt = letters("B_tilde", both, n + l, "how the additive noise reaches both")
wt = letters("w_tilde", both, 1, "additive noise of both")
At = letters("A_tilde", both, both, "moves both")
At1 = letters("A_tilde_1", both, both, "what parameter noise does to both")
Lt = letters("L_tilde", q, both, "how the error shows both")
Ct1 = letters("C_tilde_1", l, both, "how parameter noise reaches the measurement")
Wt = square("W_tilde", both, "covariance of the additive noise; the paper's `V_tilde`")
Rt_0 = square("R_tilde_0", both, "weight of both, without parameter noise")
Vt = square("V_tilde", both, "covariance of all noise of both")
Rt = square("R_tilde", both, "weight of both")
Qt = square("Q_tilde", both, "second moment of both")
Qt_next = square("Q_tilde_next", both, "the same one step on")
Pt = square("P_tilde", both, "its dual, the multiplier of the moment equation")
p_tilde = letters("p", both**2, 1, "the entries of `P_tilde`, in a column")
Phi_p = letters("Phi_p", both**2, both**2, "the map of (4.5) on them, without weight")
N_p = letters("N_p", both**2, both**2, "inverse of `I - Phi_p`")
F1 = letters("F_1", both, n, "what parameter noise does to both, first columns")
Q1 = square("Q1", n, "second moment of the state")
Q12 = letters("Q12", n, r, "second moment of state and estimator")
Q1_next = square("Q1_next", n, "second moment of the state one step on")
Q2 = square("Q2", r, "second moment of the estimator, positive definite")
P1 = square("P1", n, "dual of `Q_1`")
P12 = letters("P12", n, r, "dual of `Q_12`")
P2 = square("P2", r, "dual of `Q_2`, positive definite")

# -- what the kernels call them ------------------------------------------------------

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
dV1 = square("dV1", n, "what the pair adds to `V_1`")
dV12 = letters("dV12", n, l, "what the pair adds to `V_12`")
dV2 = square("dV2", l, "what the pair adds to `V_2`")
u = letters("u", n, 1, "all noise that moves the state")
v = letters("v", l, 1, "all noise in the measurement")
Czy = square("Czy", r + l, "covariance of estimator and measurement together")
Nzy = letters("Nzy", q, r + l, "covariance of `L x` with these")
CeDe = letters("CeDe", q, r + l, "`C_e` and `D_e` side by side")
dCeDe = letters("dCeDe", q, r + l, "how they move")
dNzy = letters("dNzy", q, r + l, "what moves them")
MOVING = (*GAINS, Q12, Q2, P12, P2)
dAe, dBe, dCe, dDe, dQ12, dQ2, dP12, dP2 = INCREMENTS = tuple(
    letters(f"d{X.name}", X.rows, X.cols, f"how `{X.name}` moves", X in (Q2, P2))
    for X in MOVING
)
dN12 = letters("dN12", n, r, "what drives `dQ_12`")
dN2 = square("dN2", r, "what drives `dQ_2`")
dM12 = letters("dM12", n, r, "what drives `dP_12`")
dM2 = square("dM2", r, "what drives `dP_2`")
dgradAe, dgradBe, dgradCe, dgradDe = (
    letters(f"dgrad{X.name}", X.rows, X.cols, f"how the gradient in `{X.name}` moves")
    for X in GAINS
)

# -- the theorem ---------------------------------------------------------------------

xh = letters("xhat", n, 1, "what the estimator says of the state, `G' x_e`")
eps = letters("eps", n, 1, "its error")
G = letters("G", r, n, "`G'` lifts the state of the estimator")
Gam = letters("Gam", r, n, "the estimator tracks `Gamma x`")
X_G = letters("X_G", n, r, "the transpose of `G`")
X_Gamma = letters("X_Gamma", n, r, "the transpose of `Gamma`")
I_e = letters("I_e", r, r, "`Gamma G'`, which should be the identity")
Q2_plus = square("Q2_plus", r, "an inverse of `Q_2` on its range")
P2_plus = square("P2_plus", r, "an inverse of `P_2` on its range")
G_0 = letters("G_0", r, n, "`G` where `Q_2` leaves it open")
Gam_0 = letters("Gam_0", r, n, "`Gamma` where `P_2` leaves it open")
G_open = letters("G_open", r, n, "a `G` for any `Q_2`")
Gam_open = letters("Gam_open", r, n, "a `Gamma` for any `P_2`")
tau = letters("tau", n, n, "the optimal projection")
tau_perp = letters("tau_perp", n, n, "what it leaves, `I - tau`")
Q = square("Q", n, "covariance of the error of `xhat`")
Q_e = square("Q_e", n, "second moment of `xhat`; the hat of section 4")
P_e = square("P_e", n, "its dual; the hat of section 4")
Qh = square("Qh", n, "the theorem's; in script in section 4")
Ph = square("Ph", n, "its dual; in script in section 4")
Qs = letters("Qs", n, l, "covariance of next state and innovation")
V2s = square("V2s", l, "covariance of the innovation, positive definite")
Kq = letters("Kq", n, l, "gain of the innovation")
Aq = letters("Aq", n, n, "moves the error of `xhat`")
Lq = letters("Lq", q, n, "what the static gain leaves of `L`")

# -- the equations -------------------------------------------------------------------

T_e = letters("T_e", n, both, "what shows `x - xhat` of both")
root_Qt = letters("H", both, both, "a root of `Q_tilde`")
root_Q2 = letters("H_Q", r, r, "a root of `Q_2`")
root_P2 = letters("H_P", r, r, "a root of `P_2`")
root_R = letters("H_R", q, q, "a root of the weight")
root_V = letters("H_V", l, l, "a root of the innovation covariance")
riccati = square("riccati", n, "residual of (3.14)")
estimate = square("estimate", n, "residual of (3.15)")
adjoint = square("adjoint", n, "residual of (3.16)")
idempotent = letters("idempotent", n, n, "residual of (3.6)")
aligned_Q = letters("aligned_Q", n, n, "residual of (3.17) in `Qh`")
aligned_P = letters("aligned_P", n, n, "residual of (3.17) in `Ph`")
De0 = letters("De0", q, l, "static gain of any estimator")
extra = letters("D_x", q, l, "what it has beyond the Kalman filter's")
S_x = letters("S_x", q, q, "second moment of the predictor's output and the estimate")
V1i = square("V1i", n, "noise that moves the predictor")
M_tau = letters("M_tau", n, n, "product of the hats between projections")
M_sharp = letters("M_tau_sharp", n, n, "its group inverse")
