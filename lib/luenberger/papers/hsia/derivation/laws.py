"""Adaptive sampling: every law of Table II is the minimum of a cost per period.

At a sample the error is read.  For the `T` seconds that follow it is held, while it
moves at the rate `rho`.  A long period costs accuracy, a short one costs a sample.
There is one family of costs, and of laws, that has all four of the table.

Source: Hsia (1974), Table II, for the laws.  That paper has an objective function of
its own, on pages we do not hold; these objectives are ours.
"""

from functools import cache

import sympy as sp

from matrixproof import Explicit, Notation, Page
from matrixproof.explicit import Positive

SOURCE = "Hsia (1974)"
periods = Notation()
T = periods.scalar("T", "period: the time to the next sample", positive=True)
J, h = (sp.Function(name)(T) for name in "Jh")  # cost of a period, saving per second
T_max = periods.scalar("T_max", "the longest period", positive=True)
rho = periods.scalar("rho", "rate of the error, without its sign", positive=True)
alpha = periods.scalar("alpha", "coefficient of laws 1 and 2", positive=True)
C = periods.scalar("C", "coefficient of law 3", positive=True)
K = periods.scalar("K", "coefficient of law 4", positive=True)
lam = periods.scalar("lambda", "price of a sample", positive=True)
g = periods.scalar("g", "what accuracy costs: `rho^a`", positive=True)
a = periods.scalar("a", "power of the rate", positive=True)
b = periods.scalar("b", "how fast the saving falls", real=True, nonzero=True)
s = periods.scalar("s", "the saving in the longest period is `(1 - s)/b`", real=True)
k = periods.scalar("k", "weight of a period, a power", nonnegative=True)
q = periods.scalar("q", "`s + b g/lambda`, where it is positive", positive=True)
c = periods.scalar("c", "a period is `c` times that of the law", positive=True)
beta = periods.scalar("beta", "size of `b`", positive=True)
sigma = periods.scalar("sigma", "size of it, where it is not", nonnegative=True)
T_s = periods.scalar("T_s", "the period of a law", positive=True)
kappa = periods.scalar("kappa", "how steep the cost is beside it", positive=True)


COSTS = {
    # error reached, squared, + (departure from the longest period)^2
    "quadratic": rho**2 * T**2 / 2 + (T_max - T) ** 2 / (2 * alpha),
    # area of the error, int_0^T rho t dt, + (departure)^2
    "absolute": rho * T**2 / 2 + (T_max - T) ** 2 / (2 * alpha),
    # error reached, rho T, + price of sampling 1 / T times a second
    "root": rho * T + C**2 / T,
    # error reached + (departure)^2
    "linear": rho * T + (T_max - T) ** 2 / (2 * K),
}
FAMILY = {
    "quadratic": {a: 2, b: 1, s: 1, k: 1, lam: 1 / alpha},
    "absolute": {a: 1, b: 1, s: 1, k: 1, lam: 1 / alpha},
    "root": {a: 1, b: 2, s: 0, k: 0, lam: 2 * C**2 / T_max**2},
    "linear": {a: 1, b: -1, s: 1, k: 0, lam: T_max / K},
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


def number(law):
    """Where the table has a law."""
    return f"Table II law {1 + list(COSTS).index(law)}"


def slope(law):
    """The slope of the cost of a law, as SymPy finds it."""
    cost = periods.derive(number(law), "the slope of its cost", COSTS[law])
    return cost.gradient(T)


def found(law):
    """The cost J, the law T_s where its slope vanishes, and kappa: J' / (T - T_s)."""
    period = slope(law).solve(T).right
    steep = sp.factor(sp.simplify(slope(law).right / (T - period)))
    return {J: COSTS[law], T_s: period, kappa: steep}


LAWS = {law: found(law) for law in COSTS}


@cache
def best(law: str) -> Explicit:
    """The statement that the cost of a law is least at its period, and only there."""
    says = "its cost falls before the law and rises after it"
    slope = sp.Derivative(J, T)
    return Explicit(number(law), says, slope, kappa * (T - T_s), {"": LAWS[law]})


def of_each(*wanted):
    """{law: the values of letters} in the order of the table."""
    found = {law: LAWS[law] | FAMILY[law] for law in LAWS}
    for values in found.values():
        values[q] = (s + b * rho**a / lam).subs(values)
    return {law: {x: values[x] for x in wanted} for law, values in found.items()}


def turned(sign):
    """h and g where `s + b g/lambda` is not positive, for b of one sign."""
    b_ = sign * beta
    return {"": {h: saving.subs(b, b_), g: lam * (-sigma - s) / b_}}


# -- the page -------------------------------------------------------------------------

saving = (T_max / T) ** b / b - s / b
cost = T ** (k + 1) * (g + lam * s / b) / (k + 1)
cost -= T ** (k + 1) * (T_max / T) ** b * lam / (b * (k + 1 - b))
beside = lam * q * (1 - c**-b) / b


page = Page(letters=periods, source=f"{SOURCE}, Table II; the objectives are our own")

page("""A period `T` has the cost `J(T)`. To make it a little longer costs `g` in
    accuracy and saves `lambda h(T)` in samples. Both are weighted by `T^k`, which moves
    no minimum: it only makes the cost a simple one.""")
page(
    Explicit(
        "",
        "the costs of the family",
        sp.Derivative(J, T),
        T**k * (g - lam * h),
        {"": {J: cost, h: saving}},
    )
)

page("""The saving falls as the period grows, and what it costs does not. So there is
    one minimum at most.""")
page(
    Positive(
        "",
        "the slope rises, but for the factor",
        sp.Derivative(g - lam * h, T),
        0,
        {"": {h: saving}},
    )
)

page("""It is where both are equal, at the period `T_s`. Take `c` times that period:
    up to the factor `T^k` the slope of the cost is as follows, which is zero for `c
    = 1`.""")
page(
    Explicit(
        "",
        "the slope beside the law",
        g - lam * ((T_max / (c * T_s)) ** b / b - s / b),
        beside,
        {"": {T_s: T_max * q ** (-1 / b), g: lam * (q - s) / b}},
    )
)

page("""It rises with `c`. So the cost falls before the law and rises after it, and
    between two bounds the best period is the law, clipped.""")
page(Positive("", "it rises with the period", sp.Derivative(beside, c), 0))

page("""Where `s + b g/lambda` is not positive there is no such period. Then the cost
    only rises if `b` is negative, and the shortest period is best; it only falls if `b`
    is positive, and the longest one is best.""")
page(Positive("", "no law, and the shortest is best", g - lam * h, 0, turned(-1)))
page(Positive("", "no law, and the longest is best", lam * h - g, 0, turned(1)))

page("""The laws of the table are four of this family. The cost of each can be written
    down at once. Law 1: the error that is reached, squared, and the departure from the
    longest period, squared. The slope is put in factors, and the law is the period at
    which one of them is zero.""")
page(slope("quadratic").factor())
page(best("quadratic"))

page("Law 2: the area under the error, and the departure squared.")
page(slope("absolute").factor())
page(best("absolute"))

page("""Law 3: the error that is reached, and a price for each sample a second. A period
    is positive, so that only one of the two roots is one.""")
page(slope("root").factor())
page(best("root"))

page("Law 4: the error that is reached, and the departure squared.")
page(slope("linear").factor())
page(best("linear"))

page("In each `kappa` is positive, so that the law is the minimum.")
page(Positive("Table II", "the factors are positive", kappa, 0, of_each(kappa)))

page("Each is a law of the family, and its cost is one of the family.")
page(
    Explicit(
        "Table II",
        "the laws of the family",
        T_max * q ** (-1 / b),
        T_s,
        of_each(b, q, T_s),
    )
)
page(
    Explicit(
        "Table II",
        "and their costs",
        T**k * (rho**a - lam * saving),
        sp.Derivative(J, T),
        of_each(a, b, s, k, lam, J),
    )
)
