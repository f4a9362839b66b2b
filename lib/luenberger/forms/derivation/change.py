"""A change of coordinates keeps the estimate and the certificate.

The state of an observer is an aid: only its estimate counts.  In coordinates `z_S` all
matrices change together, and what makes them an observer holds as before.  States that
the estimate never shows can be left out on the way.

Source: ours; that a change of coordinates keeps what a system does is common knowledge.
"""

from functools import cache

from matrixproof import Derivation, Line, Page, Stage

from .letters import *

SOURCE = "ours"
letters = letters.here()
let, suppose = letters.let, letters.suppose
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
rest = page(suppose(S * F * U * S, S * F))
shown = page(suppose(P * U * S, P))

page("These are the matrices in the new coordinates.")
is_z = page(let(z_S, S * z))
is_F = page(let(F_S, S * F * U))
is_G = page(let(G_S, S * G))
is_D = page(let(D_S, S * D))
is_P = page(let(P_S, P * U))
is_T = page(let(T_S, S * T))

page("The observer moves in the new coordinates as it did in the old ones.")
moves = page(let(z_next, F * z + G * u + D * y))
page.chain(
    "",
    "the same motion",
    S * z_next,
    Line(S * (F * z + G * u + D * y), by=(moves,)),
    Line(S * F * U * S * z + S * G * u + S * D * y, by=(rest,)),
    Line(F_S * z_S + G_S * u + D_S * y, by=(is_F, is_z, is_G, is_D)),
)

page("The estimate is the same at every instant, from every start and for every input.")
is_w = page(let(w_hat, P * z + V * y + W * u))
page.chain(
    "",
    "the same estimate",
    w_hat,
    Line(P * z + V * y + W * u, by=(is_w,)),
    Line(P * U * S * z + V * y + W * u, by=(shown,)),
    Line(P_S * z_S + V * y + W * u, by=(is_P, is_z)),
)

page("""What makes an observer of these matrices are equations between them and the
    plant. The feedthrough has none of the matrices that change.""")
dynamics = page(suppose(T * A, F * T + D * C))
page.chain(
    "",
    "the error moves as before",
    T_S * A,
    Line(S * T * A, by=(is_T,)),
    Line(S * (F * T + D * C), by=(dynamics,)),
    Line(S * F * U * S * T + S * D * C, by=(rest,)),
    Line(F_S * T_S + D_S * C, by=(is_F, is_T, is_D)),
)
enters = page(suppose(T * B, G + D * E))
page.chain(
    "",
    "the known input enters as before",
    T_S * B,
    Line(S * T * B, by=(is_T,)),
    Line(S * (G + D * E), by=(enters,)),
    Line(G_S + D_S * E, by=(is_G, is_D)),
)
output = page(let(L, P * T + V * C))
page.chain(
    "",
    "the estimate shows what it did",
    L,
    Line(P * T + V * C, by=(output,)),
    Line(P * U * S * T + V * C, by=(shown,)),
    Line(P_S * T_S + V * C, by=(is_P, is_T)),
)

page("""A program that makes the new matrices in another way is measured by two
    equations without an inverse of its own. Where nothing is left out, the first also
    says that the poles are the same.""")
page.chain(
    "",
    "what is measured of the motion",
    F_S * S,
    Line(S * F * U * S, by=(is_F,)),
    Line(S * F, by=(rest,)),
)
page.chain(
    "",
    "what is measured of the estimate",
    P_S * S,
    Line(P * U * S, by=(is_P,)),
    Line(P, by=(shown,)),
)


@cache
def changed():
    """All that changes of an observer, in the coordinates S z; U leads back."""
    stages = (
        Stage(F_S, S * F * U, by=(is_F,)),
        Stage(G_S, S * G, by=(is_G,)),
        Stage(D_S, S * D, by=(is_D,)),
        Stage(P_S, P * U, by=(is_P,)),
        Stage(T_S, S * T, by=(is_T,)),
        Stage(z_S, S * z, by=(is_z,)),
    )
    return Derivation(
        (F, G, D, P, T, z, S, U),
        stages,
        source=SOURCE,
        letters=letters,
        says="the observer in new coordinates",
    )


page(changed())
