"""A change of coordinates keeps the estimate and the certificate.

The state of an observer is an aid: only its estimate counts.  In coordinates `z_S` all
matrices change together, and what makes them an observer holds as before.  States that
the estimate never shows can be left out on the way.

Source: ours; that a change of coordinates keeps what a system does is common knowledge.
"""

from matrixproof import Page

from .letters import C, E, F, L, P, T, V, W, letters, m, n, p, q, r, s, u, w_hat, y, z

SOURCE = "ours"
letters = letters.here()
A = letters("A", n, n, "moves the state of the plant")
B = letters("B", n, m, "what the known input does to it")
G = letters("G", r, m, "what the known input does to the observer")
D = letters("D", r, p, "what the measurement does to the observer")
z_next = letters("z_next", r, 1, "the same one step on, or its rate")
S = letters("S", s, r, "changes the coordinates, and leaves out what is not shown")
U = letters("U", r, s, "changes them back")
F_S = letters("F_S", s, s, "`F` in the new coordinates")
G_S = letters("G_S", s, m, "`G` in the new coordinates")
D_S = letters("D_S", s, p, "`D` in the new coordinates")
P_S = letters("P_S", q, s, "`P` in the new coordinates")
T_S = letters("T_S", s, n, "`T` in the new coordinates")
z_S = letters("z_S", s, 1, "state of the observer in the new coordinates")


page = Page(letters=letters, source=SOURCE)

page("""The state of the observer in new coordinates is `S z`, and `U` leads back as far
    as the estimate shows: what `S` leaves out moves neither the rest nor the estimate.
    Where `S` is nonsingular and `U` its inverse, nothing is left out.""")
rest = page.suppose(S * F * U * S, S * F)
shown = page.suppose(P * U * S, P)

page("These are the matrices in the new coordinates.")
is_z = page.let(z_S, S * z)
is_F = page.let(F_S, S * F * U)
is_G = page.let(G_S, S * G)
is_D = page.let(D_S, S * D)
is_P = page.let(P_S, P * U)
is_T = page.let(T_S, S * T)

page("The observer moves in the new coordinates as it did in the old ones.")
moves = page.let(z_next, F * z + G * u + D * y)
page(
    letters.derive("", "the same motion", S * z_next)
    .put(moves)
    .by(S * F * U * S * z + S * G * u + S * D * y, rest)
    .fold(is_F, is_z, is_G, is_D)
)

page("The estimate is the same at every instant, from every start and for every input.")
is_w = page.let(w_hat, P * z + V * y + W * u)
page(
    letters.derive("", "the same estimate", w_hat)
    .put(is_w)
    .by(P * U * S * z + V * y + W * u, shown)
    .fold(is_P, is_z)
)

page("""What makes an observer of these matrices are equations between them and the
    plant. The feedthrough has none of the matrices that change.""")
dynamics = page.suppose(T * A, F * T + D * C)
page(
    letters.derive("", "the error moves as before", T_S * A)
    .put(is_T)
    .use(dynamics)
    .by(S * F * U * S * T + S * D * C, rest)
    .fold(is_F, is_T, is_D)
)
enters = page.suppose(T * B, G + D * E)
page(
    letters.derive("", "the known input enters as before", T_S * B)
    .put(is_T)
    .use(enters)
    .fold(is_G, is_D)
)
output = page.let(L, P * T + V * C)
page(
    letters.derive("", "the estimate shows what it did", L)
    .put(output)
    .by(P * U * S * T + V * C, shown)
    .fold(is_P, is_T)
)

page("""A program that makes the new matrices in another way is measured by two
    equations without an inverse of its own. Where nothing is left out, the first also
    says that the poles are the same.""")
page(letters.derive("", "what is measured of the motion", F_S * S).put(is_F).use(rest))
page(
    letters.derive("", "what is measured of the estimate", P_S * S).put(is_P).use(shown)
)

changed = page.program(
    "the observer in new coordinates",
    (F, G, D, P, T, z, S, U),
    is_F,
    is_G,
    is_D,
    is_P,
    is_T,
    is_z,
)
