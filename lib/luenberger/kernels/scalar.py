"""Lower one scalar formula of a derivation to a function of its symbols."""

from collections.abc import Callable
from typing import Any

import sympy as sp

from ..symbolic import Derivation


def function(derivation: Derivation, key: str, *names: str) -> Callable[..., Any]:
    """Compile ``derivation.formulas[key]`` into ``f(**values)``; arrays broadcast.

    `names` are the arguments: the symbols of the formula, and others it may ignore.
    Refuses a derivation whose proof fails, as `numpy.kernel` does.
    """
    if unproved := derivation.unproved() or not derivation.steps:
        raise AssertionError(f"unproved derivation: {derivation.source}: {unproved}")
    formula = derivation.formulas[key]
    symbols = {symbol.name: symbol for symbol in formula.free_symbols}
    if missing := set(symbols) - set(names):
        raise KeyError(f"{key} depends on {sorted(missing)}")
    arguments = [symbols.get(name, sp.Symbol(name)) for name in names]
    return sp.lambdify(arguments, formula, modules="numpy")
