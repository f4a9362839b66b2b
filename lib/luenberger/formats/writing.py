"""Files written beside and renamed: a reader, or a crash, finds the old or the new."""

import contextlib
import os
import secrets
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TextIO


@contextlib.contextmanager
def replacing(path: str | Path) -> Iterator[TextIO]:
    """A new text file, which takes the place of `path` if the block ends well.

    UTF-8 with the line ends that are written, so that every machine writes the same.
    A link is followed, and an old file keeps its permissions.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with replacing(Path(folder) / "a.txt") as file:
    ...         print("one", file=file)
    ...     [path.name for path in Path(folder).iterdir()]
    ['a.txt']
    """
    target = require_file(path)
    new = target.with_name(f".luenberger-{secrets.token_hex(8)}")
    try:
        with open(new, "x", encoding="utf-8", newline="") as file:
            yield file
        if target.exists():
            shutil.copymode(target, new)
        os.replace(new, target)
    except BaseException as error:
        with contextlib.suppress(OSError):
            new.unlink()
        if isinstance(error, OSError) and error.errno:
            error.filename = str(path)  # as the user knows it, or of a full disk
        raise


def require_file(path: str | Path) -> Path:
    """The file that `path` names, links followed; ValueError if it is something else.

    It need not be there, and its folder need.
    """
    target = Path(os.path.realpath(path))
    if target.exists() and not target.is_file():
        what = "a folder" if target.is_dir() else "a device or a pipe"
        raise ValueError(f"{path} is {what}; name a file")
    if not target.parent.is_dir():
        raise ValueError(f"{path}: there is no folder {target.parent}; make it first")
    return target


def write(path: str | Path, text: str) -> None:
    """Write `text` to `path`, or leave what was there; see `replacing`."""
    with replacing(path) as file:
        file.write(text)


def require_folder(folder: str | Path) -> None:
    """Raise ValueError if a folder cannot be made there, as a file is in the way."""
    for here in (Path(folder), *Path(folder).absolute().parents):
        if here.is_dir():
            return
        if here.exists():
            raise ValueError(f"{here} is a file; a folder is needed")


def write_all(folder: str | Path, texts: Mapping[str, str]) -> list[Path]:
    """Write the files of `texts`, by name, into a folder, which is made; their paths.

    All are written before the first takes its place.
    """
    require_folder(folder)
    Path(folder).mkdir(parents=True, exist_ok=True)
    with contextlib.ExitStack() as stack:
        for name, text in texts.items():
            stack.enter_context(replacing(Path(folder, name))).write(text)
    return [Path(folder, name) for name in texts]
