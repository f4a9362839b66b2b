"""Luenberger's conditions, the error equation, and Huddle's solution.

The error of any observer is driven by the state and by the input through two
residuals, so that both must vanish.  Huddle's choice makes the first vanish wherever
the estimate is unbiased.  Feedthrough and noises that are correlated are carried along.

Source: Leondes and Novak (1974), section II, (7)-(15); Aoki and Huddle (1967).
"""

from functools import cache

from matrixproof import Derivation, Line, ZeroMatrix

from .letters import *
from .stochastic_system import measured, plant

Z_1 = letters("Z_1", r, r, "added to `F`")
Z_2 = letters("Z_2", r, p, "added to `D`")
X_1 = letters("X_1", r, r, "free")
X_2 = letters("X_2", r, p, "free")
gone = ZeroMatrix

ERROR = (
    """An observer is a linear system that is driven by input and measurement. It is to
    follow `T x`, and its error is `eps`.""",
    plant,
    measured,
    moves := define(z_next, F * z + G * u + D * y, "7"),
    follows := define(z, T * x + eps, "8"),
    follows_next := define(eps_next, z_next - T_next * x_next, "8"),
    collected := letters.derive("7, 8", "what drives the error", eps_next)
    .put(follows_next)
    .put(moves, plant)
    .put(follows, measured)
    .collect(x, u),
    """State and input can be anything, so both brackets must vanish. These are
    Luenberger's conditions, which are necessary and sufficient.""",
    dynamics := define(T_next * A, F * T + D * C, "9"),
    driven := define(T_next * B, G + D * E, "10"),
    error_equation := letters.derive(
        "11", "the error is driven by the noises alone", eps_next
    )
    .put(collected)
    .use(dynamics, driven),
    """The estimate combines the observer with the measurement of the moment. It is
    unbiased for every state and input exactly if two more residuals vanish.""",
    estimate := define(x_hat, P * z + V * y + W * u, "12"),
    is_e := define(e, x_hat - x),
    biased := letters.derive("12", "the error of an estimate", e)
    .put(is_e)
    .put(estimate)
    .put(follows, measured)
    .collect(x, u),
    unbiased := define(P * T + V * C, I, "13"),
    is_W := define(W, -V * E),
    error := letters.derive("13, 26", "the error of an unbiased estimate", e)
    .put(biased)
    .use(unbiased, is_W),
    """A state that neither the observer follows nor the measurement shows must then be
    zero. So together they need `n` rows, and the observer at least `n - p` of
    them.""",
    not_followed := define(T * b, gone(r, 1)),
    not_shown := define(C * b, gone(p, 1)),
    letters.derive("13", "the least order of an observer", b)
    .insert((P * T + V * C) * b, unbiased)
    .use(not_followed, not_shown),
)

SOLUTION = (
    """Put (13) behind `T_next A`, and compare with (9) what ends in `T` and in `C`.
    What stands before them are Huddle's equations: one solution of (9), wherever the
    estimate is unbiased.""",
    between := letters.derive("9, 14, 15", "what an estimate makes of it", T_next * A)
    .insert(T_next * A * (P * T + V * C), unbiased)
    .expand(),
    *(huddle := between.match(F * T + D * C, "14", "15")),
    letters.derive("9, 14, 15", "the solution satisfies the condition", F * T + D * C)
    .put(*huddle)
    .use(unbiased),
    """Then the observer errs as the prediction does, seen through `T`: its error needs
    no other equation.""",
    seen := letters.derive(
        "11, 14, 15", "the observer errs as the prediction does", eps_next
    )
    .put(error_equation)
    .put(*huddle)
    .fold(error)
    .factor(),
    """Other solutions differ by `Z_1` and `Z_2` that cancel each other. They are all of
    the following form, with `X_1` and `X_2` free.""",
    chain(
        "9",
        "what may be added to a solution",
        (X_1 * (Identity(r) - T * P) - X_2 * C * P) * T
        + (X_2 * (Identity(p) - C * V) - X_1 * T * V) * C,
        Line((X_1 * T + X_2 * C) * (I - P * T - V * C), why="collect"),
        Line(gone(r, n), by=(unbiased,)),
    ),
    """An observer of least order, `r = n - p`, leaves no choice. There the rows of `T`
    and `C` together are invertible, with `P` and `V` the columns of the inverse.""",
    cancel := define(Z_1 * T + Z_2 * C, gone(r, n)),
    TP := define(T * P, Identity(r)),
    CP := define(C * P, gone(p, r)),
    TV := define(T * V, gone(r, p)),
    CV := define(C * V, Identity(p)),
    letters.derive("14", "at least order nothing can be added to the dynamics", Z_1)
    .insert((Z_1 * T + Z_2 * C) * P, TP, CP)
    .use(cancel),
    letters.derive("15", "at least order nothing can be added to the input", Z_2)
    .insert((Z_1 * T + Z_2 * C) * V, TV, CV)
    .use(cancel),
)
is_F, is_D = huddle


@cache
def derive():
    """The page."""
    page = (*ERROR, *SOLUTION)
    return Derivation(page=page, letters=letters, source=f"{SOURCE}, section II")
