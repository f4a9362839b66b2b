"""Lower a stage list to NumPy source, and the source to a function."""

import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixExpr

from ..derivations import Solve
from ..linalg import settle, solve_right, symmetrise

_NAMESPACE = dict(solve_right=solve_right, symmetrise=symmetrise, settle=settle)


def kernel(derivation, *outputs, settled=False):
    """Compile the stages of `derivation` into ``f(**arrays) -> dict of arrays``.

    Inputs are passed by name, so a caller cannot swap Q and R; a missing or unknown
    name is a TypeError.  Only the stages that `outputs` need are kept (all, if none
    are named).  Refuses a derivation whose proof fails.  Leading axes broadcast.
    With `settled`, covariances that later stages use are cleared of rounding (see
    `linalg.settle`), which costs half as much again.
    """
    if unproved := derivation.unproved() or not derivation.steps:
        raise AssertionError(f"unproved derivation: {derivation.source}: {unproved}")
    given, source = numpy_source(derivation, outputs, settled)
    namespace = dict(_NAMESPACE)
    exec("import numpy as np\n" + source, namespace)  # text made here, from symbols
    step = namespace["step"]
    step.source, step.given = source, given
    return step


def numpy_source(derivation, outputs=(), settled=False):
    """Return the names of the inputs and the source of one step, outputs pruned."""
    stages = needed(derivation.stages, outputs)
    names = {s.name for stage in stages for s in symbols_in(stage.formula)}
    given = [s for s in derivation.given if s.name in names]
    targets = [stage.target.name for stage in stages]
    used = {s.name for stage in stages for s in symbols_in(stage.formula)}
    sizes = {}
    for symbol in given:
        for axis, size in zip((-2, -1), symbol.shape):
            sizes.setdefault(size, f"{symbol.name}.shape[{axis}]")
    lines = [f"def step(*, {', '.join(s.name for s in given)}):"]
    for stage in stages:
        code = _formula(stage.formula, sizes)
        if stage.symmetric and settled and stage.target.name in used:
            code = f"settle({code}, {_formula(magnitude(stage.formula), sizes)})"
        elif stage.symmetric:
            code = f"symmetrise({code})"
        tag = f"  # {stage.equation}" if stage.equation else ""
        lines.append(f"    {stage.target.name} = {code}{tag}")
    results = ", ".join(f"{name}={name}" for name in outputs or targets)
    lines.append(f"    return dict({results})")
    return tuple(s.name for s in given), "\n".join(lines) + "\n"


def needed(stages, outputs):
    """The stages that `outputs` depend on, in order; all of them if none are named."""
    if not outputs:
        return stages
    wanted, kept = set(outputs), []
    for stage in reversed(stages):
        if stage.target.name in wanted:
            kept.append(stage)
            wanted |= {s.name for s in symbols_in(stage.formula)}
    missing = set(outputs) - {stage.target.name for stage in kept}
    if missing:
        raise KeyError(f"no stage assigns {sorted(missing)}")
    return tuple(reversed(kept))


def symbols_in(formula):
    if isinstance(formula, Solve):
        return symbols_in(formula.N) | symbols_in(formula.M)
    return formula.atoms(sp.MatrixSymbol)


class Magnitude(sp.MatrixSymbol):
    """The entrywise absolute value of a matrix, by name."""


def magnitude(e):
    """The sum of products `e` with every matrix and factor at its magnitude."""
    e = e.xreplace({s: Magnitude(s.name, *s.shape) for s in symbols_in(e)})
    return sp.MatAdd(
        *(
            sp.MatMul(*(a if isinstance(a, MatrixExpr) else abs(a) for a in term.args))
            if isinstance(term, sp.MatMul)
            else term
            for term in sp.MatAdd.make_args(e)
        )
    )


def _formula(e, sizes):
    if isinstance(e, Solve):
        return f"solve_right({_formula(e.N, sizes)}, {_formula(e.M, sizes)})"
    if isinstance(e, sp.MatAdd):
        return " + ".join(_formula(term, sizes) for term in e.args).replace("+ -", "- ")
    if isinstance(e, sp.MatMul):
        scalars = sp.Mul(*(a for a in e.args if not isinstance(a, MatrixExpr)))
        matrices = [a for a in e.args if isinstance(a, MatrixExpr)]
        factors = " @ ".join(
            f"({_formula(a, sizes)})" if a.is_MatAdd else _formula(a, sizes)
            for a in matrices
        )
        scale = {1: "", -1: "-"}.get(scalars, f"{float(scalars)!r} * ")
        return f"{scale}({factors})" if scale else factors
    if isinstance(e, Magnitude):
        return f"np.abs({e.name})"
    if isinstance(e, sp.Transpose):
        inner = _formula(e.arg, sizes)
        return f"{inner}.mT" if isinstance(e.arg, sp.MatrixSymbol) else f"({inner}).mT"
    if isinstance(e, sp.Identity):
        return f"np.eye({sizes[e.shape[0]]})"
    if isinstance(e, sp.MatrixSymbol):
        return e.name
    raise TypeError(
        f"no NumPy form for {type(e).__name__} in {e}; write an inverse as Solve"
    )
