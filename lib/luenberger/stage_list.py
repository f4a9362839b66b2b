"""A stage list by the place where it is written, named without loading SymPy.

A paper's front door, `papers/<paper>/derivation/__init__.py`, has one `StageList` for
each stage list of the paper.  Who wants a kernel imports it from there and gives it to
`kernels`, which call it only if the code is not kept from an earlier process.
"""

import ast
import inspect
from dataclasses import dataclass
from importlib import import_module
from typing import Any


@dataclass(frozen=True)
class StageList:
    """Where a stage list is written.

    Attributes
    ----------
    package : str
        The package of the paper's derivations.
    where : str
        "module.name" in there: the stage list, or a function that makes it.

    Examples
    --------
    >>> from luenberger.papers.leondes_novak.derivation import estimate_step
    >>> estimate_step.where
    'estimate.estimate_step'
    >>> print(estimate_step().stages[0])
    x₋ = A x + B u + J ρ  (43)
    """

    package: str
    where: str

    def __call__(self) -> Any:
        """The `Derivation`: its stages, and the proof of what is claimed of them."""
        module, _, name = self.where.partition(".")
        found = getattr(import_module(f"{self.package}.{module}"), name)
        return found() if callable(found) else found


def stage_lists(package: str) -> dict[str, StageList]:
    """The stage lists of a paper by name, in the order of its front door.

    Raises ValueError if two have one name, as the later one would replace the other.
    """
    door = import_module(package)
    items = vars(door).items()
    found = {name: one for name, one in items if isinstance(one, StageList)}
    given = set[str]()
    for statement in ast.parse(inspect.getsource(door)).body:
        for name in getattr(statement, "targets", ()):
            if isinstance(name, ast.Name) and name.id in found:
                if name.id in given:
                    raise ValueError(
                        f"line {statement.lineno} of {package} gives a second stage "
                        f"list the name {name.id!r}, and the first one is gone. Give "
                        "it a name of its own"
                    )
                given.add(name.id)
    return found
