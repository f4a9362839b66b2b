"""The command line, `python -m luenberger COMMAND`: a module for each command.

A command's module has two functions.  ``add(commands)`` says what its options are, by
`registration.register`; ``run(options)`` does the work and returns nothing, or raises.
`main` turns what it raises into an exit status and one line on stderr.  What a command
needs beyond the standard library it imports in ``run``, so that ``--help`` is quick.

What reads arguments and tells the user enters here; what computes does not.  It uses
every room, inside the function that needs it.
"""

import argparse
import contextlib
import signal
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from .. import interrupts
from . import (
    check,
    compare,
    design,
    estimate,
    export,
    filter,
    fit,
    ledger,
    robustness,
    terminal,
)

COMMANDS = (
    *(check, compare, robustness, design),
    *(fit, filter, estimate, export, ledger),
)
DONE, REFUSED = 0, 1  # 2, for wrong usage, is argparse's own
NO_READER = 128 + 13  # as if by SIGPIPE
STATUSES = """\
exit status:
  0    done
  1    refused, with the reason on stderr; also a file that cannot be read or written
  2    the command line itself is wrong
  130  interrupted (143 if terminated, 129 if hung up, 141 if nobody reads the output)
Files are written beside and renamed: after any of these, and after a crash, each is
whole, the old one or the new.  A path that is a symbolic link is followed."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit status, or raises SystemExit for --help."""
    try:
        interrupts.loaded()
        terminal.prepare()
        with _ended_like_interrupted():
            try:
                options = parser().parse_args(arguments)
                options.run(options)
            finally:
                terminal.flush()
        return DONE
    except BrokenPipeError:
        return NO_READER
    except KeyboardInterrupt:
        return _end(128 + signal.SIGINT, "interrupted")
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        return _end(REFUSED, f"{where}{error.strerror or error}")
    except (ValueError, ImportError, MemoryError) as error:
        return _end(REFUSED, _reason(error))


class _Parser(argparse.ArgumentParser):
    """A parser whose help either arrives or is an error, as argparse's is not."""

    def print_help(self, file: Any = None) -> None:
        print(self.format_help(), end="", file=file)


class _Print(argparse.Action):
    """An option that prints the text of a function and ends the command."""

    def __init__(
        self, option_strings: list[str], dest: str, const: Callable[[], str], help: str
    ) -> None:
        super().__init__(option_strings, dest, nargs=0, const=const, help=help)

    def __call__(self, *_: object) -> None:
        print(self.const())
        raise SystemExit(DONE)


def parser() -> argparse.ArgumentParser:
    """The parser of every command."""
    top = _Parser(
        prog="python -m luenberger",
        description="Reduced-order state observers.",
        epilog=STATUSES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    top.add_argument(
        "--version", action=_Print, const=_version, help="print the version and end"
    )
    commands = top.add_subparsers(
        title="commands", dest="command", metavar="COMMAND", required=True
    )
    for module in COMMANDS:
        module.add(commands)
    return top


def _version() -> str:
    from importlib.metadata import version

    return f"luenberger {version('luenberger')}"


@contextlib.contextmanager
def _ended_like_interrupted() -> Iterator[None]:
    """Ended from outside, a command removes its temporary files before it goes."""
    before = {}

    def leave(number: int, _: object) -> None:
        raise SystemExit(128 + number)

    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number and signal.getsignal(number) is signal.SIG_DFL:  # not under nohup
            before[number] = signal.signal(number, leave)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _reason(error: Exception) -> str:
    """The message of an error.  An overflow is named where LAPACK only noticed it."""
    said = str(error) or type(error).__name__
    if type(error).__name__ == "LinAlgError" or "infs or NaNs" in said:
        return f"the numbers are too large or too unlike to compute with: {said}"
    return said


def _end(status: int, message: str) -> int:
    with contextlib.suppress(OSError):
        terminal.say(f"luenberger: {message}")
    return status
