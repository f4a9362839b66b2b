"""Imported by tests that interrupt themselves or what they start.

A shell's background job is started deaf to SIGINT, and so is what it starts in turn.
"""

import signal

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
