"""`export`: an observer, or the filter of a plant, as C99 source."""

import tempfile
from argparse import ArgumentTypeError, Namespace
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from .registration import dry_run, file, folder, plant_of, register, sample
from .terminal import say, written

if TYPE_CHECKING:
    from ..observer import Observer
    from ..plant import Plant


def add(commands: Any) -> None:
    one = register(
        commands,
        "export",
        run,
        help="write an observer, or a plant's time-varying filter, as C99 source",
        description="Write C99 source that allocates nothing: NAME.c and NAME.h. An "
        "observer becomes its recursion; a plant becomes the time-varying filter with "
        "its covariance, where NaN in y means not measured. Compiled with "
        "-DNAME_SELFTEST it is a program that ends with 0 if it computes what Python "
        "does. Prints the two paths.",
        examples=[
            "export report/observer.json --c firmware",
            'export tracker.json --m1 "radar position (m)" --c firmware --name filter',
            "export report/observer.json --c firmware --dtype float --dry-run",
            "export report/observer.json --c firmware --dtype fixed --bits 16 "
            '--range "radar position (m)=500" --range "radar velocity (m/s)=50"',
            'export tracker.json --c firmware --dtype float --range "radar position '
            '(m)=500" --range "radar velocity (m/s)=50"',
        ],
    )
    one.add_argument("source", type=file, metavar="OBSERVER.json|PLANT.json")
    one.add_argument(
        "--c",
        type=folder,
        required=True,
        metavar="DIR",
        help="folder for the two files",
    )
    _beside(one)
    one.add_argument("--name", default="observer", help="of files and functions")
    _numbers(one)
    sample(one)
    dry_run(one)


def _beside(one: Any) -> None:
    """What goes with an observer, and what with a plant."""
    one.add_argument(
        "--plant",
        type=file,
        help="beside an observer: names for the comments; with --dtype float what "
        "rounding does to the estimates is measured on it, where there is a C compiler",
    )
    one.add_argument(
        "--m1",
        action="append",
        metavar="OUTPUT",
        help="beside a plant: the name of an output treated as exact, once for each; "
        "or how many of the first outputs; default none",
    )
    one.add_argument(
        "--update",
        choices=["joseph", "guarded"],
        default="joseph",
        help="beside a plant: guarded computes the covariance in its short form where "
        "rounding is sure to be small; default %(default)s",
    )


def _numbers(one: Any) -> None:
    """What the device computes in."""
    one.add_argument(
        "--dtype",
        choices=["double", "float", "fixed"],
        help="numbers of the device; fixed: whole numbers, of an observer; default "
        "double",
    )
    one.add_argument("--float", action="store_true", help="the same as --dtype float")
    one.add_argument(
        "--bits",
        type=int,
        choices=[16, 32],
        help="with --dtype fixed: of each signal and weight",
    )
    one.add_argument(
        "--range",
        action="append",
        type=sized,
        metavar="SIGNAL=SIZE",
        help="the largest size of an input or measurement, once for each; for --dtype "
        "fixed, and for the bound on rounding in the header. Those of measurements may "
        "be left out where the plant, given by --plant beside an observer, is stable, "
        "with Q and R",
    )


def sized(text: str) -> tuple[str, float]:
    """A name and a size, of --range.

    >>> sized("speed (m/s)=50")
    ('speed (m/s)', 50.0)
    """
    name, _, size = text.rpartition("=")
    try:
        return name, float(size)
    except ValueError:
        raise ArgumentTypeError(
            f"{text!r} must be SIGNAL=SIZE, with a number for the size"
        ) from None


def run(options: Namespace) -> None:
    """Write the source, or into a folder that is thrown away, and print the paths."""
    import numpy as np

    from ..export import to_c
    from ..export.c.source_and_header import places
    from ..observer import Observer

    given = _read(options)
    with np.errstate(all="ignore"), tempfile.TemporaryDirectory() as nowhere:
        where = nowhere if options.dry_run else options.c
        paths = to_c(path=where, **given)
    if options.dry_run:
        paths = places(options.c, [path.name for path in paths])
    written(paths, options.dry_run)
    if given["dtype"] == "float" and isinstance(given["source"], Observer):
        _measure(given["source"], given["plant"])


def _measure(observer: "Observer", plant: "Plant | None") -> None:
    """Say what float costs, or what is missing to know."""
    from ..export import rounding_error

    if plant is None:
        say("--plant PLANT.json, the plant with Q and R, measures what float costs")
        return
    try:
        found = rounding_error(observer, plant)
    except (RuntimeError, ValueError) as error:
        say(f"what float costs is not measured: {error}")
        return
    for sentence in found.sentences:
        say(sentence)


def _read(options: Namespace) -> dict[str, Any]:
    """The arguments of `to_c`, read from the files that are named."""
    from ..formats.json_files import json_file
    from ..formats.json_records import kind
    from ..observer import Observer
    from ..plant import Plant

    file = json_file(options.source, "a record")
    if kind(file) == "observer":
        if options.sample is not None:
            options.wrong("--sample goes with a plant, not with an observer")
        source = Observer.from_json(file)
    else:
        source = plant_of(file, options)
    m1: int | list[str] | None = None
    if options.m1 is not None:
        outputs = getattr(source, "output_names", ())
        m1 = accurate(options.m1, outputs or ())
    return dict(
        source=source,
        plant=None if options.plant is None else Plant.from_json(options.plant),
        m1=m1,
        name=options.name,
        dtype=_dtype(options),
        bits=options.bits,
        ranges=_ranges(options),
        update=options.update,
    )


def _dtype(options: Namespace) -> str:
    if options.float and options.dtype not in (None, "float"):
        options.wrong(f"--float and --dtype {options.dtype} exclude each other")
    return "float" if options.float else options.dtype or "double"


def _ranges(options: Namespace) -> dict[str, float] | None:
    """What --range says, each signal once."""
    if options.range is None:
        return None
    found = dict(options.range)
    if len(found) < len(options.range):
        options.wrong("--range names a signal twice")
    return found


def accurate(given: list[str], outputs: Sequence[str]) -> int | list[str]:
    """What --m1 says: names of outputs, or one number of them.

    >>> accurate(["2"], ["a", "b"]), accurate(["b", "a"], ["a", "b"])
    (2, ['b', 'a'])
    """
    if len(given) == 1 and given[0].isdecimal() and given[0] not in outputs:
        return int(given[0])
    return given
