"""`estimate`: a saved observer run on a CSV file of any length."""

import codecs
import contextlib
import os
from argparse import ArgumentParser, Namespace
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from .registration import file, plant_of, register, sample
from .terminal import flush, require_open, say, tell

STREAM = "-"


def add(commands: Any) -> None:
    one = register(
        commands,
        "estimate",
        run,
        help="run a saved observer on measurements",
        description="Run an observer on a CSV file of any length, a few rows at a "
        "time. The file has a column for each output and input, by name, in any order "
        "and among others, and perhaps one called time, t or instant, which is carried "
        "along as it is, unless a spreadsheet would take it for a formula. A missing "
        "measurement is refused: gains that are fixed beforehand cannot leave it out.",
        examples=[
            "estimate report/observer.json tracker.csv --out estimates.csv",
            "estimate report/observer.json tracker.csv --plant tracker.json --out -",
        ],
    )
    one.add_argument("observer", type=file, metavar="OBSERVER.json")
    reads = "measurements; - reads stdin"
    one.add_argument("data", type=stream, metavar="DATA.csv", help=reads)
    one.add_argument(
        "--out",
        type=stream,
        required=True,
        metavar="FILE.csv",
        help="estimates; - writes to stdout, where rows before a refusal remain",
    )
    one.add_argument(
        "--plant",
        type=file,
        metavar="PLANT.json",
        help="the plant it observes: names the observer lacks, and x0 for the start",
    )
    sample(one)
    _backend(one)
    one.add_argument(
        "--dry-run", action="store_true", help="read and estimate, but write nothing"
    )


def _backend(one: ArgumentParser) -> None:
    one.add_argument(
        "--backend",
        choices=("numpy", "numba"),
        default="numpy",
        help="numba compiles the observer first, which pays from 10 million rows",
    )


def stream(text: str) -> Path | str:
    """The path of a file, or `STREAM` as it is."""
    return text if text == STREAM else file(text)


def run(options: Namespace) -> None:
    """Estimate, and say how many rows were written."""
    from ..errors import few
    from ..formats.atomic import require_other
    from ..formats.csv_reader import Table
    from ..observer import Observer
    from ..run import estimate_csv

    if options.sample is not None and options.plant is None:
        options.wrong("--sample goes with --plant")
    require_other(options.out, options.observer, options.data, options.plant)
    observer = Observer.from_json(options.observer)
    plant = None if options.plant is None else plant_of(options.plant, options)
    with _source(options.data) as file, _sink(options) as out:
        where = "stdin" if options.data == STREAM else options.data
        header, rows = estimate_csv.estimates(
            observer, Table(file, where), plant, options.backend
        )
        count = estimate_csv.write(out, header, rows)
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
