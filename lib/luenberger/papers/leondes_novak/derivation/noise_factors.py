"""The error of any observer, and both noises of the plant, with factors.

Where the noises are correlated their covariances have one factor in common, with rows
for each.  What one noise tells of the other is taken out of it.

Source: our own; the recursions are Leondes and Novak's (1974), (11), (26).
"""

from sympy import symbols

from matrixproof import Identity, Page, ZeroMatrix
from matrixproof.derivation import equivalent

from .correlated_noise import (
    decorrelation,
    error_recursion,
    is_Qs,
    is_Sigma,
    is_X_next,
    told,
)
from .letters import SOURCE, letters, n, p, r
from .letters.observer import D, F, P, T_next, V, X, X_next
from .letters.plant import C, J, Q, Qs, R, S
from .letters.step import K, M, Sigma
from .quadratic import is_M, is_N
from .steady_gain import over

k, q = symbols("k q", integer=True, nonnegative=True)
letters = letters.here()
H = letters("H", r, k, "factor of `X`")
G = letters("G", n, q, "factor of `Qs`")
Nw = letters("Nw", n, q, "rows of the common factor: the process noise")
Nv = letters("Nv", p, q, "rows of the common factor: the measurement noise")
moved = letters("moved", r, k, "where `H` is moved")
drive = letters("drive", r, q, "what the noises add to that")
shown = letters("shown", n, k, "what the estimate shows of `H`")
drawn = letters("drawn", n, q, "what the measurement noise adds to that")
b = letters("b", p, q, "combinations of outputs without noise")
Z = letters("Z", n, q, "what may be added to `J`")


page = Page(letters=letters, source=f"our own; {SOURCE}")

page("""The error of any observer has a factor as well. If the noises are correlated
    they share one, with `Nw` and `Nv` for its rows.""")
is_X = page.suppose(H * H.T, X)
is_R = page.suppose(Nv * Nv.T, R)
is_Q = page.suppose(Nw * Nw.T, Q)
is_S = page.suppose(Nw * Nv.T, S)
is_moved = page.let(moved, F * H, "11")
is_drive = page.let(drive, D * Nv - T_next * Nw, "11")
page(is_X_next)
is_shown = page.let(shown, P * H, "26")
is_drawn = page.let(drawn, V * Nv, "26")
page(is_Sigma)

root_error = page.program(
    "a factor of the covariance of any observer's error",
    (F, D, T_next, P, V, Nw, Nv, H),
    (is_moved, "(11)"),
    (is_drive, "(11)"),
    (is_shown, "(26)"),
    (is_drawn, "(26)"),
)
squares = {
    moved * moved.T + drive * drive.T: X_next,
    shown * shown.T + drawn * drawn.T: Sigma,
}
known = is_X, is_R, is_Q, is_S
page(*equivalent(root_error, error_recursion, *known, same=squares))


page("""What the measurement's noise tells of the process noise is taken out of the
    shared factor, too.""")
page(told)
is_what_is_left = page.let(G, Nw - J * Nv)
page(is_Qs)
page("""Where `R` is singular, `J R = S` leaves `J` free in the directions `b` without
    noise.""")
page(is_M, is_N)
silent = page.suppose(b.T * R, ZeroMatrix(q, p))
page(
    letters.derive(
        "", "what may be added to the matrix that is told", (J + Z * b.T) * R
    )
    .use(silent)
    .fold(told)
)

page("""The prediction then differs by what `b` shows of the residual. That part of the
    residual vanishes for the Kalman filter, and for accurate outputs without noise.
    Beside a noisy output that is treated as exact it does not vanish.""")
says = "what combinations without noise show of the residual"
page(
    letters.derive("", says, b.T * (Identity(p) - C * K) * M)
    .use(over)
    .put(is_N)
    .use(is_M)
    .use(silent)
)

root_decorrelation = page.program(
    "a factor of the process noise that is left", (Nw, Nv, J), is_what_is_left
)
page(
    *equivalent(
        root_decorrelation,
        decorrelation,
        *known,
        same={G * G.T: Qs},
        says="a factor of the covariance of what is left",
    )
)
