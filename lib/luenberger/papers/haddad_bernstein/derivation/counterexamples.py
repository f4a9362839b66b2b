"""Where a weaker form of the theorem goes wrong, in exact arithmetic.

Three estimators of order one on plants of two states.  Each satisfies (3.10)-(3.16)
with a projection tau = G'Gam of rank one and Q2, P2 > 0; in the first tau is aligned
with neither Qh nor Ph, in the second with Qh alone, in the third with Ph alone.
None is stationary.  The last example has every equation, (3.17) included, and a mode
of Ae at -1: the plant's first state is the last noise of its own measurement, and no
one asks for it.

The plants are found backwards: tau, Q and the gains first, then the noise.

Source: our own.
"""

from functools import cache

import sympy as sp
from sympy import Rational as F

from ....symbolic import (
    Algebra,
    BlockMatrix,
    Claim,
    Derivation,
    Identity,
    MatrixSymbol,
    claims,
)
from .augmented import (
    GAINS,
    JOINT,
    P2,
    P12,
    PAIRS,
    Q1,
    Q2,
    Q12,
    V1,
    V2,
    V12,
    A,
    Ae,
    Be,
    C,
    Ce,
    De,
    L,
    R,
    adjoint,
    cost,
    gradients,
    l,
    moment,
    n,
    q,
    r,
)
from .converse import PH, QH, TAU
from .stationarity import BEST, G, Gam, Q, Qs, V2s, formulas, theorem

SIZES = {n: 2, l: 1, r: 1, q: 1}
NOISY = [X for pair in PAIRS for X in pair]


def value(expr, known, sizes=SIZES):
    """A formula in explicit matrices; `known` has MatrixSymbols of symbolic sizes."""
    found = expr.as_expr() if hasattr(expr, "terms") else expr
    return sp.Matrix(found.subs(sizes).xreplace(explicit(known, sizes)).doit())


def explicit(known, sizes=SIZES):
    return {X.subs(sizes): sp.ImmutableMatrix(value) for X, value in known.items()}


def stein(left, right, rest):
    """X = left X right + rest."""
    size = rest.rows * rest.cols
    both = sp.kronecker_product(left, right.T)
    return (sp.eye(size) - both).LUsolve(sp.Matrix(list(rest))).reshape(*rest.shape)


def plant(known):
    """Complete A, C, L, Q, Qs, V2s, G, Gam so that (3.10)-(3.16) hold with R = 1."""
    quiet = {X: sp.zeros(*(d.subs(SIZES) for d in X.shape)) for X in NOISY}
    known = known | quiet | {R: sp.eye(1), V1: sp.zeros(2, 2)}
    known[TAU] = known[G].T * known[Gam]
    known[De] = value(formulas()["(3.13) De"], known)
    for X in (Ae, Be, Ce):
        known[X] = value(BEST[X], known)
    still = known | {QH: sp.zeros(2, 2), PH: sp.zeros(2, 2)}
    rest = theorem(TAU, QH, PH)
    K = known[Qs] * known[V2s].inv()
    ahead = known[A] * known[TAU]
    back = known[TAU] * (known[A] - K * known[C])
    known[QH] = stein(ahead, ahead.T, value(rest["(3.15)"], still))
    known[PH] = stein(back.T, back, value(rest["(3.16)"], still))
    known[V1] = -value(rest["(3.14)"], known)
    known[V12] = value(Qs - A * Q * C.T, known)
    known[V2] = value(V2s - C * Q * C.T, known)
    return known


def truth(known):
    """The moments that the estimator really has, and their duals."""
    known = dict(known)
    ahead, back = moment(), adjoint()
    a, e = known[A], known[Ae]
    for X, block, sides in (
        (Q1, ahead[0, 0], (a, a.T)),
        (Q12, ahead[0, 1], (a, e.T)),
        (Q2, ahead[1, 1], (e, e.T)),
        (P2, back[1, 1], (e.T, e)),
        (P12, back[0, 1], (a.T, e)),
    ):
        zero = {X: sp.zeros(*(d.subs(SIZES) for d in X.shape))}
        known[X] = stein(*sides, value(block, known | zero))
    return known


def trial(A_, C_, L_, Q_, Qs_, V2s_, g, gam):
    values = (A_, C_, L_, Q_, Qs_, V2s_, [g], [gam])
    return plant(dict(zip((A, C, L, Q, Qs, V2s, G, Gam), map(sp.Matrix, values))))


@cache
def examples():
    """{what tau is aligned with: (the plant and the estimator, a better estimator)}."""
    half, quarter = sp.eye(2) / 2, sp.eye(2) / 4
    neither = trial(
        [[F(1, 2), F(1, 2)], [0, F(3, 4)]], [[0, 1]], [[1, 1]], 4 * half, [1, F(3, 2)],
        [[F(5, 2)]], [1, 2], [0, F(1, 2)],
    )  # fmt: skip
    only_Q = trial(
        [[0, 0], [0, -F(1, 2)]], [[0, 1]], [[0, 2]], quarter, [-2, -1], [[4]],
        [1, F(1, 2)], [1, 0],
    )  # fmt: skip
    only_P = trial(
        [[F(3, 4), 0], [0, F(1, 2)]], [[1, 1]], [[F(3, 2), F(1, 2)]], quarter,
        [F(1, 2), 0], [[1]], [1, -1], [F(2, 3), -F(1, 3)],
    )  # fmt: skip
    return {
        "neither": (neither, better(neither, F(1, 2), F(1, 2), 1, F(4, 5))),
        "Qh alone": (only_Q, better(only_Q, -F(1, 4), -F(1, 2), 1, F(1, 11))),
        "Ph alone": (only_P, better(only_P, F(1, 4), F(2, 3), 1, F(3, 8))),
    }


def better(known, *gains):
    return known | {X: sp.Matrix([[g]]) for X, g in zip((Ae, Be, Ce, De), gains)}


def price(known):
    """J of an estimator by its true moments."""
    return cost().as_expr().subs(SIZES).xreplace(explicit(truth(known))).doit()


# What each estimator is worth: half the gradients, J, (3.18), and J of a better one.
FOUND = {
    "neither": (
        ("-72168/65675", "-68/25", "-102/175", "-204/175"),
        ("522/175", "12/5", "3501/1750"),
    ),
    "Qh alone": (("5/12", "0", "0", "0"), ("15/16", "15/16", "35753/50820")),
    "Ph alone": (
        ("109/210", "118/525", "118/1575", "103/1575"),
        ("5237/12600", "3/8", "224117/786240"),
    ),
}


def not_stationary(name):
    """The estimator of an example satisfies (3.10)-(3.16) and is not stationary."""
    known, improved = examples()[name]
    real, tau = truth(known), known[TAU]
    slopes, (J, said, less) = FOUND[name]
    joint = sp.Matrix(JOINT.subs(SIZES).xreplace(explicit(known)).as_explicit())
    minors = [joint[:k, :k].det() for k in (1, 2, 3)]
    aligned = {
        "Qh": tau * known[QH] - known[QH] * tau.T,
        "Ph": known[PH] * tau - tau.T * known[PH],
    }
    best = (known[L] * known[Q] * known[L].T - known[De] * known[V2s] * known[De].T)[0]
    positive = [value(Gam * QH * Gam.T, known)[0], value(G * PH * G.T, known)[0]]
    positive += minors + [1 - abs(known[Ae][0])]
    positive += [known[X].trace() for X in (QH, PH)]
    semidefinite = [known[X].det() for X in (QH, PH)]
    steps = {
        f"{key} holds": Claim(value(residual, known))
        for key, residual in theorem(TAU, QH, PH).items()
    } | {
        "(3.6) tau^2 = tau": Claim(tau * tau, tau),
        "cov(w1, w2), Q2, P2 > 0, Qh, Ph >= 0 and Ae is stable": Claim(
            sp.Integer(1 if min(positive) > 0 <= min(semidefinite) else 0),
            sp.Integer(1),
        ),
        "(3.5) J": Claim(price(known), F(J)),
        "(3.18) the formula": Claim(best, F(said)),
        "another estimator has less": Claim(price(improved), F(less)),
    }
    for X, slope in zip(GAINS, slopes):
        steps[f"half the gradient in {X.name} is {slope}"] = Claim(
            value(gradients()[X], real)[0], F(slope)
        )
    for X, gap in aligned.items():
        skew = sp.Integer(1 if gap != 0 * gap else 0)
        steps[f"tau is {'' if X in name else 'not '}aligned with {X}"] = Claim(
            skew, sp.Integer(0 if X in name else 1)
        )
    return {f"weak, aligned with {name}: {key}": step for key, step in steps.items()}


def not_stable():
    """n = n_e = 2, tau = I: w1 = v1, and L does not ask for the first state."""
    sizes = {n: 2, l: 2, r: 2, q: 1}
    quiet = {X: sp.zeros(2, 2) for X in NOISY}
    one = sp.eye(2)
    known = quiet | {
        A: sp.diag(0, F(1, 2)),
        C: one,
        L: sp.Matrix([[0, 1]]),
        R: sp.eye(1),
        V1: sp.diag(1, F(7, 8)),
        V12: sp.diag(1, 0),
        V2: one,
        Q: sp.diag(0, 1),
        G: one,
        Gam: one,
        TAU: one,
        QH: sp.diag(1, F(1, 6)),
        PH: sp.diag(1, F(4, 15)),
    }
    known[V2s] = value(V2 + C * Q * C.T, known, sizes)
    known[Qs] = value(V12 + A * Q * C.T, known, sizes)
    known[De] = value(formulas()["(3.13) De"], known, sizes)
    for X in (Ae, Be, Ce):
        known[X] = value(BEST[X], known, sizes)
    residuals = theorem(TAU, QH, PH)
    return {
        f"Q2, P2 > 0, yet Ae is not stable: {key} holds": Claim(
            value(residual, known, sizes)
        )
        for key, residual in residuals.items()
    } | {
        "Q2, P2 > 0, yet Ae is not stable: Ae": Claim(known[Ae], sp.diag(-1, F(1, 4))),
        "Q2, P2 > 0, yet Ae is not stable: Ce does not show it": Claim(
            known[Ce], sp.Matrix([[0, F(1, 2)]])
        ),
        "Q2, P2 > 0, yet Ae is not stable: cov(w1, w2) is singular": Claim(
            sp.Matrix(BlockMatrix([[known[V1], known[V12]], [known[V12], one]])).det()
        ),
    }


def vacuous():
    """tau = Qhat Phat (Qhat Phat)^# holds for every tau = G'Gam, so it says nothing."""
    X, Y = MatrixSymbol("X", r, r), MatrixSymbol("Y", r, r)
    algebra = Algebra(
        [QH, PH, X, Y],
        [(Gam * G.T, Identity(r)), (Gam * QH * Gam.T, X), (G * PH * G.T, Y)],
    )
    tau = G.T * Gam
    product = tau * QH * tau.T * tau.T * PH * tau
    group = G.T * Y.I * X.I * Gam
    return claims(
        algebra,
        {
            "weak: Qhat Phat = G'X Y Gam, X = Gam Qh Gam', Y = G Ph G'": (
                product,
                G.T * X * Y * Gam,
            ),
            "weak: M M^# = tau for every tau = G'Gam, M = Qhat Phat": (
                product * group,
                tau,
            ),
            "weak: M^# M = tau": (group * product, tau),
            "weak: M M^# M = M": (product * group * product, product),
            "weak: M^# M M^# = M^#": (group * product * group, group),
        },
    )


@cache
def derive():
    steps = {}
    for name in examples():
        steps |= not_stationary(name)
    return Derivation(steps=steps | not_stable() | vacuous(), source="our own")
