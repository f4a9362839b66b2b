"""A stage list as the text of a function: one line a stage, its equation behind it."""

from collections.abc import Sequence
from typing import Any

import sympy as sp

from matrixproof import Derivation, Solve, Stage

from .printing import NumPy

MODULE = """\
import numpy as np

from luenberger.kernels.inside import eye, solve_right, symmetrise


"""


def numpy_source(
    derivation: Derivation, outputs: Sequence[str] = (), flat: bool = False
) -> tuple[tuple[str, ...], str]:
    """The names of the inputs, and ``step(*, A, ...) -> dict``, outputs pruned."""
    given, lines, results = _lines(derivation, outputs, "flat" if flat else "stacks")
    found = ", ".join(f"{name}={name}" for name in results)
    head = f"def step(*, {', '.join(given)}):"
    return given, "\n".join([head, *lines, f"    return dict({found})", ""])


def numba_source(
    derivation: Derivation, outputs: Sequence[str] = ()
) -> tuple[tuple[str, ...], str]:
    """The names of the inputs, and a module with ``run(A, ...) -> tuple``."""
    given, lines, results = _lines(derivation, outputs, "numba")
    head = f"def run({', '.join(given)}):"
    end = f"    return {', '.join(results)}" + "," * (len(results) == 1)  # a tuple
    return given, MODULE + "\n".join([head, *lines, end, ""])


def _lines(
    derivation: Derivation, outputs: Sequence[str], way: str
) -> tuple[tuple[str, ...], list[str], Sequence[str]]:
    """What is given, a line for each stage, and what is returned."""
    require_proved(derivation)
    stages = needed(derivation.stages, outputs)
    given = [s for s in derivation.given if s.name in names_in(stages)]
    sizes: dict[Any, str] = {}
    for symbol in given:
        for axis, size in zip((-2, -1), symbol.shape):
            sizes.setdefault(size, f"{symbol.name}.shape[{axis}]")
    printer, lines = NumPy(sizes, way), []
    for stage in stages:
        code = printer.doprint(stage.formula)
        if stage.symmetric:
            code = f"symmetrise({code})"
        tag = f"  # {stage.equation}" if stage.equation else ""
        lines.append(f"    {stage.target.name} = {code}{tag}")
    results = outputs or [stage.target.name for stage in stages]
    return tuple(s.name for s in given), lines, results


def require_proved(derivation: Derivation) -> None:
    """Raise AssertionError for a derivation without proofs, or with a false one."""
    if not derivation.proved():
        unproved = derivation.unproved()
        raise AssertionError(f"unproved derivation: {derivation.source}: {unproved}")


def needed(stages: tuple[Stage, ...], outputs: Sequence[str]) -> tuple[Stage, ...]:
    """The stages that `outputs` depend on, in order; all of them if none are named."""
    if not outputs:
        return stages
    wanted, kept = set(outputs), []
    for stage in reversed(stages):
        if stage.target.name in wanted:
            kept.append(stage)
            wanted |= names_in([stage])
    missing = set(outputs) - {stage.target.name for stage in kept}
    if missing:
        raise KeyError(f"no stage assigns {sorted(missing)}")
    return tuple(reversed(kept))


def names_in(stages: Sequence[Stage]) -> set[str]:
    """Names of the matrices that the formulas of stages read."""
    return {s.name for stage in stages for s in symbols_in(stage.formula)}


def symbols_in(formula: Any) -> set[Any]:
    if isinstance(formula, Solve):
        return symbols_in(formula.N) | symbols_in(formula.M)
    return formula.atoms(sp.MatrixSymbol)
