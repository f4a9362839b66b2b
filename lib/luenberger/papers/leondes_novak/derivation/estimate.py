"""The filter in innovation form: predict, compare with the measurement, correct.

The letters of the state stand for estimates on this page, as they do in the code; the
state itself has a tilde.  What the measurement's noise tells of the process noise is
kept as a residual from one instant to the next.

Source: Leondes and Novak (1974), (41)-(43); the residual is our own.
"""

from matrixproof import Page

from .best_coordinates import exact
from .correlated_noise import is_As
from .letters import SOURCE, I, letters, m, n, p
from .letters.accurate import S1
from .letters.plant import A, As, B, C, E, J, u, v, v_next, w, x, x_next, y
from .letters.step import K, e

running = letters.here(
    x="estimate of the state",
    x_next="estimate one step on",
    y="measurement one step on",
    w="process noise that is left once `v` is told",
)
u_next = running("u_next", m, 1, "input one step on")
truth = running("xt", n, 1, "state")
truth_next = running("xt_next", n, 1, "state one step on")
x_minus = running("x_minus", n, 1, "prediction")
rho = running("rho", p, 1, "what the estimate leaves of the measurement")
rho_next = running("rho_next", p, 1, "the same one step on")
innovation = running("innovation", p, 1, "what the prediction leaves of it")


page = Page(letters=running, source=f"{SOURCE}, (41)-(43)")

page("""The plant moves as in (1); of its noise, `J v` is told by the measurement. The
    residual of an estimate is its own error and the noise of the measurement.""")
plant = page.let(truth_next, A * truth + B * u + J * v + w, "1")
left = page.let(rho, C * (truth - x) + v)
is_e = page.let(e, x - truth)
page(is_As)

page("The prediction takes along what the residual tells.")
is_minus = page.let(x_minus, A * x + B * u + J * rho, "43")
before = page(
    letters.derive("43", "the error of the prediction", x_minus - truth_next)
    .put(is_minus)
    .use(plant)
    .put(left)
    .fold(is_As, is_e)
)

page("""The next measurement is compared with what the prediction leads one to expect,
    and the difference corrects it.""")
measured = page.let(y, C * truth_next + E * u_next + v_next, "2")
is_innovation = page.let(innovation, y - E * u_next - C * x_minus, "43")
corrects = page.let(x_next, x_minus + K * innovation, "43")
page(
    letters.derive("26, 43", "the error of the estimate", x_next - truth_next)
    .put(corrects, is_innovation, measured)
    .by((I - K * C) * (As * e - w) + K * v_next, before)
)

page("A gain that treats outputs as exact leaves nothing of them in the residual.")
is_rho_next = page.let(rho_next, y - E * u_next - C * x_next)
page(exact)
page(
    letters.derive("24", "accurate outputs are met", S1 * rho_next)
    .put(is_rho_next, corrects)
    .fold(is_innovation)
    .use(exact)
)

estimate_step = page.program(
    "one step of the estimate",
    (A, B, C, E, J, K, x, u, rho, y, u_next),
    (is_minus, "(43)"),
    (is_innovation, "(43)"),
    (corrects, "(43)"),
    is_rho_next,
)
