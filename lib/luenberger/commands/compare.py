"""`compare`: one plant under every method, in a table."""

import textwrap
from argparse import Namespace
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from .registration import as_json, dry_run, file, plant_of, register, sample
from .terminal import tell, tell_json, visible, written

if TYPE_CHECKING:
    from ..compare.table import Comparison
    from ..plant import Plant
    from ..show import Table

WIDE = 79


def add(commands: Any) -> None:
    one = register(
        commands,
        "compare",
        run,
        help="compare what every method makes of a plant",
        description="Design observers of a plant by every method and order, and print "
        "the error, the worst pole, the work of each, the one recommended and why, "
        "and which methods do not apply.",
        examples=[
            "compare tracker.json",
            "compare tracker.json --k=1,0.5,0 --orders 1,2 --json",
            "compare tracker.json --csv designs.csv",
            "compare ball-and-beam.json --sample 0.1",
        ],
    )
    one.add_argument("plant", type=file, metavar="PLANT.json")
    _weighed(one)
    one.add_argument(
        "--orders", type=whole_numbers, metavar="R1,R2,...", help="only these orders"
    )
    sample(one)
    as_json(one)
    one.add_argument(
        "--csv",
        type=file,
        metavar="FILE",
        help="write every design to a file, and print its path",
    )
    dry_run(one)


def _weighed(one: Any) -> None:
    """The arguments that say which errors count, and how much."""
    one.add_argument(
        "--k",
        type=numbers,
        metavar="K1,K2,...",
        help="estimate only this combination k x of the states; write --k=-1,2 where "
        "the first number is negative",
    )
    one.add_argument(
        "--scale",
        type=numbers,
        metavar="S1,S2,...",
        help="typical sizes of the states, or of the rows of k x: errors of equal "
        "importance; by default each state is judged beside its own Kalman error",
    )


def numbers(text: str) -> list[float]:
    """Numbers with commas between; argparse names the function where it fails."""
    if "_" in text or not text.isascii():  # float() takes 1_0 and foreign digits
        raise ValueError
    return [float(number) for number in text.split(",")]


def whole_numbers(text: str) -> list[int]:
    return [int(number) for number in text.split(",")]


def run(options: Namespace) -> None:
    """Compare, and print or write what came of it."""
    import numpy as np

    from ..compare import compare
    from ..formats import atomic
    from ..formats.spreadsheets import require_plain_names
    from ..report.result_files import designs_csv

    if options.json and options.csv is not None:
        options.wrong("--csv goes without --json")
    if options.csv is not None:
        atomic.destination(options.csv)
        atomic.require_other(options.csv, options.plant)
    plant = plant_of(options.plant, options)
    if options.csv is not None:
        require_plain_names(plant)
    scale = options.scale[0] if len(options.scale or ()) == 1 else options.scale
    with np.errstate(all="ignore"):  # what overflows is in the table as such
        found = compare(plant, k=options.k, orders=options.orders, scale=scale)
        if options.json:
            tell_json(_data(plant, found))
        elif options.csv is None:
            _print(found)
        elif not options.dry_run:
            atomic.write(options.csv, designs_csv(found.rows()))
    if options.csv is not None:
        written([options.csv], options.dry_run)


def _data(plant: "Plant", found: "Comparison") -> dict[str, Any]:
    return {
        "plant": plant.name,
        "k": None if found.k is None else found.k.tolist(),
        "recommended": None if found.chosen is None else found.chosen.name,
        "reasons": found.reasons(),
        "designs": found.rows(),
    }


def _print(found: "Comparison") -> None:
    tell(_table(found.table))
    for one in _refusals(found):
        tell("")
        tell(textwrap.fill(visible(one), WIDE, subsequent_indent="  "))
    tell("")
    if found.chosen is not None:
        tell(textwrap.fill(visible(f"Take the {found.chosen.name}."), WIDE))
    for sentence in found.reasons():
        tell(textwrap.fill(visible(sentence), WIDE))


def _table(table: "Table") -> "Table":
    """The table with its numbers first, as long names may leave the terminal.

    A star marks the design that is recommended.
    """
    from ..show import Table

    def turned(cells: list[str], mark: str) -> list[str]:
        return [mark, *cells[2:], *map(visible, cells[:2])]

    rows = (
        turned(cells, "*" if k in table.marked else "")
        for k, cells in enumerate(table.rows)
    )
    return Table(turned(table.header, ""), rows)


def _refusals(found: "Comparison") -> Iterator[str]:
    for method, which, reason in found.refusals.rows:
        yield f"{method}, {which}: {reason}"
