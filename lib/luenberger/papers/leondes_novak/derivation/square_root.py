"""The filter's recursions with factors of the covariances.

A covariance that is singular is carried as a factor.  Nothing is subtracted then, so no
product is ever indefinite.  Rounding by 1e-16 in a factor is rounding by 1e-32 in its
covariance.

Source: our own; the recursions are Leondes and Novak's (1974), (11), (26), (27), (33).
"""

from sympy import symbols

from matrixproof import BlockMatrix, Identity, Page, ZeroMatrix
from matrixproof.derivation import equivalent

from .best_coordinates import gain_stage, gain_step
from .letters import SOURCE, I, letters, n, p
from .letters.accurate import Gamma
from .letters.plant import As, C, Qs, R
from .letters.step import K, Kmv, M, N, Omega, Sigma, Sigma_next, Y
from .quadratic import is_M, is_N, is_Sigma_next, is_Y

d, k, q, s = symbols("d k q s", integer=True, nonnegative=True)
letters = letters.here()
H = letters("H", n, d, "factor of `Sigma`")
H_minus = letters("H_minus", n, k, "factor of `Omega`")
G = letters("G", n, q, "factor of `Qs`")
V = letters("V", p, q, "factor of `R`")
L = letters("L", p, k, "what the outputs show of `H_minus`")
U = letters("U", d, k, "matrix with orthogonal rows")
kept = letters("kept", n, k, "what the gain leaves of `H_minus`")
drawn = letters("drawn", n, q, "what the gain adds of the measurement noise")
Z = letters("Z", p, k + q, "factor of `M`")
H_0 = letters("H_0", n, k + q, "`H_minus` beside zeros")
Q_Z = letters("Q_Z", k + q, p, "orthonormal columns that span those of `Z'`")
R_Z = letters("R_Z", p, p, "upper triangle, invertible where `M` is")
W_Z = letters("W_Z", p, p, "rounding of each row of `Z`, on a diagonal")
U_Z = letters("U_Z", p, s, "left singular vectors of `Z`, in units of rounding")
D_Z = letters("D_Z", s, s, "singular values that are more than rounding")
T_Z = letters("T_Z", k + q, s, "right singular vectors")

WITNESS = {Y: -4, Z: [[-4, 1], [-2, -3]], kept: -8}


page = Page(letters=letters, source=f"our own; {SOURCE}", witness=WITNESS)

page("""A factor of a covariance moves as the error does, and a factor of the noise
    stands beside it.""")
is_H = page.suppose(H * H.T, Sigma)
is_G = page.suppose(G * G.T, Qs)
is_Omega = page.let(Omega, As * Sigma * As.T + Qs, "44")
wide = BlockMatrix([[As * H, G]])
page(
    letters.derive("44", "a factor of the covariance of the prediction", wide * wide.T)
    .multiply()
    .use(is_H, is_G)
    .fold(is_Omega)
)

page("The gain takes from it what the outputs show.")
is_H_minus = page.suppose(H_minus * H_minus.T, Omega)
is_L = page.let(L, C * H_minus)
page(is_M, is_N)
factored_M = page(
    letters.derive("33", "the covariance of the innovation in factors", M)
    .put(is_M)
    .by(L * L.T + R, is_H_minus, is_L)
)
factored_N = page(
    letters.derive("33", "the other composite in factors", N)
    .put(is_N)
    .by(H_minus * L.T, is_H_minus, is_L)
)

page("A factor `Z` of `M` takes the place of `M`, which holds half of the digits.")
is_R = page.suppose(V * V.T, R)
is_Z = page.let(Z, BlockMatrix([[L, V]]))
is_H_0 = page.let(H_0, BlockMatrix([[H_minus, ZeroMatrix(n, q)]]))
root_of_M = page(
    letters.derive("33", "a factor of the covariance of the innovation", M)
    .use(factored_M)
    .fold(is_R)
    .by(Z * Z.T, is_Z)
)
root_of_N = page(
    letters.derive("33", "the other composite by that factor", N)
    .use(factored_N)
    .by(H_0 * Z.T, is_H_0, is_Z)
)

page("""Where `M` is positive definite, `Z'` is a product of orthonormal columns and a
    triangle. They give the gain: `K_mv'` is the least-squares answer to `Z' K_mv' =
    H_0'`.""")
with page.scope(letters.suppose(Z, R_Z.T * Q_Z.T)) as triangle:
    columns = page.suppose(Q_Z.T * Q_Z, Identity(p))
    definite = page.let(Kmv, H_0 * Q_Z * R_Z.T.I, "33")
    says = "the gain where the covariance is positive definite"
    page(
        letters.derive("33", says, Kmv * M)
        .by(H_0 * Q_Z * R_Z.T.I * Z * Z.T, definite, root_of_M)
        .by(H_0 * Z.T, triangle, columns)
        .fold(root_of_N)
    )

page("""Where `M` is singular, the singular values of `Z` that are rounding are left
    out. The rest give a gain that solves `K_mv M = N`.""")
with page.scope(letters.suppose(Z, W_Z * U_Z * D_Z * T_Z.T)) as parts:
    left = page.suppose(U_Z.T * U_Z, Identity(s))
    right = page.suppose(T_Z.T * T_Z, Identity(s))
    singular = page.let(Kmv, H_0 * T_Z * D_Z.I * U_Z.T * W_Z.I, "33")
    page(
        letters.derive("33", "the gain where the covariance is singular", Kmv * M)
        .by(H_0 * T_Z * D_Z.I * U_Z.T * W_Z.I * Z * Z.T, singular, root_of_M)
        .by(H_0 * T_Z * T_Z.T * Z.T, parts, left)
        .by(H_0 * Z.T, parts, right)
        .fold(root_of_N)
    )

page("""Outputs without noise may determine the state: `K_mv` reads it off, and lets no
    noise in. That gain needs no solve and is right for every `Omega`.""")
read, quiet = (
    letters.suppose(Kmv * C, I),
    letters.suppose(Kmv * R, ZeroMatrix(n, p)),
)
with page.scope(read, quiet):
    page(
        letters.derive("33", "the gain that reads the state off", Kmv * M)
        .put(is_M)
        .by(Omega * C.T, read, quiet)
        .fold(is_N)
    )

page("""The next covariance is a sum of two squares for any gain, and each has a factor.
    Side by side they are a factor of the sum.""")
page(is_Y, is_Sigma_next)
is_kept = page.let(kept, Y * H_minus)
is_drawn = page.let(drawn, K * V)
says = "the next covariance in factors"
page(
    letters.derive("27", says, Y * Omega * Y.T + K * R * K.T).fold(
        is_H_minus, is_kept, is_R, is_drawn
    )
)
root_update = page.program(
    "a factor of the next covariance",
    (C, V, Gamma, Kmv, H_minus),
    gain_stage,
    (is_Y, "(13)"),
    is_kept,
    is_drawn,
)
square = {kept * kept.T + drawn * drawn.T: Sigma_next}
page(*equivalent(root_update, gain_step, is_H_minus, is_R, same=square))

page("""So a factor gets wider at every step. A matrix with orthogonal rows between the
    two factors brings it back to `n` columns.""")
orthogonal = page.suppose(U * U.T, Identity(d))
page(
    letters.derive("", "orthogonal rows change no covariance", H * U * (H * U).T).use(
        orthogonal
    )
)
