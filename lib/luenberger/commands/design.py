"""`design`: observers of every order for a plant, compared in a report."""

import contextlib
import dataclasses
import json
import os
import shutil
import tempfile
from argparse import Namespace
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .compare import estimated, question, within
from .registration import dry_run, file, folder, plant_of, register, sample
from .statistics import known_input, with_input
from .terminal import say, written

if TYPE_CHECKING:
    from ..formats.json_files import JsonFile
    from ..plant import Plant
    from ..run.measurements import Measurements

REPORT = "report.html"
ESTIMATES = "estimates.csv"
FROM_DATA = ("data.csv", ESTIMATES)
OBSERVER = "observer.json"
QUESTION = "question.json"  # --budget and --float where given, and what was fitted
RECOMMENDED = (OBSERVER, ESTIMATES)  # only where an observer is recommended
WRITTEN = ("design.ipynb", "plant.json", OBSERVER, "designs.csv")


def add(commands: Any) -> None:
    one = register(
        commands,
        "design",
        run,
        help="design observers of every order for a plant, and write a report",
        description="Design observers of every order for a plant, compare them, and "
        "write a report, the recommended observer and, with measurements, estimates. "
        "Without noise covariances nothing is recommended, and the report says how to "
        "get them. Prints what it wrote. All files appear at the end, together.",
        examples=[
            "design tracker.json --out report --data tracker.csv",
            "design reactor.json --out reactor --dry-run",
            "design tracker.json --out small --budget multiply_adds=12 --dry-run",
            "design tracker.json --k 'climb (m/s)=0,1,0' --out climb --dry-run",
            "design ball-and-beam.json --sample 0.1 --U 0 --out ball --dry-run",
        ],
    )
    one.add_argument("plant", type=file, metavar="PLANT.json")
    one.add_argument(
        "--out",
        type=folder,
        required=True,
        metavar="DIR",
        help="folder for the results",
    )
    one.add_argument(
        "--data",
        type=file,
        metavar="DATA.csv",
        help="measurements, in columns named after the plant's outputs and inputs",
    )
    within(one)
    estimated(one)
    known_input(one)
    sample(one)
    dry_run(one, "check the plant, the data and the folder")


def run(options: Namespace) -> None:
    """Run the report's notebook on a plant and put what it makes into a folder.

    Nothing appears there before everything is finished.
    """
    from ..formats.json_files import json_file
    from ..formats.spreadsheets import require_plain_names
    from ..plant.estimates import asking
    from ..report import notebook
    from ..report.result_files import FITTED
    from ..run import measurements

    file, out, fitted = json_file(options.plant, "a plant"), options.out, 0
    given = plant = asking(plant_of(file, options), options.k)
    require_plain_names(plant)
    record = None
    if options.data is not None:
        record = measurements.read(options.data, plant)
        plant = given if given.dt > 0 else _sampled_as(given, record, options.data)
        plant, fitted = _fitted(plant, record)
    plant = with_input(plant, options.U)
    _require_input(plant, record)
    asked = question(options)
    asked |= {FITTED: fitted} if fitted else {}
    beside = _workplace(out)
    if options.dry_run:
        with_data = options.data is not None
        written([out / name for name in _planned(plant, with_data, asked)], dry=True)
        return
    with contextlib.ExitStack() as stack:
        work = Path(tempfile.mkdtemp(prefix=".luenberger-", dir=beside))
        stack.callback(shutil.rmtree, work, ignore_errors=True)
        try:
            texts = {"plant.json": _content(plant, file)}
            if asked:
                texts[QUESTION] = json.dumps(asked, indent=2).encode() + b"\n"
            finished = _make(work, plant, texts, options.data)
        except notebook.NotebookError as error:
            raise ValueError(str(error)) from None
        paths = _publish(finished, out)
        written(paths, dry=False)
    if out / OBSERVER not in paths:
        say(f"{OBSERVER} is not written: nothing is recommended, the report says why")
    say(f"done: open {out / REPORT}")


def _require_input(plant: "Plant", record: "Measurements | None") -> None:
    """Raise if what is said of the input is wrong, before anything is designed."""
    from ..analysis.known_input import known_input
    from ..compare.stated_input import require_stated

    if plant.U is not None:
        known_input(plant)
        if record is not None:
            require_stated(plant, record.u)


def _planned(plant: "Plant", with_data: bool, asked: dict[str, Any]) -> list[str]:
    """The files of a run: without noise no observer is recommended, nor run."""
    from ..compare import noisy

    names = {*WRITTEN, REPORT, *(FROM_DATA if with_data else [])}
    names |= {QUESTION} if asked else set()
    return _in_order(names if noisy(plant) else names - set(RECOMMENDED))


def _sampled_as(plant: "Plant", record: "Measurements", data: Path) -> "Plant":
    """A continuous plant, sampled as often as a record."""
    from ..run.clock import periods

    if not record.stamps:
        raise ValueError(
            f"the plant is continuous, and {data} has no column of times; --sample DT "
            "says how many seconds its rows are apart"
        )
    steps = periods(record.time)
    if not len(steps) or not (steps == steps[0]).all():
        apart = f", {steps.min():g} to {steps.max():g} s apart" if len(steps) else ""
        raise ValueError(
            f"the plant is continuous, and the {len(record.time)} rows of {data} are "
            f"at no constant period{apart}; --sample DT gives the one to design for. "
            "lb.Filter(plant).run(table) filters at uneven instants"
        )
    say(f"sampled every {steps[0]:g} s, as {data} is")
    return plant.sampled(float(steps[0]))


def _fitted(plant: "Plant", record: "Measurements") -> tuple["Plant", int]:
    """The plant with the noise that it does not give, where the record tells it.

    And how many numbers a test of whiteness has to count as fitted.
    """
    from ..errors import DesignError
    from ..identification.fit import fit_missing, lacking

    if not lacking(plant) or plant.multiplicative or plant.is_complex:
        return plant, 0
    try:
        fit, said = fit_missing(plant, record.record)
    except DesignError as error:
        say(f"{' and '.join(lacking(plant))} cannot be fitted to the record: {error}")
        return plant, 0
    told = [*said, *fit.unidentifiable, *fit.whiteness.sentences]
    for sentence in told:
        say(sentence)
    about = [plant.description] if plant.description else []
    plant = dataclasses.replace(fit.plant, description=" ".join([*about, *told]))
    return plant, fit.whiteness.fitted


def _content(plant: "Plant", file: "JsonFile") -> bytes:
    """What plant.json holds: the bytes that were read, or what was made of them."""
    from ..formats import json_records
    from ..plant import Plant

    given = Plant.from_json(file)
    if given == plant:
        return file.content
    about = [plant.description] if plant.description else []
    if given.dt != plant.dt:
        about.append(
            f"Sampled every {plant.dt:g} s from the plant in continuous time, with "
            "inputs held between the samples."
        )
    told = dataclasses.replace(plant, description=" ".join(about) or None)
    return json_records.layout(json_records.as_data("plant", told)).encode()


def _make(
    work: Path, plant: "Plant", texts: dict[str, bytes], data: Path | None
) -> Path:
    """Everything that is to be written, in a folder below `work`.

    The notebook reads the bytes that were checked, not a file that may have changed.
    """
    from ..report import notebook

    finished = work / "out"
    finished.mkdir()
    for name, content in texts.items():
        (work / name).write_bytes(content)
    if data is not None:
        shutil.copyfile(data, work / "data.csv")
    given = [path.name for path in work.iterdir() if path.is_file()]
    made = notebook.read(notebook.TEMPLATES / "design.ipynb")
    notebook.run(made, work, progress=_show_progress)
    say(f"writing {REPORT}")
    notebook.write(made, finished / "design.ipynb")
    page = notebook.to_html(made, f"{plant.name or 'Plant'}: observer design")
    (finished / REPORT).write_text(page, encoding="utf-8", newline="")
    for name in given:
        os.replace(work / name, finished / name)
    return finished


def _workplace(out: Path) -> Path:
    """A folder on the disk of `out`, once that is seen to be usable."""
    from ..formats import atomic

    found = atomic.existing_folder(out)
    taken = [name for name in (*WRITTEN, *FROM_DATA) if (out / name).exists()]
    if taken and not (out / REPORT).exists():
        raise ValueError(
            f"{out} holds {', '.join(taken)} but no report, so these are not of an "
            "earlier run and would be overwritten; give --out another folder"
        )
    return found


def _in_order(names: Iterable[str]) -> list[str]:
    """File names by letter, the report last."""
    return sorted(names, key=lambda name: (name == REPORT, name))


def _publish(finished: Path, out: Path) -> Iterable[Path]:
    """Move finished files into `out`; returns where they are.

    What only a recommendation makes does not stay beside a report that has none, nor
    another run's budget.
    """
    from ..formats import atomic

    names = _in_order(path.name for path in finished.iterdir())
    moves = {finished / name: out / name for name in names}
    out.mkdir(parents=True, exist_ok=True)
    stale = [out / name for name in {*RECOMMENDED, QUESTION} - set(names)]
    atomic.replace_all(moves, beside=finished, gone=stale)
    return moves.values()


def _show_progress(step: int, steps: int, title: str) -> None:
    say(f"step {step} of {steps}: {title or 'Reading the plant'}")
