"""Files that a user names: plain ones only, and JSON only as finite plain data."""

import contextlib
import json
import math
import os
import stat
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

from ..errors import short

MIB = 1 << 20
LARGEST = 64  # MiB of a JSON file
DEEPEST = 5  # lists within lists: pairs of matrices are the deepest that is written
DIGITS = 300  # a longer whole number is read as a float: infinite from 1e309
WORDS = {True: "true", False: "false", None: "null"}
OTHERS = {
    stat.S_ISDIR: "a folder",
    stat.S_ISFIFO: "a pipe",
    stat.S_ISCHR: "a device",
    stat.S_ISBLK: "a device",
    stat.S_ISSOCK: "a socket",
}


def opened(path: str | Path) -> BinaryIO:
    """Open a plain file for reading bytes.

    A pipe may wait for a writer that never comes, and a device may never end.

    Raises
    ------
    ValueError
        If the path leads to something else than a plain file.
    """
    file = open(path, "rb", opener=_at_once)
    mode = os.fstat(file.fileno()).st_mode
    if not stat.S_ISREG(mode):
        file.close()
        kind = next((kind for test, kind in OTHERS.items() if test(mode)), "no file")
        raise ValueError(f"{path}: this is {kind}; a plain file is needed")
    return file


@contextlib.contextmanager
def named(path: str | Path) -> Iterator[None]:
    """An error of reading or writing says which file it is of."""
    try:
        yield
    except OSError as error:
        if error.errno and not error.filename:
            error.filename = str(path)
        raise


def _at_once(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


@dataclass(frozen=True)
class JsonFile:
    """A JSON file that was read: its path, its bytes, and the object in it."""

    path: str | Path
    content: bytes
    data: dict[str, Any]


def json_file(path: str | Path | JsonFile, what: str) -> JsonFile:
    """Read the object in a JSON file; `require_plain` is for its entries.

    Parameters
    ----------
    path : str, Path or JsonFile
        One that was read already is returned as it is.
    what : str
        What the file should hold, for messages.

    Raises
    ------
    ValueError
        If the file is not a plain one, too large, not JSON, nested too deeply, or a
        key occurs twice.
    """
    if isinstance(path, JsonFile):
        return path
    with opened(path) as file, named(path):
        content = file.read(LARGEST * MIB + 1)
    if len(content) > LARGEST * MIB:
        raise ValueError(f"{path}: the file is larger than {LARGEST} MiB")
    try:
        text = content.decode("utf-8-sig")
        data = json.loads(text, object_pairs_hook=_distinct, parse_int=_whole)
    except RecursionError:
        raise ValueError(f"{path}: not a JSON file: nested too deeply") from None
    except (UnicodeDecodeError, json.JSONDecodeError) as error:
        raise ValueError(f"{path}: not a JSON file: {error}") from None
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    if not isinstance(data, dict):
        raise ValueError(f"{path}: {what} is a JSON object, got {type(data).__name__}")
    return JsonFile(path, content, data)


def _distinct(pairs: list[tuple[str, object]]) -> dict[str, object]:
    found = dict(pairs)
    if len(found) < len(pairs):
        (twice, _), *_ = Counter(key for key, _ in pairs).most_common(1)
        raise ValueError(f"the key {short(twice)} occurs more than once")
    return found


def _whole(digits: str) -> float:
    return int(digits) if len(digits) <= DIGITS else float(digits)


def require_plain(at: str, value: object) -> None:
    """Raise unless everything within is text, a finite number, a list or an object.

    NumPy would take true for 1 and null for NaN.
    """
    level = [value]
    for _ in range(DEEPEST):
        for one in level:
            if one is None or isinstance(one, bool):
                raise ValueError(f"{at} holds {WORDS[one]}, which is not a number")
            if isinstance(one, float) and not math.isfinite(one):
                what = "NaN" if math.isnan(one) else "one is beyond 1.8e308"
                raise ValueError(f"{at} has entries that are not finite: {what}")
        level = [
            inner
            for one in level
            if isinstance(one, list | dict)
            for inner in (one.values() if isinstance(one, dict) else one)
        ]
    if level:
        raise ValueError(f"{at} is nested too deeply")
