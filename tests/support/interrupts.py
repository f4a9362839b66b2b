"""Signals for tests that interrupt themselves or what they start.

A shell's background job is started deaf to SIGINT, one under nohup to SIGHUP, and so is
what it starts in turn.
"""

import os
import signal
import sys

import pytest

HEED = """
import os, signal, sys
for name in ("SIGINT", "SIGTERM", "SIGHUP"):
    signal.signal(getattr(signal, name), signal.SIG_DFL)
os.execv(sys.executable, [sys.executable, *sys.argv[1:]])
"""


def heeding(*arguments):
    """The command line of a Python process that no signal is ignored by."""
    return [sys.executable, "-c", HEED, *arguments]


def ended(pid):
    """Whether there is no process of this number."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    return False


@pytest.fixture
def sigint():
    """This process heeds SIGINT as one in the foreground does."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
