"""What compiled code calls that numba has not.

Arrays on the stack: of arrays from the heap LLVM must assume that one may overlap
another, and leaves short loops over them scalar.  Two arrays on the stack cannot
overlap, so loops run at the speed of C.

Memory asked for ahead of time: a processor fetches ahead what is read forward.  What is
read backward it finds late, so a loop over rows from the last to the first asks for the
next row while it works on one.
"""

from typing import Any

import numpy as np

from . import fused, products

LINE = 8  # floats that memory gives at once


def ours() -> dict[str, Any]:
    """What is called, by name."""
    from numba.extending import intrinsic

    return {name: intrinsic(one) for name, one in definitions().items()}


def definitions() -> dict[str, Any]:
    """The same as definitions for numba, of which it makes functions."""
    made = dict(array=local_array(), fetch=fetch_ahead(), fma=fused.fused())
    return made | dict(product=products.in_vectors())


def plain() -> dict[str, Any]:
    """The same where nothing is compiled."""
    made = dict(array=np.empty, fetch=lambda X, row, k: None, fma=fused.plain)
    return made | dict(product=products.in_python)


def local_array() -> Any:
    """A definition for numba: ``array(9)`` is a new array of nine floats, not cleared.

    Its size is written out where it is called; it lives as long as the caller runs.
    """
    from llvmlite import ir
    from numba.core import cgutils, types
    from numba.np.arrayobj import make_array, populate_array

    def array(context: Any, size: Any) -> Any:
        if not isinstance(size, types.IntegerLiteral):
            return None
        length, kind = size.literal_value, types.Array(types.float64, 1, "C")

        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            room = ir.ArrayType(ir.DoubleType(), length)
            data = cgutils.alloca_once(builder, room)
            data = builder.bitcast(data, ir.DoubleType().as_pointer())
            whole, eight = (context.get_constant(types.intp, k) for k in (length, 8))
            made = make_array(kind)(context, builder)
            populate_array(made, data, [whole], [eight], eight, None)
            return made._getvalue()

        return kind(size), code

    return array


def fetch_ahead() -> Any:
    """A definition for numba: ``fetch(X, row, k)`` asks for the line of ``X[row, k]``.

    There may be no such row: what does not exist is not fetched.
    """
    from llvmlite import ir
    from numba.core import cgutils, types
    from numba.np.arrayobj import make_array

    def fetch(context: Any, X: Any, row: Any, k: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            whole, word = ir.IntType(64), ir.IntType(32)
            X, row, k = arguments
            array = make_array(signature.args[0])(context, builder, X)
            steps = zip((row, k), cgutils.unpack_tuple(builder, array.strides))
            at = builder.ptrtoint(array.data, whole)
            for index, stride in steps:
                at = builder.add(at, builder.mul(index, stride))
            at = builder.inttoptr(at, ir.IntType(8).as_pointer())
            kind = ir.FunctionType(ir.VoidType(), [at.type, word, word, word])
            name = "llvm.prefetch"
            ask = builder.module.declare_intrinsic(name, [at.type], kind)
            builder.call(ask, [at, *(word(number) for number in (0, 3, 1))])
            return context.get_dummy_value()

        return types.void(X, types.intp, types.intp), code

    return fetch
