"""The radar tracker: a target's position, velocity and acceleration.

The start is the parabola through the last three measured positions: three equations
for three unknowns.  Its error is linear in the noises of these measurements and in the
two manoeuvres between them, which gives its covariance.  Everything is at the sizes of
the example, with symbols for the time between scans and for the variances.

Source: Leondes and Novak (1974), section V, (54)-(58).
"""

import sympy as sp

from matrixproof import Explicit, Notation, Page

from .letters import SOURCE, n, p

T, s_x, s_v, s_m = sp.symbols("T sigma_x sigma_xdot sigma_m", positive=True)
t, w_m = sp.symbols("t w_m")
Rat = sp.Rational
letters = Notation()
k = sp.symbols("k", integer=True, nonnegative=True)  # noises, and measured positions
A_t = letters("A_t", n, n, "moves the state over any time")
dA = letters("dA_t", n, n, "its derivative by time")
N_d = letters("N_d", n, n, "differentiates position and velocity")
Y_3 = letters("Y_3", k, 1, "the last three measured positions, the newest first")
C_3 = letters("C_3", k, n, "what they measure of the state of now")
x_bar = letters("x_bar_0", n, 1, "the state at the start")
x_printed = letters("x_bar_printed", n, 1, "the start as the paper prints it")
e_0 = letters("e_0", n, 1, "error of the start")
G_n = letters("G_n", n, k, "what each noise does to the start")
noises = letters("nu", k, 1, "noises of three positions and of two manoeuvres")
D_n = letters("D_n", k, k, "their standard deviations")
Sigma_0 = letters("Sigma_0", n, n, "covariance of the start")
Sigma_printed = letters("Sigma_printed", n, n, "the covariance as the paper prints it")
A_T = letters("A_T", n, n, "moves the state from scan to scan")
g = letters("g", n, 1, "what a manoeuvre does to the state")
x = letters("x", n, 1, "position, velocity and acceleration")
x_next = letters("x_next", n, 1, "the same at the next scan")
C_r = letters("C", p, n, "what the radar measures")
y_r = letters("y", p, 1, "position and velocity")
D_v = letters("D_v", p, p, "standard deviations of the measurement noises")
R = letters("R", p, p, "covariance of the measurement noise")
K_l = letters("K_lim", n, p, "a gain where the velocity is measured ever worse")
K_p = letters("K_pos", n, p, "the gain from positions alone")

# -- the model -------------------------------------------------------------------------

N_value = sp.Matrix([[0, 1, 0], [0, 0, 1], [0, 0, 0]])
# position under constant acceleration, and its derivatives after a time
A_of = sum((N_value**j * t**j / sp.factorial(j) for j in range(3)), sp.zeros(3))
A_value = A_of.subs(t, T)
PUSH = sp.Matrix([0, 0, 1])  # a manoeuvre changes the acceleration
Q_value = PUSH * s_m**2 * PUSH.T
C_value = sp.Matrix([[1, 0, 0], [0, 1, 0]])
R_value = sp.diag(s_x**2, s_v**2)
position, velocity, acceleration = state = sp.symbols("x xdot xddot")
travelled = position + T * velocity + T**2 * acceleration / 2

# -- the start -------------------------------------------------------------------------

Y_value = sp.Matrix(sp.symbols("y_0 y_-1 y_-2"))
C_3_value = sp.Matrix.vstack(*(C_value[0, :] * A_value.inv() ** j for j in range(3)))
start = (C_3_value.inv() * Y_value).applyfunc(sp.factor)
noise_value = sp.Matrix(sp.symbols("v_0 v_-1 v_-2 w_-1 w_-2"))
deviations = sp.diag(s_x, s_x, s_x, s_m, s_m)


def start_error():
    """The start less the state, from what was measured of the three states."""
    v0, v1, v2, w1, w2 = noise_value
    x0 = sp.Matrix(state)
    x1 = A_value.inv() * (x0 - PUSH * w1)  # the state one step before
    x2 = A_value.inv() * (x1 - PUSH * w2)
    measured = [x[0] + v for x, v in ((x0, v0), (x1, v1), (x2, v2))]
    error = start.subs(dict(zip(Y_value, measured))) - x0
    return error.applyfunc(sp.expand)


error_value = start_error()
G_value = error_value.jacobian(noise_value)
Sigma_value = (G_value * deviations**2 * G_value.T).applyfunc(sp.expand)


def printed():
    """(57) and (58) as the paper prints them, for comparison only."""
    y0, y1, y2 = Y_value
    first = (Rat(3, 2) * y0 - 2 * y1 + Rat(1, 2) * y2) / T
    velocity = Rat(13, 2) * s_x**2 / T**2 + T**2 * s_m**2 / 16
    cross = 6 * s_x**2 / T**3 + s_m**2 * T / 8
    acceleration = 6 * s_x**2 / T**4 + 5 * s_m**2 / 4
    top = [s_x**2, Rat(3, 2) * s_x**2 / T, s_x**2 / T**2]
    covariance = [top, [top[1], velocity, cross], [top[2], cross, acceleration]]
    return sp.Matrix([y0, first, (y0 - 2 * y1 + y2) / T**2]), sp.Matrix(covariance)


start_printed, covariance_printed = printed()


def limits():
    """The gains (33) for this plant when the velocity is measured ever worse."""
    Omega = sp.Matrix(3, 3, lambda i, j: sp.Symbol(f"Omega_{min(i, j)}{max(i, j)}"))
    M, crossed = C_value * Omega * C_value.T + R_value, Omega * C_value.T
    whole = (crossed * M.adjugate() / M.det()).applyfunc(
        lambda entry: sp.limit(sp.cancel(entry), s_v, sp.oo)
    )
    alone = (crossed[:, 0] / M[0, 0]).row_join(sp.zeros(3, 1))
    return whole, alone


whole, alone = limits()


page = Page(letters=letters, source=f"{SOURCE}, section V")
VALUES = {
    dA: A_of.diff(t),
    N_d: N_value,
    A_t: A_of,
    x_next: sp.Matrix([travelled, velocity + T * acceleration, acceleration + w_m]),
    A_T: A_value,
    x: sp.Matrix(state),
    g: PUSH,
    y_r: sp.Matrix([position, velocity]),
    C_r: C_value,
    D_v: sp.diag(s_x, s_v),
    R: R_value,
    C_3: C_3_value,
    x_bar: start,
    Y_3: Y_value,
    x_printed: start_printed,
    e_0: error_value,
    G_n: G_value,
    noises: noise_value,
    D_n: deviations,
    Sigma_0: Sigma_value,
    Sigma_printed: covariance_printed,
    K_l: whole,
    K_p: alone,
}


def holds(number, says, left, right, **why):
    """Write that two expressions are equal in the values of the example."""
    values = {s: VALUES[s] for s in VALUES if left.has(s) or right.has(s)}
    page(Explicit(number, says, left, right, {"n = 3, p = 2": values}, **why))


page("""A target moves with constant acceleration between scans; a manoeuvre changes the
    acceleration at random. The state has position, velocity and acceleration. What
    moves it solves the equation of motion.""")
holds("54", "the motion between scans", dA, N_d * A_t)
holds("54", "the state at the next scan", x_next, A_T * x + g * w_m)

page("The radar measures position and velocity, with independent noises.")
holds("55", "what the radar shows without noise", y_r, C_r * x)
holds("56", "the noises are independent", D_v * D_v.T, R)

page("The last three positions determine a parabola, and the start is its state now.")
holds("57", "the parabola meets all three positions", C_3 * x_bar, Y_3)
holds("57", "the start is what the paper prints", x_bar, x_printed)

page("""The state drops out of the error: what is left are the noises of three positions
    and of two manoeuvres.""")
holds("57", "the error of the start holds noises only", e_0, G_n * noises)

page("""All five are independent, so the covariance is a sum of squares. It is what the
    paper prints.""")
holds("58", "the covariance of the start", G_n * D_n * (G_n * D_n).T, Sigma_0)
holds("58", "the covariance is what the paper prints", Sigma_0, Sigma_printed)

page("""If the velocity is measured ever worse, the gain (33) goes to that from
    positions alone. Its lower rows are then the gain (37) of the observer of least
    order, and the whole is that of a Kalman filter without the velocity.""")
holds(
    "33, 37, Fig. 3",
    "a useless velocity leaves the gain from positions",
    K_l,
    K_p,
    why="in the limit of infinite noise",
)
