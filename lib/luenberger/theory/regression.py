"""What one error tells of another: the gain of least covariance, and what it leaves.

Nothing is inverted: a gain is any solution of its equation, also where the covariance
of what is measured is singular.
"""

from sympy import Trace, symbols

from matrixproof import Notation, Page

n, p = symbols("n p", integer=True, nonnegative=True)
letters = Notation()

e = letters("e", n, 1, "what is to be estimated")
y = letters("y", p, 1, "what is measured")
Omega = letters("Omega", n, n, "covariance of `e`", symmetric=True)
M = letters("M", p, p, "covariance of `y`", symmetric=True)
N = letters("N", n, p, "covariance of the two")
W_e = letters("W_e", n, n, "any weight", symmetric=True)
K = letters("K", n, p, "any gain")
G = letters("G", n, p, "the gain of least covariance")
L_M = letters("L_M", p, p, "a root of `M`")
d = letters("d", n, 1, "what the gain leaves of `e`")
D = letters("D", n, n, "covariance of that", symmetric=True)

page = Page(letters=letters, source="common to all papers")


page("The covariance of what any gain leaves is a quadratic in the gain.")
is_Omega = page.moment(e * e.T, Omega)
is_M = page.moment(y * y.T, M)
is_N = page.moment(e * y.T, N)
any_gain = page(
    letters.derive("", "what any gain leaves", (e - K * y) * (e - K * y).T).expect(
        is_Omega, is_M, is_N
    )
)
slope = page(
    letters.derive("", "the slope of its trace", Trace(W_e * any_gain.right)).gradient(
        K
    )
)

page("The slope vanishes for one gain, and no other leaves less.")
is_G = page(slope.solve(K, name=G))
root = page.suppose(M, L_M * L_M.T)
least = page(
    letters.derive("", "no gain leaves less", any_gain.left)
    .expect(is_Omega, is_M, is_N)
    .square(K, is_G)
    .drop(root)
)

page("What it leaves is uncorrelated with what is measured.")
is_d = page.let(d, e - G * y)
apart = page(
    letters.derive("", "what is left is told by nothing", d * y.T)
    .put(is_d)
    .expect(is_M, is_N)
    .use(is_G)
)
is_D = page.let(D, Omega - G * N.T)
left = page(
    letters.derive("", "the covariance of what is left", d * d.T)
    .put(is_d)
    .expect(is_Omega, is_M, is_N)
    .use(is_G)
    .fold(is_D)
)
