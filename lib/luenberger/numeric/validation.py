"""Validation shared by Plant and Observer: checked once, then frozen."""

import dataclasses
import math
import re
import sys
import warnings
from collections.abc import Iterable, Mapping
from fractions import Fraction
from numbers import Integral
from typing import Any, TypeVar

import numpy as np

from ..errors import few, short
from . import Matrix, Vector

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


Frozen = TypeVar("Frozen")
LARGEST = 10**8  # entries of a matrix that is left out
EXACT = 100_000  # entries of the largest matrix that is also kept as Fractions
WORDS = {"U": "text", "S": "text", "b": "truth values"}
WORDS |= {"M": "times; count seconds from one of them", "m": "times; divide by a unit"}
# line ends, terminal controls, reordering of text, and halves of characters
STEERING = re.compile("[\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")


def matrix(
    name: str,
    value: object,
    rows: int | None = None,
    cols: int | None = None,
    steps: bool = False,
    field: type = float,
) -> Matrix:
    """Return `value` as a read-only array of the given shape.

    With ``steps=True`` a leading time axis, (N, rows, cols), is accepted too; with
    ``field=complex`` complex entries, and the array is complex if it has any.
    """
    array = numbers(name, value, field)
    require_shape(name, array, rows, cols, steps)
    if array.ndim == 3 and len(array) == 0:
        raise ValueError(f"{name} is time-varying but has no rows")
    return freeze(array)


def vector(name: str, value: object, size: int) -> Vector:
    """Return `value` as a read-only float vector of the given size."""
    array = numbers(name, value)
    if array.shape != (size,):
        raise ValueError(f"{name} must have shape ({size},), got {array.shape}")
    return freeze(array)


def numbers(name: str, value: object, field: type = float) -> Matrix:
    """Return a copy of `value`, which must be finite numbers, real or of `field`."""
    wanted = "real numbers" if field is float else "real numbers (or complex)"
    try:
        array, missing = entries(value, field)
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"{name} must be an array of {wanted}: {error}") from None
    if field is complex and not array.imag.any():
        array = array.real
    array = np.array(array)
    if not np.isfinite(array).all():
        where = tuple(int(k) for k in np.argwhere(~np.isfinite(array))[0])
        said = "missing" if missing[where] else array[where]
        raise ValueError(
            f"{name} has entries that are not finite: {name}{list(where)} is {said}"
        )
    return array


def entries(
    value: object, field: type = float, truth: bool = False
) -> tuple[Matrix, Matrix]:
    """Return `value` as an array of `field`, perhaps itself, and where it is missing.

    Missing is what a mask covers, None and pandas.NA; the array has NaN there.  Text
    and times are refused, though NumPy would read them as numbers, and so are truth
    values, unless `truth`.

    Raises
    ------
    TypeError, ValueError, OverflowError
        If something is not a number of that kind; it says what.
    """
    array = as_array(value)
    mask = np.ma.getmask(array)
    missing, masked = np.broadcast_to(mask, array.shape), bool(np.any(mask))
    array = np.ma.getdata(array)
    kind, allowed = array.dtype.kind, "iuf" + "c" * (field is complex) + "b" * truth
    if kind == "O":
        absent = np.frompyfunc(_missing, 2, 1)(array, allowed)
        missing = missing | np.asarray(absent, dtype=bool)
        array, masked = np.where(missing, np.nan, array), bool(np.any(missing))
    elif kind not in allowed and array.size:
        raise TypeError(f"its entries are {WORDS.get(kind, array.dtype.name)}")
    if masked:
        return np.where(missing, np.nan, array.astype(field)), missing
    return array.astype(field, copy=False), missing


def as_array(value: Any) -> np.ndarray:
    """`value` as NumPy takes it, masked if any part of it is."""
    if not _is_masked(value):
        return np.asarray(value)
    with warnings.catch_warnings():  # of a masked scalar in a list, which becomes NaN
        warnings.simplefilter("ignore", UserWarning)
        return np.ma.array(value)


def _is_masked(value: object) -> bool:
    if isinstance(value, list | tuple):
        return any(map(_is_masked, value))
    return isinstance(value, np.ma.MaskedArray)


def _missing(one: object, allowed: str) -> bool:
    """Whether an entry of an object array is missing; TypeError if it is no number."""
    if one is None or type(one).__name__ == "NAType":
        return True
    kind = np.asarray(one).dtype.kind
    if type(one).__name__ == "NaTType" or hasattr(one, "isoformat"):
        kind = "M"
    if kind not in allowed + "O":
        raise TypeError(f"among its entries are {WORDS.get(kind, type(one).__name__)}")
    return False


def zeros(name: str, shape: tuple[int, ...]) -> Matrix:
    """A default of zeros, unless sizes that come from other matrices are absurd."""
    if math.prod(shape) > LARGEST:
        size = " x ".join(map(str, shape))
        raise ValueError(
            f"{name} would be {size} zeros, by the sizes of the other matrices; give "
            f"{name} if that is meant"
        )
    return np.zeros(shape)


def freeze(value: Frozen) -> Frozen:
    """Return `value`, an array or lists, tuples and dicts of them, made read-only."""
    if isinstance(value, np.ndarray):
        value.setflags(write=False)
    elif isinstance(value, list | tuple | dict):
        for one in value.values() if isinstance(value, dict) else value:
            freeze(one)
    return value


class ReadOnly:
    """Base of frozen records whose arrays are read-only, in every copy of them too.

    A pickle and `copy.deepcopy` make new arrays, which NumPy lets anyone write to.
    Two records are equal where all their fields are, numbers to the last bit.
    """

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return _value(self) == _value(other)

    def __hash__(self) -> int:
        return hash(_value(self))

    def __setstate__(self, state: dict[str, Any]) -> None:
        self._fill(**freeze(state))

    def _fill(self, **values: object) -> None:
        """Set fields from within __post_init__."""
        for name, value in values.items():
            object.__setattr__(self, name, value)


def _value(one: Any) -> Any:
    """What can be compared and hashed of a record, an array or a container."""
    if isinstance(one, np.ndarray):
        return one.shape, one.dtype.kind, (one + 0.0).tobytes()  # -0 is 0
    if dataclasses.is_dataclass(one):
        return tuple(_value(getattr(one, x.name)) for x in dataclasses.fields(one))
    if isinstance(one, Mapping):
        return tuple((key, _value(inner)) for key, inner in one.items())
    return tuple(map(_value, one)) if isinstance(one, tuple | list) else one


def exact(value: Any) -> Matrix | None:
    """Return `value` as an object array of Fractions, or None if it has a float.

    Integers, Fractions and rationals of computer algebra (known by their integer
    attributes p and q) are exact.  Of matrices too large for exact arithmetic to end
    there are no Fractions, nor of masked ones.
    """
    try:
        array = as_array(value)
        other = array.dtype.kind in "fcMm" and array.size
        if other or array.size > EXACT or np.ma.is_masked(array):
            return None
        array = np.array(value, dtype=object)
    except ValueError:
        return None
    out = np.empty(array.shape, dtype=object)
    for index, entry in np.ndenumerate(array):
        if isinstance(entry, (Integral, Fraction)) and not isinstance(entry, bool):
            out[index] = Fraction(entry if isinstance(entry, Fraction) else int(entry))
        elif isinstance(getattr(entry, "p", None), Integral) and isinstance(
            getattr(entry, "q", None), Integral
        ):
            out[index] = Fraction(int(entry.p), int(entry.q))
        else:
            return None
    return freeze(out)


def sample_time(dt: float) -> float:
    """Return dt as a float: 0 for continuous time, else seconds per step."""
    number = isinstance(dt, (int, float, np.integer, np.floating))
    number = number and not isinstance(dt, (bool, np.timedelta64))
    least, most = sys.float_info.min, sys.float_info.max  # NumPy's refuse a long int
    if not number or not (dt == 0 or least <= dt <= most):
        raise ValueError(
            "dt must be 0 (continuous time) or a period in seconds, got " + short(dt)
        )
    return float(dt)


def whole(name: str, value: Any, least: int = 0) -> int:
    """Return `value`, a whole number of at least `least`, as an int."""
    number = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not number or isinstance(value, np.timedelta64) or value < least:
        got = short(value)
        raise ValueError(f"{name} must be a whole number >= {least}, got {got}")
    return int(value)


def names(kind: str, value: Iterable[str] | None, size: int) -> tuple[str, ...]:
    """Return `value` as a tuple of `size` different strings.

    `kind` is e.g. "x state"; its letter makes the default names x1, x2, ...
    """
    letter, _, kind = kind.partition(" ")
    if value is None:
        return tuple(f"{letter}{k + 1}" for k in range(size))
    listed = not isinstance(value, str) and np.iterable(value)
    value = tuple(value) if listed else ()
    if not listed or not all(isinstance(v, str) and v for v in value):
        raise ValueError(f"{kind} names must be a list of non-empty strings")
    if len(value) != size or len(set(value)) != size:
        raise ValueError(
            f"{kind} names must be {size} different strings, got {len(value)}: "
            f"{few(value)}"
        )
    for one in value:
        text(f"the {kind} name", one)
    return value


def text(what: str, value: object) -> str:
    """Return `value`, a line of text that can be shown as it is."""
    if not isinstance(value, str):
        raise ValueError(f"{what} must be a string, got {short(value)}")
    if found := STEERING.search(value):
        raise ValueError(
            f"{what} {short(value)} must be one line of text, without control "
            f"characters such as {found[0]!r}"
        )
    return value
