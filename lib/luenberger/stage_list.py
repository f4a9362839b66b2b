"""A stage list by the place where it is written, named without loading SymPy.

A paper's front door, `papers/<paper>/derivation/__init__.py`, has one `StageList` for
each stage list of the paper.  Who wants a kernel imports it from there and gives it to
`kernels`, which call it only if the code is not kept from an earlier process.
"""

from dataclasses import dataclass
from importlib import import_module
from typing import Any


@dataclass(frozen=True)
class StageList:
    """Where a stage list is written, and what it computes.

    Attributes
    ----------
    package : str
        The package of the paper's derivations.
    where : str
        "module.function" in there; its docstring says what the names mean.
    computes : str
        The names of what it assigns, in order, with a blank between them.

    Examples
    --------
    >>> from luenberger.papers.leondes_novak.derivation import estimate_step
    >>> estimate_step.where, estimate_step.computes
    ('estimate.estimate_step', 'x_minus innovation x_next rho_next')
    >>> print(estimate_step().stages[0])
    x₋ = A x + B u + J ρ  (43)
    """

    package: str
    where: str
    computes: str

    def __call__(self) -> Any:
        """The `Derivation`: its stages, and the proof of what is claimed of them."""
        module, _, function = self.where.partition(".")
        return getattr(import_module(f"{self.package}.{module}"), function)()


def stage_lists(package: str) -> dict[str, StageList]:
    """The stage lists of a paper by name, in the order of its front door."""
    found = vars(import_module(package)).items()
    return {name: one for name, one in found if isinstance(one, StageList)}
