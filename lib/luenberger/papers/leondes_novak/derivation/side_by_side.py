"""Plant and observer side by side: a step of both, and the error between them.

The observer may estimate a functional of the state only.  A Monte Carlo run repeats
the step of both, a run over a record that of the observer.

Source: Leondes and Novak (1974), (1), (2), (7)-(13), (26).
"""

from sympy import symbols

from matrixproof import Page, Stage, ZeroMatrix

from ....theory import observer
from .huddle import driven, dynamics, follows, follows_next, moves
from .letters import SOURCE, letters, m, n, p, r
from .letters.observer import D, F, G, T, z, z_next
from .letters.plant import A, B, C, E, u, x, x_next, y

d, q = symbols("d q", integer=True, nonnegative=True)
letters = letters.here()
L = letters("L", q, n, "what is wanted of the state")
P = letters("P", q, r, "weight of the observer in the estimate")
V = letters("V", q, p, "weight of the measurement in the estimate")
W = letters("W", q, m, "weight of the input in the estimate")
w = letters("w", q, 1, "the functional that is wanted")
w_hat = letters("w_hat", q, 1, "its estimate")
e = letters("e", q, 1, "error of the estimate")
xi = letters("xi", d, 1, "white noise of variance one")
Hw = letters("Hw", n, d, "its part in the process noise")
Hv = letters("Hv", p, d, "its part in the measurement noise")


page = Page(letters=letters, source=SOURCE)

page("""Both noises of the plant come from one white vector `xi`, so that they may be
    correlated.""")
plant = page.let(x_next, A * x + B * u + Hw * xi, "1")
measured = page.let(y, C * x + E * u + Hv * xi, "2")

page("The observer moves as any observer does, and Luenberger's conditions hold.")
page(moves, follows, follows_next, dynamics, driven)
noises = dict(w=Hw * xi, v=Hv * xi)
page.at("11", "the error is driven by the noises alone", observer.free, **noises)

page("""What is wanted is `L x`. Its estimate combines the observer with measurement and
    input, and is unbiased if two residuals vanish, as in (13).""")
wanted = page.let(w, L * x)
estimate = page.let(w_hat, P * z + V * y + W * u, "12")
unbiased = page.suppose(P * T + V * C, L, "13")
is_W = page.let(W, -V * E)
is_e = page.let(e, w_hat - L * x)
page.at("26", "the error of the estimate", observer.error, **noises)
beyond = page(
    letters.derive("", "what it adds to what is wanted", e).put(is_e).fold(wanted)
)

observer_step = page.program(
    "one step of any observer",
    (F, G, D, P, V, W, z, u, y),
    (estimate, "(12)"),
    Stage(z_next, F * z + G * u + D * y, "(7)", by=(moves,)),
)


page("Neither error holds the input, so that a simulation of the error leaves it out.")
no_input = page.suppose(u, ZeroMatrix(m, 1))

side_by_side = page.program(
    "one step of plant and observer",
    (A, C, L, F, D, P, V, Hw, Hv, x, z, xi),
    Stage(y, C * x + Hv * xi, "(2)", by=(measured, no_input)),
    wanted,
    Stage(w_hat, P * z + V * y, "(12)", by=(estimate, no_input)),
    Stage(e, beyond.right, by=(beyond,)),
    Stage(z_next, F * z + D * y, "(7)", by=(moves, no_input)),
    Stage(x_next, A * x + Hw * xi, "(1)", by=(plant, no_input)),
)
