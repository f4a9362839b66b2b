"""The files of a design report: the observer, the table of designs, the estimates."""

import csv
import io
from pathlib import Path

from . import measurements, record


def files(survey, estimates=None):
    """The report's results as texts by file name."""
    chosen = survey.recommended()
    out = {
        "observer.json": record.layout(record.as_data("observer", chosen.observer)),
        "designs.csv": _designs_csv(survey),
    }
    if estimates is not None:
        file = io.StringIO()
        measurements.write(file, survey.plant, estimates)
        out["estimates.csv"] = file.getvalue()
    return out


def save(texts, folder="out"):
    """Write the files into `folder` if there is such a folder, and nothing if not.

    The command makes the folder; a notebook run by hand or by a test has none.
    """
    folder = Path(folder)
    for name, text in texts.items() if folder.is_dir() else ():
        (folder / name).write_text(text, encoding="utf-8", newline="")


def _designs_csv(survey):
    file = io.StringIO()
    out = csv.writer(file, lineterminator="\n")
    out.writerow(
        "accurate,gain,order,error_trace,excess,multiply_adds,certificate,poles,"
        "refusal".split(",")
    )
    for one in survey.attempts:
        names = "; ".join(survey.plant.output_names[k] for k in one.accurate)
        row = [names, one.horizon, one.order]
        if one.refusal:
            out.writerow([*row, "", "", "", "", "", one.refusal])
            continue
        poles = " ".join(str(complex(pole)).strip("()") for pole in one.observer.poles)
        found = [one.trace, float(survey.excess(one)), one.work, one.certificate.worst]
        out.writerow([*row, *found, poles, ""])
    return file.getvalue()
