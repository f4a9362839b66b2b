"""Theorem 1, the change of coordinates, and why the stairs can be triangles.

All of it holds for every size, for complex plants as for real ones, and for both
kinds of time: the index + is the next instant or the derivative.

Source: Van Dooren (1984), (1)-(12), (24), remark 2(c); reflectors after Householder.
"""

from matrixproof import BlockMatrix, Identity, Page, ZeroMatrix
from matrixproof.explicit import Construction

from ....theory import observer
from .letters import A_U, C_U, T_U, A, C, D, F, I, W, letters, m, n, r, s, x

letters = letters.here()
B = letters("B", n, m, "what the input does to the state")
G = letters("G", n - r, m, "what the input does to it")
P = letters("P", n, n - r, "what the estimate takes of the observer's state")
V = letters("V", n, r, "what the estimate takes of the measurement")
T = letters("T", n - r, n, "what the observer's state tracks")
x_next = letters("x_next", n, 1, "state one step on, or its derivative")
x_hat = letters("x_hat", n, 1, "estimate of the state")
u = letters("u", m, 1, "input")
y = letters("y", r, 1, "measurement")
z = letters("z", n - r, 1, "state of the observer")
z_next = letters("z_next", n - r, 1, "the same one step on, or its derivative")
eps = letters("varepsilon", n - r, 1, "error of the observer's state")
eps_0 = letters("varepsilon_0", n - r, 1, "the error at the start")
eps_next = letters("varepsilon_next", n - r, 1, "error one step on, or its derivative")
Phi = letters("Phi", n - r, n - r, "`F^t`; in continuous time `e^(F t)`")
Phi_next = letters("Phi_next", n - r, n - r, "the same one step on, or its derivative")
U = letters("U", n, n, "unitary: the coordinates of the staircase")
Us = letters("U^*", n, n, "its conjugate transpose")
Ws = letters("W^*", n - r, n - r, "its conjugate transpose")
X_1 = letters("X_1", n, n - r, "the first columns of the inverse of `T_U` over `C_U`")
X_2 = letters("X_2", n, r, "its other columns")
a_s = letters("a_s", n, 1, "a column")
b_s = letters("b_s", n, 1, "a column of the same length with one entry")
as_s = letters("a_s^*", 1, n, "the conjugate transpose of `a_s`")
bs_s = letters("b_s^*", 1, n, "the conjugate transpose of `b_s`")
v = letters("v", n, 1, "their difference")
vs = letters("v^*", 1, n, "its conjugate transpose")
beta = letters("beta", 1, 1, "two over `v^* v`")
rho_s = letters("rho_s", 1, 1, "that entry")
h_s = letters("h_s", 1, s - 1, "the rest of its row")
A_r = letters("A_r", r - 1, s - 1, "what is left of a stair behind its first column")
Qs_r = letters("Q_r^*", r - 1, r - 1, "unitary: makes a triangle of what is left")
R_r = letters("R_r", r - 1, s - 1, "that triangle, above zeros")
A_s = letters("A_s", r, s, "a stair; its columns are independent")
W_s = letters("W_s", s, s, "unitary: turns the states of the stair before")
Q_s = letters("Q_s", r, r, "unitary: a product of reflectors")
Qs_s = letters("Q_s^*", r, r, "its conjugate transpose")
R_s = letters("R_s", s, s, "an upper triangle with an inverse")
J_s = letters("J_s", r, s, "the identity above zeros")
C_all = letters("C_a", s, n, "all outputs, dependent or not")
Y_1 = letters("Y_1", s, r, "orthonormal columns, which span those of `C_a`")
Y_1s = letters("Y_1^*", r, s, "its conjugate transpose")
D_all = letters("D_a", n - r, s, "what all outputs do to the observer's state")


def stacked(*blocks):
    return BlockMatrix([[block] for block in blocks])


nothing = ZeroMatrix(r - 1, 1)


page = Page(letters=letters, source="Van Dooren (1984), sections 1 and 2")

page("The plant, the observer, and its estimate of the whole state.")
is_x = page.let(x_next, A * x + B * u, "1")
is_y = page.let(y, C * x, "1")
is_z = page.let(z_next, F * z + D * y + G * u, "2")
is_estimate = page.let(x_hat, P * z + V * y, "3")

page("The theorem asks for a `T` with two properties, and takes the gains from it.")
tracked = page.suppose(T * A, F * T + D * C, "4")
driven = page.let(G, T * B, "5")
whole = page.suppose(P * T + V * C, I, "5")

page("""Then the observer's state tracks `T x`, with an error that nothing drives. The
    estimate errs by a multiple of it.""")
is_eps = page.let(eps, z - T * x)
is_eps_next = page.let(eps_next, z_next - T * x_next)
no_noise = dict(C=C, T=T, T_next=T, w=ZeroMatrix(n, 1), v=ZeroMatrix(r, 1))
no_noise |= dict(E=ZeroMatrix(r, m), W=ZeroMatrix(n, m))
free = page.at("1, 2, 4, 5", "the error moves by itself", observer.free, **no_noise)
shown = dict(L=I, w_hat=x_hat, e=x_hat - x)
says = "the estimate errs by a multiple of it"
errs = page.at("3, 5", says, observer.error, **no_noise, **shown)

page("""So the error is `F^t` times what it was at the start; in continuous time, for
    which alone the paper writes it, `e^(F t)` times. Both begin with the identity and
    both move by `F`, and an error that moves so has no choice.""")
flows = page.let(Phi_next, F * Phi)
with page.scope(letters.suppose(eps, Phi * eps_0)) as carried:
    start = letters.derive("6", "the error at any time", eps_next)
    page(start.put(free).put(carried).fold(flows))
    start = letters.derive("6", "the error of the estimate at any time", x_hat - x)
    page(start.use(errs).put(carried))

page("""Unitary coordinates neither enlarge a rounding error nor change how sensitive
    the solution is. They turn the equation for `T` into one for `T_U`.""")
inverse = page.suppose(U * Us, I, "7")
is_A_U = page.let(A_U, Us * A * U, "7")
is_C_U = page.let(C_U, C * U, "7")
is_T_U = page.let(T_U, T * U, "10")
says = "the equation in these coordinates"
start = letters.derive("9, 10", says, T_U * A_U - F * T_U)
page(start.put(is_T_U, is_A_U).use(inverse).use(tracked).fold(is_C_U))
start = letters.derive("9, 10", "both are invertible or none is", stacked(T, C) * U)
page(start.multiply().fold(is_T_U, is_C_U))

page("A solution in these coordinates leads back, with both gains.")
solved = page.suppose(T_U * A_U, F * T_U + D * C_U, "10")
is_T = page.suppose(T, T_U * Us)
page(
    letters.derive("4, 10", "back to the coordinates of the plant", T * A - F * T)
    .put(is_T)
    .insert(T_U * A_U * Us - F * T_U * Us, is_A_U, inverse)
    .use(solved)
    .put(is_C_U)
    .use(inverse)
)
page(letters.derive("24", "the gain of the input", G).put(driven, is_T))
left_inverse = page.suppose(X_1 * T_U + X_2 * C_U, I)
page(
    letters.derive("24", "the gains of the estimate", U * X_1 * T + U * X_2 * C)
    .put(is_T)
    .insert(U * (X_1 * T_U + X_2 * C_U) * Us, is_C_U, inverse)
    .use(left_inverse)
    .use(inverse)
)

page("""A unitary change of the observer's state brings `F` to triangular form, and
    changes `T_U` and `D` with it. So a triangular `F` loses nothing.""")
turned = page.suppose(W * Ws, Identity(n - r))
says = "the observer in other coordinates"
start = letters.derive("11, 12", says, Ws * T_U * A_U - Ws * F * W * Ws * T_U)
page(start.use(turned).use(solved))
start = letters.derive(
    "11, 12",
    "and its matrix is invertible as before",
    BlockMatrix([[W, ZeroMatrix(n - r, r)], [ZeroMatrix(r, n - r), Identity(r)]])
    * stacked(Ws * T_U, C_U),
)
page(start.multiply().use(turned))

page("""That the stairs can be triangles is a construction. A reflector takes a column
    to any other of the same length; for complex entries the phase of `b_s` is chosen so
    that `b_s^* a_s` is real.""")
is_v = page.let(v, a_s - b_s)
is_vs = page.let(vs, as_s - bs_s)
long = page.suppose(bs_s * b_s, as_s * a_s)
real = page.suppose(as_s * b_s, bs_s * a_s)
start = letters.derive("8", "how long the vector of a reflector is", vs * v)
doubled = page(start.put(is_v, is_vs).expand().use(long, real).factor().fold(is_vs))

page("So there is a `beta`, unless the columns are the same and nothing is to be done.")
scaled = page.suppose(beta * vs * a_s, Identity(1))
says = "a reflector leaves one entry of a column"
start = letters.derive("8", says, (I - v * beta * vs) * a_s)
page(start.expand().use(scaled).put(is_v).expand())
start = letters.derive("8", "the factor of a reflector", beta * vs * v)
norm = page(start.use(doubled).use(scaled))
says = "a reflector is its own inverse"
start = letters.derive("8", says, (I - v * beta * vs) * (I - v * beta * vs))
page(start.expand().use(norm))

page("""One reflector for each column makes a triangle of a stair: if what is left
    behind the first column has a triangle, so has the whole.""")
smaller = page.suppose(Qs_r * A_r, R_r)
start = letters.derive(
    "8",
    "one column after the other",
    BlockMatrix([[Identity(1), ZeroMatrix(1, r - 1)], [nothing, Qs_r]])
    * BlockMatrix([[rho_s, h_s], [nothing, A_r]]),
)
page(start.multiply().use(smaller))

page("""Independent columns make all entries of its diagonal different from zero. The
    reflectors turn the states of the next stair, which is made a triangle after it, and
    so on; the last ones turn the outputs.""")
factors = page.suppose(A_s * W_s, Q_s * J_s * R_s)
unitary = page.suppose(Qs_s * Q_s, Identity(r))
start = letters.derive("8", "a stair becomes a triangle", Qs_s * A_s * W_s)
page(start.use(factors).use(unitary))

page("""Whoever may not turn the outputs begins at the other end, with the columns of
    `C_k`, and gets triangles in the last rows of tall stairs. Whoever may turn them
    needs no independent outputs either: what is left of dependent ones is `C`.""")
spanned = page.suppose(Y_1 * C, C_all)
orthonormal = page.suppose(Y_1s * Y_1, Identity(r))
for_all = page.suppose(D_all * C_all, T * A - F * T, "4")
page(
    Construction(
        "remark 2(c)",
        "an observer of all outputs, dependent or not",
        {D_all: D * Y_1s},
        satisfies=(for_all,),
        by=(spanned, orthonormal, tracked),
    )
)
