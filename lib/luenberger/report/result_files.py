"""The files of a design report: the observer, the table of designs, the estimates."""

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..formats import json_records
from ..formats.json_files import json_file
from ..run import measurements

FITTED = "fitted"  # where the command notes how many numbers it fitted


def files(table, estimates=None):
    """The report's results as texts by file name; no observer unless recommended."""
    out = {"designs.csv": designs_csv(table.rows())}
    if table.chosen is not None:
        data = json_records.as_data("observer", table.chosen.observer)
        out["observer.json"] = json_records.layout(data)
    if estimates is not None:
        file = io.StringIO()
        measurements.write(file, estimates)
        out["estimates.csv"] = file.getvalue()
    return out


def question(path="question.json"):
    """What `compare` is asked beside the plant; nothing without the file.

    It is the budget and the dtype that the command was given.
    """
    asked = _asked(path)
    asked.pop(FITTED, None)
    return asked


def fitted(path="question.json"):
    """How many numbers were fitted to the record beyond the innovation's covariance.

    The command notes it where it fits Q or R, and the test of whiteness counts it.
    """
    return _asked(path).get(FITTED, 0)


def _asked(path):
    path = Path(path)
    return json_file(path, "a question").data if path.exists() else {}


def save(texts, folder="out"):
    """Write the files into `folder` if there is such a folder, and nothing if not.

    The command makes the folder; a notebook run by hand or by a test has none.
    """
    folder = Path(folder)
    for name, text in texts.items() if folder.is_dir() else ():
        (folder / name).write_text(text, encoding="utf-8", newline="")


def designs_csv(rows: Sequence[Mapping[str, Any]]) -> str:
    """The rows of a comparison, a line each.

    Lists have spaces between, names semicolons; what does not apply is empty.
    """
    file = io.StringIO()
    out = csv.writer(file, lineterminator="\n")
    out.writerow(rows[0])
    for row in rows:
        out.writerow(_cell(value) for value in row.values())
    return file.getvalue()


def _cell(value):
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        between = "; " if all(isinstance(one, str) for one in value) else " "
        return between.join(map(str, value))
    return value
