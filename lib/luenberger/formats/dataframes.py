"""Tables in and out of `estimate` and `Record`: those of pandas, by name.

pandas is not imported for its own tables: a caller who passes one has done so.  Those
of other libraries become tables of pandas, which finds columns by name.
"""

import sys
from collections.abc import Iterable, Sequence
from typing import Any, TypeGuard

import numpy as np

Names = Sequence[str] | None  # of signals
SHOWN = 8  # column names in a message


def taken(**given: Any) -> tuple[Any, ...]:
    """What a user gives, tables of other libraries than pandas as those of pandas.

    NumPy would take the columns of such a table by position.  Tables in a list are
    taken in the same way.

    Raises
    ------
    ValueError
        If such a table cannot be made one of pandas; it says what to give instead.
    """
    return tuple(_taken(name, value) for name, value in given.items())


def _taken(name: str, value: Any) -> Any:
    if value is None or type(value) is np.ndarray:
        return value
    if isinstance(value, list | tuple):
        kinds = {type(one) for one in value}
        if any(map(_foreign, kinds)):
            return [_taken(f"{name}[{k}]", one) for k, one in enumerate(value)]
        return value
    return _as_pandas(name, value) if _foreign(type(value)) else value


def _foreign(kind: type) -> bool:
    """Whether values of this type are tables, but not of pandas."""
    said = any(hasattr(kind, one) for one in ("to_pandas", "columns", "__dataframe__"))
    pandas = sys.modules.get("pandas")
    ours = pandas is not None and issubclass(kind, pandas.DataFrame | pandas.Series)
    return said and not ours


def _as_pandas(name: str, value: Any) -> Any:
    """A table of another library as one of pandas, or as an array without names."""
    library = type(value).__module__.partition(".")[0]
    what = f"{name} is a {type(value).__name__} of {library}"
    dims = list(getattr(value, "sizes", ()))  # of xarray
    if (
        getattr(value, "ndim", 0) > 2 and dims
    ):  # many records, which pandas has no table for
        if dims[-1] not in value.indexes:
            return value.values
        raise ValueError(
            f"{what} of {len(dims)} dimensions, and many records are taken by "
            f"position: give {name}.sel({dims[-1]}=[...]).values, with the plant's "
            "names in their order"
        )
    try:
        import pandas

        if library == "polars":  # its own to_pandas needs pyarrow
            names = getattr(value, "columns", None)
            if names is None:
                return value.to_numpy()  # a Series, the one channel
            return pandas.DataFrame({one: value[one].to_numpy() for one in names})
        found = value.to_pandas()
    except (AttributeError, ImportError, TypeError, ValueError) as error:
        raise ValueError(
            f"{what}, which does not become a table of pandas ({error}). Give a pandas "
            "DataFrame, whose columns are found by name, or an array with the columns "
            "in the order of the plant's signals."
        ) from None
    if dims and dims[0] not in value.indexes:
        found.index.name = None  # these number the rows; they are no times
    return found


def arrays(y: Any, u: Any, outputs: Names, inputs: Names) -> tuple[Any, Any]:
    """Return y and u as arrays; the columns of a table are found by name.

    Without u, the columns of y's DataFrame that are named as inputs are it.
    """
    y, u = taken(y=y, u=u)
    within = u is None and _is("DataFrame", y) and bool(inputs)
    if within:
        shared = sorted(set(inputs or ()) & set(outputs or ()))
        if shared:
            raise ValueError(
                f"an input and an output are both called {shared[0]!r}, so one table "
                "cannot hold both. Pass u as well, or rename one."
            )
        u = y
    if is_table(y) and is_table(u) and not y.index.equals(u.index):
        raise ValueError(
            "y and u are tables with different rows; give both the same index"
        )
    return _numbers("y", y, outputs), _numbers("y" if within else "u", u, inputs)


def ordered(name: str, value: Any, wanted: Sequence[str]) -> Any:
    """The columns `wanted` of a table, in that order; anything else as it is."""
    value = _taken(name, value)
    return _columns(name, value, wanted) if _is("DataFrame", value) else value


def like(table: Any, values: np.ndarray, names: Sequence[str]) -> Any:
    """`values` as a DataFrame with the index of `table`, if that is a table."""
    return framed(values, names, table.index if is_table(table) else None)


def note(table: Any, **said: Any) -> None:
    """Say something of a table in its `attrs`, if it is one."""
    if is_table(table):
        table.attrs.update(said)


def framed(values: np.ndarray, names: Sequence[str], index: Any) -> Any:
    """`values` as a DataFrame with an index, if there is one."""
    if index is None:
        return values
    frame = sys.modules["pandas"].DataFrame
    return frame(values, index=index, columns=list(names))


def joined(index: Any, table: Any) -> Any:
    """An index, or None, and then that of a table, if it is one."""
    if not is_table(table):
        return index
    return table.index if index is None else index.append(table.index)


def entries(name: str, value: Any, labels: Names) -> Any:
    """One value per signal; those of a labelled Series are found by name."""
    value = _taken(name, value)
    if not _is("Series", value) or list(value.index) == list(range(len(value))):
        return value
    if labels is None or sorted(map(str, value.index)) != sorted(labels):
        wanted = "nothing has names here" if labels is None else f"not {list(labels)}"
        raise ValueError(
            f"{name} is a Series with the labels {_few(value.index)}, {wanted}"
        )
    return _numbers(name, value[list(labels)], None)


def is_table(value: object) -> TypeGuard[Any]:
    """Whether it is a DataFrame or a Series."""
    return _is("DataFrame", value) or _is("Series", value)


def column(name: str, frame: Any, label: object) -> Any:
    """The column of that label of a DataFrame called `name`."""
    return _columns(name, frame, [label])[label]


def moments(name: str, values: Any) -> tuple[np.ndarray, np.ndarray, str]:
    """An index or a column of numbers or times as numbers that keep their order.

    Returns the numbers, where one is missing, and what they are: "numbers", "times" or
    "times with a zone".
    """
    pandas, missing = sys.modules["pandas"], np.asarray(values.isna())
    if getattr(values.dtype, "kind", "O") in "biuf":
        found = pandas.Series(values).to_numpy(dtype=float, na_value=np.nan)
        return found, missing, "numbers"
    if pandas.api.types.is_datetime64_any_dtype(values.dtype):
        index = pandas.DatetimeIndex(values)
        what = "times" if index.tz is None else "times with a zone"
        return index.as_unit("ns").asi8, missing, what
    raise ValueError(
        f"{name} holds {values.dtype}, not numbers or times; convert it first, for "
        "example with pandas.to_datetime"
    )


def digit(values: Any) -> float:
    """What the last digit of times is worth, in nanoseconds; 0 of numbers."""
    pandas = sys.modules["pandas"]
    if not pandas.api.types.is_datetime64_any_dtype(values.dtype):
        return 0.0
    return float(pandas.Timedelta(1, pandas.DatetimeIndex(values[:0]).unit).value)


def _is(kind: str, value: object) -> bool:
    pandas = sys.modules.get("pandas")
    return pandas is not None and isinstance(value, getattr(pandas, kind))


def _numbers(name: str, value: Any, wanted: Names) -> Any:
    if not is_table(value):
        return value
    if _is("DataFrame", value) and wanted is not None:
        value = _columns(name, value, wanted)
    types = [value.dtype] if _is("Series", value) else list(value.dtypes)
    labels = [value.name] if _is("Series", value) else list(value.columns)
    for label, dtype in zip(labels, types):
        if getattr(dtype, "kind", "O") not in "biuf":
            raise ValueError(
                f"the column {label!r} of {name} holds {dtype}, not real numbers; "
                "convert it first, for example with pandas.to_numeric"
            )
    found = value.to_numpy(dtype=float, na_value=np.nan)
    return np.ascontiguousarray(found)


def _columns(name: str, frame: Any, wanted: Sequence[Any]) -> Any:
    """The columns `wanted`, in that order, of a DataFrame that may have more."""
    if frame.columns.nlevels > 1:
        raise ValueError(
            f"{name} has columns of several levels; give them one name each"
        )
    missing = [one for one in wanted if one not in frame.columns]
    if missing:
        raise ValueError(
            f"{name} has no column {missing[0]!r}; it has {_few(frame.columns)}. "
            "Columns are found by the names of the plant's signals: rename them, name "
            "the plant's, or pass an array; u=0 says that no known input acts."
        )
    found = frame[list(wanted)]
    if found.shape[1] != len(wanted):
        twice = next(one for one in wanted if list(frame.columns).count(one) > 1)
        raise ValueError(f"{name} has more than one column {twice!r}")
    return found


def _few(labels: Iterable[object]) -> str:
    labels = list(labels)
    more = f" and {len(labels) - SHOWN} more" if len(labels) > SHOWN else ""
    return f"{labels[:SHOWN]}{more}"
