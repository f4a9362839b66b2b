"""Arrays on the stack of compiled code.

Of arrays from the heap LLVM must assume that one may overlap another, and leaves
short loops over them scalar.  Two arrays on the stack cannot overlap, so loops run at
the speed of C.
"""

from typing import Any


def local_array() -> Any:
    """A function for numba: ``array(9)`` is a new array of nine floats, not cleared.

    Its size is written out where it is called; it lives as long as the caller runs.
    """
    from llvmlite import ir
    from numba.core import cgutils, types
    from numba.extending import intrinsic
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

    return intrinsic(array)
