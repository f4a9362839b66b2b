"""Where a weaker form of the theorem goes wrong, in exact arithmetic.

Three estimators of order one on plants of two states.  Each satisfies (3.10)-(3.16)
with a projection of rank one, a definite moment and a definite dual.  The first
projection is aligned with neither hat, the second with the first hat alone, the third
with the second hat alone.  None is stationary.  The last example satisfies every
equation, (3.17) included, and its estimator has a mode at -1.  There the plant's first
state is the last noise of its own measurement, and no one asks for it.

The plants are found backwards: the projection, the covariance of the error and the
gains first, then the noise.

Source: our own.
"""

from functools import cache

import sympy as sp
from sympy import Rational as F

from matrixproof import BlockMatrix, Identity, Line, Page
from matrixproof.explicit import Claim
from matrixproof.models import evaluate

from .augmented import is_N2, is_N12, is_Qxy, is_Qxy_next, is_Qyy
from .cost import is_M2, is_M12, is_S, shown
from .equations import is_adjoint, is_estimate, is_perp, is_riccati
from .gradients import is_gradAe, is_gradBe, is_gradCe, is_gradDe
from .letters import letters, n, r
from .letters.both import P2, P12, Q1, Q2, Q12
from .letters.estimator import GAINS, Ae, Be, Ce, De
from .letters.kernels import M2, M12, N2, N12
from .letters.plant import V1, V2, V12, A, C, L, R
from .letters.theorem import Aq, G, Gam, Kq, Ph, Q, Qh, Qs, V2s, tau
from .projection import is_Lq
from .stationarity import is_Aq, is_Ce, is_tau

letters = letters.here()
M_tau = letters("M_tau", n, n, "product of the hats between projections")
M_sharp = letters("M_tau_sharp", n, n, "its group inverse")


MEANT = {x.left: x.right for x in (is_N12, is_N2, is_M12, is_M2, is_Qxy, is_Qxy_next)}
MEANT |= {x.left: x.right for x in (is_Qyy, is_S, is_Aq, is_Lq, is_perp)}
MEANT[Kq] = Qs * V2s.I
BEST = {Ae: Gam * Aq * G.T, Be: Gam * Kq, Ce: is_Ce.right}
STATIC = L * Q * C.T * V2s.I
EQUATIONS = {
    "(3.14)": is_riccati.right,
    "(3.15)": is_estimate.right,
    "(3.16)": is_adjoint.right,
}
SLOPES = [x.right / 2 for x in (is_gradAe, is_gradBe, is_gradCe, is_gradDe)]
JOINT = BlockMatrix([[V1, V12], [V12.T, V2]])


def value(expr, known):
    """A formula in explicit matrices; `known` has MatrixSymbols of symbolic sizes."""
    for _ in range(3):  # definitions in definitions
        expr = expr.xreplace(MEANT)
    return sp.Matrix(evaluate(expr, known))


def stein(left, right, rest):
    """X = left X right + rest."""
    size = rest.rows * rest.cols
    both = sp.kronecker_product(left, right.T)
    return (sp.eye(size) - both).LUsolve(sp.Matrix(list(rest))).reshape(*rest.shape)


def with_gains(known):
    """With tau and the gains (3.10)-(3.13)."""
    known = known | {tau: known[G].T * known[Gam], De: value(STATIC, known)}
    return known | {X: value(gain, known) for X, gain in BEST.items()}


def plant(known):
    """Complete A, C, L, Q, Qs, V2s, G, Gam so that (3.10)-(3.16) hold with R = 1."""
    known = with_gains(known | {R: sp.eye(1), V1: sp.zeros(2, 2)})
    still = known | {Qh: sp.zeros(2, 2), Ph: sp.zeros(2, 2)}
    ahead, back = value(A * tau, known), value(tau * Aq, known)
    known[Qh] = stein(ahead, ahead.T, value(is_estimate.right, still))
    known[Ph] = stein(back.T, back, value(is_adjoint.right, still))
    known[V1] = -value(is_riccati.right, known)
    known[V12] = value(Qs - A * Q * C.T, known)
    known[V2] = value(V2s - C * Q * C.T, known)
    return known


def truth(known):
    """The moments that the estimator really has, and their duals."""
    known = dict(known)
    a, e = known[A], known[Ae]
    for X, drive, sides in (
        (Q1, V1, (a, a.T)),
        (Q12, N12, (a, e.T)),
        (Q2, N2, (e, e.T)),
        (P2, M2, (e.T, e)),
        (P12, M12, (a.T, e)),
    ):
        known[X] = stein(*sides, value(drive, known))
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
    return value(R * shown.right, truth(known)).trace()


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
    real = truth(known)
    slopes, (J, said, less) = FOUND[name]
    joint = value(JOINT, known)
    aligned = {
        "Qh": value(tau * Qh - Qh * tau.T, known),
        "Ph": value(Ph * tau - tau.T * Ph, known),
    }
    best = value(L * Q * L.T - De * V2s * De.T, known)[0]
    positive = [value(X, known)[0] for X in (Gam * Qh * Gam.T, G * Ph * G.T)]
    positive += [joint[:k, :k].det() for k in (1, 2, 3)] + [1 - abs(known[Ae][0])]
    positive += [known[X].trace() for X in (Qh, Ph)]
    semidefinite = [known[X].det() for X in (Qh, Ph)]
    steps = {
        f"{key} holds": Claim(value(residual, known))
        for key, residual in EQUATIONS.items()
    } | {
        "(3.6) tau^2 = tau": Claim(known[tau] * known[tau], known[tau]),
        "cov(w1, w2), Q2, P2 > 0, Qh, Ph >= 0 and Ae is stable": Claim(
            sp.Integer(1 if min(positive) > 0 <= min(semidefinite) else 0),
            sp.Integer(1),
        ),
        "(3.5) J": Claim(price(known), F(J)),
        "(3.18) the formula": Claim(best, F(said)),
        "another estimator has less": Claim(price(improved), F(less)),
    }
    for X, half, slope in zip(GAINS, SLOPES, slopes):
        found = value(half, real)[0]
        steps[f"half the gradient in {X.name} is {slope}"] = Claim(found, F(slope))
    for X, gap in aligned.items():
        skew = sp.Integer(1 if gap != 0 * gap else 0)
        steps[f"tau is {'' if X in name else 'not '}aligned with {X}"] = Claim(
            skew, sp.Integer(0 if X in name else 1)
        )
    return {f"weak, aligned with {name}: {key}": step for key, step in steps.items()}


def not_stable():
    """n = n_e = 2, tau = I: w1 = v1, and L does not ask for the first state."""
    one = sp.eye(2)
    known = {
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
        Qh: sp.diag(1, F(1, 6)),
        Ph: sp.diag(1, F(4, 15)),
    }
    known[V2s] = value(V2 + C * Q * C.T, known)
    known[Qs] = value(V12 + A * Q * C.T, known)
    known = with_gains(known)
    found = {
        f"{key} holds": Claim(value(residual, known))
        for key, residual in EQUATIONS.items()
    } | {
        "Ae": Claim(known[Ae], sp.diag(-1, F(1, 4))),
        "Ce does not show it": Claim(known[Ce], sp.Matrix([[0, F(1, 2)]])),
        "cov(w1, w2) is singular": Claim(
            sp.Matrix(BlockMatrix([[known[V1], known[V12]], [known[V12], one]])).det()
        ),
    }
    return {f"Q2, P2 > 0, yet Ae is not stable: {k}": step for k, step in found.items()}


lifted = G.T * Q2 * P2 * Gam

exact = {k: x for name in examples() for k, x in not_stationary(name).items()}
page = Page(letters=letters, source="our own", steps=exact | not_stable())

page("""A weaker reading of (3.17) asks for `tau = M M#` with the group inverse of the
    product `M` of the two hats between projections. It says nothing: the equation holds
    for every product of two biorthogonal factors.""")
page(is_tau)
one = page.suppose(Gam * G.T, Identity(r), "3.9")
is_Q2 = page.let(Q2, Gam * Qh * Gam.T)
is_P2 = page.let(P2, G * Ph * G.T)
is_M = page.let(M_tau, tau * Qh * tau.T * tau.T * Ph * tau)
is_group = page.let(M_sharp, G.T * P2.I * Q2.I * Gam)
product = page.chain(
    "3.17",
    "the product of the hats between projections",
    M_tau,
    Line(tau * Qh * tau.T * tau.T * Ph * tau, by=(is_M,)),
    Line(G.T * Gam * Qh * Gam.T * G * Gam.T * G * Ph * G.T * Gam, by=(is_tau,)),
    Line(G.T * Q2 * G * Gam.T * P2 * Gam, by=(is_Q2, is_P2)),
    Line(lifted, by=(one,)),
)
right = page.chain(
    "3.17",
    "the weaker equation holds for every projection",
    M_tau * M_sharp,
    Line(lifted * M_sharp, by=(product,)),
    Line(lifted * G.T * P2.I * Q2.I * Gam, by=(is_group,)),
    Line(G.T * Gam, by=(one,)),
    Line(tau, by=(is_tau,)),
)
left = page.chain(
    "3.17",
    "from the other side as well",
    M_sharp * M_tau,
    Line(G.T * P2.I * Q2.I * Gam * M_tau, by=(is_group,)),
    Line(G.T * P2.I * Q2.I * Gam * lifted, by=(product,)),
    Line(G.T * Gam, by=(one,)),
    Line(tau, by=(is_tau,)),
)
page.chain(
    "3.17",
    "it is the group inverse",
    M_tau * M_sharp * M_tau,
    Line(tau * M_tau, by=(right,)),
    Line(G.T * Gam * lifted, by=(is_tau, product)),
    Line(lifted, by=(one,)),
    Line(M_tau, by=(product,)),
)
page.chain(
    "3.17",
    "and that one's group inverse is the product",
    M_sharp * M_tau * M_sharp,
    Line(tau * M_sharp, by=(left,)),
    Line(G.T * Gam * G.T * P2.I * Q2.I * Gam, by=(is_tau, is_group)),
    Line(G.T * P2.I * Q2.I * Gam, by=(one,)),
    Line(M_sharp, by=(is_group,)),
)
