"""A plant whose known input has statistics, as a plant without input.

The input is the output of a model of its own.  Plant and model together have no input,
and the input is one more measurement, without noise.  So what is known of a plant
without input holds for one that is driven.

Source: our own; the plant is that of Leondes and Novak (1974), (1)-(5).
"""

from sympy import symbols

from matrixproof import BlockMatrix, Identity, Page, ZeroMatrix

from .huddle import measured, plant
from .letters import SOURCE, I, letters, m, n, p
from .letters.plant import A, B, C, E, Q, R, S, u, v, w, x, x_next, y

j = symbols("n_u", integer=True, nonnegative=True)
both, noises = j + n, j + m + n + p
letters = letters.here()
gone = ZeroMatrix
A_1 = letters("A1", n, n, "what a multiplicative noise does to the state")
C_1 = letters("C1", p, n, "what it does to the measurement")
s = letters("s", j, 1, "state of the model of the input")
s_next = letters("s_next", j, 1, "the same one step on")
A_u = letters("A_u", j, j, "moves the model of the input")
C_u = letters("C_u", m, j, "what it shows is the input")
w_u = letters("w_u", j, 1, "white noise that drives it")
v_u = letters("v_u", m, 1, "white part of the input")
Q_u = letters("Q_u", j, j, "covariance of `w_u`", symmetric=True)
R_u = letters("R_u", m, m, "covariance of `v_u`", symmetric=True)
S_u = letters("S_u", j, m, "covariance of the two")
x_in = letters("x_in", both, 1, "states of model and plant")
x_in_next = letters("x_in_next", both, 1, "the same one step on")
y_in = letters("y_in", p + m, 1, "measurement and input")
w_in = letters("w_in", both, 1, "noise that moves both")
v_in = letters("v_in", p + m, 1, "noise in both measurements")
omega = letters("omega", noises, 1, "all noises, one under the other")
Q_all = letters("Q_all", noises, noises, "their covariance", symmetric=True)
N_w = letters("N_w", both, noises, "what they do to the states")
N_v = letters("N_v", p + m, noises, "what they do to the measurements")
A_in = letters("A_in", both, both, "moves both")
C_in = letters("C_in", p + m, both, "what is measured of both")
Q_in = letters("Q_in", both, both, "covariance of `w_in`", symmetric=True)
R_in = letters("R_in", p + m, p + m, "covariance of `v_in`", symmetric=True)
S_in = letters("S_in", both, p + m, "covariance of the two")
A1_in = letters("A1_in", both, both, "what the multiplicative noise does to both")
C1_in = letters("C1_in", p + m, both, "what it does to both measurements")
picked = letters("Pi_x", n, both, "rows of the identity that pick the plant's states")
placed = letters("Pi_y", p + m, p, "columns of it that place the plant's measurement")


page = Page(letters=letters, source=f"our own; {SOURCE}, (1)-(5)")

page("The input comes from a model with noises of its own.")
is_s_next = page.let(s_next, A_u * s + w_u)
is_u = page.let(u, C_u * s + v_u)
page(plant, measured)

page("Model and plant have these states, and the input stands beside the measurement.")
is_x_in = page.let(x_in, BlockMatrix([[s], [x]]))
is_x_in_next = page.let(x_in_next, BlockMatrix([[s_next], [x_next]]))
is_y_in = page.let(y_in, BlockMatrix([[y], [u]]))
is_A_in = page.let(A_in, BlockMatrix([[A_u, gone(j, n)], [B * C_u, A]]))
is_C_in = page.let(C_in, BlockMatrix([[E * C_u, C], [C_u, gone(m, n)]]))
is_w_in = page.let(w_in, BlockMatrix([[w_u], [B * v_u + w]]))
is_v_in = page.let(v_in, BlockMatrix([[E * v_u + v], [v_u]]))

page("They move as a plant without input does,")
says = "model and plant without an input"
page(
    letters.derive("1", says, A_in * x_in + w_in - x_in_next)
    .multiply(is_A_in, is_x_in, is_w_in, is_x_in_next)
    .put(is_s_next, plant, is_u)
    .expand()
)

page("and measurement and input are what is measured of it.")
page(
    letters.derive("2", "measurement and input of both", C_in * x_in + v_in - y_in)
    .multiply(is_C_in, is_x_in, is_v_in, is_y_in)
    .put(measured, is_u)
    .expand()
)

page("""Its noises come from four white ones. Those of the input are independent of
    those of the plant.""")
is_omega = page.let(omega, BlockMatrix([[w_u], [v_u], [w], [v]]))
of_w_u = [Identity(j), gone(j, m), gone(j, n), gone(j, p)]
is_N_w = page.let(N_w, BlockMatrix([of_w_u, [gone(n, j), B, I, gone(n, p)]]))
of_v = [gone(p, j), E, gone(p, n), Identity(p)]
of_v_u = [gone(m, j), Identity(m), gone(m, n), gone(m, p)]
is_N_v = page.let(N_v, BlockMatrix([of_v, of_v_u]))
is_omega_omega = page.moment(omega * omega.T, Q_all)
blocks = [[Q_u, S_u, gone(j, n), gone(j, p)], [S_u.T, R_u, gone(m, n), gone(m, p)]]
blocks += [[gone(n, j), gone(n, m), Q, S], [gone(p, j), gone(p, m), S.T, R]]
is_Q_all = page.suppose(Q_all, BlockMatrix(blocks))
blocks = [[Q_u, S_u * B.T], [B * S_u.T, Q + B * R_u * B.T]]
is_Q_in = page.let(Q_in, BlockMatrix(blocks))
blocks = [[R + E * R_u * E.T, E * R_u], [R_u * E.T, R_u]]
is_R_in = page.let(R_in, BlockMatrix(blocks))
blocks = [[S_u * E.T, S_u], [S + B * R_u * E.T, B * R_u]]
is_S_in = page.let(S_in, BlockMatrix(blocks))
to_states = page(
    letters.derive("4", "the noise of the states", w_in).by(
        N_w * omega, is_w_in, is_N_w, is_omega
    )
)
to_outputs = page(
    letters.derive("4", "the noise of the measurements", v_in).by(
        N_v * omega, is_v_in, is_N_v, is_omega
    )
)
says = "the covariance of the noise of the states"
page(
    letters.derive("4", says, w_in * w_in.T)
    .use(to_states)
    .expect(is_omega_omega)
    .by(Q_in, is_Q_in, is_N_w, is_Q_all)
)
says = "the covariance of the noise of the measurements"
page(
    letters.derive("4", says, v_in * v_in.T)
    .use(to_outputs)
    .expect(is_omega_omega)
    .by(R_in, is_R_in, is_N_v, is_Q_all)
)
page(
    letters.derive("5", "the covariance of both noises", w_in * v_in.T)
    .use(to_states, to_outputs)
    .expect(is_omega_omega)
    .by(S_in, is_S_in, is_N_w, is_N_v, is_Q_all)
)

page("A noise that multiplies the state of the plant acts on that state alone.")
is_picked = page.let(picked, BlockMatrix([[gone(n, j), I]]))
is_placed = page.let(placed, BlockMatrix([[Identity(p)], [gone(m, p)]]))
is_A1_in = page.let(A1_in, picked.T * A_1 * picked)
is_C1_in = page.let(C1_in, placed * C_1 * picked)
own = page(
    letters.derive("1", "the state of the plant", picked * x_in).multiply(
        is_picked, is_x_in
    )
)
page(
    letters.derive("1", "what a multiplicative noise does to both states", A1_in * x_in)
    .put(is_A1_in)
    .use(own)
    .multiply(is_picked)
)
page(
    letters.derive("2", "what it does to both measurements", C1_in * x_in)
    .put(is_C1_in)
    .use(own)
    .multiply(is_placed)
)

driven_plant = page.program(
    "model of the input and plant as one plant",
    (A, B, C, E, Q, R, S, A_u, C_u, Q_u, R_u, S_u),
    (is_A_in, "(1)"),
    (is_C_in, "(2)"),
    (is_Q_in, "(4)"),
    (is_R_in, "(4)"),
    (is_S_in, "(5)"),
)

driven_pair = page.program(
    "a multiplicative noise of model and plant",
    (A_1, C_1, picked, placed),
    (is_A1_in, "(1)"),
    (is_C1_in, "(2)"),
)
