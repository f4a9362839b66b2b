"""`compare`: one plant under every method, in a table."""

import textwrap
from argparse import Namespace
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from .registration import as_json, dry_run, file, plant_of, register, sample
from .statistics import known_input, with_input
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
            "compare tracker.json --k 'climb (m/s)=0,1,0; change (m/s^2)=0,0,1'",
            "compare tracker.json --csv designs.csv",
            "compare ball-and-beam.json --sample 0.1 --U 0",
            "compare tracker.json --budget multiply_adds=12,bytes=60 --float",
        ],
    )
    one.add_argument("plant", type=file, metavar="PLANT.json")
    _weighed(one)
    one.add_argument(
        "--orders", type=whole_numbers, metavar="R1,R2,...", help="only these orders"
    )
    within(one)
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
    estimated(one)
    one.add_argument(
        "--scale",
        type=numbers,
        metavar="S1,S2,...",
        help="typical sizes of the states, or of the rows of k x: errors of equal "
        "importance; by default each state is judged beside its own Kalman error",
    )
    known_input(one)


def within(one: Any) -> None:
    """What a device has to spare, and what it computes in."""
    one.add_argument(
        "--budget",
        type=limits,
        metavar="NAME=MOST,...",
        help="recommend the most accurate design within these limits: multiply_adds "
        "of a step, states, bytes of state and constants; any of them",
    )
    one.add_argument(
        "--float",
        action="store_true",
        help="count work and bytes of an export in float instead of double",
    )


def limits(text: str) -> dict[str, float]:
    """A budget, as it is written behind --budget.

    >>> limits("multiply_adds=30,states=2")
    {'multiply_adds': 30, 'states': 2}
    """
    import argparse

    from ..compare import Budget

    found: dict[str, float] = {}
    for part in text.split(","):
        name, _, most = part.partition("=")
        name = name.strip()
        try:
            (value,) = numbers(most)
        except ValueError:
            raise argparse.ArgumentTypeError(
                f"write NAME=NUMBER, as multiply_adds=30,states=2; not {part!r}"
            ) from None
        if name in found:
            raise argparse.ArgumentTypeError(f"{name} is there twice")
        found[name] = int(value) if value.is_integer() else value
    try:
        Budget.read(found)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return found


def question(options: Namespace) -> dict[str, Any]:
    """What `within` was given, as arguments of the function `compare`."""
    asked: dict[str, Any] = {"dtype": "float"} if options.float else {}
    return asked if options.budget is None else asked | {"budget": options.budget}


def estimated(one: Any) -> None:
    """The argument that says what of the state is wanted."""
    one.add_argument(
        "--k",
        type=combinations,
        metavar="K1,K2,...",
        help="estimate only this combination k x of the states, or several with "
        "semicolons between, named or not: --k 'torque (Nm)=0,120,0; drift=1,0,0'; "
        "write --k=-1,2 where the first number is negative. A name alone is that of a "
        'state or of the plant\'s "estimates", which are the default',
    )


def combinations(text: str) -> dict[str, list[float]] | list[list[float]] | list[str]:
    """Rows of numbers, rows by name, or names, with semicolons between.

    Examples
    --------
    >>> combinations("a (Nm)=1,0; b=0,1")
    {'a (Nm)': [1.0, 0.0], 'b': [0.0, 1.0]}
    >>> combinations("1,0;0,1"), combinations("speed (rad/s)")
    ([[1.0, 0.0], [0.0, 1.0]], ['speed (rad/s)'])
    """
    parts = [part.strip() for part in text.split(";") if part.strip()]
    pairs = [part.rpartition("=") for part in parts]
    named = {name.strip(): row for name, equals, row in pairs if equals}
    if not parts or named and len(named) < len(parts):  # some, or one twice
        raise ValueError
    if named:
        return {name: numbers(row) for name, row in named.items()}
    try:
        return [numbers(part) for part in parts]
    except ValueError:
        if all(any(map(str.isalpha, part)) for part in parts):
            return parts
        raise


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
        asked = dict(k=options.k, orders=options.orders, scale=scale)
        found = compare(with_input(plant, options.U), **asked | question(options))
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
        "estimates": list(found.estimates),
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
