"""An observer that uses the known input as one more measurement.

It is an observer of the plant and of the model of its input together, and has no input
itself.

Source: our own; the conditions are those of Leondes and Novak (1974), (7)-(13).
"""

from sympy import symbols

from matrixproof import BlockMatrix, Page

from . import known_input
from .any_observer import is_N_1, is_N_2
from .huddle import moves
from .known_input import (
    A_in,
    C_in,
    both,
    is_A_in,
    is_C_in,
    is_picked,
    is_x_in,
    is_y_in,
    own,
    picked,
    x_in,
    y_in,
)
from .letters import SOURCE, m, n, p, r
from .letters.observer import D, F, G, T, T_next, z, z_next
from .letters.plant import u, y

q = symbols("q", integer=True, nonnegative=True)
letters = known_input.letters.here()
L_any = letters("L_any", q, n, "what is estimated of the state")
P_any = letters("P_any", q, r, "weight of the observer in the estimate of that")
V_any = letters("V_any", q, p, "weight of the measurement in it")
W_any = letters("W_any", q, m, "weight of the input in the estimate of `L_any x`")
N_1 = letters("N_1", r, n, "what the condition on the dynamics leaves")
N_2 = letters("N_2", r, m, "what the condition on the input leaves")
w_hat = letters("w_hat", q, 1, "estimate of `L_any x`")
D_in = letters("D_in", r, p + m, "what measurement and input do to the observer")
V_in = letters("V_in", q, p + m, "weight of both in the estimate")
T_in = letters("T_in", r, both, "what the observer follows of both")
T_ahead = letters("T_ahead", r, both, "what it follows one step on")
L_in = letters("L_in", q, both, "what is estimated of both")


page = Page(letters=letters, source=f"our own; {SOURCE}, (7)-(13)")

page("""An observer uses the input as it uses a measurement. What it follows and what it
    estimates are of the plant.""")
page(is_x_in, is_y_in, moves)
estimates = page.let(w_hat, P_any * z + V_any * y + W_any * u, "12")
is_D_in = page.let(D_in, BlockMatrix([[D, G]]))
is_V_in = page.let(V_in, BlockMatrix([[V_any, W_any]]))
page(
    letters.derive("7", "the observer has no input", F * z + D_in * y_in - z_next)
    .multiply(is_D_in, is_y_in)
    .put(moves)
    .expand()
)
page(
    letters.derive("12", "its estimate has none", P_any * z + V_in * y_in - w_hat)
    .multiply(is_V_in, is_y_in)
    .put(estimates)
    .expand()
)
page(is_picked, own)
is_T_in = page.let(T_in, T * picked)
is_T_ahead = page.let(T_ahead, T_next * picked)
is_L_in = page.let(L_in, L_any * picked)
page(letters.derive("8", "it follows the plant", T_in * x_in).put(is_T_in).use(own))
page(letters.derive("13", "it estimates the plant", L_in * x_in).put(is_L_in).use(own))

page("""What Luenberger's condition leaves of both is what the two conditions on the
    plant leave. An observer that meets these two is exact for every input.""")
page(is_N_1, is_N_2, is_A_in, is_C_in)
rest = T_ahead * A_in - F * T_in - D_in * C_in
page(
    letters.derive("9, 10", "what is left of the condition on both", rest)
    .put(is_T_ahead, is_T_in)
    .multiply(is_picked, is_A_in, is_D_in, is_C_in)
    .fold(is_N_1, is_N_2)
)

observer_of_both = page.program(
    "an observer as one of model and plant",
    (D, G, V_any, W_any, T, L_any, picked),
    (is_D_in, "(7)"),
    (is_V_in, "(12)"),
    (is_T_in, "(8)"),
    (is_L_in, "(13)"),
)
