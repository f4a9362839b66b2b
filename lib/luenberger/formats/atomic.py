"""Files written beside and renamed: a reader, or a crash, finds the old or the new.

A path that is a symbolic link is followed, as `open` does: the link stays and what it
points to is replaced.  An existing file keeps its permissions.  A run that is killed
outright may leave a file `.luenberger-...` beside; nothing ever reads it.
"""

import contextlib
import errno
import os
import secrets
import shutil
import signal
import tempfile
import threading
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TextIO

from .folder_lock import alone_in

SIGNALS = [
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP")
    if hasattr(signal, name)
]


@contextlib.contextmanager
def replacing(path: str | Path) -> Iterator[TextIO]:
    """A new text file, which takes the place of `path` if the block ends well.

    UTF-8 with the line ends that are written, so that every machine writes the same.

    Raises
    ------
    ValueError
        If `path` is a folder, a device or a pipe.
    OSError
        If it cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with replacing(Path(folder) / "a.txt") as file:
    ...         print("one", file=file)
    ...     [path.name for path in Path(folder).iterdir()]
    ['a.txt']
    """
    with beside(path) as new:
        try:
            file = open(new, "x", encoding="utf-8", newline="")
        except OSError as error:  # the name the user knows
            raise type(error)(error.errno, error.strerror, str(path)) from None
        with file:
            yield file
            file.flush()


@contextlib.contextmanager
def beside(path: str | Path) -> Iterator[Path]:
    """A path for a new file, which takes the place of `path` if the block ends well.

    Raises
    ------
    ValueError, OSError
        As `replacing`.
    """
    target = destination(path)
    new = target.with_name(f".luenberger-{secrets.token_hex(8)}")
    try:
        yield new
        _move(new, target)
    except BaseException as error:
        if isinstance(error, OSError) and error.errno and not error.filename:
            error.filename = str(path)  # of a full disk, which says no more
        with contextlib.suppress(OSError):  # what went wrong first is what is said
            new.unlink()
        raise


def write(path: str | Path, text: str) -> None:
    """Write `text` to `path`, or leave what was there; see `replacing`."""
    with replacing(path) as file:
        file.write(text)


def write_all(folder: str | Path, texts: Mapping[str, str]) -> list[Path]:
    """Write the files of `texts`, by name, into `folder`, all or none of them.

    Returns their paths.  The folder is made if it is not there.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    beside = Path(tempfile.mkdtemp(prefix=".luenberger-", dir=folder))
    try:
        for name, text in texts.items():
            (beside / name).write_bytes(text.encode("utf-8"))
        moves = {beside / name: folder / name for name in texts}
        replace_all(moves, beside)
    finally:
        shutil.rmtree(beside, ignore_errors=True)
    return list(moves.values())


def replace_all(
    moves: Mapping[Path, str | Path], beside: Path, gone: Iterable[Path] = ()
) -> None:
    """Rename each file to its path, in order; {finished: path}.

    If a rename fails, what was there before is put back.  Signals wait until it is
    done: there is no point at which some files are new and others old, but for a kill.
    Another process that replaces files in these folders waits as well, so all files
    are those of one.  `beside` is a folder for copies of the old files, and the files
    `gone` do not stay beside the new ones.
    """
    targets = {finished: destination(path) for finished, path in moves.items()}
    with contextlib.ExitStack() as stack:
        # in one order, so that no two wait for each other
        for folder in sorted({target.parent for target in targets.values()}):
            stack.enter_context(alone_in(folder))
        _replace(targets, beside)
        for path in gone:
            path.unlink(missing_ok=True)


def _replace(targets: Mapping[Path, Path], beside: Path) -> None:
    kept = {}
    for k, target in enumerate(targets.values()):
        if target.exists():
            kept[target] = Path(shutil.copy2(target, beside / f".before-{k}"))
    done = []
    with _signals_wait():
        try:
            for finished, target in targets.items():
                _move(finished, target)
                done.append(target)
        except BaseException:
            for target in done:
                if target in kept:
                    os.replace(kept[target], target)
                else:
                    target.unlink(missing_ok=True)
            raise


def destination(path: str | Path) -> Path:
    """The file that `path` names, links followed, if it can be replaced.

    A device or a pipe is not a file to put another in the place of, nor is the file
    that the shell has opened for stdout or stderr: what is printed would go to one
    that has lost its name.
    """
    target = Path(os.path.realpath(path))
    if target.is_symlink():  # links were followed, so this one comes back to itself
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(path))
    if target.is_dir():
        raise ValueError(f"{path} is a folder; name a file")
    if target.exists() and not target.is_file():
        raise ValueError(f"{path} is a device or a pipe; name a file")
    if target.exists() and any(_is_open_as(number, target) for number in (1, 2)):
        raise ValueError(f"{path} is the file that stdout or stderr goes to")
    return target


def _is_open_as(number: int, path: Path) -> bool:
    with contextlib.suppress(OSError):
        return os.path.samestat(os.fstat(number), path.stat())
    return False


def existing_folder(path: str | Path) -> Path:
    """The folder `path`, or the nearest above it while it has yet to be made.

    Raises
    ------
    ValueError
        If it is a file, or below one, or a link that leads to no folder.
    """
    path = Path(path)
    for here in (path, *path.absolute().parents):
        if here.is_dir():
            return here
        if here.exists():
            raise ValueError(f"{here} is a file; a folder is needed")
        if here.is_symlink():
            raise ValueError(f"{here} is a link that leads to no folder")
    raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(path))


def require_other(path: str | Path, *read: str | Path | None) -> None:
    """Raise ValueError if what would be replaced is one of the files that are read."""
    for other in read:
        if other is None or not (os.path.exists(other) and os.path.exists(path)):
            continue
        if os.path.samefile(other, path):
            raise ValueError(f"{path} would replace {other}, which is read")


def _move(finished: Path, target: Path) -> None:
    if target.exists():
        shutil.copymode(target, finished)
    os.replace(finished, target)


@contextlib.contextmanager
def _signals_wait() -> Iterator[None]:
    """Signals that come inside the block are answered after it."""
    if threading.current_thread() is not threading.main_thread():
        yield  # Python answers signals in the main thread alone
        return
    came, before = [], {}
    for number in SIGNALS:
        old = signal.signal(number, lambda number, _: came.append(number))
        before[number] = signal.SIG_DFL if old is None else old
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for number in came:
            signal.raise_signal(number)
