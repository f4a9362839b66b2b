"""How a command is made known to argparse, which suffices and is always there."""

import argparse
import math
import os
import textwrap
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any


def register(
    commands: Any,
    name: str,
    run: Callable[[argparse.Namespace], None],
    help: str,
    description: str,
    examples: Iterable[str],
) -> argparse.ArgumentParser:
    """Add a command; returns its parser, for its options.

    ``options.wrong(message)`` ends a run whose options do not go together.

    Parameters
    ----------
    commands : the object that `main` passes to every module's ``add``
    run : callable of the parsed options
    help, description : str
        One line for the list of commands, and a paragraph for the command's own page.
    examples : sequence of str
        What follows ``python -m luenberger``, on the files of notebooks/plants and
        on what the examples before them write; the tests run every one.
    """
    lines = [f"  python -m luenberger {example}" for example in examples]
    one = commands.add_parser(
        name,
        help=help,
        description=textwrap.fill(description, 79),
        epilog="\n".join(["examples:", *lines]),
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    one.set_defaults(run=run, wrong=one.error)
    return one


def file(text: str) -> Path:
    """The path of a file; an empty one is of a variable that was never set."""
    if not text or text.endswith(os.sep):
        raise argparse.ArgumentTypeError(f"name a file, not {text!r}")
    return Path(text)


def folder(text: str) -> Path:
    """The path of a folder; an empty one is not the current folder."""
    if not text:
        raise argparse.ArgumentTypeError("give a folder; '.' is the current one")
    return Path(text)


def as_json(one: argparse.ArgumentParser) -> None:
    """The option of commands that print tables."""
    one.add_argument(
        "--json", action="store_true", help="one JSON document on stdout instead"
    )


def sample(one: argparse.ArgumentParser) -> None:
    """The option of commands that need discrete time."""
    one.add_argument(
        "--sample",
        type=_seconds,
        metavar="DT",
        help="sample a continuous plant every DT seconds, with inputs held between",
    )


def _seconds(text: str) -> float:
    """A period; the characters are those of a number in ASCII."""
    plain = text.isascii() and "_" not in text  # float() takes more
    try:
        found = float(text) if plain else 0.0
    except ValueError:
        found = 0.0
    if not 0 < found < math.inf:
        raise argparse.ArgumentTypeError(f"give seconds above 0, not {text!r}")
    return found


def plant_of(source: Any, options: argparse.Namespace) -> Any:
    """The plant of a JSON file, sampled if the options say so."""
    from ..plant import Plant

    found = Plant.from_json(source)
    return found if options.sample is None else found.sampled(options.sample)


def dry_run(
    one: argparse.ArgumentParser, instead: str = "do everything but write"
) -> None:
    """The option that every command has which writes files."""
    one.add_argument(
        "--dry-run",
        action="store_true",
        help=f"{instead}, and print which files would be written",
    )
