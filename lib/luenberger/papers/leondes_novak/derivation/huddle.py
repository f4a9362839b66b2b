"""Luenberger's conditions, the error equation, and Huddle's solution.

The error of any observer is driven by the state and by the input through two
residuals, so that both must vanish.  Huddle's choice makes the first vanish wherever
the estimate is unbiased.  Feedthrough and noises that are correlated are carried along.

Source: Leondes and Novak (1974), section II, (7)-(15); Aoki and Huddle (1967).
"""

from matrixproof import Identity, Page, ZeroMatrix

from ....theory import observer
from .letters import SOURCE, I, letters, n, p, r
from .letters.observer import (
    D,
    F,
    G,
    P,
    T,
    T_next,
    V,
    W,
    eps,
    eps_next,
    x_hat,
    z,
    z_next,
)
from .letters.plant import A, B, C, E, b, u, x, x_next, y
from .letters.step import e
from .stochastic_system import measured, plant

Z_1 = letters("Z_1", r, r, "added to `F`")
Z_2 = letters("Z_2", r, p, "added to `D`")
X_1 = letters("X_1", r, r, "free")
X_2 = letters("X_2", r, p, "free")
gone = ZeroMatrix


page = Page(letters=letters, source=f"{SOURCE}, section II")

page("""An observer is a linear system that is driven by input and measurement. It is to
    follow `T x`, and its error is `eps`.""")
page(plant, measured)
moves = page.let(z_next, F * z + G * u + D * y, "7")
follows = page.let(z, T * x + eps, "8")
follows_next = page.let(eps_next, z_next - T_next * x_next, "8")
collected = page.at("7, 8", "what drives the error", observer.collected)

page("""State and input can be anything, so both brackets must vanish. These are
    Luenberger's conditions, which are necessary and sufficient.""")
dynamics = page.suppose(T_next * A, F * T + D * C, "9")
driven = page.suppose(T_next * B, G + D * E, "10")
error_equation = page.at("11", "the error is driven by the noises alone", observer.free)

page("""The estimate combines the observer with the measurement of the moment. It is
    unbiased for every state and input exactly if two more residuals vanish.""")
estimate = page.let(x_hat, P * z + V * y + W * u, "12")
is_e = page.let(e, x_hat - x)
of_state = dict(L=I, w_hat=x_hat)
biased = page.at("12", "the error of an estimate", observer.biased, **of_state)
unbiased = page.suppose(P * T + V * C, I, "13")
is_W = page.let(W, -V * E)
error = page.at(
    "13, 26", "the error of an unbiased estimate", observer.error, **of_state
)

page("""A state that neither the observer follows nor the measurement shows must then be
    zero. So together they need `n` rows, and the observer at least `n - p` of them.""")
not_followed = page.suppose(T * b, gone(r, 1))
not_shown = page.suppose(C * b, gone(p, 1))
page(
    letters.derive("13", "the least order of an observer", b)
    .insert((P * T + V * C) * b, unbiased)
    .use(not_followed, not_shown)
)


page("""Put (13) behind `T_next A`, and compare with (9) what ends in `T` and in `C`.
    What stands before them are Huddle's equations: one solution of (9), wherever the
    estimate is unbiased.""")
between = page(
    letters.derive("9, 14, 15", "what an estimate makes of it", T_next * A)
    .insert(T_next * A * (P * T + V * C), unbiased)
    .expand()
)
huddle = page(*between.match(F * T + D * C, "14", "15", enough=True))
page(
    letters.derive("9, 14, 15", "the solution satisfies the condition", F * T + D * C)
    .put(*huddle)
    .use(unbiased)
)

page("""Then the observer errs as the prediction does, seen through `T`: its error needs
    no other equation.""")
seen = page(
    letters.derive("11, 14, 15", "the observer errs as the prediction does", eps_next)
    .put(error_equation)
    .put(*huddle)
    .fold(error)
    .factor()
)

page("""Other solutions differ by `Z_1` and `Z_2` that cancel each other. They are all
    of the following form, with `X_1` and `X_2` free.""")
added = X_1 * (Identity(r) - T * P) - X_2 * C * P
besides = X_2 * (Identity(p) - C * V) - X_1 * T * V
page(
    letters.derive("9", "what may be added to a solution", added * T + besides * C)
    .by((X_1 * T + X_2 * C) * (I - P * T - V * C))
    .use(unbiased)
)

page("""An observer of least order, `r = n - p`, leaves no choice. There the rows of `T`
    and `C` together are invertible, with `P` and `V` the columns of the inverse.""")
cancel = page.suppose(Z_1 * T + Z_2 * C, gone(r, n))
TP = page.suppose(T * P, Identity(r))
CP = page.suppose(C * P, gone(p, r))
TV = page.suppose(T * V, gone(r, p))
CV = page.suppose(C * V, Identity(p))
page(
    letters.derive("14", "at least order nothing can be added to the dynamics", Z_1)
    .insert((Z_1 * T + Z_2 * C) * P, TP, CP)
    .use(cancel)
)
page(
    letters.derive("15", "at least order nothing can be added to the input", Z_2)
    .insert((Z_1 * T + Z_2 * C) * V, TV, CV)
    .use(cancel)
)

is_F, is_D = huddle
