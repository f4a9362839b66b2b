"""Texts that are written for a plant: compiled, and kept for the next process.

A text lies in a folder of the user's under a hash of itself, with numba's files beside
it.  A file whose text differs from what is wanted is written anew, so a folder that is
old, shared or damaged costs time and nothing else.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

from .compiling import WAYS


def folder() -> Path | None:
    """Where texts are kept: the user's cache; None if it cannot be written."""
    home = os.environ.get("LUENBERGER_CACHE") or os.environ.get("XDG_CACHE_HOME")
    if home is None and os.name == "nt":
        home = os.environ.get("LOCALAPPDATA")
    with contextlib.suppress(OSError, RuntimeError):
        path = Path(home) if home else Path.home() / ".cache"
        path = path / "luenberger" / f"{sys.implementation.cache_tag}"
        path.mkdir(parents=True, exist_ok=True, mode=0o700)
        if os.access(path, os.W_OK) and _own(path):
            return path
    return None


def _own(path: Path) -> bool:
    """Whether nobody else can write there."""
    if os.name == "nt":
        return True
    state = path.stat()
    return state.st_uid == os.getuid() and not state.st_mode & 0o022


_loaded: dict[str, Callable] = {}


def function(name: str, text: str) -> Callable:
    """The function of a text, compiled by numba."""
    key = _key(text)
    if key not in _loaded:
        _loaded[key] = _compiled(name, text, key)
    return _loaded[key]


@cache
def _key(text: str) -> str:
    import numba

    said = "\n".join([text, numba.__version__, repr(sorted(WAYS.items()))])
    return "text_" + hashlib.sha256(said.encode()).hexdigest()[:32]


def _compiled(name: str, text: str, key: str) -> Callable:
    import numba

    where = folder()
    if where is None:
        names: dict[str, Any] = {}
        exec(compile(text, f"<{key}>", "exec"), names)
        ways = {way: on for way, on in WAYS.items() if way != "cache"}
        return numba.njit(**ways)(names[name])  # type: ignore[no-any-return]
    path = where / f"{key}.py"
    if not path.is_file() or path.read_text("utf-8") != text:
        with tempfile.NamedTemporaryFile(
            "w", dir=where, suffix=".tmp", delete=False, encoding="utf-8"
        ) as file:
            file.write(text)
        os.replace(file.name, path)
    spec = spec_from_file_location(key, path)
    assert spec is not None and spec.loader is not None
    module = sys.modules[key] = module_from_spec(spec)  # numba looks there
    spec.loader.exec_module(module)
    return numba.njit(**WAYS)(getattr(module, name))  # type: ignore[no-any-return]


def installed() -> bool:
    """Whether there is a compiler."""
    return find_spec("numba") is not None
