"""The smoother of Bryson and Frazier: what later rows say is carried backwards.

Instead of smoothed estimates a vector and a matrix go from row to row, in which later
measurements say by how much an estimate is to be corrected.  Neither a covariance nor
the plant is inverted.  That it is the smoother of Rauch, Tung and Striebel is proved
row by row.

Source: Bryson and Frazier (1963) for the idea, in the form for discrete measurements;
the equations are our own.
"""

from functools import cache

from ...symbolic import Derivation, Identity, Line, Solve, Stage
from .letters import *
from .next_state import corrects, is_G, is_T, is_U, recursion

letters = letters.here()
chain, define = letters.chain, letters.define
B = letters("B", p, k, "a root of an inverse of `M`, as far as it has one")
Left = letters("Left", n, n, "what smoothing leaves of the estimate's error")
H = letters("H", n, k, "a factor of `Sigma`")
Rest = letters("Rest", k, k, "what later rows leave of its unit noises", symmetric=True)
Ahead = letters("Ahead", n, n, "what it leaves of the prediction's error")
Ahead_next = letters("Ahead_next", n, n, "the same one step on")
Theta_Y = letters("Theta_Y", n, n, "`Theta` seen by what the gain leaves")
New = letters("New", p, n, "what the outputs say, less what the gain takes off")
new = letters("new", p, 1, "the same of the vector")

SMOOTHED = (
    """Suppose that later rows correct the next prediction by `Omega_next lamda_next`,
    and that `Lambda_next` says by how much they lessen its covariance. Then
    they correct this estimate by `Sigma theta`, and no gain has to be found.""",
    corrects,
    is_G,
    is_T,
    is_lamda_next := define(x_s_next - x_minus_next, Omega_next * lamda_next),
    is_Lambda_next := define(
        Sigma_s_next - Omega_next, -Omega_next * Lambda_next * Omega_next
    ),
    is_theta := define(theta, As.T * lamda_next),
    is_Theta := define(Theta, As.T * Lambda_next * As),
    estimate := chain(
        "",
        "later rows correct the estimate",
        x_s,
        Line(x + G * (x_s_next - x_minus_next), by=(corrects,)),
        Line(x + G * Omega_next * lamda_next, by=(is_lamda_next,)),
        Line(x + T.T * lamda_next, by=(is_G,)),
        Line(x + Sigma * As.T * lamda_next, by=(is_T,)),
        Line(x + Sigma * theta, by=(is_theta,)),
    ),
    covariance := chain(
        "",
        "and lessen its covariance",
        Sigma_s,
        Line(Sigma + G * (Sigma_s_next - Omega_next) * G.T, by=(recursion,)),
        Line(
            Sigma - G * Omega_next * Lambda_next * Omega_next * G.T,
            by=(is_Lambda_next,),
        ),
        Line(Sigma - T.T * Lambda_next * T, by=(is_G,)),
        Line(Sigma - Sigma * As.T * Lambda_next * As * Sigma, by=(is_T,)),
        Line(Sigma - Sigma * Theta * Sigma, by=(is_Theta,)),
    ),
)
UPDATE = (
    """The row's own measurement has made the estimate from the prediction. With the
    gain of least variance the covariance is short, and symmetric.""",
    updates := define(x, x_minus + K * innovation),
    is_Y := define(Y, I - K * C),
    is_M := define(M, C * Omega * C.T + R),
    is_K := define(K * M, Omega * C.T),
    joseph := define(Sigma, Y * Omega * Y.T + K * R * K.T),
    shorter := chain(
        "",
        "the covariance that the gain of least variance leaves",
        Sigma,
        Line(Y * Omega * Y.T + K * R * K.T, by=(joseph,)),
        Line(Y * Omega - (Omega * C.T - K * (C * Omega * C.T + R)) * K.T, by=(is_Y,)),
        Line(Y * Omega - (Omega * C.T - K * M) * K.T, by=(is_M,)),
        Line(Y * Omega, by=(is_K,)),
    ),
    """An innovation says `C' W innovation` of the prediction. The matrix `W` is any
    symmetric one with `Omega C' W = K`. Where outputs have no noise there are many; all
    do the same.""",
    is_W := define(Omega * C.T * W, K),
    is_lamda := define(lamda, C.T * W * innovation + Y.T * theta),
    is_Lambda := define(Lambda, C.T * W * C + Y.T * Theta * Y),
    chain(
        "",
        "this row and later ones correct the prediction",
        x_s - x_minus,
        Line(x + Sigma * theta - x_minus, by=(estimate,)),
        Line(K * innovation + Sigma * theta, by=(updates,)),
        Line(K * innovation + Omega * Y.T * theta, by=(shorter,)),
        Line(Omega * C.T * W * innovation + Omega * Y.T * theta, by=(is_W,)),
        Line(Omega * lamda, by=(is_lamda,)),
    ),
    left := chain(
        "",
        "what is left of the prediction's error",
        I - Omega * Lambda,
        Line(I - Omega * C.T * W * C - Omega * Y.T * Theta * Y, by=(is_Lambda,)),
        Line(I - K * C - Omega * Y.T * Theta * Y, by=(is_W,)),
        Line(I - K * C - Sigma * Theta * Y, by=(shorter,)),
        Line(Y - Sigma * Theta * Y, by=(is_Y,)),
    ),
    chain(
        "",
        "and lessen the prediction's covariance",
        Sigma_s - Omega,
        Line(Y * Omega - Sigma * Theta * Y * Omega - Omega, by=(covariance, shorter)),
        Line((I - Omega * Lambda) * Omega - Omega, by=(left,)),
        Line(-Omega * Lambda * Omega, why="multiply out"),
    ),
    """Those are the suppositions again, one row earlier. Behind the last row nothing
    is said, so both begin with zero there. Where the innovation has a definite
    covariance, `W` is its inverse; elsewhere it takes a root of an inverse on the
    combinations of outputs that are not known before.""",
    by_solve := define(W * M, Identity(p)),
    chain(
        "",
        "the inverse does it",
        Omega * C.T * W,
        Line(Omega * C.T * W * M * M.I, why="the covariance has an inverse"),
        Line(Omega * C.T * M.I, by=(by_solve,)),
        Line(K * M * M.I, by=(is_K,)),
        Line(K, why="cancel"),
    ),
    by_root := define(W, B * B.T),
    gain_of_root := define(K, Omega * C.T * B * B.T),
    chain(
        "",
        "a root does it as well",
        Omega * C.T * W,
        Line(Omega * C.T * B * B.T, by=(by_root,)),
        Line(K, by=(gain_of_root,)),
    ),
)
RUNS = (
    "What is left of the covariance, and of the prediction's error, is a product.",
    is_Left := define(Left, I - Sigma * Theta),
    is_Ahead := define(Ahead, Y - Sigma * Theta * Y),
    remains := chain(
        "",
        "what is left of the estimate's covariance",
        Sigma_s,
        Line(Sigma - Sigma * Theta * Sigma, by=(covariance,)),
        Line((I - Sigma * Theta) * Sigma, why="factor"),
        Line(Left * Sigma, by=(is_Left,)),
    ),
    quick_Ahead := chain(
        "",
        "what is left of the prediction's error, in fewer multiplications",
        Ahead,
        Line(Y - Sigma * Theta * Y, by=(is_Ahead,)),
        Line(Left * (I - K * C), by=(is_Left, is_Y)),
        Line(Left - Left * K * C, why="multiply out"),
    ),
    """Where `Sigma` is singular its factor is kept, and the same is told of the unit
    noises that it multiplies.""",
    is_H := define(Sigma, H * H.T),
    is_Rest := define(Rest, Identity(k) - H.T * Theta * H),
    chain(
        "",
        "what is left, by a factor",
        Sigma_s,
        Line(Sigma - Sigma * Theta * Sigma, by=(covariance,)),
        Line(H * H.T - H * H.T * Theta * H * H.T, by=(is_H,)),
        Line(H * (Identity(k) - H.T * Theta * H) * H.T, why="factor"),
        Line(H * Rest * H.T, by=(is_Rest,)),
    ),
    """What is carried takes a few products of a matrix and the gain. The gain is taken
    off first on one side and then on the other: what it takes off nearly all of is
    then not the difference of large numbers.""",
    is_Theta_Y := define(Theta_Y, Theta * Y),
    quick_Theta_Y := chain(
        "",
        "what is seen on one side",
        Theta_Y,
        Line(Theta * (I - K * C), by=(is_Theta_Y, is_Y)),
        Line(Theta - Theta * K * C, why="multiply out"),
    ),
    is_new := define(new, W * innovation - K.T * theta),
    quick_lamda := chain(
        "",
        "the vector that is carried",
        lamda,
        Line(C.T * W * innovation + (I - K * C).T * theta, by=(is_lamda, is_Y)),
        Line(theta + C.T * (W * innovation - K.T * theta), why="factor"),
        Line(theta + C.T * new, by=(is_new,)),
    ),
    is_New := define(New, W * C - K.T * Theta_Y),
    quick_Lambda := chain(
        "",
        "the matrix that is carried",
        Lambda,
        Line(C.T * W * C + Y.T * Theta * Y, by=(is_Lambda,)),
        Line(C.T * W * C + Y.T * Theta_Y, by=(is_Theta_Y,)),
        Line(C.T * W * C + (I - K * C).T * Theta_Y, by=(is_Y,)),
        Line(Theta_Y + C.T * (W * C - K.T * Theta_Y), why="multiply out, and factor"),
        Line(Theta_Y + C.T * New, by=(is_New,)),
    ),
    "The covariance of neighbours needs what the next row has left, and no gain.",
    is_Ahead_next := define(Ahead_next, I - Omega_next * Lambda_next),
    is_U,
    neighbours := chain(
        "",
        "the covariance of neighbours, without a gain",
        U_next,
        Line(Sigma_s_next * G.T, by=(is_U,)),
        Line(
            (Omega_next - Omega_next * Lambda_next * Omega_next) * G.T,
            by=(is_Lambda_next,),
        ),
        Line((I - Omega_next * Lambda_next) * T, by=(is_G,)),
        Line(Ahead_next * T, by=(is_Ahead_next,)),
        Line(Ahead_next * As * Sigma, by=(is_T,)),
    ),
)


SPEAKS = Stage(theta, is_theta.right, by=(is_theta,))
SMOOTHS = (
    Stage(Left, is_Left.right, by=(is_Left,)),
    Stage(x_s, estimate.right, by=(estimate,)),
    Stage(Sigma_s, remains.right, symmetric=True, by=(remains,)),
    Stage(U_next, neighbours.right, by=(neighbours,)),
    Stage(Ahead, quick_Ahead.right, by=(quick_Ahead,)),
    Stage(new, is_new.right, by=(is_new,)),
    Stage(lamda, quick_lamda.right, by=(quick_lamda,)),
)
HANDS_ON = (
    Stage(Theta_Y, quick_Theta_Y.right, by=(quick_Theta_Y,)),
    Stage(New, is_New.right, by=(is_New,)),
    Stage(Lambda, quick_Lambda.right, symmetric=True, by=(quick_Lambda,)),
)


@cache
def backward_step():
    """A row from what later ones say of its successor: smoothed, and handed on."""
    is_here = Stage(Theta, is_Theta.right, symmetric=True, by=(is_Theta,))
    return Derivation(
        (As, C, K, W, innovation, Sigma, x, lamda_next, Lambda_next, Ahead_next),
        (SPEAKS, is_here, *SMOOTHS, *HANDS_ON),
        source="our own; Bryson and Frazier (1963)",
        letters=letters,
        says="one row of the smoother, without an inverse",
    )


@cache
def rest():
    """What later rows leave of the unit noises of a factor H of Sigma."""
    return Derivation(
        (Theta, H),
        (Stage(Rest, is_Rest.right, symmetric=True, by=(is_Rest,)),),
        source="our own",
        letters=letters,
        says="what later rows leave, by a factor",
    )


@cache
def said():
    """How much an innovation says, from its covariance: W with W M = I."""
    return Derivation(
        (M,),
        (Stage(W, Solve(Identity(p), M), by=(by_solve,)),),
        source="our own",
        letters=letters,
        says="how much an innovation says, by a solve",
    )


@cache
def said_by_root():
    """The same where M may be singular: B B' is an inverse of it."""
    return Derivation(
        (B,),
        (Stage(W, by_root.right, by=(by_root,)),),
        source="our own",
        letters=letters,
        says="how much an innovation says, by a root",
    )


@cache
def derive():
    """The page."""
    page = (*SMOOTHED, *UPDATE, said(), said_by_root(), *RUNS, rest(), backward_step())
    source = "our own; Bryson and Frazier (1963), Rauch, Tung and Striebel (1965)"
    return Derivation(page=page, letters=letters, source=source)
