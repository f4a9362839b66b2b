"""The shape that a matrix has to have, and what to write where it lies on its side."""

from . import Matrix

FEW = 12  # entries of a matrix that a message writes out


def require_shape(
    name: str, array: Matrix, rows: int | None, cols: int | None, steps: bool
) -> None:
    """Raise ValueError unless `array` is a matrix, or with `steps` a stack, of a shape.

    None is any number of rows or columns.
    """
    if array.ndim not in ((2, 3) if steps else (2,)):
        wanted = "a matrix, or a stack (N, ., .) of them" if steps else "a matrix"
        upright = array.ndim == 1 and rows == len(array) and cols in (None, 1)
        meant = _written(array[:, None] if upright else array[None])
        raise ValueError(f"{name} must be {wanted}; it has shape {array.shape}{meant}")
    got = array.shape[-2:]
    if (want := _shape(got, rows, cols)) == got:
        return
    found, meant = f"got {got[0]} x {got[1]}", ""
    size = f"be {want[0]} x {want[1]}"
    if (turned := _shape(got[::-1], rows, cols)) == got[::-1]:
        meant, size = _written(array.mT), f"be {turned[0]} x {turned[1]}"
        if cols is None:
            size = f"have {rows} row{'s' * (rows != 1)}"
        elif rows is None:
            size = f"have {cols} column{'s' * (cols != 1)}"
    raise ValueError(f"{name} must {size}, {found}{meant}")


def _shape(got: tuple[int, ...], rows: int | None, cols: int | None) -> tuple[int, ...]:
    return tuple(g if w is None else w for g, w in zip(got, (rows, cols)))


def _written(array: Matrix) -> str:
    """The advice to write a small real matrix so, for the end of a message."""
    if array.ndim != 2 or not 0 < array.size <= FEW or array.dtype.kind == "c":
        return ""
    rows = (", ".join(f"{x:.15g}" for x in row) for row in array)
    return f"; write [{', '.join(f'[{row}]' for row in rows)}]"
