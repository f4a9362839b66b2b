"""`export`: an observer as C99 source."""

from pathlib import Path

from .registration import register


def add(commands):
    one = register(
        commands,
        "export",
        run,
        help="write an observer as C99 source",
        description="Write an observer as C99 source that allocates nothing: NAME.c "
        "and NAME.h. Compiled with -DNAME_SELFTEST it is a program that ends with 0 "
        "if it computes what Python does.",
        examples=["export report/observer.json --c firmware"],
    )
    one.add_argument("observer", type=Path, metavar="OBSERVER.json")
    one.add_argument(
        "--c", type=Path, required=True, metavar="DIR", help="folder for the two files"
    )
    one.add_argument(
        "--plant", type=Path, metavar="PLANT.json", help="names for the comments"
    )
    one.add_argument("--name", default="observer", help="of files and functions")
    one.add_argument("--float", action="store_true", help="float instead of double")


def run(options):
    """Write an observer as C and print what was written."""
    from ..export import to_c
    from ..observer import Observer
    from ..plant import Plant

    observer = Observer.from_json(options.observer)
    plant = None if options.plant is None else Plant.from_json(options.plant)
    dtype = "float" if options.float else "double"
    given = dict(plant=plant, name=options.name, dtype=dtype)
    for path in to_c(observer, options.c, **given):
        print(path)
