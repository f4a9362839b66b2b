"""What commands print: results on stdout, everything else on stderr."""

import sys


def say(text):
    """One line on stderr, at once."""
    print(text, file=sys.stderr, flush=True)
