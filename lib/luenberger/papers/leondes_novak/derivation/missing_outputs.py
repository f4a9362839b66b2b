"""A step at which some outputs did not arrive is the theorem for fewer outputs.

A gain that may use only the outputs that arrived costs what a gain of the shorter
problem costs, so the best one is that problem's.  An accurate output that is missing
leaves one direction more to be filtered.  The same gain is the limit of infinite noise
on what is missing.

Source: our own; the step is Leondes and Novak's (1974), (27)-(33).
"""

from sympy import symbols

from matrixproof import Identity, Page, ZeroMatrix

from . import quadratic
from .letters import I, letters, m1, n, p, r
from .letters.canonical import C_1
from .letters.plant import C, R
from .letters.step import K, M, Omega
from .quadratic import is_M, joseph

pa, pm = symbols("p_a p_m", integer=True, nonnegative=True)
Pick = letters("Pick", pa, p, "picks the outputs that arrived")
K_a = letters("K_a", n, pa, "gain of the outputs that arrived")
K_m = letters("K_m", n, pm, "gain of those that are missing")
c = letters("c", 1, n, "row of the accurate output that is missing")
N_c = letters("N_c", n, r - 1, "what none of the accurate outputs shows")
g_c = letters("g_c", n, 1, "what the missing output alone shows")
k_c = letters("k_c", r - 1, 1, "coordinates in `N_c`")
t_c = letters("t_c", 1, 1, "coordinate along `g_c`")
M_aa = letters("M_aa", pa, pa, "block of `M`: what arrived", symmetric=True)
M_ma = letters("M_ma", pm, pa, "block of `M`: what is missing, and what arrived")
M_mm = letters("M_mm", pm, pm, "block of `M`: what is missing", symmetric=True)
M_s = letters(
    "M_s", pm, pm, "its Schur complement, with infinite noise", symmetric=True
)
N_a = letters("N_a", n, pa, "block of `N`: what arrived")
N_m = letters("N_m", n, pm, "block of `N`: what is missing")


page = Page(letters=letters, source="our own")

page("""A gain that may use only what arrived is `K = K_a Pick`. Its cost is that of the
    shorter problem, in which `Pick C` is measured with the noise that is picked.""")
arrived, noise = Pick * C, Pick * R * Pick.T
cost = joseph(K_a, arrived, Omega, noise)
is_K = page.let(K, K_a * Pick)
says = "the cost is that of the shorter problem"
page(letters.derive("27", says, joseph(K, C, Omega, R)).by(cost, is_K))
page(is_M)
says = "the innovation is that of the shorter problem"
page(
    letters.derive("33", says, arrived * Omega * arrived.T + noise).by(
        Pick * M * Pick.T, is_M
    )
)

page("So the gradient vanishes where the shorter problem's does.")
shorter = dict(K=K_a, C=arrived, R=noise, M=Pick * M * Pick.T, N=Omega * C.T * Pick.T)
says = "the gradient is that of the shorter problem"
left = I - K_a * arrived
page.at("32", says, quadratic.slope, Y=left, Sigma_next=cost, **shorter)

page("""If an accurate output is missing, with the row `c`, the others leave one
    direction more free: the one that it alone would have shown.""")
others = page.suppose(C_1 * N_c, ZeroMatrix(m1, r - 1))
too = page.suppose(c * N_c, ZeroMatrix(1, r - 1))
alone = page.suppose(C_1 * g_c, ZeroMatrix(m1, 1))
shown = page.suppose(c * g_c, Identity(1))
new = N_c * k_c + g_c * t_c
page(letters.derive("", "the others show nothing of it", C_1 * new).use(others, alone))
says = "the missing output would show the new direction"
page(letters.derive("", says, c * new).use(too, shown))

page("""Another way to leave an output out is to give it infinite noise. In blocks of
    what arrived and what is missing, the gain solves two equations. The Schur
    complement `M_s` grows with the noise, so `K_m` goes to zero, and what is left of
    `K_a` is the gain without the missing outputs.""")
is_M_s = page.let(M_s, M_mm - M_ma * M_aa.I * M_ma.T)
is_K_m = page.let(K_m, (N_m - N_a * M_aa.I * M_ma.T) * M_s.I)
is_K_a = page.let(K_a, (N_a - K_m * M_ma) * M_aa.I)
first, second = K_a * M_aa + K_m * M_ma, K_a * M_ma.T + K_m * M_mm
page(letters.derive("33", "the columns of what arrived", first).by(N_a, is_K_a))
page(
    letters.derive("33", "the columns of what is missing", second)
    .put(is_K_a)
    .by(N_a * M_aa.I * M_ma.T + K_m * M_s, is_M_s)
    .by(N_m, is_K_m)
)
no_gain = page.suppose(K_m, ZeroMatrix(n, pm))
page(
    letters.derive("33", "the limit of infinite noise", K_a)
    .put(is_K_a)
    .by(N_a * M_aa.I, no_gain)
)
