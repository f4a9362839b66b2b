"""Ctrl-C while `python -m luenberger` loads: the end of a command, no traceback.

Python imports the package before it runs `__main__`, so no `try` there is early enough.
Nor is it for a stderr that is closed, which NumPy 2.0 asks for its `write`.
"""

import contextlib
import os
import signal
import sys
from types import FrameType


def _leave(number: int, _: FrameType | None) -> None:
    with contextlib.suppress(OSError):  # stderr may be closed
        os.write(2, b"luenberger: interrupted\n")
    os._exit(128 + number)


def loaded() -> None:
    """From here on Ctrl-C is a KeyboardInterrupt again."""
    if signal.getsignal(signal.SIGINT) is _leave:
        signal.signal(signal.SIGINT, signal.default_int_handler)


_commanded = sys.argv[:1] == ["-m"] and sys.orig_argv[-len(sys.argv)] == "luenberger"
if _commanded and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
    signal.signal(signal.SIGINT, _leave)
if _commanded and sys.stderr is None:
    sys.stderr = open(os.devnull, "w", encoding="utf-8")
