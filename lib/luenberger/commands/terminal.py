"""What commands print: results on stdout, everything else on stderr.

Text may hold names from a user's file.  Characters that would steer a terminal are
printed as escapes, as are those that its encoding lacks.
"""

import contextlib
import json
import os
import sys
from collections.abc import Iterable
from typing import TextIO


def say(text: object) -> None:
    """One line on stderr, at once."""
    print(visible(text), file=sys.stderr, flush=True)


def tell(text: object) -> None:
    """Lines on stdout."""
    print("\n".join(visible(line) for line in str(text).split("\n")))


def tell_json(value: object) -> None:
    """One JSON document on stdout; ASCII, keys in the order of `value`.

    Raises
    ------
    ValueError
        If a number in it is not finite: null is for what is not there.
    """
    print(json.dumps(value, indent=2, allow_nan=False))


def written(paths: Iterable[object], dry: bool) -> None:
    """Print the files of a run on stdout; after a dry run, say that none is there."""
    for path in paths:
        tell(path)
    if dry:
        say("dry run: nothing was written")


def visible(text: object) -> str:
    r"""The text in one line, with escapes for what is not printable.

    >>> visible("a\x1b[31m\nb")
    'a\\x1b[31m\\nb'
    """
    text = str(text)
    if text.isprintable():
        return text
    return "".join(
        c if c.isprintable() else c.encode("unicode_escape").decode("ascii")
        for c in text
    )


def prepare() -> None:
    """Let both streams print any text, whatever their encoding.

    Where stderr is closed, what is said goes nowhere.  No file that is opened later
    takes the number of a closed stream, as a child process would write into it.

    Raises
    ------
    OSError
        If stdout is closed: nobody would learn the results.
    """
    for number in range(3):
        _keep_from_others(number)
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")
    require_open("stdout")
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


def _keep_from_others(number: int) -> None:
    """Fill the place of a closed stream, once those of lower numbers are open."""
    try:
        os.fstat(number)
    except OSError:
        os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free


def require_open(name: str) -> TextIO:
    """The stream "stdin" or "stdout"; OSError if it was closed."""
    stream = getattr(sys, name)
    if stream is None:
        raise OSError(f"{name} is closed")
    return stream


def flush() -> None:
    """Send what was printed, so that a full disk or a closed pipe is noticed now."""
    try:
        sys.stdout.flush()
    except OSError:
        with contextlib.suppress(OSError):  # nobody is to try again when Python ends
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, sys.stdout.fileno())
            os.close(nowhere)
        raise
