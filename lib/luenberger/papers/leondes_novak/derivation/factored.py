"""A covariance in factors `U D U'`: what one reading and one prediction make of it.

A reading changes one column of `U` after the other, a prediction finds one row after
the other, from the last one up.  Here is one column and one row; the filter repeats
them.  Nothing is inverted, no root is taken, and what a reading without noise tells is
an exact zero in `D`.

Source: Bierman (1977), "Factorization methods for discrete sequential estimation",
sections V.3 and VI.4; Thornton (1976).
"""

from sympy import symbols

from matrixproof import Identity, Page

from .letters import I, letters, n
from .letters.step import Omega

SOURCE = "Bierman (1977), sections V.3 and VI.4; Thornton (1976)"
q = symbols("q", integer=True, positive=True)
factored = letters.here(
    Omega="covariance before a reading",
    Sigma="covariance after it",
)
c = factored("c", n, 1, "what one output measures, as a column")
K = factored("k", n, 1, "the gain of least variance of its reading")
kappa = factored("kappa", n, 1, "`Omega c`, which the columns add up")
alpha = factored.scalar("alpha", "variance of the innovation", positive=True)
rho = factored.scalar("rho", "variance of the noise of the reading", positive=True)
beta = factored.scalar("beta", "variance by the columns before", positive=True)
delta = factored.scalar("delta", "entry of `D` for this column", positive=True)
phi = factored.scalar(
    "phi", "what the output sees of this column, of `U' c`", real=True
)
u_j = factored("u_j", n, 1, "the column of `U`")
u_new = factored("u_new", n, 1, "the column after the reading")
k_j = factored("k_j", n, 1, "what the columns before make of `kappa`")
k_new = factored("k_new", n, 1, "the same with this column")
W_0 = factored("W_0", n, q, "rows whose covariance is `W_0 D_q W_0'`")
W_1 = factored("W_1", n, q, "the same rows without what the last of them tells")
D_q = factored("D_q", q, q, "variances of the columns of `W_0`", symmetric=True)
w_j = factored("w_j", q, 1, "the last row, as a column")
t_j = factored("t_j", n, 1, "what each row has of the last one")

a = beta + delta * phi**2  # the variance with this column


page = Page(letters=factored, source=SOURCE)

page("""A reading of one output is a row `c'` of `C` with noise of variance `rho`, and
    `Omega = U D U'`. The columns of `U` are taken one after the other. Those before
    this one have left a column `k_j` and a variance `beta`, which begins with `rho`;
    `phi` is what the output sees of this column, an entry of `U' c`. With this column
    they are `k_j + delta phi u_j` and `beta + delta phi^2`.""")
is_k = page.let(k_new, k_j + delta * phi * u_j)
is_u = page.let(u_new, u_j - phi / beta * k_j)
column = page(
    factored.derive(
        "",
        "one column of a reading",
        delta * beta / a * u_new * u_new.T - 1 / beta * k_j * k_j.T,
    )
    .put(is_u)
    .by(
        delta * u_j * u_j.T
        - 1 / a * (k_j + delta * phi * u_j) * (k_j + delta * phi * u_j).T
    )
    .fold(is_k)
)

page("""So the column `u_new` with the variance `delta beta / (beta + delta phi^2)`
    takes the place of `u_j` with `delta`, and the sum over all columns is what is left
    of `U D U'`. A first reading without noise finds `beta = 0`, and leaves the variance
    zero. After the last column the two sums are `Omega c` and the variance of the
    innovation, and this is the covariance that the gain of least variance leaves.""")
is_kappa = page.let(kappa, Omega * c)
is_alpha = page.suppose(c.T * Omega * c, (alpha - rho) * Identity(1))
is_K = page.let(K, 1 / alpha * kappa)
says = "what a reading leaves"
page(
    factored.derive("27", says, (I - K * c.T) * Omega * (I - K * c.T).T + rho * K * K.T)
    .by(
        Omega - K * kappa.T - kappa * K.T + K * c.T * Omega * c * K.T + rho * K * K.T,
        is_kappa,
    )
    .use(is_alpha, is_K)
)

page("""A prediction has the covariance `W_0 D_q W_0'`, with `W_0 = [A U, G]` and the
    variances `D_q` of what drives its columns. What every row has of the last one is
    taken off. That is a column of the next `U`; nothing of the last row is left.""")
is_delta = page.suppose(w_j.T * D_q * w_j, delta * Identity(1))
is_t = page.suppose(W_0 * D_q * w_j, delta * t_j)
is_W_1 = page.let(W_1, W_0 - t_j * w_j.T)
page(
    factored.derive(
        "44", "one row of a prediction", W_1 * D_q * W_1.T + delta * t_j * t_j.T
    )
    .put(is_W_1)
    .expand()
    .use(is_t)
    .use(is_delta)
)
page(
    factored.derive("", "nothing of the last row is left", W_1 * D_q * w_j).use(
        is_W_1, is_t, is_delta
    )
)

page("""The last row itself has `1` of itself, and rows that are done have nothing, so
    `U` is a triangle with ones on its diagonal. Where the last row has no variance
    there is nothing to take off: its column of `U` is free.""")
