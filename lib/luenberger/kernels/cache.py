"""Compile generated Python with numba, and keep the machine code from run to run.

A generated module lies in a folder of the user's as ``luenberger_KEY.py``, KEY a hash
of its text and of every version that matters, and numba's files for it beside it.
What runs is the text made here, never the text of the file, and numba's files are
used only if their hashes are those written down when they were made and nobody else
can write there.  Whatever is not as it should be is made anew; a folder that cannot
be used costs the time of compiling, nothing else.
"""

import hashlib
import inspect
import os
import stat
import sys
import tempfile
import warnings
from functools import cache
from pathlib import Path
from types import ModuleType

import numpy as np

from . import stack

FASTMATH = ("contract", "reassoc")  # sums may be taken in another order, NaNs count
OPTIONS = dict(error_model="numpy", fastmath=set(FASTMATH))


@cache
def compiled(text, types):
    """The function `run` of a generated module, compiled for arguments of `types`.

    `types` names them as numba does, e.g. ("i8", "f8[::1]").
    """
    from numba import config

    if config.DISABLE_JIT:
        return _function(text, "luenberger_uncompiled", np.empty)
    folder = usable_folder()
    if folder is not None:
        try:
            return _from_folder(folder, text, types)
        except (
            Exception
        ) as error:  # of numba's files or of the disk: not our arithmetic
            warnings.warn(f"compiled code is not kept: {error}", stacklevel=2)
    name = f"luenberger_{key(text, types)}"
    return _compile(_function(text, name, stack.local_array()), types)


def folder():
    """Where compiled code is kept: LUENBERGER_CACHE, or the platform's place for it."""
    if named := os.environ.get("LUENBERGER_CACHE"):
        return Path(named)
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local"
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "luenberger"


def usable_folder():
    """The folder, made if need be; None if it cannot be written, or not trusted."""
    try:
        path = folder()
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not private(path):
            warnings.warn(
                f"{path} belongs to somebody else or can be written by others, so "
                "compiled code is neither read from it nor kept in it. Take their "
                "write permission away, or set LUENBERGER_CACHE to a folder of yours.",
                stacklevel=2,
            )
            return None
        with tempfile.TemporaryFile(dir=path):
            return path
    except (OSError, RuntimeError):  # RuntimeError: there is no home folder
        return None


def private(path):
    """Whether only this user can write there, as far as the platform tells."""
    if not hasattr(os, "getuid"):
        return True
    found = os.stat(path)
    return found.st_uid == os.getuid() and not found.st_mode & 0o022


def _function(text, path, array):
    """`run` of a module made of `text`, as if it came from `path`.

    The text calls `array` for its arrays.  The module is entered by its name, because
    numba asks for it by name when it reads its files.
    """
    module = ModuleType(Path(path).stem)
    sys.modules[module.__name__] = module
    module.array = array
    exec(compile(text, path, "exec"), module.__dict__)  # text made here, from symbols
    return module.run


def _compile(function, types, **options):
    """A numba function for exactly these types."""
    import numba

    run = numba.njit(**OPTIONS, **options)(function)
    if options:
        return run
    return _settled(run, types)


def _settled(run, types):
    from numba.core import types as known

    array = {"f8[::1]": known.float64[::1], "i8[::1]": known.int64[::1]}
    array |= {"f8[:,::1]": known.float64[:, ::1], "b1[::1]": known.boolean[::1]}
    array |= {"i8": known.int64, "b1": known.boolean}
    run.compile(tuple(array[name] for name in types))
    run.disable_compile()
    return run


def _from_folder(folder, text, types):
    path = folder / f"luenberger_{key(text, types)}.py"
    if not _says(path, text):
        replace(path, text)
    function = _function(text, str(path), stack.local_array())
    run = _compile(function, types, cache=True)
    beside = Path(run.stats.cache_path)
    written = path.with_suffix(".sha256")
    kept = hashes(beside, path.stem)
    trusted = kept is not None and _says(written, kept)
    if not trusted:
        for old in _files(beside, path.stem):
            old.unlink()
    run = _settled(run, types)
    made = hashes(beside, path.stem)
    if made is not None and not (trusted and made == kept):
        replace(written, made)
    return run


def _says(path, text):
    """Whether a file holds this text; bytes, as a broken one need not be text."""
    return path.is_file() and path.read_bytes() == text.encode()


def key(text, types):
    """A name for a text, its types, and whatever the machine code depends on."""
    import numba

    versions = numba.__version__, sys.version, sys.platform
    parts = text, *types, *versions, *FASTMATH, inspect.getsource(stack)
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:32]


def _files(beside, stem):
    return sorted(p for p in beside.glob(f"{stem}.*") if p.suffix in (".nbi", ".nbc"))


def hashes(beside, stem):
    """Names and hashes of numba's files for a module; None if not ours alone."""
    if not beside.is_dir() or not private(beside):
        return None
    lines = []
    for path in _files(beside, stem):
        if not stat.S_ISREG(os.lstat(path).st_mode) or not private(path):
            return None
        lines.append(f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n")
    return "".join(lines)


def replace(path, text):
    """Write a file in one go, so that nobody reads half of it."""
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=".making-")
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="") as file:
            file.write(text)
        os.replace(name, path)
    except OSError:
        os.unlink(name)
        raise
