"""A start of which nothing is known: the limit of wide ones.

The covariance of a state is then kappa times a matrix, and another one, as kappa grows
beyond all numbers.  What a filter finds from leading terms alone is the limit.

Source: our own; the limit is that of de Jong (1991), "The diffuse Kalman filter".
"""

from sympy import Symbol, symbols

from matrixproof import Identity, Notation, Page

SOURCE = "our own; de Jong (1991)"

n = symbols("n", integer=True, nonnegative=True)
letters = Notation()
kappa = Symbol("kappa", positive=True)
v = letters("v", n, 1, "a direction of which nothing is known")
a = letters("a", n, 1, "any column")
C_j = letters("C_j", 1, n, "row of `C` of one reading")
s_j = letters("s_j", 1, 1, "what the reading has of the direction")
r_j = letters("r_j", 1, 1, "variance of its noise")
P_f = letters("P_f", n, n, "what is finite of the covariance", symmetric=True)
M_j = letters("M_j", 1, 1, "variance of its innovation")
N_j = letters("N_j", n, 1, "covariance of the state and the innovation")
m_j = letters("m_j", 1, 1, "what is finite of `M_j`")
g = letters("g", n, 1, "the gain, as `kappa` grows")
Y_g = letters("Y_g", n, n, "what the gain leaves of an error")


page = Page(letters=letters, source=SOURCE)

page("""Let a state have the covariance `kappa v v' + P_f`, and read one output. If it
    has something of the direction, `s_j` is not zero, the variance of the innovation
    grows with `kappa`, and so does what state and innovation have in common.""")
is_s = page.let(s_j, C_j * v)
is_M = page.let(M_j, C_j * (kappa * v * v.T + P_f) * C_j.T + r_j)
is_N = page.let(N_j, (kappa * v * v.T + P_f) * C_j.T)
is_m = page.let(m_j, C_j * P_f * C_j.T + r_j)
page(
    letters.derive("", "the variance of the innovation has a leading term", M_j)
    .put(is_M)
    .fold(is_s, is_m)
)
page(
    letters.derive("", "so has what the state and the innovation have in common", N_j)
    .put(is_N)
    .fold(is_s)
)

page("""The gain, the quotient of both, has that of the leading terms as its limit, and
    the gain meets the direction.""")
is_g = page.suppose(g * s_j, v)
is_Y = page.let(Y_g, Identity(n) - g * C_j)
none_left = page(
    letters.derive("", "nothing of the direction is left", Y_g * v)
    .use(is_Y)
    .fold(is_s)
    .use(is_g)
)

page("""So what is finite of the covariance matters only up to parts along the
    direction: another mean and another finite part along it lead to the same. That is
    why terms that do not lead may be dropped.""")
says = "parts along the direction are forgotten"
page(letters.derive("", says, Y_g * (P_f + v * a.T + a * v.T) * Y_g.T).use(none_left))
