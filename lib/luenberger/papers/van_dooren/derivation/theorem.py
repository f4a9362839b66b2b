"""Theorem 1, the change of coordinates, and why the stairs can be triangles.

All of it holds for every size, for complex plants as for real ones, and for both
kinds of time: the index + is the next instant or the derivative.

Source: Van Dooren (1984), (1)-(12), (24), remark 2(c); reflectors after Householder.
"""

from matrixproof import BlockMatrix, Construction, Page

from ....theory import observer
from .letters import *


def stacked(*blocks):
    return BlockMatrix([[block] for block in blocks])


nothing = ZeroMatrix(r - 1, 1)


page = Page(letters=letters, source=f"{SOURCE}, sections 1 and 2")

page("The plant, the observer, and its estimate of the whole state.")
is_x = page(let(x_next, A * x + B * u, "1"))
is_y = page(let(y, C * x, "1"))
is_z = page(let(z_next, F * z + D * y + G * u, "2"))
is_estimate = page(let(x_hat, P * z + V * y, "3"))

page("The theorem asks for a `T` with two properties, and takes the gains from it.")
tracked = page(suppose(T * A, F * T + D * C, "4"))
driven = page(let(G, T * B, "5"))
whole = page(suppose(P * T + V * C, I, "5"))

page("""Then the observer's state tracks `T x`, with an error that nothing drives. The
    estimate errs by a multiple of it.""")
is_eps = page(let(eps, z - T * x))
is_eps_next = page(let(eps_next, z_next - T * x_next))
no_noise = dict(C=C, T=T, T_next=T, w=ZeroMatrix(n, 1), v=ZeroMatrix(r, 1))
no_noise |= dict(E=ZeroMatrix(r, m), W=ZeroMatrix(n, m))
free = page.at("1, 2, 4, 5", "the error moves by itself", observer.free, **no_noise)
shown = dict(L=I, w_hat=x_hat, e=x_hat - x)
says = "the estimate errs by a multiple of it"
errs = page.at("3, 5", says, observer.error, **no_noise, **shown)

page("""So the error is `F^t` times what it was at the start; in continuous time, for
    which alone the paper writes it, `e^(F t)` times. Both begin with the identity and
    both move by `F`, and an error that moves so has no choice.""")
flows = page(let(Phi_next, F * Phi))
with page.scope(suppose(eps, Phi * eps_0)) as carried:
    page(
        letters.derive("6", "the error at any time", eps_next)
        .put(free)
        .put(carried)
        .fold(flows)
    )
    page(
        letters.derive("6", "the error of the estimate at any time", x_hat - x)
        .use(errs)
        .put(carried)
    )

page("""Unitary coordinates neither enlarge a rounding error nor change how sensitive
    the solution is. They turn the equation for `T` into one for `T_U`.""")
inverse = page(suppose(U * Us, I, "7"))
is_A_U = page(let(A_U, Us * A * U, "7"))
is_C_U = page(let(C_U, C * U, "7"))
is_T_U = page(let(T_U, T * U, "10"))
page(
    letters.derive("9, 10", "the equation in these coordinates", T_U * A_U - F * T_U)
    .put(is_T_U, is_A_U)
    .use(inverse)
    .use(tracked)
    .fold(is_C_U)
)
page(
    letters.derive("9, 10", "both are invertible or none is", stacked(T, C) * U)
    .multiply()
    .fold(is_T_U, is_C_U)
)

page("A solution in these coordinates leads back, with both gains.")
solved = page(suppose(T_U * A_U, F * T_U + D * C_U, "10"))
is_T = page(suppose(T, T_U * Us))
page(
    letters.derive("4, 10", "back to the coordinates of the plant", T * A - F * T)
    .put(is_T)
    .insert(T_U * A_U * Us - F * T_U * Us, is_A_U, inverse)
    .use(solved)
    .put(is_C_U)
    .use(inverse)
)
page(letters.derive("24", "the gain of the input", G).put(driven, is_T))
left_inverse = page(suppose(X_1 * T_U + X_2 * C_U, I))
page(
    letters.derive("24", "the gains of the estimate", U * X_1 * T + U * X_2 * C)
    .put(is_T)
    .insert(U * (X_1 * T_U + X_2 * C_U) * Us, is_C_U, inverse)
    .use(left_inverse)
    .use(inverse)
)

page("""A unitary change of the observer's state brings `F` to triangular form, and
    changes `T_U` and `D` with it. So a triangular `F` loses nothing.""")
turned = page(suppose(W * Ws, Identity(n - r)))
page(
    letters.derive(
        "11, 12",
        "the observer in other coordinates",
        Ws * T_U * A_U - Ws * F * W * Ws * T_U,
    )
    .use(turned)
    .use(solved)
)
page(
    letters.derive(
        "11, 12",
        "and its matrix is invertible as before",
        BlockMatrix([[W, ZeroMatrix(n - r, r)], [ZeroMatrix(r, n - r), Identity(r)]])
        * stacked(Ws * T_U, C_U),
    )
    .multiply()
    .use(turned)
)

page("""That the stairs can be triangles is a construction. A reflector takes a column
    to any other of the same length; for complex entries the phase of `b_s` is chosen so
    that `b_s^* a_s` is real.""")
is_v = page(let(v, a_s - b_s))
is_vs = page(let(vs, as_s - bs_s))
long = page(suppose(bs_s * b_s, as_s * a_s))
real = page(suppose(as_s * b_s, bs_s * a_s))
doubled = page(
    letters.derive("8", "how long the vector of a reflector is", vs * v)
    .put(is_v, is_vs)
    .expand()
    .use(long, real)
    .factor()
    .fold(is_vs)
)

page("So there is a `beta`, unless the columns are the same and nothing is to be done.")
scaled = page(suppose(beta * vs * a_s, Identity(1)))
page(
    letters.derive(
        "8", "a reflector leaves one entry of a column", (I - v * beta * vs) * a_s
    )
    .expand()
    .use(scaled)
    .put(is_v)
    .expand()
)
norm = page(
    letters.derive("8", "the factor of a reflector", beta * vs * v)
    .use(doubled)
    .use(scaled)
)
page(
    letters.derive(
        "8",
        "a reflector is its own inverse",
        (I - v * beta * vs) * (I - v * beta * vs),
    )
    .expand()
    .use(norm)
)

page("""One reflector for each column makes a triangle of a stair: if what is left
    behind the first column has a triangle, so has the whole.""")
smaller = page(suppose(Qs_r * A_r, R_r))
page(
    letters.derive(
        "8",
        "one column after the other",
        BlockMatrix([[Identity(1), ZeroMatrix(1, r - 1)], [nothing, Qs_r]])
        * BlockMatrix([[rho_s, h_s], [nothing, A_r]]),
    )
    .multiply()
    .use(smaller)
)

page("""Independent columns make all entries of its diagonal different from zero. The
    reflectors turn the states of the next stair, which is made a triangle after it, and
    so on; the last ones turn the outputs.""")
factors = page(suppose(A_s * W_s, Q_s * J_s * R_s))
unitary = page(suppose(Qs_s * Q_s, Identity(r)))
page(
    letters.derive("8", "a stair becomes a triangle", Qs_s * A_s * W_s)
    .use(factors)
    .use(unitary)
)

page("""Whoever may not turn the outputs begins at the other end, with the columns of
    `C_k`, and gets triangles in the last rows of tall stairs. Whoever may turn them
    needs no independent outputs either: what is left of dependent ones is `C`.""")
spanned = page(suppose(Y_1 * C, C_all))
orthonormal = page(suppose(Y_1s * Y_1, Identity(r)))
for_all = page(suppose(D_all * C_all, T * A - F * T, "4"))
page(
    Construction(
        "remark 2(c)",
        "an observer of all outputs, dependent or not",
        {D_all: D * Y_1s},
        satisfies=(for_all,),
        by=(spanned, orthonormal, tracked),
    )
)
