"""The error of any observer, and both noises of the plant, with factors.

Where the noises are correlated their covariances have one factor in common, with rows
for each.  What one noise tells of the other is taken out of it.

Source: our own; the recursions are Leondes and Novak's (1974), (11), (26).
"""

from functools import cache

from sympy import symbols

from matrixproof import Derivation, Line, Page, Stage, ZeroMatrix

from .correlated_noise import is_Qs, is_Sigma, is_X_next, told
from .letters import *
from .quadratic import is_M, is_N
from .steady_gain import over

k, q = symbols("k q", integer=True, nonnegative=True)
letters = letters.here()
let, suppose = letters.let, letters.suppose
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
is_X = page(suppose(H * H.T, X))
is_R = page(suppose(Nv * Nv.T, R))
is_Q = page(suppose(Nw * Nw.T, Q))
is_S = page(suppose(Nw * Nv.T, S))
is_moved = page(let(moved, F * H, "11"))
is_drive = page(let(drive, D * Nv - T_next * Nw, "11"))
page(is_X_next)
noises = page.chain(
    "11",
    "what the noises add",
    drive * drive.T,
    Line((D * Nv - T_next * Nw) * (D * Nv - T_next * Nw).T, by=(is_drive,)),
    Line(
        D * Nv * Nv.T * D.T
        + T_next * Nw * Nw.T * T_next.T
        - D * Nv * Nw.T * T_next.T
        - T_next * Nw * Nv.T * D.T,
        why="multiply out",
    ),
    Line(
        D * R * D.T + T_next * Q * T_next.T - D * S.T * T_next.T - T_next * S * D.T,
        by=(is_R, is_Q, is_S),
    ),
)
page.chain(
    "11",
    "a factor of the covariance of the observer's error",
    moved * moved.T + drive * drive.T,
    Line(F * H * H.T * F.T + drive * drive.T, by=(is_moved,)),
    Line(F * X * F.T + drive * drive.T, by=(is_X,)),
    Line(F * X * F.T + noises.right, by=(noises,)),
    Line(X_next, by=(is_X_next,)),
)
is_shown = page(let(shown, P * H, "26"))
is_drawn = page(let(drawn, V * Nv, "26"))
page(is_Sigma)
page.chain(
    "26",
    "a factor of the covariance of the estimate",
    shown * shown.T + drawn * drawn.T,
    Line(P * H * H.T * P.T + V * Nv * Nv.T * V.T, by=(is_shown, is_drawn)),
    Line(P * X * P.T + V * R * V.T, by=(is_X, is_R)),
    Line(Sigma, by=(is_Sigma,)),
)


@cache
def root_error():
    """A factor H of cov(eps) one step on, and of the error itself: (11), (26).

    Nw and Nv are the rows of a factor of [[Q, S], [S', R]].
    """
    return Derivation(
        (F, D, T_next, P, V, Nw, Nv, H),
        (
            Stage(moved, F * H, "(11)", by=(is_moved,)),
            Stage(drive, D * Nv - T_next * Nw, "(11)", by=(is_drive,)),
            Stage(shown, P * H, "(26)", by=(is_shown,)),
            Stage(drawn, V * Nv, "(26)", by=(is_drawn,)),
        ),
        source="our own",
        letters=letters,
        says="a factor of the covariance of any observer's error",
    )


page(root_error())


page("""What the measurement's noise tells of the process noise is taken out of the
    shared factor, too.""")
page(told)
is_what_is_left = page(let(G, Nw - J * Nv))
page(is_Qs)
page.chain(
    "",
    "a factor of the covariance of what is left",
    G * G.T,
    Line((Nw - J * Nv) * (Nw - J * Nv).T, by=(is_what_is_left,)),
    Line(Q - J * S.T - S * J.T + J * R * J.T, by=(is_Q, is_S, is_R)),
    Line(Q - J * S.T - J * R * J.T + J * R * J.T, by=(told,)),
    Line(Qs, by=(is_Qs,)),
)

page("""Where `R` is singular, `J R = S` leaves `J` free in the directions `b` without
    noise.""")
page(is_M, is_N)
silent = page(suppose(b.T * R, ZeroMatrix(q, p)))
page.chain(
    "",
    "what may be added to the matrix that is told",
    (J + Z * b.T) * R,
    Line(J * R, by=(silent,)),
    Line(S, by=(told,)),
)

page("""The prediction then differs by what `b` shows of the residual. That part of the
    residual vanishes for the Kalman filter, and for accurate outputs without noise.
    Beside a noisy output that is treated as exact it does not vanish.""")
page.chain(
    "",
    "what combinations without noise show of the residual",
    b.T * (Identity(p) - C * K) * M,
    Line(b.T * M - b.T * C * K * M, why="multiply out"),
    Line(b.T * M - b.T * C * N - b.T * C * Gamma * R, by=(over,)),
    Line(b.T * M - b.T * C * Omega * C.T - b.T * C * Gamma * R, by=(is_N,)),
    Line(b.T * R - b.T * C * Gamma * R, by=(is_M,)),
    Line(-b.T * C * Gamma * R, by=(silent,)),
)


@cache
def root_decorrelation():
    """A factor G of Qs, from the rows Nw, Nv of one of [[Q, S], [S', R]]."""
    return Derivation(
        (Nw, Nv, J),
        (Stage(G, Nw - J * Nv, by=(is_what_is_left,)),),
        source="our own",
        letters=letters,
        says="a factor of the process noise that is left",
    )


page(root_decorrelation())
