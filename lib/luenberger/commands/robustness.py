"""`robustness`: designs for one plant, judged on all plants that there may be."""

import re
import textwrap
from argparse import ArgumentTypeError, Namespace
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from .compare import WIDE, estimated, whole_numbers
from .registration import as_json, file, register, sample
from .statistics import known_input, with_input
from .terminal import say, tell, tell_json, visible

if TYPE_CHECKING:
    from pathlib import Path

    from ..compare import Comparison, Robustness
    from ..observer import Observer
    from ..plant import Plant


def add(commands: Any) -> None:
    one = register(
        commands,
        "robustness",
        run,
        help="judge designs on plants that differ from the one they are for",
        description="Design observers of a plant by every method, or take observers "
        "from files, and judge each on every plant that there may be: its worst case, "
        "its spread, and the design whose worst case is least. The error on a plant "
        "is measured beside that of the Kalman filter that knows this plant. Writes "
        "nothing.",
        examples=[
            'robustness reactor.json --ranges "A[0,0]=1%" "C[0,0]=5%" --orders 9 '
            "--samples 10",
            'robustness tracker.json --ranges "A[2,2]=0.9:1" --samples 10 --json',
            "robustness tracker.json --plants tracker.json --observers "
            "report/observer.json",
        ],
    )
    one.add_argument("plant", type=file, metavar="PLANT.json")
    _plants(one)
    one.add_argument(
        "--observers",
        type=file,
        nargs="+",
        metavar="OBSERVER.json",
        help="judge these, and not designs by every method",
    )
    estimated(one)
    one.add_argument(
        "--orders", type=whole_numbers, metavar="R1,R2,...", help="only these orders"
    )
    known_input(one)
    sample(one)
    as_json(one)


def _plants(one: Any) -> None:
    """The arguments that say which plants there may be."""
    one.add_argument(
        "--plants",
        type=file,
        nargs="+",
        default=[],
        metavar="OTHER.json",
        help="the plants that there may be, beside PLANT.json",
    )
    one.add_argument(
        "--ranges",
        type=_range,
        nargs="+",
        default=[],
        metavar="ENTRY=RANGE",
        help='entries of the plant, counted from 0: "A[1,1]=30%%" to either side of '
        'the nominal one, or "A[1,1]=-0.65:-0.35" from the least to the greatest',
    )
    one.add_argument(
        "--samples",
        type=int,
        default=100,
        metavar="N",
        help="how many plants are drawn from the ranges (100)",
    )
    one.add_argument(
        "--seed", type=int, default=0, metavar="N", help="of what is drawn (0)"
    )


def _range(text: str) -> tuple[str, Any]:
    """An entry and its range, which the library checks."""
    name, _, value = text.partition("=")
    if not name or not value:
        raise ArgumentTypeError(f'give "A[1,1]=30%" or "A[1,1]=0.5:0.9", not {text!r}')
    if value.rstrip().endswith("%"):
        return name.strip(), value
    low, _, high = value.partition(":")
    number = r"\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*"
    if not (re.fullmatch(number, low, re.A) and re.fullmatch(number, high, re.A)):
        raise ArgumentTypeError(f'give "{name}=0.5:0.9" or "{name}=30%", not {text!r}')
    return name.strip(), (float(low), float(high))


def run(options: Namespace) -> None:
    """Judge, and print what came of it."""
    import numpy as np

    from ..compare.robustness import robustness
    from ..plant import Plant

    if bool(options.ranges) == bool(options.plants):
        options.wrong("give --ranges or --plants, one of them")
    given = with_input(Plant.from_json(options.plant), options.U)
    plant = given if options.sample is None else given.sampled(options.sample)
    observers, ranges = _read(options.observers), dict(options.ranges)
    if len(ranges) < len(options.ranges):
        options.wrong("--ranges name one entry twice")
    plants: Any = given
    if options.plants:
        others = {
            str(path): with_input(Plant.from_json(path), options.U)
            for path in options.plants
        }
        plants = {str(options.plant): given} | others
    with np.errstate(all="ignore"):  # what overflows is in the table as such
        found = robustness(
            observers or _designs(options, plant),
            plants,
            ranges=ranges or None,
            samples=options.samples,
            seed=options.seed,
            k=options.k,
        )
    if options.json:
        tell_json(_data(plant, found))
    else:
        _print(found)


def _read(paths: Iterable["Path"] | None) -> dict[str, "Observer"]:
    """The observers that are judged, by file; none where designs are."""
    from ..observer import Observer

    return {str(path): Observer.from_json(path) for path in paths or ()}


def _designs(options: Namespace, plant: "Plant") -> "Comparison":
    """Designs by every method."""
    from ..compare import compare

    say(f"designing for {options.plant}")
    return compare(plant, k=options.k, orders=options.orders)


def _data(plant: "Plant", found: "Robustness") -> dict[str, Any]:
    return {
        "plant": plant.name,
        "estimates": list(found.estimates),
        "recommended": None if found.chosen is None else found.chosen.name,
        "reasons": found.reasons(),
        "cases": found.rows(),
    }


def _print(found: "Robustness") -> None:
    from ..show import Table

    def turned(cells: list[str], mark: str) -> list[str]:
        return [mark, *cells[1:], visible(cells[0])]

    shown = found.table
    rows = (
        turned(cells, "*" if k in shown.marked else "")
        for k, cells in enumerate(shown.rows)
    )
    tell(Table(turned(shown.header, ""), rows))
    tell("")
    if found.chosen is not None:
        tell(textwrap.fill(visible(f"Take {found.chosen.name}."), WIDE))
    for sentence in found.reasons():
        tell(textwrap.fill(visible(sentence), WIDE))
