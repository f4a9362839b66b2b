"""Writes the marks as tables: python marks.py, in the folder of the course.

grades.csv has a row for each student and assignment, with the points of each task.
moodle.csv and canvas.csv have a row for each student, to import.  What was not handed
in, or still waits for marks by hand, is no number there, so that it is not taken for 0.
"""

import csv
import json
import re
from pathlib import Path

from nbgrader.api import Gradebook, MissingEntry

from luenberger.coursework import identifier

HERE = Path(__file__).parent
CANVAS = ("Student", "ID", "SIS User ID", "SIS Login ID", "Section")
MOODLE = ("First name", "Last name", "ID number", "Email address")
TASKS = range(1, 6)


def cells(path):
    """The cells of a notebook, with their sources joined."""
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        yield cell | {"source": "".join(cell["source"])}


def tasks(name):
    """The task to which each marked cell of an assignment belongs."""
    found, task = {}, 0
    for cell in cells(HERE / "source" / name / f"{name}.ipynb"):
        if heading := re.match(r"## Task (\d)", cell["source"]):
            task = int(heading[1])
        if cell["metadata"].get("nbgrader", {}).get("grade"):
            found[cell["metadata"]["nbgrader"]["grade_id"]] = task
    return found


def written_in(name, student):
    """The identifier that a notebook has in its first cell of code."""
    for cell in cells(HERE / "submitted" / student / name / f"{name}.ipynb"):
        if given := re.search(r"^student *= *(['\"])(.*)\1", cell["source"], re.M):
            return given[2]
    return ""


def ungraded(name, student):
    """Why there are no marks, judged by the files; empty if there are."""
    file = Path(student, name, f"{name}.ipynb")
    if (HERE / "autograded" / file).exists():
        return ""
    found = sorted((HERE / "submitted" / file).parent.glob("*.ipynb"))
    if not found:
        return "not handed in"
    if found[0].name != file.name:
        return f"not graded: {found[0].name!r} should be named {file.name!r}"
    return "not graded: see what nbgrader autograde says"


def row(book, name, student):
    """What became of an assignment: its state, its points and those of each task."""
    empty = dict(assignment=name, student=student.id, state="not handed in")
    try:
        notebook = book.find_submission_notebook(name, name, student.id)
    except MissingEntry:
        notebook = None
    if why := ungraded(name, student.id):
        return empty | {"state": why}
    if notebook is None:
        return empty
    grades, of = notebook.grades, tasks(name)
    waits = any(grade.needs_manual_grade for grade in grades)
    points = dict.fromkeys((f"task {task}" for task in TASKS), 0.0)
    for grade in grades:
        points[f"task {of[grade.name]}"] += grade.score
    given = written_in(name, student.id)
    other = identifier(given) != identifier(student.id)
    return empty | points | dict(
        state="waits for marks by hand" if waits else "marked",
        points=sum(points.values()),
        identifier=f"the notebook says {given!r}" if other else "",
    )  # fmt: skip


def write(name, rows):
    with (HERE / name).open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows(rows)


def main():
    with Gradebook(f"sqlite:///{HERE / 'gradebook.db'}") as book:
        names = [assignment.name for assignment in book.assignments]
        most = [int(assignment.max_score) for assignment in book.assignments]
        people = sorted(book.students, key=lambda student: student.id)
        found = [[row(book, name, student) for name in names] for student in people]
        who = [
            (one.first_name or "", one.last_name or "", one.id, one.email or "")
            for one in people
        ]
    columns = ["assignment", "student", "state", "points"]
    columns += [*(f"task {task}" for task in TASKS), "identifier"]
    every = [[one.get(column, "") for column in columns] for of in found for one in of]
    write("grades.csv", [columns, *every])
    totals = [
        [one["points"] if one["state"] == "marked" else "" for one in of]
        for of in found
    ]
    write("moodle.csv", [[*MOODLE, *names], *([*w, *t] for w, t in zip(who, totals))])
    possible = ["    Points Possible", *[""] * (len(CANVAS) - 1), *most]
    rows = [
        [f"{last}, {first}".strip(", "), "", student, student, "", *total]
        for (first, last, student, _), total in zip(who, totals)
    ]
    write("canvas.csv", [[*CANVAS, *names], possible, *rows])


if __name__ == "__main__":
    main()
