"""What drives the error of any observer (F, G, D, P, V, W, T), and of its estimate.

A plus below is the next instant, or the derivative in continuous time.
"""

from sympy import symbols

from matrixproof import Notation, Page

n, p, m, r, q = symbols("n p m r q", integer=True, nonnegative=True)
letters = Notation()

A = letters("A", n, n, "moves the state")
B = letters("B", n, m, "what the input does to the state")
C = letters("C", p, n, "what is measured")
E = letters("E", p, m, "what the input does to the measurement")
L = letters("L", q, n, "what is estimated")
F = letters("F", r, r, "moves the observer")
G = letters("G", r, m, "what the input does to the observer")
D = letters("D", r, p, "what the measurement does to the observer")
P = letters("P", q, r, "weight of the observer in the estimate")
V = letters("V", q, p, "weight of the measurement in the estimate")
W = letters("W", q, m, "weight of the input in the estimate")
T = letters("T", r, n, "what the observer follows")
T_next = letters("T_next", r, n, "what the observer follows one step on")
x = letters("x", n, 1, "state")
x_next = letters("x_next", n, 1, "state one step on")
u = letters("u", m, 1, "input")
y = letters("y", p, 1, "measurement")
w = letters("w", n, 1, "process noise")
v = letters("v", p, 1, "measurement noise")
z = letters("z", r, 1, "observer")
z_next = letters("z_next", r, 1, "observer one step on")
w_hat = letters("w_hat", q, 1, "estimate of `L x`")
e = letters("e", q, 1, "error of the estimate")
eps = letters("varepsilon", r, 1, "error of the observer")
eps_next = letters("varepsilon_next", r, 1, "error of the observer one step on")

page = Page(letters=letters, source="common to all papers")


page("An observer is a linear system that is driven by input and measurement.")
plant = page.let(x_next, A * x + B * u + w)
measured = page.let(y, C * x + E * u + v)
moves = page.let(z_next, F * z + G * u + D * y)
follows = page.let(z, T * x + eps)
follows_next = page.let(eps_next, z_next - T_next * x_next)
collected = page(
    letters.derive("", "what drives the error", eps_next)
    .put(follows_next)
    .put(moves, plant)
    .put(follows, measured)
    .collect(x, u)
)

page("State and input can be anything, so both brackets must vanish.")
dynamics = page.suppose(T_next * A, F * T + D * C)
driven = page.suppose(T_next * B, G + D * E)
free = page(
    letters.derive("", "the error is driven by the noises alone", eps_next)
    .put(collected)
    .use(dynamics, driven)
)

page("So it is with the estimate, if two more residuals vanish.")
estimate = page.let(w_hat, P * z + V * y + W * u)
is_e = page.let(e, w_hat - L * x)
biased = page(
    letters.derive("", "the error of an estimate", e)
    .put(is_e)
    .put(estimate)
    .put(follows, measured)
    .collect(x, u)
)
unbiased = page.suppose(P * T + V * C, L)
is_W = page.suppose(W, -V * E)
error = page(
    letters.derive("", "the error of an unbiased estimate", e)
    .put(biased)
    .use(unbiased, is_W)
)
