"""An observer that is none: with the state beside it, it satisfies every condition.

Where Luenberger's conditions fail, the state drives the error.  Then the state is
followed as well, with its sign turned: what follows `-x` from zero errs by the whole
`x`.  Both together are an observer that satisfies the conditions, so its error has the
covariance of (11) and (26).

Source: our own; the conditions are those of Leondes and Novak (1974), (9), (13).
"""

from sympy import symbols

from matrixproof import BlockMatrix, Page, Stage, ZeroMatrix

from .letters import SOURCE, I, letters, m, n, p, r
from .letters.observer import D, F, G, T, T_next, z
from .letters.plant import A, B, C, E, u, x
from .start import here

q = symbols("q", integer=True, nonnegative=True)
both = n + r
L_any = letters("L_any", q, n, "what is estimated of the state")
P_any = letters("P_any", q, r, "weight of the observer in the estimate of that")
V_any = letters("V_any", q, p, "weight of the measurement in it")
N_1 = letters("N_1", r, n, "what the condition on the dynamics leaves")
N_3 = letters("N_3", q, n, "what the condition on the estimate leaves")
z_both = letters("z_both", both, 1, "observer of state and error")
eps_both = letters("eps_both", both, 1, "its error: state and error")
F_both = letters("F_both", both, both, "moves it")
D_both = letters("D_both", both, p, "what the measurement does to it")
T_both = letters("T_both", both, n, "what it follows")
T_ahead = letters("T_ahead", both, n, "what it follows one step on")
P_both = letters("P_both", q, both, "its weight in the estimate")
W_any = letters("W_any", q, m, "weight of the input in the estimate of `L_any x`")
N_2 = letters("N_2", r, m, "what the condition on the input leaves")
N_4 = letters("N_4", q, m, "what the input leaves in the estimate")
G_both = letters("G_both", both, m, "what the input does to it")
B_both = letters("B_both", both, m, "what the input does to state and error")
eps_bar = letters("eps_bar", both, 1, "state and error, of the input alone")
e_bar = letters("e_bar", q, 1, "error of the estimate, of the input alone")
gone = ZeroMatrix


page = Page(letters=letters, source=f"our own; {SOURCE}, (9)")

page("""An observer of `L_any x` need not satisfy the conditions. Two residuals are
    left.""")
is_N_1 = page.let(N_1, T_next * A - F * T - D * C, "9")
is_N_3 = page.let(N_3, P_any * T + V_any * C - L_any, "13")

page("""Beside it stands the state itself, with its sign turned. The following matrices
    belong to both.""")
is_z = page.let(z_both, BlockMatrix([[gone(n, 1)], [z]]))
is_T = page.let(T_both, BlockMatrix([[-I], [T]]))
is_T_ahead = page.let(T_ahead, BlockMatrix([[-I], [T_next]]))
is_F = page.let(F_both, BlockMatrix([[A, gone(n, r)], [-N_1, F]]))
is_D = page.let(D_both, BlockMatrix([[gone(n, p)], [D]]))
is_P = page.let(P_both, BlockMatrix([[N_3, P_any]]))
page(here)
is_eps = page.let(eps_both, z_both - T_both * x, "8")
page(
    letters.derive("8", "the error of both is the state and the error", eps_both)
    .put(is_eps)
    .multiply(is_z, is_T)
    .fold(here)
)

page("They satisfy the condition on the dynamics, whatever the observer is.")
says = "both together satisfy the condition on the dynamics"
page(
    letters.derive("9", says, F_both * T_both + D_both * C - T_ahead * A)
    .multiply(is_F, is_T, is_D, is_T_ahead)
    .use(is_N_1)
)

page("And the estimate of both is unbiased.")
says = "both together estimate without bias"
page(
    letters.derive("13", says, P_both * T_both + V_any * C)
    .multiply(is_P, is_T)
    .use(is_N_3)
)

page("""A known input drives state and error. The observer of both gets it as the one
    observer does, and two more residuals are left.""")
is_N_2 = page.let(N_2, T_next * B - G - D * E, "10")
is_N_4 = page.let(N_4, W_any + V_any * E, "12")
is_G = page.let(G_both, BlockMatrix([[gone(n, m)], [G]]))
is_B = page.let(B_both, BlockMatrix([[B], [-N_2]]))
says = "what the input does to state and error"
page(
    letters.derive("10", says, G_both + D_both * E - T_ahead * B - B_both)
    .multiply(is_G, is_D, is_T_ahead, is_B)
    .use(is_N_2)
)

page("The estimate passes on what is left of both.")
shows = page.let(e_bar, P_both * eps_bar + (W_any + V_any * E) * u, "12")
answer = page(
    letters.derive("12", "the error that the input leaves", e_bar)
    .put(shows)
    .fold(is_N_4)
)

beside_the_state = page.program(
    "state and error as the error of one observer",
    (A, F, D, P_any, T, T_next, z, N_1, N_3),
    is_F,
    is_D,
    is_P,
    is_T,
    is_T_ahead,
    is_z,
)

driven_beside_the_state = page.program(
    "what the known input does to state and error", (B, N_2), (is_B, "(10)")
)

error_of_input = page.program(
    "the error that the input leaves in the estimate",
    (P_both, N_4, eps_bar, u),
    Stage(e_bar, P_both * eps_bar + N_4 * u, "(12)", by=(answer,)),
)
