"""Mean-square stability of plant and estimator: lemma 4.1, and the largest noise.

The map of the second moment is block triangular, so its eigenvalues are those of three
maps: the plant's own, that of the mixed moment and that of the estimator.  Both
together are mean-square stable exactly if the plant is and the estimator is stable.
That the plant is stable without its noise, as printed, is not enough.

Source: Haddad and Bernstein (1987), lemma 4.1; the scaling is our own.
"""

import sympy as sp
from sympy import Rational, Trace
from sympy import kronecker_product as kron

from matrixproof import (
    BlockMatrix,
    Explicit,
    Identity,
    Page,
    ZeroMatrix,
)

from .augmented import is_At, is_At1, is_Qt, is_V1, own
from .letters import SOURCE, letters, n, r, square, sum_i
from .letters.both import Q1, Q2, Q12, At, At1, Qt, both
from .letters.estimator import Ae, Be
from .letters.kernels import X
from .letters.plant import A1, C1, W1, A, C

k = sp.symbols("k", integer=True, nonnegative=True)
c, s = sp.symbols("c s", positive=True)
F12 = letters("F12", n, r, "what `Q_1` adds to `Q_12` in one step")
F2 = square("F2", r, "what `Q_1` and `Q_12` add to `Q_2` in one step")
H_k = letters("H_k", both**2, both**2, "matrix of the map of the moment of both")
q_k = letters("q_k", both**2, 1, "entries of a matrix, row by row")
q_k_next = letters("q_k_next", both**2, 1, "the same one step on, without new noise")
V_A = letters("V_A", n, k, "spans the real modes of one eigenvalue of `A'`")
M_c = letters("M_c", k, k, "how they turn in one step")
H_X = letters("H_X", n, n, "a root of `X`")
Y = square("Y", n, "what `X` sums up to through the noise")
X_k = square("X_k", n, "an approximation of the moment of the state")
X_k_next = square("X_k_next", n, "the next approximation")
none = ZeroMatrix

a, a1, ae, b, c0, c1 = scalars = sp.symbols("a a_1 a_e b c_0 c_1")
system, noisy = sp.Matrix([[a, 0], [b * c0, ae]]), sp.Matrix([[a1, 0], [b * c1, 0]])
NUMBERS = dict(zip(scalars, map(Rational, "1/2 6/5 3/10 1 1 0".split())))
GROWTH = (a**2 + a1**2).subs(NUMBERS)


def order_one():
    """The map at n = n_e = 1, and any second moment one step on."""
    moment = sp.Matrix(2, 2, sp.symbols("q_1:5"))
    step = (system * moment * system.T + noisy * moment * noisy.T).expand()
    H0 = kron(system, system) + kron(noisy, noisy)
    return {H_k: H0, q_k: sp.Matrix(list(moment)), q_k_next: sp.Matrix(list(step))}


def growing():
    """The map at explicit numbers, and the moment that it multiplies by 169/100."""
    H0 = order_one()[H_k].subs(NUMBERS)
    (mode,) = (H0 - GROWTH * sp.eye(4)).nullspace()
    return {H_k: H0, q_k: mode / mode[0]}


page = Page(letters=letters, source=SOURCE)

page("""Lemma 4.1 asks when the moment of both settles. Without new noise one step takes
    it through the two matrices of the system, block by block.""")
page(is_At, is_At1, is_Qt)
is_F12 = page.let(F12, (A * Q1 * C.T + sum_i * A1 * Q1 * C1.T) * Be.T)
is_F2 = page.let(
    F2,
    Be * C * Q12 * Ae.T
    + Ae * Q12.T * C.T * Be.T
    + Be * (C * Q1 * C.T + sum_i * C1 * Q1 * C1.T) * Be.T,
)
page(
    letters.derive(
        "lemma 4.1",
        "one step of the moment without new noise",
        At * Qt * At.T + sum_i * At1 * Qt * At1.T,
    ).by(
        BlockMatrix(
            [
                [A * Q1 * A.T + sum_i * A1 * Q1 * A1.T, A * Q12 * Ae.T + F12],
                [Ae * Q12.T * A.T + F12.T, Ae * Q2 * Ae.T + F2],
            ]
        ),
        *(is_At, is_At1, is_Qt, is_F12, is_F2),
    )
)

page("""The first block depends on itself alone, the second on itself and the first, the
    third on itself and the other two. So the map is triangular.""")
with page.scope(letters.suppose(Q1, none(n, n)), letters.suppose(Q12, none(n, r))) as (
    no_Q1,
    no_Q12,
):
    page(
        letters.derive(
            "lemma 4.1", "what the first block adds to the second", is_F12
        ).use(no_Q1)
    )
    page(
        letters.derive("lemma 4.1", "what both add to the third", is_F2).use(
            no_Q1, no_Q12
        )
    )

page("""The lemma writes the map as a matrix of Kronecker products, with the entries of
    the moment in a column. At order one, and for one noise, it is this matrix. Its
    eigenvalues stand on the diagonal: that of the plant's own map, twice that of the
    mixed moment, and that of the estimator's.""")
page(
    Explicit(
        "lemma 4.1",
        "the matrix of the map at order one",
        H_k * q_k,
        q_k_next,
        {"order one": order_one()},
    )
)

page("""So `A` and `A_e` may be stable and the moment grow: for `A = 1/2`, `A_1 = 6/5`,
    `A_e = 3/10` there is a moment that one step multiplies by 1.69.""")
grows = page(
    Explicit(
        "lemma 4.1",
        "stable systems whose moment grows",
        H_k * q_k,
        GROWTH * q_k,
        {"these numbers": growing()},
    )
)

page("""The plant's own map is never more stable than `A`. Let `V_A` span the modes of
    an eigenvalue, and `c` be its squared modulus. What the moment shows of these modes
    grows at least by `c`. So where the plant's own map is stable, `A` is; with a stable
    `A_e` the map of the mixed moment is stable, too.""")
modes = page.suppose(A.T * V_A, V_A * M_c)
turn = page.suppose(M_c * M_c.T, c * Identity(k))
root = page.suppose(X, H_X * H_X.T)
page(
    letters.derive(
        "lemma 4.1",
        "the moment grows at least as the modes do",
        Trace(V_A.T * (A * X * A.T + sum_i * A1 * X * A1.T) * V_A),
    )
    .use(modes)
    .use(turn)
    .drop(root, of=A1)
)

page("""How strong may the noise of the parameters be? Let it be multiplied by `s`, and
    let `Y` be what `X` sums up to through the noise. One step with the stronger noise
    is then one without, of another matrix.""")
sums = page.steady(Y, A * Y * A.T + sum_i * A1 * X * A1.T)
page(
    letters.derive(
        "", "the noise is scaled", X - A * X * A.T - s**2 * sum_i * A1 * X * A1.T
    )
    .fold(sums)
    .by((X - s**2 * Y) - A * (X - s**2 * Y) * A.T)
)

page("""The map from `X` to `Y` keeps matrices that are not negative. So its largest
    eigenvalue `rho` has such an eigenvector (Krein and Rutman), and the plant is
    mean-square stable exactly for `s^2 rho < 1`. At the limit the eigenvector is a
    moment that stays as it is.""")
limit = page.suppose(X, s**2 * Y)
page(
    letters.derive("", "the largest noise", A * X * A.T + s**2 * sum_i * A1 * X * A1.T)
    .fold(sums)
    .fold(limit)
)

page("""The same map measures how an iteration converges that takes the noise from the
    last approximation: it takes the error before a step to the error after it.""")
page(is_V1)
takes = page.steady(X_k_next, A * X_k_next * A.T + sum_i * A1 * X_k * A1.T + W1)
page(
    letters.derive("", "the error of the next approximation", Q1 - X_k_next)
    .put(own)
    .put(is_V1)
    .put(takes)
    .factor()
)
