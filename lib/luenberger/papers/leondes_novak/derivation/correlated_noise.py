"""Noises that are correlated, and the covariance of any observer's error.

What the measurement's noise tells of the process noise is known, and can be taken out:
the plant is the same, and its noises are independent.  Every error of an observer has
a covariance that moves by a recursion.

Source: our own; Leondes and Novak (1974), (5), have independent noises.
"""

from sympy import Symbol

from matrixproof import Page, Stage, ZeroMatrix

from ....theory import regression
from .huddle import error, error_equation, unbiased
from .letters import SOURCE, letters, n, p, r
from .letters.observer import D, F, P, T, T_next, V, X, X_next, eps, eps_next
from .letters.plant import A, As, C, J, Q, Qs, R, S, a, b, v, w, x
from .letters.step import Sigma, e

t = Symbol("t", real=True)
gone = ZeroMatrix


page = Page(letters=letters, source=f"our own; {SOURCE}, (5), (11)")

page("""The paper's noises are independent of each other, (5). The library lets them be
    correlated. Then what `v` tells of `w` is known and can be taken out, with a matrix
    `J` that solves `J R = S`.""")
is_Q = page.moment(w * w.T, Q, "4")
is_R = page.moment(v * v.T, R, "4")
is_S = page.moment(w * v.T, S)
told = page.suppose(S, J * R)

page("""Such a matrix exists, also where `R` is singular: a combination of outputs
    without noise is correlated with nothing. A variance is not negative, and the
    following one is linear in `t`, so its slope is zero.""")
silent = page.suppose(R * a, gone(p, 1))
says = "outputs without noise are correlated with nothing"
page(
    letters.derive("", says, (b.T * w + t * a.T * v) * (b.T * w + t * a.T * v).T)
    .expect(is_Q, is_R, is_S)
    .use(silent)
)
is_As = page.let(As, A - J * C)
page(
    letters.derive("", "the same plant, with what is told taken out", A * x + w).by(
        As * x + J * (C * x + v) + (w - J * v), is_As
    )
)
by_v = dict(e=w, y=v, Omega=Q, M=R, N=S, G=J, d=w - J * v, D=Qs)
says = "what is left is independent of the measurement noise"
page.at("", says, regression.apart, **by_v)
is_Qs = page.let(Qs, Q - J * S.T)
page.at("", "the covariance of what is left", regression.left, **by_v)

page("""Every error of an observer then has a covariance by recursion, whatever its
    matrices are. The two crossed terms are those that (5) sets to zero.""")
is_X = page.moment(eps * eps.T, X)
past_w = page.moment(eps * w.T, gone(r, n))
past_v = page.moment(eps * v.T, gone(r, p))
is_X_next = page.let(
    X_next,
    F * X * F.T
    + D * R * D.T
    + T_next * Q * T_next.T
    - D * S.T * T_next.T
    - T_next * S * D.T,
    "11",
    name="covariance of the observer's error",
)
says = "the covariance of the error moves by a recursion"
page(
    letters.derive("4, 5, 11", says, eps_next * eps_next.T)
    .put(error_equation)
    .expect(is_X, is_Q, is_R, is_S, past_w, past_v)
    .fold(is_X_next)
)
is_Sigma = page.let(Sigma, P * X * P.T + V * R * V.T, "27")
page(
    letters.derive("26, 27", "the covariance of the estimate", e * e.T)
    .put(error)
    .expect(is_X, is_R, past_v)
    .fold(is_Sigma)
)

page("""Huddle's equations for the plant with independent noises are the same, with `As`
    in place of `A`; what is told enters through the measurement.""")
page(unbiased)
is_F_s = page.let(F, T_next * As * P, "14")
is_D_s = page.let(D, T_next * As * V + T_next * J, "15")
solution = page(
    letters.derive("9", "the solution for correlated noises", F * T + D * C)
    .put(is_F_s)
    .use(is_D_s, unbiased, is_As)
)

decorrelation = page.program(
    "correlated noises, and the plant with independent ones",
    (A, C, Q, S, J),
    is_As,
    Stage(Qs, Q - J * S.T, symmetric=True, by=(is_Qs, told)),
)

crossed = D * S.T * T_next.T
moved = F * X * F.T + D * R * D.T + T_next * Q * T_next.T - crossed - crossed.T
error_recursion = page.program(
    "the covariance of any observer's error, one step",
    (F, D, T_next, P, V, Q, R, S, X),
    Stage(X_next, moved, "(11)", symmetric=True, by=(is_X_next,)),
    (is_Sigma, "(26)"),
)
