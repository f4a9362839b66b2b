"""`export`: an observer, or the filter of a plant, as C99 source."""

import tempfile
from argparse import Namespace
from collections.abc import Sequence
from typing import Any

from .registration import dry_run, file, folder, plant_of, register, sample
from .terminal import say, written


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
            "export report/observer.json --c firmware --dtype float --plant "
            "tracker.json --measure",
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
        help="beside an observer: names for the comments, and what --measure runs on",
    )
    one.add_argument(
        "--m1",
        action="append",
        metavar="OUTPUT",
        help="beside a plant: the name of an output treated as exact, once for each; "
        "or how many of the first outputs; default none",
    )


def _numbers(one: Any) -> None:
    """What the device computes in."""
    one.add_argument(
        "--dtype",
        choices=["double", "float"],
        help="numbers of the device; default double",
    )
    one.add_argument("--float", action="store_true", help="the same as --dtype float")
    one.add_argument(
        "--measure",
        action="store_true",
        help="beside an observer with --plant: compile the source, run it on a "
        "simulated record and say how far rounding moves the estimates",
    )


def run(options: Namespace) -> None:
    """Write the source, or into a folder that is thrown away, and print the paths."""
    import numpy as np

    from ..export import rounding_error, to_c
    from ..export.c.source_and_header import places
    from ..observer import Observer

    given = _read(options)
    source, plant = given["source"], given["plant"]
    if options.measure and not (isinstance(source, Observer) and plant):
        options.wrong("--measure goes with an observer, and --plant says of what plant")
    with np.errstate(all="ignore"), tempfile.TemporaryDirectory() as nowhere:
        where = nowhere if options.dry_run else options.c
        paths = to_c(path=where, **given)
    if options.dry_run:
        paths = places(options.c, [path.name for path in paths])
    written(paths, options.dry_run)
    if options.measure:
        for sentence in rounding_error(source, plant, dtype=given["dtype"]).sentences:
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
    )


def _dtype(options: Namespace) -> str:
    if options.float and options.dtype not in (None, "float"):
        options.wrong(f"--float and --dtype {options.dtype} exclude each other")
    return "float" if options.float else options.dtype or "double"


def accurate(given: list[str], outputs: Sequence[str]) -> int | list[str]:
    """What --m1 says: names of outputs, or one number of them.

    >>> accurate(["2"], ["a", "b"]), accurate(["b", "a"], ["a", "b"])
    (2, ['b', 'a'])
    """
    if len(given) == 1 and given[0].isdecimal() and given[0] not in outputs:
        return int(given[0])
    return given
