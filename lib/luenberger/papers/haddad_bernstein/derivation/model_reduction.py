"""H2 model reduction is a fixed-order filter of a plant that is its own noise.

A model of low order is to answer white noise as a plant does, in continuous time.  The
Cayley transform of both leaves the solution of their Lyapunov equation as it is, and
so their distance.  In discrete time the noise itself is measured, and the filter of
least error without feedthrough is the transform of the best model.

Source: our own.
"""

from sympy import symbols

from matrixproof import BlockMatrix, Identity, Page, ZeroMatrix

from .augmented import is_At, is_Qt, is_Vt
from .cost import is_Lt, is_Sigma
from .letters import I, l, letters, n, r
from .letters.both import Q1, Q2, Q12, At, Qt, both
from .letters.estimator import Ae, Be, Ce
from .letters.plant import V1, V2, V12, A, C, L
from .sensitivity import silent

h = symbols("h", positive=True)
A_c = letters("A_c", n, n, "moves the plant in continuous time")
A_m = letters("A_m", r, r, "moves the model in continuous time")
F_c = letters("F_c", both, both, "moves both in continuous time")
B_c = letters("B_c", both, l, "how the noise reaches both in continuous time")
B_d = letters("B_d", both, l, "how the noise reaches both in discrete time")
B_1 = letters("B_1", n, l, "how the noise reaches the plant in discrete time")
N_c = letters("N_c", both, both, "what the Cayley transform divides by")
N_1 = letters("N_1", n, n, "its block of the plant")
N_m = letters("N_m", r, r, "its block of the model")


def side_by_side(top, low):
    """Plant and model, neither of which moves the other."""
    return BlockMatrix([[top, ZeroMatrix(n, r)], [ZeroMatrix(r, n), low]])


page = Page(letters=letters, source="our own")

page("""In continuous time the second moment of plant and model satisfies `F_c Q~ + Q~
    F_c' + B_c B_c' = 0`. The Cayley transform with the step `h^2` moves both in
    discrete time, where the moment satisfies (4.4). Both equations are one.""")
page(is_At)
is_Nc = page.let(N_c, Identity(both) - h**2 / 2 * F_c)
transformed = page.suppose(At, 2 * N_c.I - Identity(both))
is_Bd = page.let(B_d, h * N_c.I * B_c)
page(
    letters.derive(
        "4.4",
        "the moment equation is that of continuous time",
        N_c * (At * Qt * At.T + B_d * B_d.T - Qt) * N_c.T,
    )
    .use(transformed, is_Bd)
    .use(is_Nc)
)

page("""For the filter, the noise itself is measured: `C = 0`, `V_2 = I`, and the noise
    of state and measurement have the covariance `B_1`. The input of the filter is that
    of the model.""")
page(is_Vt)
unseen = page.suppose(C, ZeroMatrix(l, n))
is_V1 = page.suppose(V1, B_1 * B_1.T)
is_V12 = page.suppose(V12, B_1)
is_V2 = page.suppose(V2, Identity(l))
is_blocks = page.suppose(B_d, BlockMatrix([[B_1], [Be]]))
alone = page(
    letters.derive("section 2", "the filter is not moved by the plant", is_At).use(
        unseen
    )
)
page(
    letters.derive(
        "4.4", "the noise of plant and filter is that of plant and model", is_Vt
    ).by(B_d * B_d.T, is_V1, is_V12, is_V2, is_blocks)
)

page("""So plant and filter do not move each other, no more than plant and model do.
    Each is the transform of its own.""")
is_Fc = page.let(F_c, side_by_side(A_c, A_m))
is_N1 = page.let(N_1, I - h**2 / 2 * A_c)
is_Nm = page.let(N_m, Identity(r) - h**2 / 2 * A_m)
parts = page(
    letters.derive("", "what the transform divides by in blocks", is_Nc)
    .put(is_Fc)
    .fold(is_N1, is_Nm)
)
page(
    letters.derive(
        "",
        "plant and filter are transforms of plant and model",
        side_by_side(A * N_1, Ae * N_m),
    )
    .by(At * N_c, alone, parts)
    .use(transformed)
    .put(parts)
    .multiply()
)

page("Without feedthrough the error of the filter is the distance of the two outputs.")
page(is_Lt, is_Qt, is_Sigma, silent)
page(
    letters.derive("3.5", "the distance of two models", is_Sigma).by(
        L * Q1 * L.T - L * Q12 * Ce.T - Ce * Q12.T * L.T + Ce * Q2 * Ce.T,
        *(is_Lt, is_Qt, silent),
    )
)
