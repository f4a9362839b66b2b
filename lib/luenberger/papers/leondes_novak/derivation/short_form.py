"""The short form of the covariance, and how far rounding moves it at most.

The gain of minimum variance leaves `Omega - K N'`, in a fifth of the multiplications
that the form for any gain takes.  A gain that was computed is another one, and a device
rounds its sums: both are bounded here by sizes that a step has at hand.

Source: our own; that the roundings of `L D L'` and of what is solved with it are a
change of `M` is in Higham, Accuracy and Stability of Numerical Algorithms (2002),
chapters 9 and 10.
"""

from functools import cache

from ....symbolic import Derivation, Line, Relation, Solve, Stage
from .estimate import x_minus
from .letters import *
from .on_target import definitions, device, in_turn, predict, update
from .one_pass import Z
from .quadratic import is_Kmv, is_M, is_N, joseph

short = device.here(K="gain of minimum variance", Sigma="covariance that it leaves")
chain, define = short.chain, short.define

# -- what a device computes ------------------------------------------------------------

N_f = short("N_f", n, p, "`N` that a device computes")
M_f = short("M_f", p, p, "`M` that it computes", symmetric=True)
K_f = short("K_f", n, p, "the gain that it computes")
Sigma_f = short("Sigma_f", n, n, "the covariance that it computes", symmetric=True)
Sigma_K = short("Sigma_K", n, n, "the covariance that this gain leaves", symmetric=True)
d_N = short("d_N", n, p, "rounding of `N_f`")
d_M = short("d_M", p, p, "rounding of `M_f`, and what that of `N_f` does to it")
d_K = short("d_K", n, p, "what the gain leaves of its equation")
d_S = short("d_S", n, n, "rounding of `Sigma_f`")

# -- sizes -----------------------------------------------------------------------------

w = short("w", n, 1, "sizes of the state: no entry of `Omega` is larger than `w w'`")
r_s = short("r_s", p, 1, "sizes of noise: no entry of `R` is larger than `r_s r_s'`")
C_s = short("C_s", p, n, "sizes of the entries of `C`")
K_s = short("K_s", n, p, "sizes of the entries of `K_f`")
a = short("a", p, 1, "sizes of the measurement")
k = short("k", n, 1, "sizes of what the gain makes of it")
b = short("b", n, 1, "sizes of both: what rounding is measured by")
N_s = short("N_s", n, p, "sizes of `d_N`, at most")
M_s = short("M_s", p, p, "sizes of `d_M`, at most")
G_s = short("G_s", n, p, "sizes of `d_K`, at most")
S_s = short("S_s", n, n, "sizes of `d_S`, at most")
E_s = short("E_s", n, n, "sizes of `Sigma_f - Sigma_K`, at most")
g_N = short.scalar("g_N", "part of its sizes that the roundings of `N_f` are")
g_M = short.scalar("g_M", "the same of `M_f`")
g_K = short.scalar("g_K", "the same of the gain's equation")
g_S = short.scalar("g_S", "the same of `Sigma_f`")

SHORT = (
    """The covariance that any gain leaves is a sum of two terms. With the gain of
    minimum variance most of it cancels.""",
    is_N,
    is_M,
    is_K := is_Kmv.mapped(lambda e: e.xreplace({Kmv: K})),
    is_Sigma := define(Sigma, joseph(K, C, Omega, R), "27"),
    shorter := chain(
        "27, 33",
        "the covariance in its short form",
        Sigma,
        Line(joseph(K, C, Omega, R), by=(is_Sigma,)),
        Line(
            Omega - K * C * Omega - Omega * C.T * K.T + K * (C * Omega * C.T + R) * K.T,
            why="multiply out",
        ),
        Line(Omega - K * N.T - N * K.T + K * M * K.T, by=(is_N, is_M)),
        Line(Omega - K * N.T, by=(is_K,)),
    ),
)

COMPUTED = (
    """A device computes `N_f`, `M_f` and a gain that solves its equation nearly. It is
    some gain, and `Sigma_K` is what it leaves, exactly.""",
    is_N_f := define(N_f, Omega * C.T + d_N),
    is_M_f := define(M_f, C * Omega * C.T + R + d_M),
    is_K_f := define(K_f * M_f, N_f + d_K),
    is_Sigma_f := define(Sigma_f, Omega - K_f * N_f.T + d_S),
    is_Sigma_K := define(Sigma_K, joseph(K_f, C, Omega, R), "27"),
    chain(
        "",
        "what rounding does to the short form",
        Sigma_f - Sigma_K,
        Line(Sigma_f - joseph(K_f, C, Omega, R), by=(is_Sigma_K,)),
        Line(
            Sigma_f
            - Omega
            + K_f * C * Omega
            + Omega * C.T * K_f.T
            - K_f * (C * Omega * C.T + R) * K_f.T,
            why="multiply out",
        ),
        Line(
            Sigma_f
            - Omega
            + K_f * (N_f - d_N).T
            + (N_f - d_N) * K_f.T
            - K_f * (M_f - d_M) * K_f.T,
            by=(is_N_f, is_M_f),
        ),
        Line(
            Sigma_f
            - Omega
            + K_f * N_f.T
            - K_f * d_N.T
            - d_N * K_f.T
            - d_K * K_f.T
            + K_f * d_M * K_f.T,
            by=(is_K_f,),
        ),
        Line(
            d_S - K_f * d_N.T - d_N * K_f.T - d_K * K_f.T + K_f * d_M * K_f.T,
            by=(is_Sigma_f,),
        ),
    ),
    """No inverse stands in it, so neither `R` nor `Omega` need have one. The form for
    any gain has no such terms: there a gain may be wrong.""",
)

BOUND = (
    """Sizes are taken entry by entry, and the size of a product is at most the product
    of the sizes. A step takes the roots of the variances in `Omega` for `w`, and tests
    that no entry of `Omega` is larger than `w w'`; it takes the sizes of the gain that
    it has computed.""",
    is_a := define(a, C_s * w + r_s),
    is_k := define(k, K_s * a),
    is_b := define(b, w + K_s * a),
    """So no entry of `N` is larger than `w a'`, and none of `M` larger than `a a'`. The
    same holds of `L D L'` with the sizes of `L`, as it has the variances of `M_f` on
    its diagonal. Rounding is a part of those sizes: of `N_f`, of `M_f` with what `d_N`
    does to it, of what is solved, and of the last sum.""",
    is_N_s := define(N_s, g_N * w * a.T),
    is_M_s := define(M_s, g_M * a * a.T),
    is_G_s := define(G_s, g_K * K_s * a * a.T),
    is_S_s := define(S_s, g_S * (w + K_s * a) * w.T),
    is_E_s := define(
        E_s, S_s + K_s * N_s.T + N_s * K_s.T + G_s * K_s.T + K_s * M_s * K_s.T
    ),
    """What is left over has no negative entry: rounding moves no entry of the
    covariance further than `g b b'`, where `g` is the sum of the four parts.""",
    chain(
        "",
        "how far rounding moves the short form, at most",
        (g_N + g_M + g_K + g_S) * b * b.T - E_s,
        Line(
            (g_N + g_M + g_K + g_S) * b * b.T
            - S_s
            - K_s * N_s.T
            - N_s * K_s.T
            - G_s * K_s.T
            - K_s * M_s * K_s.T,
            by=(is_E_s,),
        ),
        Line(
            (g_N + g_M + g_K + g_S) * b * b.T
            - g_S * (w + k) * w.T
            - g_N * k * w.T
            - g_N * w * k.T
            - (g_K + g_M) * k * k.T,
            by=(is_S_s, is_N_s, is_G_s, is_M_s, is_k),
        ),
        Line(
            (g_N + g_M + g_K + g_S) * (w + k) * (w + k).T
            - g_S * (w + k) * w.T
            - g_N * k * w.T
            - g_N * w * k.T
            - (g_K + g_M) * k * k.T,
            by=(is_b, is_k),
        ),
        Line(
            (g_N + g_M + g_K) * w * w.T
            + (g_M + g_K) * k * w.T
            + (g_M + g_K + g_S) * w * k.T
            + (g_N + g_S) * k * k.T,
            why="collect",
        ),
    ),
    """With the unit roundoff `u` there are `n` roundings in an entry of `N_f`,
    `2 n + 1` in one of `M_f`, `3 p + 6` in what is solved and `n + p + 1` in the last
    sum, so `g` is `4 (n + p + 2) u`, and a little for what is of second order. Where
    `g b b'` is more than a small part of a variance in `Sigma_f`, a step takes the form
    for any gain. Else no entry errs by more than that part of the root of its two
    variances.""",
)


@cache
def short_update():
    """The update of a sample with the gain of minimum variance, and its sizes."""
    kept = [s for s in update().stages if s.target in (N, M)]
    after = [s for s in update().stages if s.target not in (N, M, Kmv, K, Z, Sigma)]
    return Derivation(
        (C, R, E, u, y, Omega, x_minus, w, r_s, C_s, K_s),
        (
            *kept,
            Stage(K, Solve(N, M), "(33)", by=(is_K,)),
            Stage(a, C_s * w + r_s, by=(is_a,)),
            Stage(b, w + K_s * a, by=(is_b,)),
            Stage(Sigma, Omega - K * N.T, "(27)", symmetric=True, by=(shorter,)),
            *after,
        ),
        source=SOURCE,
        letters=short,
        says="what a sample does, with the covariance in its short form",
    )


@cache
def short_sample():
    """From one prediction to the next in the short form, all outputs having arrived."""
    return in_turn(short_update(), predict())


@cache
def derive():
    """The page."""
    said = {one for one in (*SHORT, *COMPUTED, *BOUND) if isinstance(one, Relation)}
    page = (
        *SHORT,
        *COMPUTED,
        *BOUND,
        "The estimate is corrected as with any gain.",
        *(one for one in definitions(short_update()) if one not in said),
        short_update(),
    )
    return Derivation(page=page, letters=short, source="our own")
