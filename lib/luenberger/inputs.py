"""Files that a user names: only plain ones are read, and only up to a limit."""

import os
import stat

MIB = 1 << 20
OTHERS = {
    stat.S_ISDIR: "a folder",
    stat.S_ISFIFO: "a pipe",
    stat.S_ISCHR: "a device",
    stat.S_ISBLK: "a device",
    stat.S_ISSOCK: "a socket",
}


def opened(path):
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


def _at_once(path, flags):
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def contents(path, limit):
    """The bytes of a plain file of at most `limit` MiB."""
    with opened(path) as file:
        found = file.read(limit * MIB + 1)
    if len(found) > limit * MIB:
        raise ValueError(f"{path}: the file is larger than {limit} MiB")
    return found
