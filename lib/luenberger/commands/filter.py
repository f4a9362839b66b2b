"""`filter`: the states of a plant from a CSV record of any length, with one sigma."""

from argparse import Namespace
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
    "agree with its dt. With --lag N, each row waits for N more."
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
    lag(one, "smooth each row with N more rows; memory holds as many")
    one.add_argument(
        "--undriven",
        action="store_true",
        help="no known input acts: the file needs no columns of inputs",
    )
    sample(one)
    one.add_argument(
        "--backend",
        choices=("auto", "numpy", "numba"),
        default="auto",
        help="auto: numba from 20000 rows on, where it is installed",
    )
    one.add_argument(
        "--dry-run", action="store_true", help="read and filter, but write nothing"
    )


def run(options: Namespace) -> None:
    """Filter, and say how many rows were written."""
    run_over(options, options.plant, _reader(options))


def _reader(options: Namespace) -> Callable[[Any], Any]:
    """What makes header and rows of a table."""
    from ..run import filter_csv
    from ..smoothing import table as smoothed

    plant, backend = plant_of(options.plant, options), options.backend
    if options.lag is None:
        return lambda table: filter_csv.estimates(
            plant, table, options.undriven, backend
        )
    return lambda table: smoothed.estimates(
        plant, table, options.lag, backend, options.undriven
    )
