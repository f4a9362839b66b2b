"""When the best gain is the only one.

It is the only one exactly when the covariance of the innovation is definite.  If that
is singular along a combination of outputs, the combination is neither moved by the
state nor by noise, and may be added to the gain at no cost.  The paper's condition is
enough if the noises of the two groups are uncorrelated.

Source: our own; Leondes and Novak (1974), after (33), state the condition.
"""

from sympy import Matrix, Trace

from matrixproof import BlockMatrix, Page, ZeroMatrix
from matrixproof.explicit import Counterexample

from .canonical_gain import in_blocks, trace_of
from .coordinates import is_H
from .letters import SOURCE, letters, m1, p, p2, r
from .letters.accurate import L_M
from .letters.canonical import R_11, R_22, H, K_low, N_low, Omega_11
from .letters.plant import A, C, Q, R, a
from .letters.step import M, Omega, Sigma
from .quadratic import is_M, is_Omega

D_K = letters("Delta_K", r, p, "a change of the gains")
a_1 = letters("a_1", m1, 1, "its entries for the accurate outputs")
a_2 = letters("a_2", p2, 1, "its other entries")
k = letters("k", r, 1, "any column")
X_11 = letters("X_11", m1, m1, "what `Omega_11` is without new noise", symmetric=True)
L_X = letters("L_X", m1, m1, "a root of `X_11 + R_11`")
Q_11 = letters("Q_11", m1, m1, "block of `Q`", symmetric=True)
none = ZeroMatrix
ONES = Matrix.ones(2, 2)


page = Page(letters=letters, source=f"our own; {SOURCE}, after (33)")

page("""A change of the gains from the minimum costs `tr(Delta_K M Delta_K')`. If `M =
    L_M L_M'` with an invertible root this is a sum of squares, zero for no change but
    none.""")
with page.scope(letters.suppose(M, L_M * L_M.T)) as root:
    page(letters.derive("33", "the cost of a change", Trace(D_K * M * D_K.T)).put(root))
    no_cost = page.suppose(D_K * L_M, none(r, p))
    page(
        letters.derive("33", "a change without cost is none", D_K)
        .insert(D_K * L_M * L_M.I, why="the root has an inverse")
        .by(none(r, p), no_cost)
    )

page("""If `M a = 0` for some `a`, the gains are not determined along it. Neither what
    the outputs show nor their noise moves this combination.""")
page(is_Omega, is_M)
singular = page.suppose(M * a, none(p, 1))
along = a.T * C * Omega * C.T * a + a.T * R * a
page(
    letters.derive("33", "no variance along it", along)
    .by(a.T * M * a, is_M)
    .use(singular)
)

page("Then other gains solve (32) as well, and have the same trace.")
others = K_low + k * a.T
page(
    letters.derive("32", "other gains satisfy the same equation", others * M - N_low)
    .expand()
    .use(singular)
)
unseen = page.suppose(N_low * a, none(r, 1))
page(
    letters.derive("30", "other gains have the same trace", trace_of(others)).by(
        trace_of(K_low), singular, unseen
    )
)

page("""The paper asks for `R_22 > 0` and for a covariance of the first states' noise
    that is definite. If the two groups have uncorrelated noise, the first leaves no
    `a_2`.""")
page(is_H, in_blocks)
blocks = BlockMatrix([[R_11, none(m1, p2)], [none(p2, m1), R_22]])
uncorrelated = page.suppose(R, blocks, "31", name="the blocks of R")
split_a = page.suppose(a, BlockMatrix([[a_1], [a_2]]))
variance = a.T * (H * Omega * H.T + R) * a
noise = variance - (H.T * a).T * Omega * (H.T * a)
page(
    letters.derive("33", "the noise of the other outputs", noise)
    .expand()
    .by(a_1.T * R_11 * a_1 + a_2.T * R_22 * a_2, uncorrelated, split_a)
)

page("The second then leaves no `a_1`, because new noise only adds to a variance.")
only = page.suppose(a, BlockMatrix([[a_1], [none(p2, 1)]]))
fresh = page.suppose(Omega_11, X_11 + Q_11)
at_least = page.suppose(X_11 + R_11, L_X * L_X.T)
page(
    letters.derive("33", "the noise of the first states", variance)
    .by(a_1.T * (Omega_11 + R_11) * a_1, is_H, in_blocks, uncorrelated, only)
    .by(a_1.T * Q_11 * a_1 + a_1.T * L_X * (a_1.T * L_X).T, fresh, at_least)
    .drop(of=L_X)
)

page("""With correlated noises the condition is not enough, because noises can cancel
    each other: here two states are equal, and so are the noises of two outputs.""")
not_enough = page(
    Counterexample(
        "33",
        "the condition is not enough",
        a,
        none(p, 1),
        {
            A: Matrix.eye(2),
            Sigma: ONES,
            Q: ONES,
            Omega: 2 * ONES,
            C: Matrix.eye(2),
            R: ONES,
            M: 3 * ONES,
            a: Matrix([1, -1]),
        },
        given=(is_Omega, is_M, singular),
        symmetric=letters.symmetric,
    )
)
