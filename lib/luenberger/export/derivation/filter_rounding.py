"""What rounding does to a filter that computes its covariance on a device.

The error of the estimate moves as the state does.  A step adds what the wrong gain
makes of the innovation, and its roundings.  All that was added is moved by the steps
that follow, from one side or, in a covariance, from both.

Source: ours.
"""

from functools import cache

from ...symbolic import Derivation, Line, Stage
from .filter_covariance import is_F, is_Y
from .filter_letters import *

SOURCE = "ours"

ESTIMATE = (
    """The exact filter has the gain `K`. The device has the gain `K_f`. Rounding adds
    `r_x` to its estimate, and `r_m` to its prediction.""",
    is_Y,
    is_F,
    is_s := define(s, y - E_u * u),
    is_nu := define(nu, s - C * x_m),
    is_x := define(x, x_m + K * nu),
    is_x_m_next := define(x_m_next, As * x + B * u + J * s),
    is_x_f := define(x_f, x_fm + K_f * (s - C * x_fm) + r_x),
    is_x_fm_next := define(x_fm_next, As * x_f + B * u + J * s + r_m),
    is_e := define(e, x_f - x),
    is_e_m := define(x_fm, x_m + e_m),
    is_e_m_next := define(e_m_next, x_fm_next - x_m_next),
    of_estimate := chain(
        "",
        "the error of the computed estimate",
        e,
        Line(x_f - x, by=(is_e,)),
        Line(x_fm + K_f * (s - C * x_fm) + r_x - x_m - K * nu, by=(is_x_f, is_x)),
        Line(e_m + K_f * (s - C * x_m - C * e_m) + r_x - K * nu, by=(is_e_m,)),
        Line(e_m + K_f * (nu - C * e_m) + r_x - K * nu, by=(is_nu,)),
        Line(
            (I - G * C) * e_m + (G - K_f) * C * e_m + (K_f - K) * nu + r_x,
            why="collect",
        ),
        Line(Y * e_m + (G - K_f) * C * e_m + (K_f - K) * nu + r_x, by=(is_Y,)),
    ),
    of_prediction := chain(
        "",
        "the error of the computed prediction, one step on",
        e_m_next,
        Line(x_fm_next - x_m_next, by=(is_e_m_next,)),
        Line(As * x_f + r_m - As * x, by=(is_x_fm_next, is_x_m_next)),
        Line(As * e + r_m, by=(is_e,)),
        Line(
            As * (Y * e_m + (G - K_f) * C * e_m + (K_f - K) * nu + r_x) + r_m,
            by=(of_estimate,),
        ),
        Line(
            F * e_m + As * ((G - K_f) * C * e_m + (K_f - K) * nu + r_x) + r_m,
            by=(is_F,),
        ),
    ),
    "The exact prediction moves with `F` as well.",
    is_D_y := define(D_y, As * G + J),
    is_B_u := define(B_u, B - D_y * E_u),
    chain(
        "",
        "the exact prediction, one step on",
        x_m_next,
        Line(As * x + B * u + J * s, by=(is_x_m_next,)),
        Line(As * (x_m + K * nu) + B * u + J * s, by=(is_x,)),
        Line(
            As * (x_m + G * (s - C * x_m) + (K - G) * nu) + B * u + J * s, by=(is_nu,)
        ),
        Line(As * Y * x_m + As * G * s + As * (K - G) * nu + B * u + J * s, by=(is_Y,)),
        Line(F * x_m + D_y * s + As * (K - G) * nu + B * u, by=(is_F, is_D_y)),
        Line(F * x_m + D_y * (y - E_u * u) + As * (K - G) * nu + B * u, by=(is_s,)),
        Line(F * x_m + D_y * y + B_u * u + As * (K - G) * nu, by=(is_B_u,)),
    ),
)

MOVES = (
    """So what a step adds is moved by all steps that follow. How they move it is
    computed step by step, and rounded. The rounding counts as something more that the
    last step added.""",
    is_Phi_next := define(F * Phi, Phi_next - R_m),
    chain(
        "",
        "what a step added to a difference, moved once more",
        F * Phi * L_x * Phi.T * F.T,
        Line(
            (Phi_next - R_m) * L_x * (Phi_next - R_m).T,
            by=(is_Phi_next,),
        ),
        Line(
            Phi_next * L_x * Phi_next.T
            - R_m * L_x * Phi_next.T
            - Phi_next * L_x * R_m.T
            + R_m * L_x * R_m.T,
            why="multiply out",
        ),
    ),
    chain(
        "",
        "what a step added to an error, moved once more",
        F * Phi * l_e,
        Line(Phi_next * l_e - R_m * l_e, by=(is_Phi_next,)),
    ),
    """What was added longer ago than a window reaches counts in the same way, with its
    whole size. Once the covariance has settled `F` stays, and bounds of what a step
    adds are tried. If they hold until the window has passed over them once, they hold
    at every later instant: each step then looks back on the same window.""",
)

SIZES = (
    "Sizes are taken entry by entry, as for an observer.",
    is_k_o := define(k_o, (g_s + X_K) * V_o),
    is_k_r := define(k_r, (N_o + (G_s + k_o) * E_s) * V_f),
    is_k_f := define(k_f, k_o + k_r),
    is_k_d := define(k_d, k_f + k_e),
    """What a step adds to a difference before `As` moves it is `l_s`, and what it adds
    to an error `a_s`.""",
    is_l_s := define(l_s, k_r * M_s * k_r.T + k_o * (g_s + X_K).T + r_ts),
    is_a_s := define(a_s, k_f * C_s * e_s + k_d * nu_s + r_xs),
    is_z_s := define(z_s, As_s * k_e * nu_s),
)


@cache
def known_gain():
    """What one gain makes of errors, measurements and inputs."""
    return Derivation(
        (As, B, C, E_u, J, G),
        (
            Stage(Y, is_Y.right, by=(is_Y,)),
            Stage(F, is_F.right, by=(is_F,)),
            Stage(D_y, is_D_y.right, by=(is_D_y,)),
            Stage(B_u, is_B_u.right, by=(is_B_u,)),
        ),
        source=SOURCE,
        letters=letters,
        says="what one gain makes of errors and readings",
    )


@cache
def gains():
    """How far the gain of a filter is from the one that is known, at most."""
    return Derivation(
        (g_s, X_K, V_o, N_o, G_s, E_s, V_f),
        (
            Stage(k_o, is_k_o.right, by=(is_k_o,)),
            Stage(k_r, is_k_r.right, by=(is_k_r,)),
            Stage(k_f, is_k_f.right, by=(is_k_f,)),
        ),
        source=SOURCE,
        letters=letters,
        says="how far the computed gain is off",
    )


@cache
def grows():
    """What one step adds to a difference of covariances, at most."""
    return Derivation(
        (k_r, M_s, k_o, g_s, X_K, r_ts),
        (Stage(l_s, is_l_s.right, by=(is_l_s,)),),
        source=SOURCE,
        letters=letters,
        says="what a step adds to a difference of covariances",
    )


@cache
def strays():
    """What wrong gains add to an error in one step, at most."""
    return Derivation(
        (As_s, C_s, k_f, k_e, e_s, nu_s, r_xs),
        (
            Stage(k_d, is_k_d.right, by=(is_k_d,)),
            Stage(a_s, is_a_s.right, by=(is_a_s,)),
            Stage(z_s, is_z_s.right, by=(is_z_s,)),
        ),
        source=SOURCE,
        letters=letters,
        says="what wrong gains add to the error of the estimate",
    )


@cache
def derive():
    """The page."""
    page = (
        *ESTIMATE, known_gain(), *MOVES, *SIZES, gains(), grows(), strays(),
    )  # fmt: skip
    return Derivation(page=page, letters=letters, source=SOURCE)
