"""The command line, `python -m luenberger COMMAND`: a module for each command.

A command's module has two functions.  ``add(commands)`` says what its options are, by
`registration.register`; ``run(options)`` does the work and returns nothing, or raises.
`main` turns what it raises into an exit status and one line on stderr.  What a command
needs beyond the standard library it imports in ``run``, so that ``--help`` is quick.
"""

import argparse
import signal
import sys

from . import design, export
from .terminal import say

COMMANDS = (design, export)
DONE, REFUSED = 0, 1  # 2, for wrong usage, is argparse's own
STATUSES = """\
exit status:
  0    done
  1    refused, with the reason on stderr; also a file that cannot be read or written
  2    the command line itself is wrong
  130  interrupted (143 when terminated); every file is whole, the old one or the new"""


def main(arguments=None):
    """Run a command; returns the exit status."""
    options = parser().parse_args(arguments)
    # ended from outside is like interrupted: temporary files are to be removed
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    try:
        options.run(options)
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        return _refuse(f"{where}{error.strerror or error}")
    except (ValueError, ImportError) as error:
        return _refuse(str(error))
    except KeyboardInterrupt:
        say("luenberger: interrupted; nothing was written")
        return 128 + signal.SIGINT
    return DONE


def parser():
    """The parser of every command."""
    top = argparse.ArgumentParser(
        prog="python -m luenberger",
        description="Reduced-order state observers.",
        epilog=STATUSES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    commands = top.add_subparsers(
        title="commands", dest="command", metavar="COMMAND", required=True
    )
    for module in COMMANDS:
        module.add(commands)
    return top


def _refuse(message):
    say(f"luenberger: {message}")
    return REFUSED
