"""Lower a stage list to NumPy source, and the source to a function."""

from collections.abc import Sequence
from typing import Any

import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixExpr

from ..symbolic import Derivation, Solve
from .lowering import needed, require_proved, symbols_in
from .step import assemble


def kernel(derivation: Derivation, *outputs: str, flat: bool = False) -> Any:
    """Compile the stages of `derivation` into ``f(**arrays) -> dict of arrays``.

    Inputs are passed by name, so a caller cannot swap Q and R; a missing or unknown
    name is a TypeError.  Only the stages that `outputs` need are kept (all, if none
    are named).  Refuses a derivation whose proof fails.  Leading axes broadcast, but
    not those of a `flat` kernel, which is faster.
    """
    require_proved(derivation)
    given, source = numpy_source(derivation, outputs, flat)
    return assemble(source, given)


def numpy_source(
    derivation: Derivation, outputs: Sequence[str] = (), flat: bool = False
) -> tuple[tuple[str, ...], str]:
    """Return the names of the inputs and the source of one step, outputs pruned."""
    stages = needed(derivation.stages, outputs)
    names = {s.name for stage in stages for s in symbols_in(stage.formula)}
    given = [s for s in derivation.given if s.name in names]
    targets = [stage.target.name for stage in stages]
    sizes: dict[Any, str] = {}
    for symbol in given:
        for axis, size in zip((-2, -1), symbol.shape):
            sizes.setdefault(size, f"{symbol.name}.shape[{axis}]")
    code_of = Printer(sizes, flat)
    lines = [f"def step(*, {', '.join(s.name for s in given)}):"]
    for stage in stages:
        code = code_of(stage.formula)
        if stage.symmetric:
            code = f"symmetrise({code})"
        tag = f"  # {stage.equation}" if stage.equation else ""
        lines.append(f"    {stage.target.name} = {code}{tag}")
    results = ", ".join(f"{name}={name}" for name in outputs or targets)
    lines.append(f"    return dict({results})")
    return tuple(s.name for s in given), "\n".join(lines) + "\n"


class Printer:
    """SymPy matrix expressions as NumPy source.

    `flat` code is for matrices only: ``dot`` takes half the time of ``@`` on small
    ones, which is most of a step's time.  Otherwise leading axes broadcast.
    """

    def __init__(self, sizes: dict[Any, str], flat: bool) -> None:
        self.sizes, self.flat = sizes, flat

    def __call__(self, e: Any) -> str:
        if isinstance(e, Solve):
            return f"solve_right({self(e.N)}, {self(e.M)})"
        if isinstance(e, sp.MatAdd):
            return " + ".join(map(self, e.args)).replace("+ -", "- ")
        if isinstance(e, sp.MatMul):
            return self.product(e)
        if isinstance(e, sp.Transpose):
            return f"{self.factor(e.arg)}.{'T' if self.flat else 'mT'}"
        if isinstance(e, sp.BlockMatrix):
            return self.joined(e.blocks.tolist())
        if isinstance(e, sp.ZeroMatrix):
            return f"np.zeros(({', '.join(map(self.size, e.shape))}))"
        if isinstance(e, sp.Identity):
            return f"eye({self.size(e.shape[0])})"
        if isinstance(e, sp.MatrixSymbol):
            return e.name
        raise TypeError(
            f"no NumPy form for {type(e).__name__} in {e}; write an inverse as Solve"
        )

    def size(self, e: Any) -> str:
        return str(e) if e.is_Integer else self.sizes[e]

    def joined(self, rows: list[list[Any]]) -> str:
        """Blocks side by side or one above the other; `np.block` does both, slowly."""
        codes = [", ".join(map(self, row)) for row in rows]
        if len(rows) == 1:
            return f"np.concatenate([{codes[0]}], axis=-1)"
        if len(rows[0]) == 1:
            return f"np.concatenate([{', '.join(codes)}], axis=-2)"
        return f"np.block([[{'], ['.join(codes)}]])"

    def product(self, e: Any) -> str:
        scalars = sp.Mul(*(a for a in e.args if not isinstance(a, MatrixExpr)))
        first, *rest = (a for a in e.args if isinstance(a, MatrixExpr))
        if self.flat:
            code = self.factor(first) + "".join(f".dot({self(a)})" for a in rest)
        else:
            code = " @ ".join(map(self.factor, (first, *rest)))
        scale = {1: "", -1: "-"}.get(scalars, f"{float(scalars)!r} * ")
        return f"{scale}({code})" if scale else code

    def factor(self, e: Any) -> str:
        """The code of `e`, in parentheses where an operator would tear it apart."""
        return f"({self(e)})" if isinstance(e, sp.MatAdd | sp.MatMul) else self(e)
