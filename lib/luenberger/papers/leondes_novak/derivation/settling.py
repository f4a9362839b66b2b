"""How the covariances of two rows differ, once a filter has all but settled.

The plant does not change.  A row is compared with any later one: both covariances went
through the same step, so their difference obeys an equation of its own, and a ball
around the one is found that the other can never leave.

Source: our own; the difference of two solutions of a Riccati equation is in Bitmead,
Gevers, Petersen and Kaye (1985), "Monotonicity and stabilizability properties of
solutions of the Riccati difference equation".
"""

from functools import cache

from ....symbolic import Derivation, Identity, Line, Stage
from .letters import *
from .quadratic import is_Kmv, is_M, is_N

SOURCE = "our own; Bitmead, Gevers, Petersen and Kaye (1985)"
settling = letters.here(
    Omega="covariance of the prediction where the recursion stops",
    Sigma_next="covariance of the estimate there",
)
chain, define = settling.chain, settling.define
Omega_i = settling("Omega_i", n, n, "the same in a later row", symmetric=True)
M_i = settling("M_i", p, p, "covariance of its innovation", symmetric=True)
Kmv_i = settling("Kmv_i", n, p, "its gain of minimum variance")
Sigma_i = settling("Sigma_i", n, n, "covariance of its estimate", symmetric=True)
Xi = settling("Xi", n, n, "what `Omega_i` has beside `Omega`", symmetric=True)
Theta = settling("Theta", n, p, "what a reading does to that")
U = settling("Xi_i", n, n, "what the reading leaves of it", symmetric=True)
Y_0 = settling("Y_0", n, n, "what the Kalman filter's gain leaves of an error")
F_0 = settling("F_0", n, n, "moves a difference of covariances")
G_0 = settling("G_0", n, n, "the same, of what accurate outputs see of it")
delta = settling("delta", n, n, "what one more step adds to `Omega`", symmetric=True)

DIFFERENCE = (
    """The recursion stops at a row whose prediction has the covariance `Omega`. A later
    row of the full recursion has `Omega_i`. Its gain differs by `Theta`.""",
    is_N,
    is_M,
    is_Kmv,
    is_Xi := define(Omega_i, Omega + Xi),
    is_M_i := define(M_i, M + C * Xi * C.T),
    is_Kmv_i := define(Kmv_i * M_i, Omega_i * C.T, "33"),
    is_Theta := define(Theta * M_i, Xi * C.T),
    is_Y_0 := define(Y_0, I - Kmv * C),
    chain(
        "",
        "how the Kalman filter's gain differs",
        Kmv_i * M_i - Kmv * M_i,
        Line((Omega + Xi) * C.T - Kmv * M_i, by=(is_Kmv_i, is_Xi)),
        Line((Omega + Xi) * C.T - Kmv * M - Kmv * C * Xi * C.T, by=(is_M_i,)),
        Line((I - Kmv * C) * Xi * C.T, by=(is_Kmv, is_N)),
        Line(Y_0 * Theta * M_i, by=(is_Y_0, is_Theta)),
    ),
    """`M_i` is regular. The covariance that is left differs by what a reading leaves of
    `Xi`, seen through the gain of the row at which the recursion stopped.""",
    differs := define(Kmv_i, Kmv + Y_0 * Theta),
    is_U := define(U, Xi - Theta * C * Xi),
    left := chain(
        "",
        "what the reading shows of what it leaves",
        U * C.T,
        Line(Xi * C.T - Theta * C * Xi * C.T, by=(is_U,)),
        Line(Theta * (M_i - C * Xi * C.T), by=(is_Theta,)),
        Line(Theta * M, by=(is_M_i,)),
    ),
    chain(
        "",
        "how the least covariance differs",
        Omega_i - Kmv_i * C * Omega_i - Omega + Kmv * C * Omega,
        Line(
            Xi - Kmv * C * Xi - Y_0 * Theta * C * (Omega + Xi),
            by=(is_Xi, differs),
        ),
        Line(Y_0 * (Xi - Theta * C * Xi) - Y_0 * Theta * N.T, by=(is_Y_0, is_N)),
        Line(Y_0 * U - Y_0 * Theta * M * Kmv.T, by=(is_U, is_Kmv)),
        Line(Y_0 * U * (I - Kmv * C).T, by=(left,)),
        Line(Y_0 * U * Y_0.T, by=(is_Y_0,)),
    ),
    """Accurate outputs add to the least covariance what their noise costs,
    `Gamma (I - C K_mv) R Gamma'`. It grows where the least covariance shrinks.""",
    noise := chain(
        "",
        "what is left of accurate outputs",
        (Identity(p) - C * Kmv) * M,
        Line(M - C * N, by=(is_Kmv,)),
        Line(R, by=(is_M, is_N)),
    ),
    chain(
        "",
        "how the cost of accurate outputs differs",
        Gamma * (Identity(p) - C * Kmv_i) * R * Gamma.T
        - Gamma * (Identity(p) - C * Kmv) * R * Gamma.T,
        Line(-Gamma * C * Y_0 * Theta * R * Gamma.T, by=(differs,)),
        Line(
            -Gamma * C * Y_0 * Theta * M * (Identity(p) - C * Kmv).T * Gamma.T,
            by=(noise,),
        ),
        Line(
            -Gamma * C * Y_0 * U * C.T * (Identity(p) - C * Kmv).T * Gamma.T,
            by=(left,),
        ),
        Line(-Gamma * C * Y_0 * U * Y_0.T * C.T * Gamma.T, by=(is_Y_0,)),
    ),
    """One step moves the rest on, beside what it would add to `Omega` itself.""",
    is_F_0 := define(F_0, As * Y_0),
    is_G_0 := define(G_0, As * Gamma * C * Y_0),
    is_delta := define(As * Sigma_next * As.T + Qs, Omega + delta),
    is_Sigma_i := define(
        Sigma_i,
        Sigma_next + Y_0 * U * Y_0.T - Gamma * C * Y_0 * U * Y_0.T * C.T * Gamma.T,
    ),
    chain(
        "",
        "the difference one step on",
        As * Sigma_i * As.T + Qs - Omega,
        Line(
            As * Sigma_next * As.T
            + Qs
            - Omega
            + As * Y_0 * U * Y_0.T * As.T
            - As * Gamma * C * Y_0 * U * Y_0.T * C.T * Gamma.T * As.T,
            by=(is_Sigma_i,),
        ),
        Line(delta + F_0 * U * F_0.T - G_0 * U * G_0.T, by=(is_delta, is_F_0, is_G_0)),
    ),
)


@cache
def settled_step():
    """How differences of covariances move where the recursion stops."""
    return Derivation(
        (As, Qs, C, Gamma, Kmv, Omega, Sigma_next),
        (
            Stage(Y_0, is_Y_0.right, by=(is_Y_0,)),
            Stage(F_0, is_F_0.right, by=(is_F_0,)),
            Stage(G_0, As * Gamma * C * Y_0, by=(is_G_0,)),
            Stage(
                delta,
                As * Sigma_next * As.T + Qs - Omega,
                symmetric=True,
                by=(is_delta,),
            ),
        ),
        source=SOURCE,
        letters=settling,
        says="how differences of covariances move",
    )


@cache
def derive():
    """The page."""
    page = (*DIFFERENCE, settled_step())
    return Derivation(page=page, letters=settling, source=SOURCE)
