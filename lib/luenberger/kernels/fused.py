"""A product and a sum as one operation of compiled code.

Whether LLVM joins a product with the sum behind it hangs on the code around them.
Where bits must not depend on that, the text says which are joined.
"""

from typing import Any


def fused() -> Any:
    """A function for numba: ``fma(a, b, c)`` is a * b + c.

    It is rounded once where the processor has such an instruction, else twice: always
    the same on one machine.
    """
    from llvmlite import ir
    from numba.core import types
    from numba.extending import intrinsic

    def fma(context: Any, a: Any, b: Any, c: Any) -> Any:
        number = ir.DoubleType()
        kind = ir.FunctionType(number, [number] * 3)

        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            name = "llvm.fmuladd"
            call = builder.module.declare_intrinsic(name, [number], kind)
            return builder.call(call, arguments)

        return types.float64(*[types.float64] * 3), code

    return intrinsic(fma)


def plain(a: float, b: float, c: float) -> float:
    """The same where nothing is compiled."""
    return a * b + c
