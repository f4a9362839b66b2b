"""Keep what is generated for the next process: texts, and what numba makes of them.

A text lies in a folder of the user's as ``derived_QUESTION.txt``.  QUESTION is a hash
of what was asked, of the sources that derive and print, and of the versions they need;
the first line of the file is a hash of all that follows and of QUESTION.  What numba
compiles lies there as ``luenberger_KEY.py``, KEY a hash of its text and of every
version that matters, and numba's files beside it, with their hashes.

A file is used only if it is a plain file in a folder where nobody else can write, and
has the hash that goes with it.  So one that is broken, cut short, edited, renamed, or
of another version or question is noticed and made anew.  That keeps out accidents and
other users.  It does not keep out a program that runs as this user and makes the
hashes fit; it could change this library as well.  A folder that cannot be used costs
the time of deriving and compiling, nothing else.
"""

import contextlib
import hashlib
import inspect
import json
import os
import stat
import sys
import tempfile
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from . import making, stack
from .making import FASTMATH, OPTIONS, WRITING, Way

PACKAGE = Path(__file__).parents[1]
DERIVING = ("symbolic", "papers/*/derivation", "*/derivation", "kernels")
DERIVING += ("stage_list.py", "certificate.py", "errors.py", "numeric/linalg.py")


class CacheWarning(UserWarning):
    """What is generated is not kept: only time is lost."""


def derived(question: object, make: Callable[[], tuple[str, Any]]) -> tuple[str, Any]:
    """What ``make()`` returns, (text, arguments), or what it returned before.

    The repr of `question` says what it hangs on apart from the sources; `arguments`
    are anything that JSON gives back as it was.
    """
    name, folder = asked(question), usable_folder()
    path = folder and name and folder / f"derived_{name}.txt"
    found = path and recall(path, name)
    if found:
        return found
    text, arguments = make()
    if path:
        note = json.dumps([text, arguments])
        try:
            replace(path, f"{_seal(name, note)}\n{note}")
        except OSError as error:
            said = f"a derivation is not kept: {error}"
            warnings.warn(said, CacheWarning, stacklevel=2)
    return text, arguments


def keeps(question: object) -> bool:
    """Whether the folder has machine code of the text that answers a question."""
    name, folder = asked(question), usable_folder()
    if not (name and folder):
        return False
    found = recall(folder / f"derived_{name}.txt", name)
    if not found:
        return False
    text, types = found
    stem = f"luenberger_{key(text, tuple(types.values()))}"
    return (folder / f"{stem}.sha256").is_file()


def recall(path: Path, name: str) -> tuple[str, Any] | None:
    """What a file says, or None if it does not say that it answers this question."""
    try:
        if not ours(path):
            return None
        seal, _, note = path.read_bytes().decode().partition("\n")
        return json.loads(note) if seal == _seal(name, note) else None
    except (OSError, ValueError):  # not there, or no text
        return None


def _seal(name: str, note: str) -> str:
    return hashlib.sha256(f"{name}\n{note}".encode()).hexdigest()


def asked(question: object) -> str | None:
    """A name for a question to this version of the library; None if it has no files."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        parts = repr(question), sources(), version("sympy"), np.__version__, sys.version
    except (OSError, PackageNotFoundError):
        return None
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:32]


@cache
def sources() -> str:
    """A hash of the files that a derived text comes from."""
    found = hashlib.sha256()
    for part in DERIVING:
        for one in sorted(PACKAGE.glob(part)) or [PACKAGE / part]:
            for path in sorted(one.rglob("*.py")) if one.is_dir() else [one]:
                name = path.relative_to(PACKAGE).as_posix()
                found.update(f"{name}\0".encode() + path.read_bytes())
    return found.hexdigest()


@cache
def compiled(text: str, types: tuple[str, ...], exact: bool = False) -> Any:
    """The function `run` of a generated module, compiled for arguments of `types`.

    `types` names them as numba does, e.g. ("i8", "f8[::1]").  What is `exact` is
    computed in the order of the text, else as `FASTMATH` allows.
    """
    from numba import config as numba_config

    config: Any = numba_config

    if config.DISABLE_JIT:
        return making.function(Way(text, stack.plain()), "luenberger_uncompiled")
    with contextlib.suppress(making.Unknown):
        return _made(text, types, exact, making.soon(text))
    return _made(text, types, exact, Way(text, stack.ours()))


def _made(text: str, types: tuple[str, ...], exact: bool, way: Way) -> Any:
    """The function, one way, from the folder if it can be."""
    folder = usable_folder()
    if folder is not None:
        try:
            return _from_folder(folder, text, types, exact, way)
        except making.Unknown:
            raise
        except (
            Exception
        ) as error:  # of numba's files or of the disk: not our arithmetic
            said = f"compiled code is not kept: {error}"
            warnings.warn(said, CacheWarning, stacklevel=2)
    function = making.function(way, f"luenberger_{key(text, types, exact)}")
    return _settled(making.jit(function, exact), types)


def folder() -> Path:
    """Where code is kept: LUENBERGER_CACHE, or the platform's place for it."""
    if named := os.environ.get("LUENBERGER_CACHE"):
        return Path(named)
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local"
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "luenberger"


def usable_folder() -> Path | None:
    """The folder, made if need be; None if it cannot be written, or not trusted."""
    try:
        path = folder()
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not private(path):
            warnings.warn(
                f"{path} belongs to somebody else or can be written by others, so "
                "generated code is neither read from it nor kept in it. Take their "
                "write permission away, or set LUENBERGER_CACHE to a folder of yours.",
                CacheWarning,
                stacklevel=1,  # one place, so that Python says it once
            )
            return None
        with tempfile.TemporaryFile(dir=path):
            return path
    except (OSError, RuntimeError):  # RuntimeError: there is no home folder
        return None


def private(path: Path) -> bool:
    """Whether only this user can write there, as far as the platform tells."""
    if not hasattr(os, "getuid"):
        return True
    found = os.stat(path)
    return found.st_uid == os.getuid() and not found.st_mode & 0o022


def ours(path: Path) -> bool:
    """Whether this is a plain file that nobody else can write to."""
    return stat.S_ISREG(os.lstat(path).st_mode) and private(path)


def _settled(run: Any, types: tuple[str, ...]) -> Any:
    """A numba function for exactly these types."""
    from numba.core import types as known

    array: dict[str, Any] = {"f8[::1]": known.float64[::1], "i8[::1]": known.int64[::1]}
    array |= {"f8[:,::1]": known.float64[:, ::1], "b1[::1]": known.boolean[::1]}
    array |= {"i8": known.int64, "b1": known.boolean}
    run.compile(tuple(array[name] for name in types))
    run.disable_compile()
    return run


def _from_folder(
    folder: Path, text: str, types: tuple[str, ...], exact: bool, way: Way
) -> Any:
    path = folder / f"luenberger_{key(text, types, exact)}.py"
    if not _says(path, text):
        replace(path, text)
    run = making.jit(making.function(way, str(path)), exact, cache=True)
    beside = Path(run.stats.cache_path)
    written = path.with_suffix(".sha256")
    kept = hashes(beside, path.stem)
    trusted = kept is not None and _says(written, kept)
    if not trusted:
        if beside.parent == folder:  # and not a place that numba was told to use
            _close(beside)
        for old in _files(beside, path.stem):
            old.unlink()
    run = _settled(run, types)
    if not trusted:
        for new in _files(beside, path.stem):
            _close(new)
    made = hashes(beside, path.stem)
    if made is not None and not (trusted and made == kept):
        replace(written, made)
    return run


def _close(path: Path) -> None:
    """Take from others the right to write that a loose umask gave them."""
    with contextlib.suppress(OSError):  # of somebody else's, which `private` notices
        path.chmod(path.stat().st_mode & ~0o022)


def _says(path: Path, text: str) -> bool:
    """Whether a file of ours holds this text; bytes, as a broken one need not."""
    return path.is_file() and ours(path) and path.read_bytes() == text.encode()


def key(text: str, types: tuple[str, ...], exact: bool = False) -> str:
    """A name for a text, its types, and whatever the machine code depends on."""
    import numba

    versions = numba.__version__, sys.version, sys.platform
    options = (f"{name} {one}" for name, one in OPTIONS.items() if name != "fastmath")
    parts = text, *types, *versions, *(() if exact else FASTMATH), *options
    parts += tuple(map(inspect.getsource, WRITING))
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:32]


def _files(beside: Path, stem: str) -> list[Path]:
    return sorted(p for p in beside.glob(f"{stem}.*") if p.suffix in (".nbi", ".nbc"))


def hashes(beside: Path, stem: str) -> str | None:
    """Names and hashes of numba's files for a module; None if not ours alone."""
    if not beside.is_dir() or not private(beside):
        return None
    lines = []
    for path in _files(beside, stem):
        if not ours(path):
            return None
        lines.append(f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n")
    return "".join(lines)


def replace(path: Path, text: str) -> None:
    """Write a file in one go, so that nobody reads half of it."""
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=".making-")
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="") as file:
            file.write(text)
        os.replace(name, path)
    except OSError:
        os.unlink(name)
        raise
