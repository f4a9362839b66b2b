"""The sampling laws are minima of their costs: proofs, damage, and brute force."""

import dataclasses
import itertools

import numpy as np
import pytest
import scipy.linalg
import sympy as sp
from worlds import Numbers, symbols

from luenberger import sampling
from luenberger.kernels.scalar import function
from luenberger.papers.hsia.derivation import laws
from luenberger.papers.hsia.laws import formula_of
from luenberger.symbolic import Derivation, vanishes

LAWS = list(laws.FAMILY)
COEFFICIENT = {"quadratic": "alpha", "absolute": "alpha", "root": "C", "linear": "K"}
STEPS = laws.derive().steps
NOISE = {
    "of a period": laws.noise_of_a_period(),
    "doubled": laws.noise_doubled(),
}


# -- proved -------------------------------------------------------------------------


@pytest.mark.parametrize("name", list(STEPS))
def test_proved(name):
    assert vanishes(STEPS[name])


def test_every_law_has_its_steps_and_the_derivation_says_whose_it_is():
    for number in (1, 2, 3, 4):
        assert sum(f"Table II law {number}:" in name for name in STEPS) == 5
    assert "objectives are our own" in laws.derive().source
    assert all(sp.latex(f) for f in laws.derive().formulas.values())


def test_all_four_are_members_of_one_family():
    """Only law 3 has s = 0, only law 4 rises without bound: a table one can read."""
    a, b, s = (getattr(laws, letter) for letter in "abs")
    found = {law: [given[x] for x in (a, b, s)] for law, given in family().items()}
    assert found == {
        "quadratic": [2, 1, 1],
        "absolute": [1, 1, 1],
        "root": [1, 2, 0],
        "linear": [1, -1, 1],
    }


def family():
    return laws.FAMILY


# -- damage -------------------------------------------------------------------------


def unproved(steps):
    return [name for name, step in steps.items() if not vanishes(step)]


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("term", [0, 1])
@pytest.mark.parametrize("change", [2, -1, laws.T])
def test_a_damaged_cost_is_noticed(monkeypatch, law, term, change):
    terms = list(laws.READINGS[law].args)
    terms[term] = terms[term] * change
    damaged = laws.READINGS | {law: sp.Add(*terms)}
    monkeypatch.setattr(laws, "READINGS", damaged)
    try:
        assert unproved(laws.table())
    except ValueError:  # no stationary period any more, or several
        pass


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("letter", ["a", "b", "s", "k", "lam"])
def test_a_damaged_member_of_the_family_is_noticed(monkeypatch, law, letter):
    symbol = getattr(laws, letter)
    given = dict(laws.FAMILY[law])
    given[symbol] = given[symbol] + 2 if letter != "lam" else 2 * given[symbol]
    damaged = laws.FAMILY | {law: given}
    monkeypatch.setattr(laws, "FAMILY", damaged)
    wrong = unproved(laws.table())
    number = 1 + LAWS.index(law)
    assert wrong and all(f"law {number}" in name for name in wrong)


@pytest.mark.parametrize(
    "damage",
    [
        lambda h: -h,
        lambda h: h + 1,
        lambda h: h * laws.T,
        lambda h: h.subs(laws.s, 2 * laws.s),
    ],
    ids=["sign", "constant", "power", "shift"],
)
def test_a_damaged_price_is_noticed(monkeypatch, damage):
    sound = laws.price
    monkeypatch.setattr(
        laws,
        "price",
        lambda t: damage(sound(laws.T)).subs(laws.T, t),
    )
    assert not all(map(vanishes, laws.general().values()))


def test_a_maximum_is_not_taken_for_a_minimum(monkeypatch):
    """With the sign of J turned the same point is stationary; only d2J/dT2 tells."""
    turned = {law: -J for law, J in laws.READINGS.items()}
    monkeypatch.setattr(laws, "READINGS", turned)
    wrong = unproved(laws.table())
    assert sum("d2J/dT2 > 0" in name for name in wrong) == 4
    assert not any("one zero" in name for name in wrong)


@pytest.mark.parametrize("part", list(NOISE))
def test_damaged_noise_is_noticed(part):
    for name, claim in NOISE[part].steps.items():
        if claim.right == 0:
            continue
        for symbol in symbols(claim.right):  # A and X drop out
            wrong = claim.left.xreplace({symbol: 2 * symbol})
            assert not dataclasses.replace(claim, left=wrong).is_zero, (name, symbol)
        for term in sp.Add.make_args(sp.expand(claim.left)):
            wrong = claim.left - 2 * term
            assert not dataclasses.replace(claim, left=wrong).is_zero, (name, term)


# -- numbers ------------------------------------------------------------------------


@pytest.mark.parametrize("law", LAWS)
def test_the_kernel_is_theformula_of_formula(law):
    formula = laws.derive().formulas[laws.key(law)]
    given = {"rho": 3.7, "T_max": 0.13, COEFFICIENT[law]: 0.021}
    exact = formula.subs({x: given[x.name] for x in formula.free_symbols})
    found = formula_of(law, COEFFICIENT[law])(**given)
    assert np.isclose(found, float(exact), rtol=1e-14)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("value", [0.004, 0.06, 0.9])
def test_the_law_is_the_best_period_within_bounds_by_brute_force(law, value):
    symbol = sp.Symbol(COEFFICIENT[law], positive=True)
    J = laws.READINGS[law].subs({symbol: value, "T_max": 0.1})
    J = J.subs(laws.T_max, 0.1)
    cost = sp.lambdify([laws.T, laws.rho], J, "numpy")
    grid = np.linspace(0.02, 0.1, 8001)
    rates = np.logspace(-3, 3, 25)
    best = [grid[np.argmin(cost(grid, rate))] for rate in rates]
    found = getattr(sampling, law)(value)(rates)
    np.testing.assert_allclose(found, best, atol=1.01e-5)
    assert found.min() == 0.02 or found.max() == 0.1  # some bound was met


@pytest.mark.parametrize(
    "b, s, k", list(itertools.product([-2, -0.5, 0.5, 1.5], [0, 1, -0.3], [0, 1, 2]))
)
def test_the_general_law_is_the_best_period_by_brute_force(b, s, k):
    """Also where the root is not a positive number, and for every weight T^k."""
    names = ("T_max", "lambda", "b", "s", "k", "T", "g")
    derivation = laws.derive()
    slope = function(derivation, "general form dJ/dT", *names)
    grid = np.linspace(0.02, 0.1, 4001)
    for g in (0.01, 0.3, 1.0, 4.0):
        middle = (grid[1:] + grid[:-1]) / 2
        steps = slope(0.1, 0.7, b, s, k, middle, g) * np.diff(grid)
        best = grid[np.argmin(np.concatenate([[0], np.cumsum(steps)]))]
        q = s + b * g / 0.7
        if q > 0:
            law = 0.1 * q ** (-1 / b)
        else:  # J falls for b > 0, rises for b < 0, whatever T
            law = np.inf if b > 0 else 0.0
        assert abs(np.clip(law, 0.02, 0.1) - best) < 3e-5


def test_the_proofs_of_the_noise_hold_for_matrices():
    """With Phi, X, H from matrix exponentials, each side of each step."""
    rng = np.random.default_rng(4)
    A = rng.normal(size=(3, 3))
    Q = A @ A.T
    block = np.block([[-A, Q], [np.zeros((3, 3)), A.T]])
    E = scipy.linalg.expm(0.7 * block)
    values = dict(A=A, Q=Q, Phi=E[3:, 3:].T, X=E[:3, 3:], H=scipy.linalg.expm(0.4 * A))
    for name, claim in STEPS.items():
        if name.startswith("noise") and claim.right != 0:
            numbers = Numbers({"n": 3}, values=values)
            left, right = numbers.value(claim.left), numbers.value(claim.right)
            np.testing.assert_allclose(left, right, rtol=1e-12)


def test_kernels_refuse_what_is_not_proved_or_not_there():
    sound = laws.derive()
    with pytest.raises(AssertionError, match="unproved"):
        function(Derivation(formulas=sound.formulas), "general form h", "T")
    with pytest.raises(KeyError, match="depends on"):
        function(sound, laws.key("root"), "rho")
