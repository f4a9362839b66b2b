"""Two pages of derivations as chains: what the other tests check, show and damage.

Leondes and Novak (1974), section III, (24)-(33), and Haddad and Bernstein (1987),
(4.13)-(4.16) repaired, to (3.6), (3.15) and (3.16).
"""

from sympy import Trace, symbols

from matrixproof import Chain, Identity, Line, MatrixSymbol, Relation, ZeroMatrix

n, p, m1, k, r, q = symbols("n p m_1 k r q", integer=True, positive=True)

# -- the gain of least error trace -----------------------------------------------------

Omega = MatrixSymbol("Omega", n, n)  # covariance of the prediction error
R = MatrixSymbol("R", p, p)  # covariance of the measurement noise
C = MatrixSymbol("C", p, n)  # what is measured
K = MatrixSymbol("K", n, p)  # any gain
S1 = MatrixSymbol("S_1", m1, p)  # picks the accurate outputs
Gamma = MatrixSymbol("Gamma", n, m1)  # the direction of the push
U = MatrixSymbol("U", n, k)  # a basis of the null space of S1 C
Z = MatrixSymbol("Z", k, p)  # what is left free
M, Kmv = MatrixSymbol("M", p, p), MatrixSymbol("K_mv", n, p)
N, E = MatrixSymbol("N", n, p), MatrixSymbol("E", m1, p)
I = Identity(n)

innovation = Relation("M = C Ω C' + R", M, C * Omega * C.T + R)
cross = Relation("N", N, Omega * C.T)
kalman = Relation("K_mv M = N", Kmv * M, N)
short = Relation("E = S_1 - S_1 C K_mv", E, S1 - S1 * C * Kmv)
push = Relation("S_1 C Γ = I", S1 * C * Gamma, Identity(m1))
null = Relation("S_1 C U = 0", S1 * C * U, ZeroMatrix(m1, k))
shortest = Relation("Γ'U = 0", Gamma.T * U, ZeroMatrix(m1, k))
SYMMETRIC = (Omega, R, M)


def spread(X):
    """What a gain X costs."""
    return Trace(X * M * X.T)


GAIN = [
    Chain(
        "27–29",
        "completed square",
        (I - K * C) * Omega * (I - K * C).T + K * R * K.T,
        [
            Line(
                Omega
                - K * C * Omega
                - Omega * C.T * K.T
                + K * (C * Omega * C.T + R) * K.T,
                why="multiply out",
            ),
            Line(
                Omega - K * C * Omega - Omega * C.T * K.T + K * M * K.T,
                by=[innovation],
            ),
            Line(Omega - K * N.T - N * K.T + K * M * K.T, by=[cross]),
            Line(Omega - N * Kmv.T + (K - Kmv) * M * (K - Kmv).T, by=[kalman]),
        ],
        SYMMETRIC,
    ),
    Chain(
        "24",
        "the gains that meet the condition",
        S1 * C * (Kmv + Gamma * E + U * Z),
        [
            Line(S1 * C * Kmv + E + S1 * C * U * Z, by=[push]),
            Line(S1 * C * Kmv + E, by=[null]),
            Line(S1, by=[short]),
        ],
        SYMMETRIC,
    ),
    Chain(
        "30–33",
        "the trace",
        spread(Gamma * E + U * Z),
        [
            Line(
                spread(Gamma * E)
                + 2 * Trace(Gamma * E * M * Z.T * U.T)
                + spread(U * Z),
                why="multiply out, tr X = tr X'",
            ),
            Line(spread(Gamma * E) + spread(U * Z), by=[shortest]),
        ],
        SYMMETRIC,
    ),
    Chain(
        "33",
        "the gain that runs",
        Kmv + Gamma * E,
        [Line(Kmv + Gamma * S1 - Gamma * S1 * C * Kmv, by=[short])],
        SYMMETRIC,
    ),
]

# -- the optimal projection ------------------------------------------------------------

A, B = MatrixSymbol("A", n, n), MatrixSymbol("K", n, p)
Qs, Ls, W = (
    MatrixSymbol("Q_s", n, p),
    MatrixSymbol("L_s", q, n),
    MatrixSymbol("R", q, q),
)
As = MatrixSymbol("A_s", n, n)  # A - K C
G, Gam = MatrixSymbol("G", r, n), MatrixSymbol("Gamma", r, n)
tau = MatrixSymbol("tau", n, n)
Q2, P2 = MatrixSymbol("Q_2", r, r), MatrixSymbol("P_2", r, r)
Qh, Ph = MatrixSymbol("Qhat", n, n), MatrixSymbol("Phat", n, n)
MOMENTS = (Q2, P2, Qh, Ph, W)

r13 = Relation("(4.13) G'Q_2 = Q̂Γ'", G.T * Q2, Qh * Gam.T)
r14 = Relation("(4.14) ΓQ̂Γ' = Q_2", Gam * Qh * Gam.T, Q2)
r16 = Relation("(4.16) GP̂G' = P_2", G * Ph * G.T, P2)
rtau = Relation("(3.8) τ = G'Γ", tau, G.T * Gam)
rone = Relation("ΓG' = I", Gam * G.T, Identity(r))
rqh = Relation("(4.6)", Qh, A * G.T * Q2 * G * A.T + B * Qs.T)
rph = Relation("(4.7)", Ph, As.T * Gam.T * P2 * Gam * As + Ls.T * W * Ls)

PROJECTION = [
    Chain(
        "3.9",
        "G and Γ are biorthogonal",
        Gam * G.T,
        [Line(Gam * Qh * Gam.T * Q2.I, by=[r13]), Line(Identity(r), by=[r14])],
        MOMENTS,
    ),
    Chain(
        "3.6",
        "τ is a projection",
        tau * tau,
        [
            Line(G.T * Gam * G.T * Gam, by=[rtau]),
            Line(G.T * Gam, by=[rone]),
            Line(tau, by=[rtau]),
        ],
        MOMENTS,
    ),
    Chain(
        "3.15",
        "the equation of the estimate",
        A * tau * Qh * tau.T * A.T + B * Qs.T,
        [
            Line(A * G.T * Gam * Qh * Gam.T * G * A.T + B * Qs.T, by=[rtau]),
            Line(A * G.T * Q2 * G * A.T + B * Qs.T, by=[r14]),
            Line(Qh, by=[rqh]),
        ],
        MOMENTS,
    ),
    Chain(
        "3.16",
        "the adjoint equation",
        As.T * tau.T * Ph * tau * As + Ls.T * W * Ls,
        [
            Line(
                As.T * Gam.T * G * Ph * G.T * Gam * As + Ls.T * W * Ls,
                by=[rtau],
            ),
            Line(As.T * Gam.T * P2 * Gam * As + Ls.T * W * Ls, by=[r16]),
            Line(Ph, by=[rph]),
        ],
        MOMENTS,
    ),
]
