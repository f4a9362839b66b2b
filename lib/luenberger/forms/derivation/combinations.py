"""Combinations of what an observer estimates are estimated by the same observer.

Whoever needs a torque, and not the whole state, takes the rows of the output map that
belong to it.  The state of the observer and its motion stay as they are.

Source: ours; that an observer of the state estimates each `k x` is common knowledge.
"""

from matrixproof import Page, ZeroMatrix

from .letters import C, E, L, P, T, V, W, letters, m, n, p, q, r, s, u, w_hat, y, z

letters = letters.here()
H = letters("H", s, q, "which combinations of the estimates, a row for each")
w_H = letters("w_H", s, 1, "estimate of the combinations")
L_H = letters("L_H", s, n, "what is estimated of the state")
P_H = letters("P_H", s, r, "what the combinations take from the observer")
V_H = letters("V_H", s, p, "what they take from the measurement")
W_H = letters("W_H", s, m, "what they take from the known input")


SOURCE = "ours"


page = Page(letters=letters, source=SOURCE)

page("""Let each row of `H` be a combination of the estimates. The output map of the
    observer is combined in the same way, and so is what it estimates.""")
is_L = page.let(L_H, H * L)
is_P = page.let(P_H, H * P)
is_V = page.let(V_H, H * V)
is_W = page.let(W_H, H * W)

page("The new estimate is the combination of the old ones, at every instant.")
shows = page.let(w_hat, P * z + V * y + W * u)
combined = page.let(w_H, H * w_hat)
page(
    letters.derive("", "the combined estimate", w_H)
    .put(combined, shows)
    .fold(is_P, is_V, is_W)
)

page("""Of the four equations that make an observer, two are about its motion, and they
    stay. The others are about its estimate, and they hold for each combination.""")
output = page.suppose(P * T + V * C, L)
page(
    letters.derive("", "the combinations are unbiased", P_H * T + V_H * C)
    .put(is_P, is_V)
    .use(output)
    .fold(is_L)
)
through = page.suppose(W + V * E, ZeroMatrix(q, m))
page(
    letters.derive(
        "", "the known input does not disturb the combinations", W_H + V_H * E
    )
    .put(is_W, is_V)
    .use(through)
)

combined_estimates = page.program(
    "the output map of combinations", (P, V, W, L, H), is_P, is_V, is_W, is_L
)
