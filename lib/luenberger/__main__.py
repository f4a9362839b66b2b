"""The command line.

python -m luenberger design PLANT.json --out DIR
python -m luenberger export OBSERVER.json --c DIR
"""

import argparse
import contextlib
import os
import shutil
import signal
import sys
import tempfile
from pathlib import Path

from . import measurements, offline
from .export import to_c
from .observer import Observer
from .plant import Plant

REPORT = "report.html"
WRITTEN = ("design.ipynb", "plant.json", "data.csv", "observer.json", "designs.csv")
FAILED = 2


def main(arguments=None):
    """Run a command; returns the exit status, 2 when something was refused."""
    options = _parser().parse_args(arguments)
    # ended from outside is like interrupted: temporary folders are to be removed
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    try:
        options.run(options)
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        return _fail(f"{where}{error.strerror or error}")
    except (ValueError, offline.NotebookError) as error:
        return _fail(str(error))
    except KeyboardInterrupt:
        _say("luenberger: interrupted; nothing was written")
        return 128 + signal.SIGINT
    return 0


def _parser():
    parser = argparse.ArgumentParser(
        prog="python -m luenberger", description="Reduced-order state observers."
    )
    commands = parser.add_subparsers(dest="command", required=True)
    _design_options(commands)
    _export_options(commands)
    return parser


def _design_options(commands):
    one = commands.add_parser(
        "design",
        help="design observers of every order for a plant, and write a report",
        description="Design observers of every order for a plant, compare them, and "
        "write a report, the recommended observer and, with measurements, estimates.",
    )
    one.set_defaults(run=lambda given: design(given.plant, given.out, given.data))
    one.add_argument("plant", type=Path, metavar="PLANT.json")
    one.add_argument(
        "--out", type=Path, required=True, metavar="DIR", help="folder for the results"
    )
    one.add_argument(
        "--data",
        type=Path,
        metavar="DATA.csv",
        help="measurements, in columns named after the plant's outputs and inputs",
    )


def _export_options(commands):
    one = commands.add_parser(
        "export",
        help="write an observer as C99 source",
        description="Write an observer as C99 source that allocates nothing: NAME.c "
        "and NAME.h. Compiled with -DNAME_SELFTEST it is a program that ends with 0 "
        "if it computes what Python does.",
    )
    one.set_defaults(run=export)
    one.add_argument("observer", type=Path, metavar="OBSERVER.json")
    one.add_argument(
        "--c", type=Path, required=True, metavar="DIR", help="folder for the two files"
    )
    one.add_argument(
        "--plant", type=Path, metavar="PLANT.json", help="names for the comments"
    )
    one.add_argument("--name", default="observer", help="of files and functions")
    one.add_argument("--float", action="store_true", help="float instead of double")


def export(options):
    """Write an observer as C and print what was written."""
    observer = Observer.from_json(options.observer)
    plant = None if options.plant is None else Plant.from_json(options.plant)
    dtype = "float" if options.float else "double"
    given = dict(plant=plant, name=options.name, dtype=dtype)
    for path in to_c(observer, options.c, **given):
        print(path)


def design(plant_path, out, data_path=None):
    """Run the report's notebook on a plant and put what it makes into `out`.

    Nothing appears in `out` before everything is finished.
    """
    plant = Plant.from_json(plant_path)
    if data_path is not None:
        measurements.read(data_path, plant)
    beside = _existing_parent(out)
    with contextlib.ExitStack() as stack:
        work = Path(tempfile.mkdtemp(prefix=".luenberger-", dir=beside))
        stack.callback(shutil.rmtree, work, ignore_errors=True)
        shutil.copyfile(plant_path, work / "plant.json")
        if data_path is not None:
            shutil.copyfile(data_path, work / "data.csv")
        (work / "out").mkdir()
        notebook = offline.read(offline.TEMPLATES / "design.ipynb")
        offline.run(notebook, work, progress=_show_progress)
        _say(f"writing {REPORT}")
        finished = work / "out"
        offline.write(notebook, finished / "design.ipynb")
        page = offline.to_html(notebook, f"{plant.name or 'Plant'}: observer design")
        (finished / REPORT).write_text(page, encoding="utf-8")
        for given in (work / "plant.json", work / "data.csv"):
            if given.exists():
                os.replace(given, finished / given.name)
        _publish(finished, out)
    _say(f"done: open {out / REPORT}")


def _existing_parent(out):
    """The nearest folder above `out` that exists, once `out` is seen to be usable."""
    if out.exists() and not out.is_dir():
        raise ValueError(f"{out} is a file; --out must name a folder")
    taken = [name for name in (*WRITTEN, "estimates.csv") if (out / name).exists()]
    if taken and not (out / REPORT).exists():
        raise ValueError(
            f"{out} holds {', '.join(taken)} but no report, so these are not of an "
            "earlier run and would be overwritten; give --out another folder"
        )
    parent = Path(os.path.abspath(out)).parent
    while not parent.exists():
        parent = parent.parent
    return parent


def _publish(finished, out):
    """Move finished files into `out`, the report last.

    Estimates of an earlier run do not stay beside a report that has none.
    """
    out.mkdir(parents=True, exist_ok=True)
    made = sorted(finished.iterdir(), key=lambda path: (path.name == REPORT, path.name))
    for path in made:
        os.replace(path, out / path.name)
    if not any(path.name == "estimates.csv" for path in made):
        (out / "estimates.csv").unlink(missing_ok=True)


def _show_progress(step, steps, title):
    _say(f"step {step} of {steps}: {title or 'Reading the plant'}")


def _say(text):
    print(text, file=sys.stderr, flush=True)


def _fail(message):
    _say(f"luenberger: {message}")
    return FAILED


if __name__ == "__main__":
    sys.exit(main())
