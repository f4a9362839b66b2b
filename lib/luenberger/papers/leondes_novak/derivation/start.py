"""How the observer starts, from what is known of the first state.

It starts at what it would follow if the state were its mean, and errs by the rest.  An
observer that starts elsewhere errs by the difference as well.

Source: Leondes and Novak (1974), section III, (34)-(36); the root is our own.
"""

from sympy import symbols

from matrixproof import BlockMatrix, Page, ZeroMatrix

from .letters import SOURCE, letters, n, r
from .letters.observer import T, T_next, eps, eps_next, z, z_next
from .letters.plant import A, B, d, u, x, x_bar, x_next
from .quadratic import is_Omega
from .stochastic_system import deviation, is_d, is_Q, is_Sigma_x, white

k = symbols("k", integer=True, nonnegative=True)
H_x = letters("H_x", n, k, "rows of a common root: the state")
H_z = letters("H_z", r, k, "rows of it: the observer")
z_bar = letters("z_bar", r, 1, "mean of the observer")
d_z = letters("d_z", r, 1, "deviation of the observer from its mean")
H_eps = letters("H_eps", r, k + 1, "a root of the second moment of the error")


page = Page(letters=letters, source=f"{SOURCE}, section III")

page("""The observer starts at what is known of the first state. It then errs by what is
    not known, and the recursion starts with (36).""")
starts = page.let(z_next, T_next * (A * x_bar + B * u), "34")
errs = page.let(eps_next, z_next - T_next * x_next, "8")
start = page(
    letters.derive("34", "the error at the start", eps_next)
    .put(errs, starts)
    .use(deviation)
)
page(is_d, is_Sigma_x, is_Q, white, is_Omega)
page(
    letters.derive("35, 36", "its covariance", eps_next * eps_next.T)
    .put(start)
    .expect(is_Sigma_x, is_Q, white)
    .fold(is_Omega)
)

page("""An observer that starts at some other `z` errs by what the mean of the state
    does not explain, too. Its start may depend on what is known of the past, such as a
    first input, and then deviates from its own mean as the state does. Both deviations
    have a root in common, with `H_x` and `H_z` for its rows. In a root of the second
    moment the difference of the means is a single column beside it.""")
is_d_z = page.let(d_z, z - z_bar)
here = page.let(eps, z - T * x, "8")
elsewhere = page(
    letters.derive("8", "the error of any start", eps)
    .put(here)
    .by((z_bar - T * x_bar) + d_z - T * d, is_d, is_d_z)
)
centred = page.moment(d, ZeroMatrix(n, 1), "6")
centred_z = page.moment(d_z, ZeroMatrix(r, 1))
is_xx = page.moment(d * d.T, H_x * H_x.T)
is_xz = page.moment(d * d_z.T, H_x * H_z.T)
is_zz = page.moment(d_z * d_z.T, H_z * H_z.T)
is_H_eps = page.let(H_eps, BlockMatrix([[T * H_x - H_z, z_bar - T * x_bar]]))
page(
    letters.derive("35", "the second moment of any start", eps * eps.T)
    .put(elsewhere)
    .expect(is_xx, is_xz, is_zz, centred, centred_z)
    .by(H_eps * H_eps.T, is_H_eps)
)

start_root = page.program(
    "a root of the second moment of the error at any start",
    (T, H_x, H_z, z_bar, x_bar),
    (is_H_eps, "(35)"),
)
