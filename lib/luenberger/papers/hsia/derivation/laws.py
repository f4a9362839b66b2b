r"""Adaptive sampling: every law of Table II is the minimum of a cost per period.

At a sample the error is read, and for the T seconds that follow it is held while it
moves at the rate rho = |e'|.  A long period costs accuracy, a short one costs a
sample.  Lengthening the period a little costs rho^a in accuracy and saves lambda h(T)
in samples, both weighted by T^k:

    dJ/dT = T^k (rho^a - lambda h(T)),    h(T) = ((T_max / T)^b - s) / b.

h falls as T grows: the longer the period already is, the less is saved by making it
longer.  A longer period pays while lambda h is above rho^a, so the best one is

    T = T_max (s + b rho^a / lambda)^(-1/b).

The four laws are four choices of (a, b, s) and of lambda.  The weight T^k moves
neither the minimum nor its uniqueness, only what the cost may be called; `READINGS`
takes the k that makes it a simple one.

Between samples nothing is approximated; `noise_of_a_period` derives what white noise on
the plant becomes at instants that are not evenly spaced.

Source: Hsia (1974), Table II and (17), for the laws and the plant.  That paper has
an objective function of its own, on pages we do not hold; these objectives are ours.
Van Loan (1978) for the integral of the noise.
"""

from functools import cache

import sympy as sp

from ....symbolic import Algebra, Claim, Derivation, Identity, MatrixSymbol, Stage

T, T_max, rho = sp.symbols("T T_max rho", positive=True)
alpha, C, K = sp.symbols("alpha C K", positive=True)
a, lam, g, q, c, beta = sp.symbols("a lambda g q c beta", positive=True)
k, sigma = sp.symbols("k sigma", nonnegative=True)
b = sp.Symbol("b", real=True, nonzero=True)
s = sp.Symbol("s", real=True)

# a, b, s, k and lambda of each law, with the coefficient that Table II gives it
FAMILY = {
    "quadratic": {a: 2, b: 1, s: 1, k: 1, lam: 1 / alpha},
    "absolute": {a: 1, b: 1, s: 1, k: 1, lam: 1 / alpha},
    "root": {a: 1, b: 2, s: 0, k: 0, lam: 2 * C**2 / T_max**2},
    "linear": {a: 1, b: -1, s: 1, k: 0, lam: T_max / K},
}
# the same costs as one would write them down, up to a constant
READINGS = {
    # error reached, squared, + (departure from the longest period)^2
    "quadratic": rho**2 * T**2 / 2 + (T_max - T) ** 2 / (2 * alpha),
    # area of the error, int_0^T rho t dt, + (departure)^2
    "absolute": rho * T**2 / 2 + (T_max - T) ** 2 / (2 * alpha),
    # error reached, rho T, + price of sampling 1 / T times a second
    "root": rho * T + C**2 / T,
    # error reached + (departure)^2
    "linear": rho * T + (T_max - T) ** 2 / (2 * K),
}
PRINTED = {
    "quadratic": T_max / (alpha * rho**2 + 1),
    "absolute": T_max / (alpha * rho + 1),
    "root": C / sp.sqrt(rho),
    "linear": T_max - K * rho,
}

# Table II: samples in 1.2 s; then for each scheme (coefficient, E) in that order
SAMPLES = (30, 20, 15)
TABLE_II = {
    "periodic": ((0.04, 0.05962), (0.06, 0.09704), (0.08, 0.14314)),
    "quadratic": ((2.5, 0.03594), (0.05, 0.05560), (0.008, 0.09876)),
    "absolute": ((1.4, 0.03424), (0.275, 0.0550), (0.05, 0.11105)),
    "root": ((0.03, 0.03756), (0.08, 0.05443), (0.15, 0.09125)),
    "linear": ((0.065, 0.03584), (0.01, 0.05587), (0.003, 0.1162)),
}


def price(period):
    """h: what one more second of period saves, in units of lambda."""
    return ((T_max / period) ** b - s) / b


def slope(period):
    """dJ/dT of the general form, with g = rho^a."""
    return period**k * (g - lam * price(period))


def objective(period):
    """J of the general form for b != k + 1, up to a constant."""
    saved = T_max**b * period ** (k + 1 - b) / (k + 1 - b)
    return g * period ** (k + 1) / (k + 1) - lam / b * (
        saved - s * period ** (k + 1) / (k + 1)
    )


def member(expression, law):
    """A general expression at the parameters of one law, g = rho^a."""
    given = FAMILY[law]
    return sp.sympify(expression).subs({g: rho ** given[a]} | given)


def positive(expression):
    """The claim that `expression` is positive for all values of its symbols."""
    return Claim(sp.sign(sp.simplify(expression)), 1)


def general():
    """One stationary point at most, a minimum, and the best period within bounds."""
    law = T_max * q ** (-1 / b)  # q = s + b g / lambda
    of_q = {g: lam * (q - s) / b}
    rise = sp.diff(slope(T) / T**k, T)
    within = (slope(c * law) / (c * law) ** k).subs(of_q)

    def beyond(b_):
        """T^-k dJ/dT where q = -sigma: the law would not be a positive number."""
        return (slope(T) / T**k).subs({b: b_, g: lam * (-sigma - s) / b_})

    return {
        "general form: dJ/dT = T^k (rho^a - lambda h(T))": Claim(
            sp.diff(objective(T), T), slope(T)
        ),
        "general form: dJ/dT = 0 at T = T_max (s + b rho^a / lambda)^(-1/b)": Claim(
            slope(law).subs(of_q)
        ),
        "general form: d2J/dT2 > 0 there": positive(
            sp.diff(slope(T), T).subs(T, law).subs(of_q)
        ),
        "general form: T^-k dJ/dT rises at the rate lambda T_max^b T^(-b-1)": Claim(
            rise, lam * T_max**b * T ** (-b - 1)
        ),
        "general form: which is > 0, so dJ/dT has one zero at most": positive(rise),
        "bounds: at c T, T the law, T^-k dJ/dT is lambda q (1 - c^-b) / b": Claim(
            within, lam * q * (1 - c**-b) / b
        ),
        "bounds: which is 0 at c = 1": Claim(within.subs(c, 1)),
        "bounds: and rises with c: J falls before the law and rises after it": positive(
            sp.diff(within, c)
        ),
        "bounds: where s + b rho^a / lambda <= 0 and b < 0, J rises: the shortest": (
            positive(beyond(-beta))
        ),
        "bounds: where s + b rho^a / lambda <= 0 and b > 0, J falls: the longest": (
            positive(-beyond(beta))
        ),
        "k = 0: J is convex": positive(sp.diff(slope(T).subs(k, 0), T)),
    }


def solved(law):
    """The period at which the cost of one law is stationary; there is exactly one."""
    (period,) = sp.solve(sp.diff(READINGS[law], T), T)
    return period


def table():
    """Each law of Table II from its cost, and the cost as one of the family."""
    steps = {}
    for number, law in enumerate(FAMILY, 1):
        name, J = f"Table II law {number}", READINGS[law]
        curvature = sp.diff(J, T, 2)
        steps |= {
            f"{name}: the one zero of dJ/dT is the law": Claim(
                solved(law), PRINTED[law]
            ),
            f"{name}: dJ/dT is that of the general form": Claim(
                sp.diff(J, T), member(slope(T), law)
            ),
            f"{name}: J is that of the general form, but for a constant": Claim(
                sp.diff(J - member(objective(T), law), T)
            ),
            f"{name}: the general law gives it": Claim(
                member(T_max * (s + b * g / lam) ** (-1 / b), law), PRINTED[law]
            ),
            f"{name}: d2J/dT2 > 0 for every T, so J is convex": positive(curvature),
        }
    return steps


# -- the plant and the response error ------------------------------------------------


def plant():
    """Hsia's plant 10 (s + 10) / s^2 as position and velocity, and y* for a step."""
    t, S = sp.Symbol("t", nonnegative=True), sp.Symbol("S")
    A, B = sp.Matrix([[0, 1], [0, 0]]), sp.Matrix([0, 1])
    H = sp.Matrix([[100, 10]])
    transfer = (H * (S * sp.eye(2) - A).inv() * B)[0]
    # x1* of the loop u = 1 - y*, and what is measured of it
    root = 5 * sp.sqrt(3)
    decay = sp.exp(-5 * t) * (sp.cos(root * t) + sp.sin(root * t) / sp.sqrt(3))
    x = sp.Matrix([(1 - decay) / 100, sp.diff((1 - decay) / 100, t)])
    y = (H * x)[0]
    u, jump = sp.symbols("u jump")
    rate = (H * (A * x + B * u))[0]
    name = "(the paper's plant)"
    steps = {
        f"C (s I - A)^-1 B = 10 (s + 10) / s^2 {name}": Claim(
            transfer, 10 * (S + 10) / S**2
        ),
        f"(17) y* solves the continuous loop, x' = A x + B (1 - y*) {name}": Claim(
            sp.diff(x, t), A * x + B * (1 - y)
        ),
        f"(17) y* starts at rest {name}": Claim(x.subs(t, 0)),
        f"the rate of the error jumps with u, by C B = 10 {name}": Claim(
            rate.subs(u, u + jump) - rate, 10 * jump
        ),
    }
    return {"plant A": A, "plant B": B, "plant C": H, "(17) y*": y}, steps


# -- noise at uneven instants --------------------------------------------------------


n = sp.Symbol("n", integer=True, positive=True)
A, Q, X, Phi, P = (MatrixSymbol(name, n, n) for name in ("A", "Q", "X", "Phi", "P"))
ALGEBRA = Algebra([Q, P], [(A * Phi, Phi * A)])
FLOW = Phi * Q * Phi.T  # the derivative of P(t) = int_0^t Phi Q Phi'


@cache
def noise_of_a_period():
    """Q of one period by Van Loan's exponential.

    Phi(t) = e^(A t) and X(t), the upper right block of the exponential of
    [[-A, Q], [0, A']] t, are known by their derivatives; Phi X then has the
    derivative and the start of the integral.
    """
    stages = (Stage(P, Phi * X, symmetric=True),)
    formula = stages[0].formula
    derivative = formula.subs(Phi, Phi * A) + formula.subs(X, Q * Phi.T - A * X)
    start = ALGEBRA.with_relations((Phi, Identity(n)), (X, 0 * X))
    steps = {
        "noise: Phi X has the derivative Phi Q Phi' of the integral": Claim(
            derivative, FLOW, ALGEBRA
        ),
        "noise: both are 0 at t = 0": Claim(formula, 0, start),
    }
    return Derivation((Phi, X), stages, steps=steps, source="Van Loan (1978)")


@cache
def noise_doubled():
    """Q of a period twice as long."""
    P_2, H = (MatrixSymbol(name, n, n) for name in ("P_2", "H"))
    stages = (Stage(P_2, P + Phi * P * Phi.T, symmetric=True),)
    # after a fixed time with transition H: P + H P(t) H', whose second part moves
    moves = (stages[0].formula.subs(Phi, H) - P).subs(P, FLOW)
    steps = {
        "noise: P(h) + H P(t) H' has the derivative of the integral up to h + t": Claim(
            moves, (H * Phi) * Q * (H * Phi).T, ALGEBRA
        ),
    }
    return Derivation((Phi, P), stages, steps=steps, source="our own")


def key(law: str) -> str:
    """Where `derive().formulas` has the period of one law."""
    return f"Table II law {1 + list(FAMILY).index(law)}, {law}: T"


@cache
def derive() -> Derivation:
    """The laws of Table II, the general form, the plant, and the noise."""
    formulas = {
        "general form h": price(T),
        "general form dJ/dT": slope(T),
        "general form J": objective(T),
        "general form T": T_max * (s + b * g / lam) ** (-1 / b),
    }
    for law in FAMILY:
        formulas[key(law).replace(": T", ": J")] = READINGS[law]
        formulas[key(law)] = solved(law)
    matrices, steps = plant()
    steps = general() | table() | steps
    return Derivation(
        formulas=formulas | matrices,
        steps=steps | noise_of_a_period().steps | noise_doubled().steps,
        source="Hsia (1974), Table II and (17); the objectives are our own",
    )
