"""Keep derived texts for the next process, which then needs no SymPy to run them.

A text lies in a folder of the user's as ``derived_QUESTION.txt``.  QUESTION is a hash
of what was asked, of the sources that derive and print, and of the versions they need;
the first line of the file is a hash of all that follows and of QUESTION.

A file is used only if it is a plain file in a folder where nobody else can write, and
has the hash that goes with it.  So one that is broken, cut short, edited, renamed, or
of another version or question is noticed and made anew.  That keeps out accidents and
other users.  It does not keep out a program that runs as this user and makes the
hashes fit; it could change this library as well.  A folder that cannot be used costs
the time of deriving, nothing else.
"""

import hashlib
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

HOME = Path(__file__).parents[2]  # of this package and of `matrixproof`
DERIVING = "papers/*/derivation", "*/derivation", "kernels"
DERIVING += "stage_list.py", "certificate.py", "errors.py", "numeric/linalg.py"
DERIVING = ("matrixproof", *(f"luenberger/{part}" for part in DERIVING))


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
        for one in sorted(HOME.glob(part)) or [HOME / part]:
            for path in sorted(one.rglob("*.py")) if one.is_dir() else [one]:
                name = path.relative_to(HOME).as_posix()
                found.update(f"{name}\0".encode() + path.read_bytes())
    return found.hexdigest()


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
