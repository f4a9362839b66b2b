"""What rounding does to an observer on a device, step by step and in the long run.

A device computes with rounded matrices, rounds what it reads, and rounds its sums.  One
step adds to the error what these do, and the observer forgets it as it forgets
everything else.  Nothing is said of averages: every bound holds at every instant.

Source: ours; that `j` roundings move a term by at most `j u / (1 - j u)` of it is in
Higham, Accuracy and Stability of Numerical Algorithms (2002), Lemma 3.1.
"""

from functools import cache

from sympy import Rational

from ...symbolic import Derivation, Line, Stage, Substitute
from .letters import *

SOURCE = "ours"

ONE_STEP = (
    "The observer moves its state and makes its estimate of it. A device does the same "
    "with other matrices and other readings, and its sums are rounded.",
    moves := define(z_next, F * z + B * s),
    shows := define(w_hat, P * z + V * s),
    moves_f := define(z_f_next, F_f * z_f + B_f * s_f + l_z),
    shows_f := define(w_f, P_f * z_f + V_f * s_f + l_w),
    is_F := define(F_f, F + dF),
    is_B := define(B_f, B + dB),
    is_P := define(P_f, P + dP),
    is_V := define(V_f, V + dV),
    is_s := define(s_f, s + ds),
    is_e := define(e, z_f - z),
    is_e_next := define(e_next, z_f_next - z_next),
    is_e_w := define(e_w, w_f - w_hat),
    "The following is what one step adds.",
    is_d := define(d, dF * z_f + dB * s_f + B * ds + l_z),
    is_d_w := define(d_w, dP * z_f + dV * s_f + V * ds + l_w),
    chain(
        "",
        "the error of the computed state, one step on",
        e_next,
        Line(z_f_next - z_next, by=(is_e_next,)),
        Line(F_f * z_f + B_f * s_f + l_z - F * z - B * s, by=(moves, moves_f)),
        Line((F + dF) * z_f + (B + dB) * s_f + l_z - F * z - B * s, by=(is_F, is_B)),
        Line(F * e + dF * z_f + (B + dB) * s_f + l_z - B * s, by=(is_e,)),
        Line(F * e + dF * z_f + dB * s_f + B * ds + l_z, by=(is_s,)),
        Line(F * e + d, by=(is_d,)),
    ),
    chain(
        "",
        "the error of the computed estimate",
        e_w,
        Line(w_f - w_hat, by=(is_e_w,)),
        Line(P_f * z_f + V_f * s_f + l_w - P * z - V * s, by=(shows, shows_f)),
        Line((P + dP) * z_f + (V + dV) * s_f + l_w - P * z - V * s, by=(is_P, is_V)),
        Line(P * e + dP * z_f + (V + dV) * s_f + l_w - V * s, by=(is_e,)),
        Line(P * e + dP * z_f + dV * s_f + V * ds + l_w, by=(is_s,)),
        Line(P * e + d_w, by=(is_d_w,)),
    ),
)

SIZES = (
    """Sizes are taken entry by entry. A matrix is its positive entries less its
    negative ones, and its sizes are the sum of both.""",
    is_F_p := define(F, F_p - F_m),
    is_F_s := define(F_s, F_p + F_m),
    is_z_p := define(z, z_p - z_m),
    is_z_s := define(z_s, z_p + z_m),
    "The size of a product is at most the product of the sizes, from above and below: "
    "what is left over has no negative entry.",
    chain(
        "",
        "a product beside the product of sizes, from above",
        F_s * z_s - F * z,
        Line((F_p + F_m) * (z_p + z_m) - F * z, by=(is_F_s, is_z_s)),
        Line(
            (F_p + F_m) * (z_p + z_m) - (F_p - F_m) * (z_p - z_m), by=(is_F_p, is_z_p)
        ),
        Line(2 * F_p * z_m + 2 * F_m * z_p, why="multiply out"),
    ),
    chain(
        "",
        "a product beside the product of sizes, from below",
        F_s * z_s + F * z,
        Line((F_p + F_m) * (z_p + z_m) + F * z, by=(is_F_s, is_z_s)),
        Line(
            (F_p + F_m) * (z_p + z_m) + (F_p - F_m) * (z_p - z_m), by=(is_F_p, is_z_p)
        ),
        Line(2 * F_p * z_p + 2 * F_m * z_m, why="multiply out"),
    ),
)

ROUNDING = (
    """An operation in floating point errs by at most the part `u` of its result, and
    a sum of `j` products, in any order, takes each of them through at most `j`
    operations. Where a product is rounded together with its sum there are fewer. So
    let `gamma_j` be the following.""",
    is_gamma := define(gamma_j, j * u / (1 - j * u)),
    is_more := define(gamma_more, (j + 1) * u / (1 - (j + 1) * u)),
    """One more operation moves a term no further than the next one of them says, as
    long as the roundings are few: `u` is less than `1 / (j + 1)`.""",
    chain(
        "",
        "room for one more rounding",
        1 + gamma_more - (1 + gamma_j) * (1 + u),
        Substitute(
            1 + (j + 1) * u / (1 - (j + 1) * u) - (1 + j * u / (1 - j * u)) * (1 + u),
            by=(is_gamma, is_more),
        ),
        Line((j + 1) * u**2 / ((1 - j * u) * (1 - (j + 1) * u)), why="collect"),
    ),
    """So the rounding of a sum has at most the size of this part of the sizes that it
    adds up, and `eta_z` for numbers that are too small to have all digits. In whole
    numbers a sum is exact, and `eta_z` is half of the last place to which it is
    rounded.""",
    is_l_zs := define(l_zs, gamma_z * (F_fs * z_fs + B_fs * s_fs) + eta_z),
    is_l_ws := define(l_ws, gamma_w * (P_fs * z_fs + V_fs * s_fs) + eta_w),
)

ADDED = (
    """A state that is computed is no larger than the exact one and its error.""",
    is_z_fs := define(z_fs, reach + e_s),
    is_d_s := define(d_s, dF_s * z_fs + dB_s * s_fs + B_s * ds_s + l_zs),
    is_d_ws := define(d_ws, dP_s * z_fs + dV_s * s_fs + V_s * ds_s + l_ws),
    "What a step adds is `c`, and more where there is an error already.",
    is_M_z := define(M_z, dF_s + gamma_z * F_fs),
    is_M_s := define(M_s, dB_s + gamma_z * B_fs),
    is_c := define(c, M_z * reach + M_s * s_fs + B_s * ds_s + eta_z),
    is_N_z := define(N_z, dP_s + gamma_w * P_fs),
    is_N_s := define(N_s, dV_s + gamma_w * V_fs),
    is_c_w := define(c_w, N_z * reach + N_s * s_fs + V_s * ds_s + eta_w),
    of_state := chain(
        "",
        "what a step adds to the error of the state, at most",
        d_s,
        Line(dF_s * z_fs + dB_s * s_fs + B_s * ds_s + l_zs, by=(is_d_s,)),
        Line(
            (dF_s + gamma_z * F_fs) * z_fs
            + (dB_s + gamma_z * B_fs) * s_fs
            + B_s * ds_s
            + eta_z,
            by=(is_l_zs,),
        ),
        Line(M_z * z_fs + M_s * s_fs + B_s * ds_s + eta_z, by=(is_M_z, is_M_s)),
        Line(M_z * (reach + e_s) + M_s * s_fs + B_s * ds_s + eta_z, by=(is_z_fs,)),
        Line(c + M_z * e_s, by=(is_c,)),
    ),
    of_estimate := chain(
        "",
        "what a step adds to that of the estimate, at most",
        d_ws,
        Line(dP_s * z_fs + dV_s * s_fs + V_s * ds_s + l_ws, by=(is_d_ws,)),
        Line(
            (dP_s + gamma_w * P_fs) * z_fs
            + (dV_s + gamma_w * V_fs) * s_fs
            + V_s * ds_s
            + eta_w,
            by=(is_l_ws,),
        ),
        Line(N_z * z_fs + N_s * s_fs + V_s * ds_s + eta_w, by=(is_N_z, is_N_s)),
        Line(N_z * (reach + e_s) + N_s * s_fs + V_s * ds_s + eta_w, by=(is_z_fs,)),
        Line(c_w + N_z * e_s, by=(is_c_w,)),
    ),
)

POWERS = (
    """After some steps the error is the sum of what was added, each part moved by a
    power of `F`. So what matters is the sum of the sizes of all powers. They are
    computed one after the other, and rounded.""",
    is_more_F := define(F_more, F * F_less),
    is_C := define(C_next, C * F + R_C),
    chain(
        "",
        "a power that was computed, and the rounding in the next",
        C * F_more,
        Line(C * F * F_less, by=(is_more_F,)),
        Line((C_next - R_C) * F_less, by=(is_C,)),
        Line(C_next * F_less - R_C * F_less, why="multiply out"),
    ),
    """Taken from the first power to the last one that was computed, this says: a later
    power is that one times an earlier power of `F`, less each rounding times an
    earlier power. Add up the sizes of all powers up to some instant. That sum is at
    most `b`, the sizes that were computed, and `T` times the sum up to the instant
    before, where `T` adds up the sizes of the last power and of all roundings.""",
)

TRIED = (
    """A bound that refers to itself one instant before is proved by trying: `x` is a
    bound if it has something to spare, `g`.""",
    is_a := define(a_next, b + T * a - h),
    is_x := define(x, b + T * x + g),
    tried := chain(
        "",
        "a bound that was tried holds at the next instant",
        x - a_next,
        Line(x - b - T * a + h, by=(is_a,)),
        Line(T * (x - a) + g + h, by=(is_x,)),
    ),
    """Where no entry of `T`, `g`, `h` and `x - a` is negative, none of `x - a_next` is:
    the bound holds at every instant if it holds at the first. It is used twice: for the
    sums of powers, and for the error. What has been added so far moves with the
    powers, and what the error was at first becomes `a_0` at most.""",
    is_a_e := define(a_e, a_0 + S * d_s),
    error := chain(
        "",
        "the error of the state refers to the one before",
        a_e,
        Line(a_0 + S * d_s, by=(is_a_e,)),
        Line(a_0 + S * (c + M_z * e_s), by=(of_state,)),
    ),
    is_a_w := define(a_w, a_0w + S_P * d_s + d_ws),
    estimate := chain(
        "",
        "the error of the estimate, at most",
        a_w,
        Line(a_0w + S_P * d_s + d_ws, by=(is_a_w,)),
        Line(
            a_0w + S_P * (c + M_z * e_s) + c_w + N_z * e_s, by=(of_state, of_estimate)
        ),
    ),
)


@cache
def added():
    """What a step adds to the errors, from the sizes of what is rounded."""
    return Derivation(
        (
            dF_s, dB_s, dP_s, dV_s, F_fs, B_fs, P_fs, V_fs, B_s, V_s,
            gamma_z, gamma_w, eta_z, eta_w, ds_s, s_fs, reach,
        ),
        (
            Stage(M_z, is_M_z.right, by=(is_M_z,)),
            Stage(M_s, is_M_s.right, by=(is_M_s,)),
            Stage(c, is_c.right, by=(is_c,)),
            Stage(N_z, is_N_z.right, by=(is_N_z,)),
            Stage(N_s, is_N_s.right, by=(is_N_s,)),
            Stage(c_w, is_c_w.right, by=(is_c_w,)),
        ),
        source=SOURCE,
        letters=letters,
        says="what a step adds to the errors",
    )  # fmt: skip


@cache
def errs():
    """The errors at most, where the state errs by `e_s` one instant before."""
    return Derivation(
        (S, S_P, M_z, N_z, c, c_w, a_0, a_0w, e_s),
        (
            Stage(a_e, a_0 + S * (c + M_z * e_s), by=(error,)),
            Stage(
                a_w,
                a_0w + S_P * (c + M_z * e_s) + c_w + N_z * e_s,
                by=(estimate,),
            ),
        ),
        source=SOURCE,
        letters=letters,
        says="how far state and estimate err",
    )


@cache
def derive():
    """The page."""
    page = (*ONE_STEP, *SIZES, *ROUNDING, *ADDED, added(), *POWERS, *TRIED, errs())
    small = {u: Rational(1, 4), j: 1}
    return Derivation(page=page, letters=letters, source=SOURCE, witness=small)
