"""One process, or thread, at a time puts files into a folder.

The lock is the system's, on a file in the folder, so it ends with the process that
holds it, however that ends: a file that a killed process left behind locks nothing.
"""

import contextlib
import errno
import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

NAME = ".luenberger-lock"
PATIENCE = 60.0  # seconds; files are moved in a fraction of one
OFTEN = 0.01
TAKEN = (errno.EACCES, errno.EAGAIN, errno.EDEADLK)
NO_LOCKS = (errno.ENOSYS, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOLCK)


@contextlib.contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """No other process or thread is in such a block of this folder.

    It waits for the one that is.  On a disk that knows no locks nothing is locked.

    Raises
    ------
    OSError
        If the folder cannot be written, or the other takes longer than a minute.
    """
    end = time.monotonic() + PATIENCE
    while (number := _taken(folder)) is None:
        if time.monotonic() > end:
            text = "another process has been writing to this folder for a minute"
            raise OSError(errno.EBUSY, text, str(folder))
        time.sleep(OFTEN)
    windows = sys.platform == "win32"  # where an open file cannot be removed
    try:
        yield
    finally:
        for closes in (windows, not windows):
            if closes:
                os.close(number)
            else:
                with contextlib.suppress(OSError):
                    (folder / NAME).unlink()


def _taken(folder: Path) -> int | None:
    """The locked file, open, or None while another holds it."""
    path = folder / NAME
    try:
        number = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    except PermissionError as error:
        if sys.platform == "win32" and path.exists():  # it is being removed
            return None
        raise type(error)(error.errno, error.strerror, str(folder)) from None
    kept = False
    try:
        if sys.platform == "win32":
            msvcrt.locking(number, msvcrt.LK_NBLCK, 1)
        else:
            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
        # not one that its holder removed before we had it
        kept = os.path.samestat(os.fstat(number), path.stat())
    except FileNotFoundError:
        pass
    except OSError as error:
        kept = error.errno in NO_LOCKS
        if not kept and error.errno not in TAKEN:
            raise
    finally:
        if not kept:
            os.close(number)
    return number if kept else None
