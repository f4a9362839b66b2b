"""A state that is known exactly, and what is known of its readings before they come.

Where no noise is left that outputs do not show, an estimate is the state itself from
some row on.  Its covariance is zero then, and one gain does for all rows to come.

Source: our own.
"""

from functools import cache

from sympy import symbols

from ....symbolic import Derivation, Line, Stage, ZeroMatrix
from .letters import *
from .on_target import device
from .one_pass import innovation, x_minus
from .quadratic import is_Y

k, q = symbols("k q", integer=True, nonnegative=True)
known = device.here(
    x="estimate of the state",
    x_next="estimate one step on",
    u="input",
    u_next="input one step on",
    y="measurement one step on",
)
chain, define = known.chain, known.define
xt = known("xt", n, 1, "state")
xt_next = known("xt_next", n, 1, "state one step on")
G = known("G", n, q, "factor of `Q`")
V = known("V", p, q, "factor of `R`")
g = known("g", q, 1, "process noise of unit covariance")
h = known("h", q, 1, "measurement noise of unit covariance")
U = known("U", p, k, "combinations of outputs that are known before")
left = known("left", k, 1, "what the innovation has of them")
A_s = known("A_s", n, n, "squares of the entries of `A`")
B_s = known("B_s", n, m, "squares of the entries of `B`")
C_s = known("C_s", p, n, "squares of the entries of `C`")
E_s = known("E_s", p, m, "squares of the entries of `E`")
U_s = known("U_s", p, k, "squares of the entries of `U`")
x_s = known("x_s", n, 1, "squares of the entries of `x`")
u_s = known("u_s", m, 1, "squares of the entries of `u`")
v_s = known("v_s", m, 1, "squares of the entries of `u_next`")
y_s = known("y_s", p, 1, "squares of the entries of `y`")
made = known("made", n, 1, "squares that `x_minus` is a sum of")
size = known("size", k, 1, "squares that `left` is a sum of")

PAGE = (
    """Let an estimate be the state itself. What is predicted from it errs by the noise
    of one step, and so does the innovation.""",
    exact := define(x, xt),
    moves := define(xt_next, A * xt + B * u + G * g),
    measured := define(y, C * xt_next + E * u_next + V * h),
    is_minus := define(x_minus, A * x + B * u),
    is_innovation := define(innovation, y - E * u_next - C * x_minus),
    noise := chain(
        "",
        "the innovation is noise of one step",
        innovation,
        Line(y - E * u_next - C * (A * x + B * u), by=(is_innovation, is_minus)),
        Line(
            C * xt_next + E * u_next + V * h - E * u_next - C * (A * xt + B * u),
            by=(measured, exact),
        ),
        Line(C * G * g + V * h, by=(moves,)),
    ),
    """Some combinations of outputs may show no noise. They are known before they are
    read: the innovation has nothing of them, whatever the noise.""",
    blind_G := define(U.T * C * G, ZeroMatrix(k, q)),
    blind_V := define(U.T * V, ZeroMatrix(k, q)),
    is_left := define(left, U.T * innovation),
    chain(
        "",
        "what is known before it is read",
        left,
        Line(U.T * (C * G * g + V * h), by=(is_left, noise)),
        Line(ZeroMatrix(k, 1), by=(blind_G, blind_V)),
    ),
    """A gain may take from the prediction all noise that drives the state, and bring in
    none of the outputs. The next estimate is the state again then. Neither condition
    asks what was read, so what holds of one row holds of all behind it.""",
    is_Y,
    takes := define(Y * G, ZeroMatrix(n, q)),
    adds := define(K * V, ZeroMatrix(n, q)),
    is_next := define(x_next, x_minus + K * innovation),
    chain(
        "",
        "a state that is known exactly stays so",
        x_next - xt_next,
        Line(x_minus + K * innovation - xt_next, by=(is_next,)),
        Line(A * x + B * u + K * innovation - xt_next, by=(is_minus,)),
        Line(K * innovation - G * g, by=(exact, moves)),
        Line(K * C * G * g + K * V * h - G * g, by=(noise,)),
        Line(-Y * G * g + K * V * h, by=(is_Y,)),
        Line(ZeroMatrix(n, 1), by=(takes, adds)),
    ),
    """Computed numbers that should be zero are rounding of what they were made of. The
    squares of that are added up beside them.""",
    is_made := define(made, A_s * x_s + B_s * u_s),
    is_size := define(size, U_s.T * (y_s + E_s * v_s + C_s * made)),
)


@cache
def known_row():
    """A row of a state that is known exactly: its estimate, and what has to vanish."""
    return Derivation(
        (A, B, C, E, K, U, A_s, B_s, C_s, E_s, U_s, x, u, y, u_next)
        + (x_s, u_s, y_s, v_s),
        (
            Stage(x_minus, is_minus.right, by=(is_minus,)),
            Stage(innovation, is_innovation.right, by=(is_innovation,)),
            Stage(x_next, is_next.right, by=(is_next,)),
            Stage(left, is_left.right, by=(is_left,)),
            Stage(made, is_made.right, by=(is_made,)),
            Stage(size, is_size.right, by=(is_size,)),
        ),
        source="our own",
        letters=known,
        says="a row of a state that is known exactly",
    )


@cache
def derive():
    """The page."""
    return Derivation(page=(*PAGE, known_row()), letters=known, source="our own")
