"""A parameter that is not known and does not change, beside one that is white noise.

An unknown constant moves the state for as long as the state remembers itself, and
white noise of the same variance for one step.  Both effects are known up to the second
power of the parameter, with what is left over, and so is the factor between them.

Source: our own; the system is that of Haddad and Bernstein (1987), (3.1), (4.4).
"""

from functools import cache

from sympy import Rational, symbols

from matrixproof import Derivation, Page, Stage, ZeroMatrix

from . import cost
from .letters import SOURCE, n
from .letters import letters as paper

letters = paper.here()


def square(name, meaning):
    """A symmetric letter."""
    return letters(name, n, n, meaning, symmetric=True)


theta, s = symbols("theta s", positive=True)
half = Rational(1, 2)
A = letters("A", n, n, "moves the state")
A_1 = letters("A_1", n, n, "how that depends on the parameter")
A_theta = letters("A_theta", n, n, "what moves the state in truth")
W = square("W", "covariance of the noise")
M = square("M", "weight of the state in the cost")
X = square("X", "second moment for one value of the parameter")
X_0 = square("X_0", "second moment without the parameter")
X_1 = square("X_1", "how it begins to move with the parameter")
X_2 = square("X_2", "what the square of the parameter does to it")
X_w = square("X_w", "what white noise of unit variance does to it")
X_p = square("X_p", "second moment up to the square of the parameter")
X_v = square("X_v", "second moment up to the variance of white noise")
X_up = square("X_up", "the same where the parameter is `s`")
X_down = square("X_down", "the same where it is `-s`")
B_p = square("B_p", "what is left over, of third order")
B_v = square("B_v", "what is left over, of fourth order")
B_1 = square("B_1", "what drives `X_1`")
B_w = square("B_w", "what drives `X_w`")
B_2 = square("B_2", "what drives `X_2`")
Y = square("Y", "what a constant does beyond white noise")
Lambda = square("Lambda", "the cost of noise that enters now and is remembered")


page = Page(letters=letters, source=f"our own; {SOURCE}, (4.4)")

page("The system `A_theta` moves the state, and depends on a parameter `theta`.")
is_A_theta = page.let(A_theta, A + theta * A_1)

page("""For one value that stays, the second moment of the steady state is the solution
    of a Lyapunov equation, and without the parameter that of another.""")
is_X = page.steady(X, A_theta * X * A_theta.T + W)
is_X_0 = page.steady(X_0, A * X_0 * A.T + W)

page("Two more equations say how it moves with the parameter.")
is_B_1 = page.let(B_1, A_1 * X_0 * A.T + A * X_0 * A_1.T)
is_X_1 = page.steady(X_1, A * X_1 * A.T + B_1)
is_B_w = page.let(B_w, A_1 * X_0 * A_1.T)
is_B_2 = page.let(B_2, B_w + A_1 * X_1 * A.T + A * X_1 * A_1.T)
is_X_2 = page.steady(X_2, A * X_2 * A.T + B_2)
is_X_p = page.let(X_p, X_0 + theta * X_1 + theta**2 * X_2)

page("""Up to the square of the parameter this sum solves the true equation. What it
    misses is of third order.""")
is_B_p = page.let(
    B_p,
    theta**3 * (A_1 * X_1 * A_1.T + A_1 * X_2 * A.T + A * X_2 * A_1.T)
    + theta**4 * A_1 * X_2 * A_1.T,
)
missed = page(
    letters.derive("constant", "the sum one step on", A_theta * X_p * A_theta.T + W)
    .put(is_A_theta, is_X_p)
    .fold(is_B_1, is_B_w, is_B_2, is_B_p)
    .fold(is_X_0, is_X_1, is_X_2)
    .fold(is_X_p)
)

page("So the true moment differs by what this remainder drives, for any `theta`.")
page(
    letters.derive(
        "constant", "what the sum is off by", A_theta * (X - X_p) * A_theta.T + B_p
    )
    .fold(is_X)
    .use(missed)
)

page("""A parameter of mean zero may as well have the other sign. In the mean over both,
    what is of first order cancels, and the square is left.""")
is_up = page.let(X_up, X_0 + s * X_1 + s**2 * X_2)
is_down = page.let(X_down, X_0 - s * X_1 + s**2 * X_2)
page(
    letters.derive("constant", "the mean over both signs", half * (X_up + X_down)).use(
        is_up, is_down
    )
)


page("""White noise of variance `s^2` in place of the parameter adds its covariance at
    every step.""")
is_X_w = page.steady(X_w, A * X_w * A.T + B_w)
is_X_v = page.let(X_v, X_0 + s**2 * X_w)
is_B_v = page.let(B_v, s**4 * A_1 * X_w * A_1.T)
page(
    letters.derive(
        "white",
        "the sum one step on, where white noise takes the place of the constant",
        A * X_v * A.T + s**2 * A_1 * X_v * A_1.T + W,
    )
    .put(is_X_v)
    .fold(is_X_0, is_B_w, is_B_v)
    .fold(is_X_w)
    .fold(is_X_v)
)

page("A constant does more: what it did to the state before, it meets again.")
is_Y = page.let(Y, X_2 - X_w)
page(
    letters.derive("constant", "what a constant does beyond white noise", is_Y)
    .put(is_X_2, is_X_w)
    .use(is_B_2)
    .fold(is_Y)
)


page("""A cost adds up what noise does now and later. So both effects are traces of what
    drives them, and their quotient is the factor by which white noise must be stronger
    than the constant to cost the same.""")
dual = page.steady(Lambda, A.T * Lambda * A + M)
once = dict(P_tilde=Lambda, R_tilde=M, A_tilde=A, A_tilde_1=ZeroMatrix(n, n))
white = dict(Q_tilde=X_w, W_tilde=B_w)
page.at("white", "what white noise costs", cost.pairing, **once, **white)
constant = dict(Q_tilde=X_2, W_tilde=B_2)
page.at("constant", "what a constant costs", cost.pairing, **once, **constant)


@cache
def first_drive():
    """What drives the first order of the moment."""
    return Derivation(
        (A, A_1, X_0),
        (Stage(B_1, is_B_1.right, symmetric=True, by=(is_B_1,)),),
        source="our own",
        letters=letters,
        says="what drives the first order",
    )


page(first_drive())


@cache
def second_drive():
    """What drives the second order, of white noise and of a constant."""
    return Derivation(
        (A, A_1, X_0, X_1),
        (
            Stage(B_w, is_B_w.right, symmetric=True, by=(is_B_w,)),
            Stage(B_2, is_B_2.right, symmetric=True, by=(is_B_2,)),
        ),
        source="our own",
        letters=letters,
        says="what drives the second order",
    )


page(second_drive())
