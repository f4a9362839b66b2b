"""The likelihood of a record, from the innovations of its filter.

A filter turns a record into innovations: each is what a measurement adds to those
before it.  They are independent, so the density of the record is the product of
theirs.

Source: our own; the factorisation is that of Schweppe (1965), "Evaluation of
likelihood functions for Gaussian signals".
"""

from sympy import Symbol

from matrixproof import Identity, Page, Solve, Stage

from ...papers.leondes_novak.derivation.estimate import innovation, running
from ...papers.leondes_novak.derivation.letters import p
from ...papers.leondes_novak.derivation.letters.step import M

SOURCE = "our own; Schweppe (1965)"
N_all = Symbol("N", integer=True, positive=True)

letters = running.here()
W = letters("W", p, p, "inverse of `M`", symmetric=True)
e = letters("e", p, 1, "innovation, weighed by its covariance")
y_all = letters("y_all", N_all, 1, "the whole record, less its mean")
nu_all = letters("nu_all", N_all, 1, "its innovations, one below the other")
T_all = letters("T_all", N_all, N_all, "lower triangle with ones on its diagonal")
V_all = letters("V_all", N_all, N_all, "covariance of the record", symmetric=True)
M_all = letters("M_all", N_all, N_all, "that of the innovations", symmetric=True)


page = Page(letters=letters, source=SOURCE)

page("""A measurement is what the filter predicts from those before it, and the
    innovation. So the record is a lower triangle times its innovations, with ones on
    the diagonal. The innovations are independent: `M_all` has their covariances `M` on
    its diagonal, and zeros elsewhere.""")
triangle = page.let(y_all, T_all * nu_all)
is_V = page.suppose(T_all * M_all, V_all * T_all.T.I)
says = "the exponent of the density, from the innovations"
page(
    letters.derive("", says, y_all.T * V_all.I * y_all)
    .use(triangle)
    .by(nu_all.T * M_all.I * nu_all, is_V)
)

page("""The determinant of such a triangle is one, so that of `V_all` is the product of
    the determinants of all `M`. Of a record with `p` outputs at each instant the
    logarithm of the likelihood is therefore the sum over instants of `-1/2 (p log(2 pi)
    + log det(M) + innovation' W innovation)`, with `W` the inverse of `M`.""")
is_W = page.suppose(W * M, Identity(p))
is_e = page.let(e, W * innovation)
row = innovation.T * M.I * innovation
page(
    letters.derive("", "what one row adds to the exponent", row).by(
        innovation.T * e, is_W, is_e
    )
)

weighed = page.program(
    "an innovation, weighed",
    (M, innovation),
    Stage(W, Solve(Identity(p), M), by=(is_W,)),
    is_e,
)
