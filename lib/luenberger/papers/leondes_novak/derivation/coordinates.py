"""The canonical coordinates of the paper, and the way back.

Rows that complete the measurement matrix make it invertible, and give a state whose
first entries are what the accurate outputs measure.  That the inverse exists is what
"full rank" means, and nothing else about the measurement is used.

Source: Leondes and Novak (1974), section III, (16)-(23).
"""

from sympy import Trace

from matrixproof import BlockMatrix, Identity, Page, ZeroMatrix

from .letters import SOURCE, I, letters, m1, n, p, p2, r
from .letters.canonical import C_1, H_2, H, L, q, v_1, v_2
from .letters.observer import D, F, P, T, T_next, V
from .letters.plant import A, C, v, x, x_next
from .letters.step import Sigma, e
from .stochastic_system import plant

letters = letters.here()
Mbar = letters("Mbar", n, n, "rows of `C`, and rows that complete them; the paper's M")
Mbar_next = letters("Mbar_next", n, n, "the same one step on")
Mbar_2 = letters("Mbar_2", r, n, "its rows below the accurate outputs")
C_2 = letters("C_2", p2, n, "rows of the other outputs")
q_next = letters("q_next", n, 1, "the same one step on")
q_1 = letters("q_1", m1, 1, "states that the accurate outputs measure")
q_2 = letters("q_2", r, 1, "the other states")
T_q = letters("T_q", r, n, "what the observer follows, in canonical coordinates")
T_q_next = letters("T_q_next", r, n, "the same one step on")
P_q = letters("P_q", n, r, "weight of the observer, in canonical coordinates")
V_q = letters("V_q", n, p, "weight of the measurement, in canonical coordinates")
e_q = letters("e_q", n, 1, "error of the estimate, in canonical coordinates")
kept, other, gone = Identity(m1), Identity(p2), ZeroMatrix


page = Page(letters=letters, source=f"{SOURCE}, section III")

page("""The outputs are split into accurate ones and the others, and their rows are
    completed to an invertible matrix. The paper writes M for it, a letter that is the
    covariance of the innovation here.""")
is_C = page.let(C, BlockMatrix([[C_1], [C_2]]), "16")
is_Mbar_2 = page.let(Mbar_2, BlockMatrix([[C_2], [L]]), "19")
is_Mbar = page.let(Mbar, BlockMatrix([[C_1], [Mbar_2]]), "19")

page("""In these coordinates the measurement picks states. The other outputs pick the
    first of the lower ones.""")
is_H_2 = page.let(H_2, BlockMatrix([[other, gone(p2, n - p)]]), "23")
blocks = [[kept, gone(m1, r)], [gone(p2, m1), H_2]]
is_H = page.let(H, BlockMatrix(blocks), "18")
says = "the other outputs pick the first of the lower states"
lower = page(letters.derive("23", says, H_2 * Mbar_2).multiply(is_H_2, is_Mbar_2))
picked = page(
    letters.derive("18", "the measurement picks states", H * Mbar)
    .multiply(is_H, is_Mbar)
    .use(lower)
    .fold(is_C)
)
measured = page(
    letters.derive("18", "the measurement matrix in these coordinates", C * Mbar.I)
    .fold(picked)
    .expand()
)

page("""The state `q` of these coordinates moves with a plant of its own. The rows may
    differ from one instant to the next, and the input, which the page leaves out, is
    carried along.""")
is_q = page.let(q, Mbar * x, "19")
is_q_next = page.let(q_next, Mbar_next * x_next, "19")
page(plant)
back = page(letters.derive("19", "the way back", x).by(Mbar.I * q, is_q))
moves = page(
    letters.derive("17, 20", "the plant in these coordinates", q_next)
    .put(is_q_next, plant)
    .use(back)
)
page(
    letters.derive("16, 18", "the measurement in these coordinates", C * x + v)
    .put(back)
    .use(measured)
)
split_q = page.suppose(q, BlockMatrix([[q_1], [q_2]]), "17")
split_v = page.let(v, BlockMatrix([[v_1], [v_2]]), "16")
says = "accurate outputs show the first states"
page(letters.derive("21, 22", says, H * q + v).multiply(is_H, split_q, split_v))

page("""What is designed in these coordinates returns with its certificates. An estimate
    that is unbiased in `q` is unbiased in `x`.""")
T_back = page.let(T, T_q * Mbar)
P_back = page.let(P, Mbar.I * P_q)
V_back = page.let(V, Mbar.I * V_q)
unbiased_q = page.suppose(P_q * T_q + V_q * H, I, "13")
page(
    letters.derive("13", "an unbiased estimate stays unbiased", P * T + V * C)
    .put(T_back, P_back, V_back)
    .fold(picked)
    .use(unbiased_q)
)

page("""The observer's own equations return as they are: what it follows is the same,
    written in other coordinates.""")
T_back_next = page.let(T_next, T_q_next * Mbar_next)
in_q = T_q_next * Mbar_next * A * Mbar.I
dynamics_q = page.suppose(in_q, F * T_q + D * H, "9", name="in q")
page(
    letters.derive("9", "the condition on the dynamics returns", F * T + D * C)
    .put(T_back)
    .fold(picked, dynamics_q, T_back_next)
)

page("""The error trace is not the same number. The trace that the paper minimises, of
    the error in `q`, is a weighted trace of the error in `x`.""")
is_e_q = page.let(e_q, Mbar * e)
is_Sigma = page.moment(e * e.T, Sigma)
says = "the trace in these coordinates is weighted"
page(
    letters.derive("27", says, Trace(e_q * e_q.T))
    .use(is_e_q)
    .expect(is_Sigma)
    .cyclic(Mbar.T)
)
