"""`design`: observers of every order for a plant, compared in a report."""

import contextlib
import os
import shutil
import tempfile
from pathlib import Path

from .. import measurements, offline
from ..plant import Plant
from .registration import register
from .terminal import say

REPORT = "report.html"
WRITTEN = ("design.ipynb", "plant.json", "data.csv", "observer.json", "designs.csv")


def add(commands):
    one = register(
        commands,
        "design",
        run,
        help="design observers of every order for a plant, and write a report",
        description="Design observers of every order for a plant, compare them, and "
        "write a report, the recommended observer and, with measurements, estimates.",
        examples=[
            "design tracker.json --out report",
            "design tracker.json --out report --data tracker.csv",
        ],
    )
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


def run(options):
    """Design, or say what would be written."""
    try:
        design(options.plant, options.out, options.data)
    except offline.NotebookError as error:
        raise ValueError(str(error)) from None


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
        say(f"writing {REPORT}")
        finished = work / "out"
        offline.write(notebook, finished / "design.ipynb")
        page = offline.to_html(notebook, f"{plant.name or 'Plant'}: observer design")
        (finished / REPORT).write_text(page, encoding="utf-8")
        for given in (work / "plant.json", work / "data.csv"):
            if given.exists():
                os.replace(given, finished / given.name)
        _publish(finished, out)
    say(f"done: open {out / REPORT}")


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
    say(f"step {step} of {steps}: {title or 'Reading the plant'}")
