"""Two stretches of rows as one, as they are joined: with one symmetric solve.

What a stretch adds to the one before it is known.  Here it is written in products with
a factor of the first one's covariance.

Source: our own.
"""

from functools import cache

from ....symbolic import Derivation, Identity, Line, Solve, Stage
from .late_behind import (
    D_1,
    F_1,
    G_2,
    L_1,
    U_1,
    Z_1,
    Kept,
    Lambda_1,
    Lambda_2,
    Left,
    Phi_1,
    Phi_2,
    Sigma_1,
    Sigma_2,
    W_s,
    beyond,
    is_D_1,
    is_Kept,
    is_L_1,
    is_Left,
    is_Phi,
    is_said,
    is_U_1,
    is_xi,
    is_Z_1,
    much,
    r,
    said,
    t_2,
    theta_1,
    theta_2,
    whole,
    xi_1,
    xi_2,
)
from .late_behind import joined as behind
from .late_stretch import Lambda, Phi, theta, xi
from .letters import *

joined = behind.here()
chain, define = joined.chain, joined.define
T_1 = joined("T_1", n, r, "what the second says of the factor")
V_1 = joined("V_1", r, n, "the same of `Phi_1` and the factor")
N_1 = joined("N_1", n, r, "the factor, moved to the end")
N_2 = joined("N_2", n, r, "the noises that are left, moved to the end")

RUNS = (
    """What the readings of both stretches say adds up, and the second leads what is
    left of the first one's noise to the end. In products of the factor one solve finds
    all parts of the joined stretch.""",
    is_D_1,
    is_U_1,
    is_Z_1,
    is_Left,
    is_Kept,
    is_L_1,
    is_said,
    is_Phi,
    is_xi,
    is_theta := define(theta, theta_1 + W_s * (t_2 - G_2 * xi_1)),
    is_Lambda := define(Lambda, Lambda_1 + W_s * G_2 * Phi_1),
    is_Sigma := define(Sigma, Phi_2 * Z_1 * Phi_2.T + Sigma_2),
    is_T_1 := define(T_1, Lambda_2 * F_1),
    is_V_1 := define(V_1, F_1.T * L_1),
    is_N_1 := define(N_1, Phi_2 * F_1),
    is_N_2 := define(N_2, Phi_2 * U_1),
    quick_Kept := chain(
        "",
        "what is left of the first map",
        Kept,
        Line(Left * Phi_1, by=(is_Kept,)),
        Line((I - Z_1 * Lambda_2) * Phi_1, by=(is_Left,)),
        Line(Phi_1 - Z_1 * L_1, by=(is_L_1,)),
        Line(Phi_1 - U_1 * F_1.T * L_1, by=(is_Z_1,)),
        Line(Phi_1 - U_1 * V_1, by=(is_V_1,)),
    ),
    chain(
        "",
        "what is left of the covariance is symmetric",
        Z_1,
        Line(U_1 * F_1.T, by=(is_Z_1,)),
        Line(U_1 * D_1 * U_1.T, by=(is_U_1,)),
    ),
    left := chain(
        "",
        "what is left undoes the sum from the left as well",
        Left * (I + Sigma_1 * Lambda_2),
        Line((I - Z_1 * Lambda_2) * (I + Sigma_1 * Lambda_2), by=(is_Left,)),
        Line(
            I + Sigma_1 * Lambda_2 - Z_1 * (I + Lambda_2 * Sigma_1) * Lambda_2,
            why="multiply out",
        ),
        Line(I, by=(whole,)),
    ),
    noise := chain(
        "",
        "and leaves that of the covariance",
        Left * Sigma_1,
        Line((I - Z_1 * Lambda_2) * Sigma_1, by=(is_Left,)),
        Line(Sigma_1 + Z_1 - Z_1 * (I + Lambda_2 * Sigma_1), why="add and subtract"),
        Line(Z_1, by=(whole,)),
    ),
    quick_xi := chain(
        "43",
        "the end of both if the beginning is zero",
        xi,
        Line(Phi_2 * Left * (xi_1 + Sigma_1 * theta_2) + xi_2, by=(is_xi,)),
        Line(
            Phi_2 * Left * (I + Sigma_1 * Lambda_2) * xi_1
            + Phi_2 * Left * Sigma_1 * said
            + xi_2,
            by=(is_said,),
        ),
        Line(Phi_2 * xi_1 + Phi_2 * Left * Sigma_1 * said + xi_2, by=(left,)),
        Line(Phi_2 * xi_1 + Phi_2 * Z_1 * said + xi_2, by=(noise,)),
        Line(Phi_2 * xi_1 + Phi_2 * U_1 * F_1.T * said + xi_2, by=(is_Z_1,)),
        Line(Phi_2 * xi_1 + N_2 * F_1.T * said + xi_2, by=(is_N_2,)),
    ),
    quick_Sigma := chain(
        "44",
        "the covariance at the end of both",
        Sigma,
        Line(Phi_2 * Z_1 * Phi_2.T + Sigma_2, by=(is_Sigma,)),
        Line(Phi_2 * U_1 * F_1.T * Phi_2.T + Sigma_2, by=(is_Z_1,)),
        Line(N_2 * N_1.T + Sigma_2, by=(is_N_2, is_N_1)),
    ),
    quick_theta := chain(
        "",
        "what both say",
        theta,
        Line(theta_1 + W_s * (t_2 - G_2 * xi_1), by=(is_theta,)),
        Line(theta_1 + Kept.T * said, by=(beyond,)),
    ),
    quick_Lambda := chain(
        "",
        "how much both say",
        Lambda,
        Line(Lambda_1 + W_s * G_2 * Phi_1, by=(is_Lambda,)),
        Line(Lambda_1 + Kept.T * L_1, by=(much,)),
    ),
)


@cache
def late_pair():
    """Two stretches as one; `F_1` is a factor of the first one's covariance."""
    return Derivation(
        (Phi_1, xi_1, F_1, theta_1, Lambda_1, Phi_2, xi_2, Sigma_2, theta_2, Lambda_2),
        (
            Stage(T_1, is_T_1.right, by=(is_T_1,)),
            Stage(
                D_1,
                Identity(r) + F_1.T * T_1,
                symmetric=True,
                by=(is_D_1, is_T_1),
            ),
            Stage(U_1, Solve(F_1, D_1), by=(is_U_1,)),
            Stage(L_1, is_L_1.right, by=(is_L_1,)),
            Stage(V_1, is_V_1.right, by=(is_V_1,)),
            Stage(Kept, quick_Kept.right, by=(quick_Kept,)),
            Stage(Phi, is_Phi.right, by=(is_Phi,)),
            Stage(Lambda, quick_Lambda.right, symmetric=True, by=(quick_Lambda,)),
            Stage(said, is_said.right, by=(is_said,)),
            Stage(theta, quick_theta.right, by=(quick_theta,)),
            Stage(N_1, is_N_1.right, by=(is_N_1,)),
            Stage(N_2, is_N_2.right, by=(is_N_2,)),
            Stage(Sigma, quick_Sigma.right, symmetric=True, by=(quick_Sigma,)),
            Stage(xi, quick_xi.right, "(43)", by=(quick_xi,)),
        ),
        source="our own",
        letters=joined,
        says="two stretches as one",
    )


@cache
def derive():
    """The page."""
    page = (*RUNS, late_pair())
    return Derivation(page=page, letters=joined, source="our own")
