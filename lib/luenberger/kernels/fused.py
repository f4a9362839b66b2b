"""A product and a sum as one operation of compiled code.

Whether LLVM joins a product with the sum behind it hangs on the code around them.
Where bits must not depend on that, the text says which are joined.
"""

from collections.abc import Sequence
from typing import Any

Sums = Sequence[tuple[float, Sequence[str]]]  # terms: a factor, and names


def fused() -> Any:
    """A definition for numba: ``fma(a, b, c)`` is a * b + c.

    It is rounded once where the processor has such an instruction, else twice: always
    the same on one machine.
    """
    from llvmlite import ir
    from numba.core import types

    def fma(context: Any, a: Any, b: Any, c: Any) -> Any:
        number = ir.DoubleType()
        kind = ir.FunctionType(number, [number] * 3)

        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            name = "llvm.fmuladd"
            call = builder.module.declare_intrinsic(name, [number], kind)
            return builder.call(call, arguments)

        return types.float64(*[types.float64] * 3), code

    return fma


def plain(a: float, b: float, c: float) -> float:
    """The same where nothing is compiled."""
    return a * b + c


def joined(terms: Sums, number: float) -> str:
    """A sum, every product but the first joined with what stands before it."""
    terms = sorted(terms, key=lambda term: term[0] < 0)  # stable
    alone = [
        k for k, (scale, names) in enumerate(terms) if (scale, len(names)) == (1, 1)
    ]
    if alone and not number:
        terms.insert(0, terms.pop(alone[0]))
    text = repr(number) if number else ""
    for scale, names in terms:
        factors = list(names) if abs(scale) == 1 else [repr(abs(scale)), *names]
        *left, last = factors
        product, minus = " * ".join(left), "-" if scale < 0 else ""
        if not text:
            text = minus + " * ".join(factors)
        elif not left:
            text = f"{text} {minus or '+'} {last}"
        else:
            product = f"({product})" if len(left) > 1 else product
            text = f"fma({minus}{product}, {last}, {text})"
    return text
