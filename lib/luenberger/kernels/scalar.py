"""Lower one scalar formula of a derivation to a function of its symbols."""

from collections.abc import Callable
from typing import Any

import sympy as sp

from matrixproof import Explicit


def function(statement: Explicit, letter: sp.Symbol, *names: str) -> Callable[..., Any]:
    """Compile what a statement says that `letter` is into ``f(**values)``.

    Arrays broadcast.  `names` are the arguments: the symbols of the formula, and others
    it may ignore.  Refuses a statement that does not hold, as `compiled` does.
    """
    if faults := statement.check():
        raise AssertionError(f"unproved: {statement.says}: {faults}")
    (values,) = statement.cases.values()
    formula = values[letter]
    symbols = {symbol.name: symbol for symbol in formula.free_symbols}
    if missing := set(symbols) - set(names):
        raise KeyError(f"{letter} depends on {sorted(missing)}")
    arguments = [symbols.get(name, sp.Symbol(name)) for name in names]
    return sp.lambdify(arguments, formula, modules="numpy")
