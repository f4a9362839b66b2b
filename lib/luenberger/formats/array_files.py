"""Arrays that come in parts, written to one file: .npz of NumPy, .parquet of pyarrow.

Memory holds one part.  Each file is replaced whole or not at all.
"""

import errno
import os
import shutil
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from .atomic import beside, destination

SUFFIXES = (".npz", ".parquet")
Put = Callable[[int, Mapping[str, np.ndarray]], None]  # from a first record on


def require_name(name: str, path: str | Path) -> Path:
    """The path, if its suffix is one of `SUFFIXES` and it can be in its folder.

    Raises
    ------
    ValueError
        If it has another suffix, or is a folder, a device or a pipe.
    OSError
        If there is no such folder.
    """
    found = Path(path)
    if found.suffix not in SUFFIXES:
        raise ValueError(
            f"{name} must be a function, or the path of a file that ends in .npz or "
            f".parquet, got {str(path)!r}"
        )
    target = destination(found)
    if not target.parent.is_dir():
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(path))
    return found


@contextmanager
def npz(path: str | Path, total: int) -> Iterator[Put]:
    """Write arrays of `total` records, which come in order, to a .npz file.

    It takes twice the room of the file on its disk while it is written.

    Examples
    --------
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "a.npz"
    ...     with npz(path, 3) as put:
    ...         put(0, {"x": np.array([[1.0], [2.0]])})
    ...         put(2, {"x": np.array([[3.0]])})
    ...     np.load(path)["x"].T
    array([[1., 2., 3.]])
    """
    with ExitStack() as stack:
        new = stack.enter_context(beside(path))
        folder = Path(_folder(path, new.parent))
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        files: dict[str, Any] = {}

        def put(first: int, arrays: Mapping[str, np.ndarray]) -> None:
            for name, X in arrays.items():
                if name not in files:
                    files[name] = stack.enter_context(open(folder / name, "xb"))
                    shape = (total, *X.shape[1:])
                    head = dict(descr="<f8", fortran_order=False, shape=shape)
                    np.lib.format.write_array_header_2_0(files[name], head)
                files[name].write(np.ascontiguousarray(X, dtype="<f8").data)

        yield put
        with zipfile.ZipFile(new, "x") as file:
            for name, one in files.items():
                one.close()
                file.write(folder / name, f"{name}.npy")
                (folder / name).unlink()


def _folder(path: str | Path, parent: Path) -> str:
    try:
        return tempfile.mkdtemp(prefix=".luenberger-", dir=parent)
    except OSError as error:  # the name the user knows
        raise type(error)(error.errno, error.strerror, str(path)) from None


@contextmanager
def parquet(path: str | Path, columns: Mapping[str, Sequence[str]]) -> Iterator[Put]:
    """Write arrays (records, rows, ...) as a table to a .parquet file.

    ``columns[name]`` are the names of the columns of the array called `name`; others
    are left out.  The index of the table, as pandas reads it, are the numbers of
    record and instant.

    Raises
    ------
    ImportError
        If pandas or pyarrow is not installed.
    """
    try:
        import pandas
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise ImportError(
            "a .parquet file needs pandas and pyarrow, which are not installed: "
            "pip install 'luenberger[tables]', or name a file that ends in .npz"
        ) from None
    labels = [label for one in columns.values() for label in one]
    if len(set(labels)) < len(labels):
        twice = next(label for label in labels if labels.count(label) > 1)
        raise ValueError(f"{twice!r} would be the name of two columns; rename a state")
    with ExitStack() as stack:
        new, writers = stack.enter_context(beside(path)), list[Any]()

        def put(first: int, arrays: Mapping[str, np.ndarray]) -> None:
            parts = [arrays[name] for name in columns]
            records, rows = parts[0].shape[:2]
            table = np.concatenate([X.reshape(records * rows, -1) for X in parts], 1)
            numbers = range(first, first + records), range(1, rows + 1)
            index = pandas.MultiIndex.from_product(numbers, names=["record", "instant"])
            frame = pandas.DataFrame(table, index, labels)
            found = pyarrow.Table.from_pandas(frame)
            if not writers:
                writer = pyarrow.parquet.ParquetWriter(new, found.schema)
                writers.append(stack.enter_context(writer))
            writers[0].write_table(found)

        yield put
