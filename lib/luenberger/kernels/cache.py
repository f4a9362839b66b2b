"""Keep what numba makes of the texts of recursions, beside the texts that are `kept`.

A text lies in the same folder as ``luenberger_KEY.py``, KEY a hash of it and of every
version that matters, and numba's files beside it, with their hashes.  What is not ours
or has another hash is made anew.
"""

import contextlib
import hashlib
import inspect
import sys
import warnings
from functools import cache
from pathlib import Path
from typing import Any

from . import making, stack
from .kept import CacheWarning as CacheWarning
from .kept import derived as derived
from .kept import ours, private, replace, usable_folder
from .making import FASTMATH, OPTIONS, WRITING, Way


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
