"""`estimate`: an observer run on a CSV file of any length, or a plant smoothed."""

import codecs
import contextlib
import os
from argparse import SUPPRESS, ArgumentParser, ArgumentTypeError, Namespace
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from .registration import file, plant_of, register, sample
from .terminal import flush, require_open, say, tell

STREAM = "-"
DESCRIPTION = (
    "Run an observer on a CSV file of any length, a few rows at a "
    "time. The file has a column for each output and input, by name, in any order "
    "and among others, and perhaps one called time, t or instant: seconds, dates or "
    "numbers of samples, which agree with dt and are written as they are. A missing "
    "measurement is refused: gains that are fixed beforehand cannot leave it out; "
    "`filter` can. "
    "With --smooth, the file is a plant instead, and each row is estimated from "
    "all measurements, earlier and later, with its one sigma; some may be missing. "
    "With --lag N, each row is estimated with N more rows. --smooth holds the whole "
    "file."
)


def add(commands: Any) -> None:
    one = register(
        commands,
        "estimate",
        run,
        help="run a saved observer on measurements",
        description=DESCRIPTION,
        examples=[
            "estimate report/observer.json tracker.csv --out estimates.csv",
            "estimate report/observer.json tracker.csv --plant tracker.json --out -",
            "estimate tracker.json tracker.csv --smooth --out smoothed.csv",
        ],
    )
    one.add_argument(
        "observer",
        type=file,
        metavar="OBSERVER.json",
        help="the observer; with --smooth or --lag, a plant with Q, R and P0",
    )
    data_and_out(one)
    one.add_argument(
        "--plant",
        type=file,
        metavar="PLANT.json",
        help="the plant it observes: names the observer lacks, and x0 for the start",
    )
    one.add_argument(
        "--smooth", action="store_true", help="smooth a plant's record with all of it"
    )
    lag(one, "smooth it with N more rows at each")
    sample(one)
    # named where it goes
    one.add_argument("--arrival", action="append", help=SUPPRESS)
    one.add_argument(
        "--dry-run", action="store_true", help="read and estimate, but write nothing"
    )


def data_and_out(one: ArgumentParser) -> None:
    """The record that is read, and the file that is written."""
    reads = "measurements; - reads stdin"
    one.add_argument("data", type=stream, metavar="DATA.csv", help=reads)
    one.add_argument(
        "--out",
        type=stream,
        required=True,
        metavar="FILE.csv",
        help="estimates; - writes to stdout, where rows before a refusal remain",
    )


def lag(one: ArgumentParser, help: str) -> None:
    """The option of a fixed lag."""
    one.add_argument("--lag", type=_rows, metavar="N", help=help)


def stream(text: str) -> Path | str:
    """The path of a file, or `STREAM` as it is."""
    return text if text == STREAM else file(text)


def _rows(text: str) -> int:
    """A number of rows."""
    if not (text.isascii() and text.isdigit()):
        raise ArgumentTypeError(f"give a number of rows, 0 or more, not {text!r}")
    return int(text)


def _reader(options: Namespace) -> Callable[[Any], Any]:
    """What makes header and rows of a table: an observer, or a plant's smoother."""
    from ..observer import Observer
    from ..run import tables

    if options.smooth or options.lag is not None:
        if options.plant is not None:
            options.wrong(
                "--plant goes with an observer; --smooth takes the plant alone"
            )
        plant = plant_of(options.observer, options)
        return lambda table: tables.smoothed(plant, table, options.lag)
    if options.sample is not None and options.plant is None:
        options.wrong("--sample goes with --plant or --smooth")
    observer = Observer.from_json(options.observer)
    known = None if options.plant is None else plant_of(options.plant, options)
    return lambda table: tables.estimates(observer, table, known)


def run(options: Namespace) -> None:
    """Estimate, and say how many rows were written."""
    from ..formats.atomic import require_other

    if options.arrival is not None:
        options.wrong(
            "estimate takes no readings that arrive late: an observer's gains are "
            "fixed beforehand, and smoothing needs whole rows. The filter of a plant "
            "takes them: filter PLANT.json DATA.csv --arrival OUTPUT=COLUMN"
        )
    require_other(options.out, options.plant)
    run_over(options, options.observer, _reader(options))


def run_over(
    options: Namespace, model: Path, read: Callable[[Any], tuple[Any, Any]]
) -> None:
    """Run `read` over the data; `model` is the file that says how."""
    from ..errors import few
    from ..formats.atomic import require_other
    from ..formats.csv_reader import Table
    from ..run import tables

    require_other(options.out, model, options.data)
    with _source(options.data) as file, _sink(options) as out:
        where = "stdin" if options.data == STREAM else options.data
        header, rows = read(Table(file, where))
        count = tables.write(out, header, rows)
    if options.out == STREAM:
        flush()
    else:
        tell(options.out)
    say(f"{count} rows of {few(header)}")
    if options.dry_run:
        say("dry run: nothing was written")


def _source(path: Path | str) -> AbstractContextManager[Any]:
    from ..formats.json_files import opened

    if path == STREAM:
        return contextlib.nullcontext(require_open("stdin").buffer)
    return opened(path)


def _sink(options: Namespace) -> AbstractContextManager[Any]:
    from ..formats.atomic import destination, replacing

    if options.dry_run and options.out != STREAM:
        destination(options.out)
    if options.dry_run:
        return open(os.devnull, "w", encoding="utf-8")
    if options.out == STREAM:  # UTF-8, whatever the terminal has
        return contextlib.nullcontext(
            codecs.getwriter("utf-8")(require_open("stdout").buffer)
        )
    return replacing(options.out)
