"""Hsia's plant, and the loop that is closed all the time.

The paper measures a sampled loop against the one that is not sampled.  Its response
has a closed form, and the rate of its error jumps where the input does.

Source: Hsia (1974), (17).
"""

import sympy as sp

from matrixproof import Explicit, Identity, Notation, Page, ZeroMatrix

n, m = sp.symbols("n m", integer=True, positive=True)
t, S = sp.Symbol("t", nonnegative=True), sp.Symbol("s")
letters = Notation()
A = letters("A", n, n, "moves the state")
x = letters("x", n, 1, "state of the loop that is closed all the time")
B = letters("B", n, m, "what the input does to it")
C_p = letters("C", m, n, "what is measured")
G = letters("G", m, m, "the transfer function, at the frequency `s`")
x_0 = letters("x_0", n, 1, "where it starts")
x_dot = letters("x_next", n, 1, "its rate")
y_star = letters("y*", m, 1, "output of that loop")
step = letters("r", m, 1, "the reference, a step")
jump = letters("j", m, m, "by how much the rate of the output jumps with the input")


# -- the plant and its response -------------------------------------------------------

decay, turn = sp.exp(-5 * t), 5 * sp.sqrt(3) * t
sine = sp.sin(turn) / sp.sqrt(3)
state = sp.Matrix([(1 - decay * (sp.cos(turn) + sine)) / 100, decay * sine / 5])
VALUES = {
    A: sp.Matrix([[0, 1], [0, 0]]),
    B: sp.Matrix([0, 1]),
    C_p: sp.Matrix([[100, 10]]),
    G: sp.Matrix([[10 * (S + 10) / S**2]]),
    x: state,
    x_dot: state.diff(t).expand(),
    x_0: state.subs(t, 0),
    y_star: sp.Matrix([1 - decay * (sp.cos(turn) - sine)]),
    step: sp.Matrix([1]),
    jump: sp.Matrix([10]),
}


def of_plant(*wanted):
    return {"": {letter: VALUES[letter] for letter in wanted}}


# -- the page -------------------------------------------------------------------------


page = Page(letters=letters, source="Hsia (1974), (17)")

page("The plant has two integrators and a zero: a position and a velocity.")
page(
    Explicit(
        "",
        "the transfer function of the plant",
        C_p * (S * Identity(n) - A).I * B,
        G,
        of_plant(A, B, C_p, G),
    )
)

page("Closed all the time, and at rest before the step, the loop moves as follows.")
page(
    Explicit(
        "17",
        "the continuous loop",
        A * x + B * (step - C_p * x),
        x_dot,
        of_plant(A, B, C_p, step, x, x_dot),
    )
)
page(Explicit("17", "it starts at rest", x_0, ZeroMatrix(n, 1), of_plant(x_0)))
page(Explicit("17", "its response", C_p * x, y_star, of_plant(C_p, x, y_star)))

page("""The rate of the output is `C A x + C B u`. A sampled loop holds `u`, which jumps
    at a sample, and the rate jumps with it. So it matters whether the rate is read
    before the jump or after it.""")
page(Explicit("", "by how much it jumps", C_p * B, jump, of_plant(C_p, B, jump)))
