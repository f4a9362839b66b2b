"""Moore's observer of a functional of the state, without feedthrough.

The observer reads its estimate off its own state alone, so that the noise of the
measurement is filtered.  Which matrices do that is four equations; that they are also
necessary rests on the states that the input reaches from rest.

Source: Moore (1973), (1)-(7) and `l` after (13); the graph that makes
them necessary, and what l is where there is no observer, are our own.
"""

from sympy import Matrix

from matrixproof import BlockMatrix, Identity, Line, Page, ZeroMatrix
from matrixproof.explicit import Counterexample
from matrixproof.lines import Equation, Iff

from ....certificate import residuals
from ....theory import observer as theory
from .condition import companion_row as companion_row
from .letters import A, C, D, F, P, T, eps, k, letters, m, n, p, r, x

letters = letters.here()
B = letters("B", n, m, "what the input does to the state")
E = letters("E", p, m, "what the input does to the measurement; zero in the paper")
G = letters("G", r, m, "what the input does to it")
x_next = letters("x_next", n, 1, "state one step on, or its derivative")
u = letters("u", m, 1, "input")
y = letters("y", p, 1, "measurement")
z = letters("z", r, 1, "state of the observer")
z_next = letters("z_next", r, 1, "the same one step on, or its derivative")
w = letters("w", 1, 1, "estimate of `k x`")
eps_next = letters("varepsilon_next", r, 1, "error one step on, or its derivative")
J = letters("J", r, m, "what the input does to the error")
Delta = letters("Delta", r, n, "difference of two `T`")
A_j = letters("A_j", n, n, "`A` to the power `j`")
F_j = letters("F_j", r, r, "`F` to the power `j`")
P_0 = letters("P_0", 1, r, "a row with `P_0 T = k`")
M = letters("M", r, r, "`T T'`, which has an inverse", symmetric=True)


dynamics, drive, _, _ = residuals(
    A, B, C, E, k, F, G, D, P, ZeroMatrix(1, p), ZeroMatrix(1, m), T, T
)
moved = BlockMatrix([[A, ZeroMatrix(n, r)], [D * C, F]])
parted = BlockMatrix([[A, ZeroMatrix(n, r)], [ZeroMatrix(r, n), F]])
no_column = ZeroMatrix(r, 1)
turn, back = (
    BlockMatrix([[Identity(n), ZeroMatrix(n, r)], [side, Identity(r)]])
    for side in (-T, T)
)


page = Page(letters=letters, source="Moore (1973), (1)-(7) and after (13)")

page("""The plant and an observer that has no direct path from the measurement to the
    estimate.""")
is_x = page.let(x_next, A * x + B * u, "1")
is_y = page.let(y, C * x + E * u, "1")
is_z = page.let(z_next, F * z + G * u + D * y, "3")
is_w = page.let(w, P * z, "3")

page("""Let the observer's state track `T x`, for a `T` still to be found. Its error is
    driven by itself, by the state and by the input.""")
is_eps = page.let(eps, z - T * x, "4")
is_eps_next = page.let(eps_next, z_next - T * x_next, "4")
no_noise = dict(w=ZeroMatrix(n, 1), v=ZeroMatrix(p, 1), T_next=T)
shown = dict(L=k, V=ZeroMatrix(1, p), W=ZeroMatrix(1, m), w_hat=w, e=w - k * x)
moves = page.at("4", "how the error moves", theory.collected, **no_noise)
page.at("4", "the error of the estimate", theory.biased, **no_noise, **shown)

page("""`T` is chosen so that the state does not drive the error. In `x` and the error
    plant and observer then fall apart, which is how the paper arranges it.""")
tracked = page.suppose(T * A, F * T + D * C, "5")
page.chain(
    "4, 5",
    "plant and observer fall apart",
    turn * moved * back,
    Line(parted, by=(tracked,)),
)
is_J = page.let(J, G + D * E - T * B)
start = letters.derive("4, 5", "only the input is left to drive the error", eps_next)
driven = page(start.put(moves).use(tracked).fold(is_J))

page("""Let the error tend to zero for all starts and inputs. With `u = 0` this says
    that `F` is stable: after `j` steps the error is `F^j` times what it was. With a
    constant `u` the error settles, and what it settles at is zero. So `J u = 0` for
    every `u`, and `J = 0`.""")
with page.scope(
    letters.suppose(eps, no_column), letters.suppose(eps_next, no_column)
) as resting:
    page.chain(
        "6",
        "the input must not drive the error",
        J * u,
        Line(eps_next - F * eps, by=(driven,)),
        Line(no_column, by=resting),
    )

page("""That is enough as well: if `J = 0` and `F` is stable, the error obeys an
    equation of its own and dies out.""")
undriven = page.suppose(J, ZeroMatrix(r, m), "6")
page(letters.derive("6", "then nothing drives it", eps_next).put(driven).use(undriven))
start = letters.derive("6", "the gain of the input", G)
gain = page(start.insert(J + T * B - D * E, is_J).put(undriven))

page("The estimate is right in the limit if besides `P T = k`.")
read = page.suppose(P * T, k, "7")
says = "the estimate errs by what is left of the error"
page.at("7", says, theory.error, **no_noise, **shown)

page("""None of this can be avoided. Let `w - k x` tend to zero for all starts and
    inputs, let `A`, `B` be controllable and `F`, `P` observable. From rest the error
    must then be zero for every input, since any input can be continued so that the
    error stays. Take all pairs `x`, `z` that some input reaches from rest. They have
    every `x` among them, because the plant is controllable. A pair with `x = 0` moves
    on to `x = 0` and `F z` without an input, always with `P z = 0`; so `z = 0`, because
    `F`, `P` is observable. Hence `z` is a function of `x`, and a linear one: `z = T x`.
    The pairs that are reached stay among themselves, which is (5) and (6) once it holds
    for every `x` and `u`.""")
with page.scope(letters.suppose(z, T * x)) as graph:
    page.chain(
        "5, 6",
        "the graph is never left",
        Equation(z_next, T * x_next),
        Iff(
            Equation(F * T * x + G * u + D * (C * x + E * u), T * A * x + T * B * u),
            by=(is_x, is_y, is_z, graph),
        ),
        Iff(Equation(dynamics * x, -drive * u)),
    )

    page("On it the error vanishes for every `x`, which is (7).")
    page.chain(
        "7",
        "the error vanishes on the graph",
        Equation(w, k * x),
        Iff(Equation(P * T * x, k * x), by=(is_w, graph)),
    )

page("""There is only one such `T`. The difference of two is not seen by `F`, `P`, and
    what is not seen is zero.""")
apart = page.suppose(F * Delta, Delta * A)
unread = page.suppose(P * Delta, ZeroMatrix(1, n))
so_far = page.suppose(F_j * Delta, Delta * A_j)
start = letters.derive("7", "powers of the difference", F * F_j * Delta)
page(start.use(so_far).use(apart))
says = "the difference of two solutions is not seen"
page(letters.derive("7", says, P * F_j * Delta).use(so_far).use(unread))

page("""For a given `T` of full row rank the paper solves `P T = k` by a formula. Its
    answer is the only row there can be.""")
is_M = page.suppose(M, T * T.T)
solves = page.suppose(k, P_0 * T)
start = letters.derive("after 13", "the row that reads the estimate", k * T.T * M.I)
page(start.put(solves).insert(P_0 * M * M.I, is_M).expand())

page("""If there is none, the formula still answers: with least squares, whose residual
    is orthogonal to the rows of `T`.""")
says = "otherwise it is least squares"
start = letters.derive("after 13", says, (k * T.T * M.I * T - k) * T.T)
page(start.expand().fold(is_M))

page("""That is no observer. A cart's velocity from its position with one state: (5)
    holds with the pole -1, and the formula answers 1/2.""")
page(
    Counterexample(
        "after 13",
        "a formula that answers where there is no observer",
        k * T.T * (T * T.T).I * T,
        k,
        {
            A: Matrix([[0, 0], [1, 0]]),
            C: Matrix([[0, 1]]),
            F: Matrix([[-1]]),
            D: Matrix([[-1]]),
            T: Matrix([[1, -1]]),
            k: Matrix([[1, 0]]),
        },
        given=(tracked,),
    )
)

observer = page.program("the input's gain", (T, B, D, E), (gain, "(6)"))
