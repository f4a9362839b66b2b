"""What noise on the plant becomes at instants that are not evenly spaced.

Between two samples nothing is approximated: the integral of the noise is two blocks of
one exponential, and that of a period twice as long follows from it.

Source: Van Loan (1978), "Computing integrals involving the matrix exponential", for
the instants of Hsia (1974); the doubling is our own.
"""

from sympy import symbols

from matrixproof import BlockMatrix, Notation, Page, Stage, ZeroMatrix

n = symbols("n", integer=True, positive=True)
letters = Notation()
A = letters("A", n, n, "moves the state")
Q = letters("Q", n, n, "intensity of the noise of the plant", symmetric=True)
Phi = letters("Phi", n, n, "`e^(A t)`: what a state becomes in the time `t`")
dPhi = letters("dPhi", n, n, "its rate")
Block = letters("Block", 2 * n, 2 * n, "what Van Loan takes the exponential of")
E = letters("E", 2 * n, 2 * n, "its exponential at the time `t`")
dE = letters("dE", 2 * n, 2 * n, "its rate")
U = letters("U", n, n, "upper left block of that")
dU = letters("dU", n, n, "its rate")
X = letters("X", n, n, "upper right block of the exponential of `[-A, Q; 0, A'] t`")
dX = letters("dX", n, n, "its rate")
Phi_0 = letters("Phi_0", n, n, "`Phi` at `t = 0`")
X_0 = letters("X_0", n, n, "`X` at `t = 0`")
P = letters("P", n, n, "covariance that the noise adds in the time `t`", symmetric=True)
dP = letters("dP", n, n, "its rate", symmetric=True)
H = letters("H", n, n, "what a state becomes in a first period")
P_h = letters("P_h", n, n, "covariance that the noise adds in it", symmetric=True)
P_2 = letters("P_2", n, n, "covariance of a period twice as long", symmetric=True)


page = Page(letters=letters, source="Van Loan (1978)")

page("""White noise of intensity `Q` adds up to a covariance `P` in the time `t`. It is
    an integral, of which the rate is known, and which is zero at `t = 0`.""")
flows = page.suppose(dPhi, Phi * A)
is_rate = page.suppose(dP, Phi * Q * Phi.T)

page("""The exponential of the block matrix `[-A, Q; 0, A'] t` has `Phi'` in its lower
    right corner. The blocks above it have rates as well.""")
is_Block = page.let(Block, BlockMatrix([[-A, Q], [ZeroMatrix(n, n), A.T]]))
is_E = page.let(E, BlockMatrix([[U, X], [ZeroMatrix(n, n), Phi.T]]))
is_dE = page.let(dE, BlockMatrix([[dU, dX], [ZeroMatrix(n, n), dPhi.T]]))
is_dU = page.suppose(dU, -A * U)
is_dX = page.suppose(dX, Q * Phi.T - A * X)
page(
    letters.derive("", "the rate of the exponential", Block * E)
    .multiply(is_Block, is_E)
    .by(dE, is_dE, is_dU, is_dX, flows)
)

page("The product `Phi X` has the rate of the integral.")
page(
    letters.derive("", "the rate of the product", Phi * X)
    .differential({Phi: dPhi, X: dX})
    .by(dP, flows, is_dX, is_rate)
)

page("It begins with zero as well. So it is the integral.")
starts = page.suppose(X_0, ZeroMatrix(n, n))
page(letters.derive("", "where the product begins", Phi_0 * X_0).use(starts))
is_P = page.let(P, Phi * X)

page("The rate `Phi Q Phi'` is symmetric, and so is what it adds up to.")
even = page.suppose(P, P.T)

noise_block = page.program("the block matrix of the noise", (A, Q), is_Block)
noise_of_a_period = page.program(
    "what the noise adds in a period",
    (Phi, X),
    Stage(P, Phi * X, symmetric=True, by=(is_P, even)),
)

page("""A first period has added `P_h`. Let it go on for the time `t`, which adds `H P
    H'`. The rate is that of the integral at this time, because `H Phi` is what a state
    becomes in both.""")
page(
    letters.derive("", "the rate of what is added", P_h + H * P * H.T)
    .differential({P: dP}, held=(P_h, H))
    .put(is_rate)
)

page("So it is the integral. Let it go on for as long again: `H` is then `Phi`.")
is_P_2 = page.let(P_2, P_h + H * P * H.T)
as_long = page.let(H, Phi)
as_much = page.let(P_h, P)
doubled = page(
    letters.derive("", "a period twice as long", P_2).put(is_P_2, as_long, as_much)
)
noise_doubled = page.program(
    "what it adds in a period twice as long",
    (Phi, P),
    Stage(P_2, doubled.right, symmetric=True, by=(doubled,)),
)
