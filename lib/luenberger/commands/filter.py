"""`filter`: the states of a plant from a CSV record of any length, with one sigma."""

from argparse import ArgumentTypeError, Namespace
from collections.abc import Callable
from typing import Any

from .estimate import data_and_out, lag, run_over
from .registration import file, plant_of, register, sample

DESCRIPTION = (
    "Filter a record of a plant in one pass, a few rows at a time: each row gives the "
    "states and their one sigma, from what was measured up to it. The file has a "
    "column for each output and input, by name, in any order and among others. An "
    "empty cell of an output was not measured, so sensors may have rates of their own "
    "and drop out. A column called time or t holds seconds or dates. A continuous "
    "plant is sampled at these instants, however uneven; those of a discrete one "
    "agree with its dt. With --lag N, each row waits for N more. With --arrival, a "
    "reading is used from the row on at which it is known."
)


def add(commands: Any) -> None:
    one = register(
        commands,
        "filter",
        run,
        help="filter a record of a plant: gaps, several rates, dates, any length",
        description=DESCRIPTION,
        examples=[
            "filter tracker.json tracker.csv --out filtered.csv",
            "filter tracker.json tracker.csv --lag 20 --out lagged.csv",
            "filter tracker.json tracker.csv --out -",
        ],
    )
    plant = "the plant, continuous or discrete, with Q, R and P0"
    one.add_argument("plant", type=file, metavar="PLANT.json", help=plant)
    data_and_out(one)
    lag(one, "smooth each row with N more rows")
    one.add_argument(
        "--undriven",
        action="store_true",
        help="no known input acts: the file needs no columns of inputs",
    )
    sample(one)
    one.add_argument(
        "--arrival",
        type=_pair,
        action="append",
        metavar="OUTPUT=COLUMN",
        help="readings of this output are known at the times in that column, numbers "
        "or dates like those in the column of times; never where its cell is empty; "
        "repeat it for other outputs",
    )
    one.add_argument(
        "--dry-run", action="store_true", help="read and filter, but write nothing"
    )


def _pair(text: str) -> tuple[str, str]:
    """An output and its column."""
    output, mark, column = text.partition("=")
    if not (output and mark and column):
        raise ArgumentTypeError(f"give OUTPUT=COLUMN, not {text!r}")
    return output, column


def run(options: Namespace) -> None:
    """Filter, and say how many rows were written."""
    if options.arrival is not None and options.lag is not None:
        options.wrong("--arrival does not go with --lag: late readings are filtered")
    run_over(options, options.plant, _reader(options))


def _reader(options: Namespace) -> Callable[[Any], Any]:
    """What makes header and rows of a table."""
    from ..run import tables

    plant = plant_of(options.plant, options)
    if options.lag is None:
        late = dict(options.arrival or ())
        return lambda table: tables.filtered(plant, table, options.undriven, late)
    return lambda table: tables.smoothed(plant, table, options.lag, options.undriven)
