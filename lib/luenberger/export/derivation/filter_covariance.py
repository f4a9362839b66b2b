"""How far the covariance and the gain of a filter on a device are off, in one step.

Covariances are compared with one that is known, and gains with one gain, `G`.  With
that gain a difference of covariances moves as `F Xi F'`.  What a filter does otherwise
is a square in the difference of gains: a small error of the gain does next to nothing
to the covariance.

Source: ours; that a factor, and what is solved with it, are those of a matrix near by
is in Higham, Accuracy and Stability of Numerical Algorithms (2002), Lemma 8.4 and
chapter 10.
"""

from functools import cache

from ...symbolic import Derivation, Line
from .filter_letters import *

SOURCE = "ours"

COVARIANCE = (
    """A filter has the covariance `Omega_f` of its prediction, and makes the next one
    with a gain `K_f`. Rounding adds `r_t` to the covariance of the estimate, and `r_s`
    to the next one. It is compared with a covariance `Omega` that is known, and with
    `Omega_next`, which the known gain `G` makes of that.""",
    is_Xi := define(Omega_f, Omega + Xi),
    is_Y := define(Y, I - G * C),
    is_F := define(F, As * Y),
    is_Y_f := define(Y_f, I - K_f * C),
    is_M_f := define(M_f, C * Omega_f * C.T + R),
    is_N_f := define(N_f, Omega_f * C.T),
    best := define(K_o * M_f, N_f),
    of_next := define(
        Omega_next, As * (Y * Omega * Y.T + G * R * G.T) * As.T + Q - delta
    ),
    of_f_next := define(
        Omega_f_next,
        As * (Y_f * Omega_f * Y_f.T + K_f * R * K_f.T + r_t) * As.T + Q + r_s,
    ),
    is_Xi_next := define(Xi_next, Omega_f_next - Omega_next),
    "For any gain the covariance of the estimate is a square around the best gain.",
    around_f := chain(
        "",
        "the covariance with the gain that was computed",
        Y_f * Omega_f * Y_f.T + K_f * R * K_f.T,
        Line((I - K_f * C) * Omega_f * (I - K_f * C).T + K_f * R * K_f.T, by=(is_Y_f,)),
        Line(
            Omega_f - K_f * N_f.T - N_f * K_f.T + K_f * M_f * K_f.T,
            by=(is_N_f, is_M_f),
        ),
        Line(Omega_f - N_f * K_o.T + (K_f - K_o) * M_f * (K_f - K_o).T, by=(best,)),
    ),
    around_G := chain(
        "",
        "the covariance with the gain that is known",
        Y * Omega_f * Y.T + G * R * G.T,
        Line((I - G * C) * Omega_f * (I - G * C).T + G * R * G.T, by=(is_Y,)),
        Line(
            Omega_f - G * N_f.T - N_f * G.T + G * M_f * G.T,
            by=(is_N_f, is_M_f),
        ),
        Line(Omega_f - N_f * K_o.T + (G - K_o) * M_f * (G - K_o).T, by=(best,)),
    ),
    "So one may stand for the other, but for squares.",
    is_S_K := define(
        S_K, (K_f - K_o) * M_f * (K_f - K_o).T - (G - K_o) * M_f * (G - K_o).T
    ),
    between := chain(
        "",
        "what the gain that was computed does otherwise",
        Y_f * Omega_f * Y_f.T + K_f * R * K_f.T - Y * Omega_f * Y.T - G * R * G.T,
        Line(
            (K_f - K_o) * M_f * (K_f - K_o).T - (G - K_o) * M_f * (G - K_o).T,
            by=(around_f, around_G),
        ),
        Line(S_K, by=(is_S_K,)),
    ),
    moved := chain(
        "",
        "the difference of covariances, one step on",
        Xi_next,
        Line(Omega_f_next - Omega_next, by=(is_Xi_next,)),
        Line(
            As
            * (
                Y_f * Omega_f * Y_f.T
                + K_f * R * K_f.T
                - Y * Omega * Y.T
                - G * R * G.T
                + r_t
            )
            * As.T
            + delta
            + r_s,
            by=(of_next, of_f_next),
        ),
        Line(
            As * (Y * Omega_f * Y.T - Y * Omega * Y.T + S_K + r_t) * As.T + delta + r_s,
            by=(between,),
        ),
        Line(
            As * Y * Xi * Y.T * As.T + As * (S_K + r_t) * As.T + delta + r_s,
            by=(is_Xi,),
        ),
        Line(F * Xi * F.T + As * (S_K + r_t) * As.T + delta + r_s, by=(is_F,)),
    ),
    """The exact filter is such a filter without rounding: there `K_f` is `K_o`, and
    `r_t` and `r_s` are zero.""",
)

GAIN = (
    """The best gain differs from `G` by as much as the covariances do.""",
    is_g := define(g, Omega * C.T - G * (C * Omega * C.T + R)),
    chain(
        "",
        "the best gain beside the one that is known",
        (K_o - G) * M_f,
        Line(N_f - G * M_f, by=(best,)),
        Line(Omega_f * C.T - G * (C * Omega_f * C.T + R), by=(is_N_f, is_M_f)),
        Line(
            Omega * C.T + Xi * C.T - G * (C * Omega * C.T + C * Xi * C.T + R),
            by=(is_Xi,),
        ),
        Line(g + Xi * C.T - G * C * Xi * C.T, by=(is_g,)),
        Line(g + Y * Xi * C.T, by=(is_Y,)),
    ),
    """A device solves for a row of its gain with factors `L D L'` that it computed. The
    row is that of a matrix near by: `L` and `D` are rounded where they are used. By
    Lemma 8.4 of Higham the sums in a factor, and those of a substitution, move each of
    their terms no further than `gamma_j` with as many roundings as a term takes.""",
    are_factors := define(L * D * L.T, M_c + E_1),
    is_L_1 := define(L_1, L + dL_1),
    is_D_1 := define(D_1, D + dD),
    is_L_2 := define(L_2, L + dL_2),
    is_E := define(
        E,
        E_1 + dL_1 * D * L.T + L_1 * dD * L.T + L_1 * D_1 * dL_2.T,
    ),
    solves := define(K_f * L_1 * D_1 * L_2.T, N_f + dN),
    near_by := chain(
        "",
        "the matrix that a gain was solved with",
        L_1 * D_1 * L_2.T,
        Line(L_1 * D_1 * L.T + L_1 * D_1 * dL_2.T, by=(is_L_2,)),
        Line(L_1 * D * L.T + L_1 * dD * L.T + L_1 * D_1 * dL_2.T, by=(is_D_1,)),
        Line(
            L * D * L.T + dL_1 * D * L.T + L_1 * dD * L.T + L_1 * D_1 * dL_2.T,
            by=(is_L_1,),
        ),
        Line(M_c + E, by=(are_factors, is_E)),
    ),
    """Each part of `E` is a few roundings of `|L| D |L'|`. By the inequality of Cauchy
    and Schwarz an entry of that is at most the root of the product of two diagonal
    entries, and those are the entries of `M_c` but for `E_1`. The matrix `M_c` itself
    is `M_f` with its rounding.""",
    is_M_c := define(M_c, M_f + dM),
    is_E_M := define(E_M, dM + E),
    with_E := chain(
        "",
        "what the computed gain solves",
        K_f * (M_f + E_M),
        Line(K_f * (M_f + dM + E), by=(is_E_M,)),
        Line(K_f * (M_c + E), by=(is_M_c,)),
        Line(K_f * L_1 * D_1 * L_2.T, by=(near_by,)),
        Line(N_f + dN, by=(solves,)),
    ),
    chain(
        "",
        "the computed gain beside the best one",
        (K_f - K_o) * (M_f + E_M),
        Line(N_f + dN - K_o * (M_f + E_M), by=(with_E,)),
        Line(dN - K_o * E_M, by=(best,)),
    ),
    """What is left is the inverse of a matrix that is known and of what is added to it.
    It refers to itself: a bound that was tried holds, as the sizes of `rho` and
    `V_0 D_M` then have powers that vanish.""",
    leaves := define(V_0 * M, Identity(p) - rho),
    inverts := define((M + D_M) * V_M, Identity(p)),
    chain(
        "",
        "an inverse refers to itself",
        V_0 + (rho - V_0 * D_M) * V_M,
        Line(V_0 * (M + D_M) * V_M + (rho - V_0 * D_M) * V_M, by=(inverts,)),
        Line((Identity(p) - rho) * V_M + rho * V_M, by=(leaves,)),
        Line(V_M, why="collect"),
    ),
)


@cache
def derive():
    """The page."""
    return Derivation(page=(*COVARIANCE, *GAIN), letters=letters, source=SOURCE)
