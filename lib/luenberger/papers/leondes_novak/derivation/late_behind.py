"""What a stretch of rows adds to the one before it.

The first stretch leads a known state to an estimate of the state where the second
begins.  So the second does to it what a stretch does to any estimate; and what it reads
of its beginning is, through the first stretch, a reading of where that begins.

Source: our own.
"""

from functools import cache

from sympy import symbols

from ....symbolic import Derivation, Expect, Identity, Line, ZeroMatrix
from .late_prior import prior
from .late_stretch import Phi, k, s, xi
from .letters import *

r = symbols("r", integer=True, nonnegative=True)
joined = prior.here(
    Phi="what the beginning does to the estimate at the end of both",
    xi="the estimate at the end of both if the beginning is zero",
    Sigma="covariance of its error if the beginning is known",
    theta="what both stretches say of the beginning",
    Lambda="how much they say of it",
)
chain, define, moment = joined.chain, joined.define, joined.moment
Phi_1 = joined("Phi_1", n, n, "that of the first stretch")
xi_1 = joined("xi_1", n, 1, "that of the first stretch")
Sigma_1 = joined("Sigma_1", n, n, "that of the first stretch", symmetric=True)
theta_1 = joined("theta_1", n, 1, "that of the first stretch")
Lambda_1 = joined("Lambda_1", n, n, "that of the first stretch", symmetric=True)
Phi_2 = joined("Phi_2", n, n, "that of the second stretch")
xi_2 = joined("xi_2", n, 1, "that of the second stretch")
Sigma_2 = joined("Sigma_2", n, n, "that of the second stretch", symmetric=True)
theta_2 = joined("theta_2", n, 1, "what the second says of its beginning")
Lambda_2 = joined("Lambda_2", n, n, "how much it says of it", symmetric=True)
s_2 = joined("s_2", n, 1, "state where the second stretch begins")
e_1 = joined("e_1", n, 1, "error at the end of the first")
x_2 = joined("x_2", n, 1, "estimate of `s_2` once both stretches are known")
P_2 = joined("P_2", n, n, "covariance of its error", symmetric=True)
F_1 = joined("F_1", n, r, "a factor of `Sigma_1`")
t_2 = joined("t_2", k, 1, "what the second reads of its beginning")
G_2 = joined("G_2", k, n, "how it reads it")
zeta_2 = joined("zeta_2", k, 1, "noise of these readings")
M_2 = joined("M_2", k, k, "covariance of that", symmetric=True)
D_2 = joined("D_2", k, k, "the same read through the first", symmetric=True)
W_2 = joined("W_2", n, k, "what the readings say of `s_2`")
W_s = joined("W_s", n, k, "what they say of `s`")
D_1 = joined("D_1", r, r, "what the second leaves of unit noises", symmetric=True)
U_1 = joined("U_1", n, r, "the noises that are left, in the state")
Z_1 = joined("Z_1", n, n, "what the second leaves of `Sigma_1`", symmetric=True)
Left = joined("Left", n, n, "what it leaves of an error")
L_1 = joined("L_1", n, n, "what it says of `Phi_1`")
Kept = joined("Kept", n, n, "what is left of `Phi_1`")
said = joined("said", n, 1, "what the second says beyond `xi_1`")

LEFT = (
    """The first stretch ends with an estimate of the state where the second begins, and
    the second corrects it as it corrects any estimate. A factor of the covariance makes
    the solve symmetric, and it is always possible.""",
    is_F_1 := define(Sigma_1, F_1 * F_1.T),
    is_D_1 := define(D_1, Identity(r) + F_1.T * Lambda_2 * F_1),
    is_U_1 := define(U_1 * D_1, F_1),
    is_Z_1 := define(Z_1, U_1 * F_1.T),
    is_Left := define(Left, I - Z_1 * Lambda_2),
    part := chain(
        "",
        "the solve undoes the sum",
        (I + Sigma_1 * Lambda_2) * U_1,
        Line((I + F_1 * F_1.T * Lambda_2) * U_1, by=(is_F_1,)),
        Line(
            (I + F_1 * F_1.T * Lambda_2) * U_1 * D_1 * D_1.I,
            why="the matrix has an inverse",
        ),
        Line((I + F_1 * F_1.T * Lambda_2) * F_1 * D_1.I, by=(is_U_1,)),
        Line(F_1 * (Identity(r) + F_1.T * Lambda_2 * F_1) * D_1.I, why="push through"),
        Line(F_1 * D_1 * D_1.I, by=(is_D_1,)),
        Line(F_1, why="cancel"),
    ),
    whole := chain(
        "",
        "what is left of the covariance",
        (I + Sigma_1 * Lambda_2) * Z_1,
        Line((I + Sigma_1 * Lambda_2) * U_1 * F_1.T, by=(is_Z_1,)),
        Line(F_1 * F_1.T, by=(part,)),
        Line(Sigma_1, by=(is_F_1,)),
    ),
    inverse := chain(
        "",
        "what is left of an error",
        (I + Sigma_1 * Lambda_2) * Left,
        Line((I + Sigma_1 * Lambda_2) * (I - Z_1 * Lambda_2), by=(is_Left,)),
        Line(
            I + Sigma_1 * Lambda_2 - (I + Sigma_1 * Lambda_2) * Z_1 * Lambda_2,
            why="multiply out",
        ),
        Line(I, by=(whole,)),
    ),
    """So the estimate where the second begins, corrected, is linear in the state where
    the first begins.""",
    is_x_2 := define(x_2, Left * (Phi_1 * s + xi_1 + Sigma_1 * theta_2)),
    chain(
        "43",
        "it is the corrected estimate",
        (I + Sigma_1 * Lambda_2) * x_2,
        Line(
            (I + Sigma_1 * Lambda_2) * Left * (Phi_1 * s + xi_1 + Sigma_1 * theta_2),
            by=(is_x_2,),
        ),
        Line(Phi_1 * s + xi_1 + Sigma_1 * theta_2, by=(inverse,)),
    ),
)
SAID = (
    """The second stretch reads its beginning. That is the estimate at the end of the
    first less its error, so it is a reading of where the first begins as well, with
    more noise.""",
    is_t_2 := define(t_2, G_2 * s_2 + zeta_2),
    is_e_1 := define(s_2, Phi_1 * s + xi_1 - e_1),
    chain(
        "",
        "a reading through the first stretch",
        t_2 - G_2 * xi_1,
        Line(G_2 * s_2 + zeta_2 - G_2 * xi_1, by=(is_t_2,)),
        Line(G_2 * Phi_1 * s + (zeta_2 - G_2 * e_1), by=(is_e_1,)),
    ),
    is_Sigma_1 := moment(e_1 * e_1.T, Sigma_1),
    is_M_2 := moment(zeta_2 * zeta_2.T, M_2),
    apart := moment(e_1 * zeta_2.T, ZeroMatrix(n, k)),
    is_D_2 := define(D_2, M_2 + G_2 * Sigma_1 * G_2.T),
    chain(
        "",
        "its noise",
        (zeta_2 - G_2 * e_1) * (zeta_2 - G_2 * e_1).T,
        Expect(M_2 + G_2 * Sigma_1 * G_2.T, moments=(is_M_2, is_Sigma_1, apart)),
        Line(D_2, by=(is_D_2,)),
    ),
    is_W_2 := define(W_2 * M_2, G_2.T),
    is_theta_2 := define(theta_2, W_2 * t_2),
    is_Lambda_2 := define(Lambda_2, W_2 * G_2),
    is_Kept := define(Kept, Left * Phi_1),
    is_W_s := define(W_s, Kept.T * W_2),
    chain(
        "",
        "what the readings say of where the first begins",
        W_s * D_2,
        Line(Phi_1.T * Left.T * W_2 * D_2, by=(is_W_s, is_Kept)),
        Line(
            Phi_1.T * Left.T * (W_2 * M_2 + W_2 * G_2 * Sigma_1 * G_2.T),
            by=(is_D_2,),
        ),
        Line(Phi_1.T * Left.T * (G_2.T + W_2 * G_2 * Sigma_1 * G_2.T), by=(is_W_2,)),
        Line(Phi_1.T * Left.T * (I + Lambda_2 * Sigma_1) * G_2.T, by=(is_Lambda_2,)),
        Line((G_2 * Phi_1).T, by=(inverse,)),
    ),
    is_said := define(said, theta_2 - Lambda_2 * xi_1),
    beyond := chain(
        "",
        "what they say of it",
        W_s * (t_2 - G_2 * xi_1),
        Line(Kept.T * W_2 * (t_2 - G_2 * xi_1), by=(is_W_s,)),
        Line(Kept.T * (theta_2 - Lambda_2 * xi_1), by=(is_theta_2, is_Lambda_2)),
        Line(Kept.T * said, by=(is_said,)),
    ),
    is_L_1 := define(L_1, Lambda_2 * Phi_1),
    much := chain(
        "",
        "how much they say of it",
        W_s * G_2 * Phi_1,
        Line(Kept.T * W_2 * G_2 * Phi_1, by=(is_W_s,)),
        Line(Kept.T * Lambda_2 * Phi_1, by=(is_Lambda_2,)),
        Line(Kept.T * L_1, by=(is_L_1,)),
    ),
    "The second stretch leads its corrected beginning to the end of both.",
    is_Phi := define(Phi, Phi_2 * Kept),
    is_xi := define(xi, Phi_2 * Left * (xi_1 + Sigma_1 * theta_2) + xi_2),
    chain(
        "43",
        "the end of both is linear in the beginning",
        Phi_2 * x_2 + xi_2,
        Line(
            Phi_2 * Left * (Phi_1 * s + xi_1 + Sigma_1 * theta_2) + xi_2, by=(is_x_2,)
        ),
        Line(
            Phi_2 * Kept * s + Phi_2 * Left * (xi_1 + Sigma_1 * theta_2) + xi_2,
            by=(is_Kept,),
        ),
        Line(Phi * s + xi, by=(is_Phi, is_xi)),
    ),
)


@cache
def derive():
    """The page."""
    return Derivation(page=(*LEFT, *SAID), letters=joined, source="our own")
