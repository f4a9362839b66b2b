"""The sampling laws are minima of their costs: damage, and brute force."""

import dataclasses
import itertools

import numpy as np
import pytest
import scipy.linalg
import sympy as sp
from damage import fails
from worlds import Numbers

from luenberger import sampling
from luenberger.kernels.scalar import function
from luenberger.papers.hsia.derivation import laws, noise
from luenberger.papers.hsia.derivation.laws import J, T, T_max, T_s, a, b, rho, s
from luenberger.papers.hsia.laws import formula_of
from matrixproof import Chain

LAWS = list(laws.LAWS)
COEFFICIENT = {"quadratic": "alpha", "absolute": "alpha", "root": "C", "linear": "K"}


# -- proved -------------------------------------------------------------------------


def test_the_derivation_says_whose_it_is():
    assert "objectives are our own" in laws.page.source


def test_all_four_are_members_of_one_family():
    """Only law 3 has s = 0, only law 4 rises without bound: a table one can read."""
    found = {law: [given[x] for x in (a, b, s)] for law, given in laws.FAMILY.items()}
    assert found == {
        "quadratic": [2, 1, 1],
        "absolute": [1, 1, 1],
        "root": [1, 2, 0],
        "linear": [1, -1, 1],
    }


# -- damage -------------------------------------------------------------------------


def wrong(item, values):
    """A statement about one law with other values."""
    return dataclasses.replace(item, cases={"": {**item.cases[""], **values}})


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("term", [0, 1])
@pytest.mark.parametrize("change", [2, -1, T])
def test_a_damaged_cost_is_noticed(law, term, change):
    terms = list(laws.LAWS[law][J].args)
    terms[term] = terms[term] * change
    assert fails(wrong(laws.best(law), {J: sp.Add(*terms)}))


@pytest.mark.parametrize("law", LAWS)
def test_the_chain_of_a_law_ends_in_a_factor_that_is_zero_there(law):
    chain = laws.page.steps[f"({laws.number(law)}) the slope of its cost"]
    assert sp.simplify(chain.right.subs(T, laws.LAWS[law][T_s])) == 0
    for term in chain.left.args:
        assert fails(dataclasses.replace(chain, left=chain.left - 2 * term))
    for k, line in enumerate(chain.lines):
        for term in sp.Add.make_args(sp.expand(line.right)):
            lines = list(chain.lines)
            lines[k] = dataclasses.replace(line, right=line.right - 2 * term)
            assert fails(dataclasses.replace(chain, lines=tuple(lines)))


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("letter", ["a", "b", "s", "k", "lambda"])
def test_a_damaged_member_of_the_family_is_noticed(law, letter):
    item = laws.page.steps["(Table II) and their costs"]
    (symbol,) = (x for x in item.cases[law] if str(x) == letter)
    given = dict(item.cases[law])
    given[symbol] = 2 * given[symbol] if letter == "lambda" else given[symbol] + 2
    assert fails(dataclasses.replace(item, cases={law: given}))


@pytest.mark.parametrize(
    "damage",
    [lambda h: -h, lambda h: h + 1, lambda h: h * T, lambda h: h.subs(s, 2 * s)],
    ids=["sign", "constant", "power", "shift"],
)
def test_a_damaged_saving_is_noticed(damage):
    item = laws.page.steps["the costs of the family"]
    assert fails(wrong(item, {laws.h: damage(laws.saving)}))


def test_a_maximum_is_not_taken_for_a_minimum():
    """With the sign of J turned the point is stationary as well; kappa tells."""
    found = laws.LAWS["root"]
    turned = {J: -found[J], laws.kappa: -found[laws.kappa]}
    [fault] = wrong(laws.best("root"), turned).check()
    assert "kappa" in fault and fault.endswith("is not positive")
    positive = laws.page.steps["(Table II) the factors are positive"]
    cases = positive.cases | {"root": {laws.kappa: -found[laws.kappa]}}
    assert fails(dataclasses.replace(positive, cases=cases))


# -- numbers ------------------------------------------------------------------------


@pytest.mark.parametrize("law", LAWS)
def test_the_kernel_is_the_formula(law):
    formula = laws.LAWS[law][T_s]
    given = {"rho": 3.7, "T_max": 0.13, COEFFICIENT[law]: 0.021}
    exact = formula.subs({x: given[x.name] for x in formula.free_symbols})
    found = formula_of(law, COEFFICIENT[law])(**given)
    assert np.isclose(found, float(exact), rtol=1e-14)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("value", [0.004, 0.06, 0.9])
def test_the_law_is_the_best_period_within_bounds_by_brute_force(law, value):
    symbol = sp.Symbol(COEFFICIENT[law], positive=True)
    cost = laws.LAWS[law][J].subs({symbol: value, T_max: 0.1})
    cost = sp.lambdify([T, rho], cost, "numpy")
    grid = np.linspace(0.02, 0.1, 8001)
    rates = np.logspace(-3, 3, 25)
    best = [grid[np.argmin(cost(grid, rate))] for rate in rates]
    found = getattr(sampling, law)(value)(rates)
    np.testing.assert_allclose(found, best, atol=1.01e-5)
    assert found.min() == 0.02 or found.max() == 0.1  # some bound was met


@pytest.mark.parametrize(
    "b_, s_, k_",
    list(itertools.product([-2, -0.5, 0.5, 1.5], [0, 1, -0.3], [0, 1, 2])),
)
def test_the_general_law_is_the_best_period_by_brute_force(b_, s_, k_):
    """Also where the root is not a positive number, and for every weight T^k."""
    general = laws.page.steps["the costs of the family"]
    slope = general.right.subs(laws.h, laws.saving)
    given = {T_max: 0.1, laws.lam: 0.7, b: b_, s: s_, laws.k: k_}
    slope = sp.lambdify([T, laws.g], slope.subs(given), "numpy")
    grid = np.linspace(0.02, 0.1, 4001)
    for g in (0.01, 0.3, 1.0, 4.0):
        middle = (grid[1:] + grid[:-1]) / 2
        steps = slope(middle, g) * np.diff(grid)
        best = grid[np.argmin(np.concatenate([[0], np.cumsum(steps)]))]
        q = s_ + b_ * g / 0.7
        if q > 0:
            law = 0.1 * q ** (-1 / b_)
        else:  # J falls for b > 0, rises for b < 0, whatever T
            law = np.inf if b_ > 0 else 0.0
        assert abs(np.clip(law, 0.02, 0.1) - best) < 3e-5


def test_the_proofs_of_the_noise_hold_for_matrices():
    """With Phi, X, H from matrix exponentials, each line with its reasons put in."""
    rng = np.random.default_rng(4)
    A = rng.normal(size=(3, 3))
    Q = A @ A.T
    block = np.block([[-A, Q], [np.zeros((3, 3)), A.T]])
    E = scipy.linalg.expm(0.7 * block)
    values = dict(A=A, Q=Q, Phi=E[3:, 3:].T, X=E[:3, 3:], H=scipy.linalg.expm(0.4 * A))
    values |= dict(Block=block, E=E, U=E[:3, :3], dE=block @ E)
    values["dPhi"] = A @ values["Phi"]  # which commute
    values["dX"] = Q @ values["Phi"].T - A @ values["X"]
    values["dP"] = values["Phi"] @ Q @ values["Phi"].T
    numbers = Numbers({"n": 3}, values=values)
    rates = [c for c in noise.page.steps.values() if "the rate" in c.says]
    assert len(rates) == 3 and all(isinstance(chain, Chain) for chain in rates)
    for chain in rates:
        first, *rest = (numbers.value(line.right) for line in chain.lines)
        for other in rest:
            np.testing.assert_allclose(other, first, rtol=1e-12, atol=1e-12)


def test_kernels_refuse_what_is_not_proved_or_not_there():
    sound = laws.best("root")
    with pytest.raises(AssertionError, match="unproved"):
        function(wrong(sound, {T_s: T_max}), T_s, "T_max")
    with pytest.raises(KeyError, match="T_s depends on"):
        function(sound, T_s, "rho")
