"""The coursework: every wrong answer gets its lesson, and nbgrader gives the marks.

tests/course/NAME.toml holds the wrong answers to assignment NAME.
"""

import ast
import contextlib
import copy
import csv
import dis
import html
import io
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from functools import cache
from types import CodeType

import browsing
import pytest

ROOT = pathlib.Path(__file__).parents[2]
COURSE = ROOT / "notebooks" / "coursework"
NAMES = sorted(path.parent.name for path in COURSE.glob("source/*/*.ipynb"))
STEPS = (
    *("install", "copy", "release", "hand out", "students"),
    *("grade", "key", "feedback", "marks"),
)
REGION = re.compile(r"^[ \t]*### BEGIN (\w+).*?^[ \t]*### END \1[^\n]*\n?", re.M | re.S)


def assignment(name, folder=COURSE / "source"):
    """A notebook as JSON, with the sources of its cells joined."""
    path = folder / name / f"{name}.ipynb"
    notebook = json.loads(path.read_text(encoding="utf-8"))
    for cell in notebook["cells"]:
        cell["source"] = "".join(cell["source"])
    return notebook


def role(cell):
    return cell["metadata"].get("nbgrader", {})


def named(notebook):
    """The cells with a role, by grade_id."""
    found = (cell for cell in notebook["cells"] if role(cell))
    return {role(cell)["grade_id"]: cell for cell in found}


def answers(notebook):
    """The solution cells of code, those that are written, and the checks, by id."""
    cells = named(notebook)
    solved = {k: c for k, c in cells.items() if role(c)["solution"]}
    code = {k: c for k, c in solved.items() if c["cell_type"] == "code"}
    checks = {k: c for k, c in cells.items() if role(c)["grade"] and k not in solved}
    return code, {k: c for k, c in solved.items() if k not in code}, checks


@cache
def tried(name):
    """The answers that are tried on an assignment, by kind."""
    text = (ROOT / "tests" / "course" / f"{name}.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


def mistakes(name):
    return tried(name)["mistake"]


def carried(name):
    return tried(name).get("carried", ())


def owned(name, answers):
    """The checks of some answers."""
    return {k for m in mistakes(name) if m["answer"] in answers for k in m["fails"]}


def submissions(name):
    """The mistakes that are handed in together, by number."""
    together = {}
    for mistake in mistakes(name):
        if "submission" in mistake:
            together.setdefault(mistake["submission"], []).append(mistake)
    return together


def graded(check, names):
    """What a check gives as nbgrader reads it, None for all its points, and prints."""
    cell, names, printed = ast.parse(check["source"]), dict(names), io.StringIO()
    value = None
    with contextlib.redirect_stdout(printed):
        if isinstance(cell.body[-1], ast.Expr):
            last = ast.Expression(cell.body.pop().value)
            exec(compile(cell, "check", "exec"), names)
            value = eval(compile(last, "check", "eval"), names)
        else:
            exec(compile(cell, "check", "exec"), names)
    return value, printed.getvalue()


# The notebooks themselves


@pytest.fixture(scope="module")
def solved():
    """The names that an assignment leaves behind, and its checks, run through once."""
    kept = {}

    def run(name):
        if name not in kept:
            notebook, names = assignment(name), {"__name__": name}
            for cell in notebook["cells"]:
                if cell["cell_type"] == "code":
                    exec(cell["source"], names)
            kept[name] = names, answers(notebook)[2]
        names, checks = kept[name]
        return dict(names), checks

    return run


@pytest.mark.parametrize("name", NAMES)
def test_points_and_tasks_are_stated(name):
    notebook = assignment(name)
    code, written, checks = answers(notebook)
    head = notebook["cells"][0]["source"]
    by_machine = sum(role(cell)["points"] for cell in checks.values())
    by_hand = sum(role(cell)["points"] for cell in written.values())
    assert (by_machine, by_hand) == (14, 6), "20 points, 6 of them by hand"
    assert "**Points** 20" in head and "**You will be able to**" in head
    minutes = re.search(r"\*\*Time\*\* (\d+) minutes", head)
    assert minutes and 60 <= int(minutes[1]) <= 120
    rows = re.findall(r"^\| \d .*?\|([ \d]*)\|([ \d]*)\|([ \d]*)\|$", head, re.M)
    stated = [[int(cell) if cell.strip() else 0 for cell in row] for row in rows]
    assert len(stated) == 5
    total = [int(minutes[1]), by_machine, by_hand]
    assert [sum(column) for column in zip(*stated)] == total
    tasks = [re.match(r"## Task (\d)", c["source"]) for c in notebook["cells"]]
    assert [int(task[1]) for task in tasks if task] == [1, 2, 3, 4, 5]


@pytest.mark.parametrize("name", NAMES)
def test_every_answer_and_check_is_covered_by_a_mistake(name):
    code, written, checks = answers(assignment(name))
    assert {mistake["answer"] for mistake in mistakes(name)} == set(code)
    assert {check for m in mistakes(name) for check in m["fails"]} == set(checks)
    handed_in = [m for together in submissions(name).values() for m in together]
    assert {check for m in handed_in for check in m["fails"]} == set(checks)
    for answer in code:
        assert sum(m["answer"] == answer for m in mistakes(name)) >= 2


def names_of(source):
    """The names that a cell takes from other cells, and those it sets."""
    parts, taken, own = [compile(source, "cell", "exec")], set(), set()
    for part in parts:  # the functions in the cell come after its own lines
        parts += [const for const in part.co_consts if isinstance(const, CodeType)]
        for step in dis.get_instructions(part):
            if step.opname in ("LOAD_NAME", "LOAD_GLOBAL"):
                taken |= {step.argval} - own
            elif step.opname == "STORE_NAME" and part is parts[0]:
                own.add(step.argval)
    return taken, own


@pytest.mark.parametrize("name", NAMES)
def test_an_answer_that_fails_does_not_spoil_the_next(name):
    """A check that reads more than its own answer is tried on what follows."""
    notebook = assignment(name)
    code, _, checks = answers(notebook)
    followed = {answer for each in carried(name) for answer in each["answers"]}
    comes_from = {}  # the answers that a name depends on
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            key = role(cell).get("grade_id")
            taken, own = names_of(cell["source"])
            needed = {key} & set(code)
            needed = needed.union(*(comes_from.get(name, ()) for name in taken))
            comes_from |= dict.fromkeys(own, needed)
            if key in checks:
                owners = {m["answer"] for m in mistakes(name) if key in m["fails"]}
                assert owners <= needed, key
                assert needed - owners <= followed, key


CARRIED = [(name, each) for name in NAMES for each in carried(name)]


@pytest.mark.parametrize("name, each", CARRIED)
def test_an_error_does_not_carry_forward(name, each, solved):
    """What follows from a wrong answer has all its points, and the wrong one none."""
    names, checks = solved(name)
    for code in each["answers"].values():
        exec(code, names)
    fails = set()
    for check in [key for key in checks if key in owned(name, each["answers"])]:
        try:
            exec(checks[check]["source"], names)
        except AssertionError:
            fails.add(check)
    assert fails == set(each["fails"])


MISTAKES = [(name, mistake) for name in NAMES for mistake in mistakes(name)]


@pytest.mark.parametrize(
    "name, mistake", MISTAKES, ids=[f"{name}-{m['says']}" for name, m in MISTAKES]
)
def test_a_wrong_answer_gets_its_lesson(name, mistake, solved):
    names, checks = solved(name)
    exec(mistake["code"], names)
    for k, check in enumerate(mistake["fails"]):
        if check in mistake.get("marks", {}):
            points, printed = graded(checks[check], names)
            assert points == mistake["marks"][check] < role(checks[check])["points"]
            assert mistake["says"] in printed
            continue
        with pytest.raises(Exception) as caught:
            exec(checks[check]["source"], dict(names))
        if k == 0:
            assert caught.type is AssertionError
            assert mistake["says"] in str(caught.value)


OTHERS = [(name, other) for name in NAMES for other in tried(name).get("right", ())]


@pytest.mark.parametrize(
    "name, other", OTHERS, ids=[f"{name}-{other['form']}" for name, other in OTHERS]
)
def test_a_right_answer_in_another_form_passes(name, other, solved):
    names, checks = solved(name)
    exec(other["code"], names)
    passes = owned(name, [other["answer"]])
    assert passes
    for check in passes:
        points, _ = graded(checks[check], names)
        assert points in (None, role(checks[check])["points"])


# The whole cycle, by the commands of the instructor's page


def commands():
    """The instructor's commands, one block for each step of the page."""
    page = (COURSE / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```sh\n(.*?)^```$", page, re.M | re.S)
    return dict(zip(STEPS, blocks, strict=True))


class Course:
    """A course in a folder of its own, and what nbgrader says of it."""

    def __init__(self, folder):
        self.folder = folder
        self.repository = folder / "repository"
        shutil.copytree(COURSE, self.repository / "notebooks" / "coursework")
        built = shutil.ignore_patterns("__pycache__", "build", "*.egg-info")
        shutil.copytree(ROOT / "lib", self.repository / "lib", ignore=built)
        shutil.copy(ROOT / "environment-pip.txt", self.repository)
        self.said = {}
        self.run("copy", self.repository)
        self.root = folder / "course"

    def run(self, step, cwd=None):
        binaries = str(pathlib.Path(sys.executable).parent)
        own = {
            f"JUPYTER_{kind}_DIR": str(self.folder / kind.lower())
            for kind in ("CONFIG", "DATA", "RUNTIME")
        }
        env = os.environ | own | {
            "PATH": binaries + os.pathsep + os.environ["PATH"],
            "PYTHONPATH": str(ROOT / "lib"),
            "IPYTHONDIR": str(self.folder / "ipython"),
            "OMP_NUM_THREADS": "1",
        }  # fmt: skip
        done = subprocess.run(
            ["sh", "-e", "-c", commands()[step]], cwd=cwd or self.root, env=env,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=1800,
        )  # fmt: skip
        assert done.returncode == 0, done.stdout[-5000:]
        self.said[step] = done.stdout

    def released(self, name):
        return assignment(name, self.root / "release")

    def hand_in(self, student, name, notebook):
        folder = self.root / "submitted" / student / name
        folder.mkdir(parents=True)
        (folder / f"{name}.ipynb").write_text(json.dumps(notebook), encoding="utf-8")

    def gradebook(self):
        from nbgrader.api import Gradebook

        return Gradebook(f"sqlite:///{self.root / 'gradebook.db'}")

    def marks(self, student, name):
        """The marks by the machine, by check."""
        with self.gradebook() as book:
            grades = book.find_submission_notebook(name, name, student).grades
            return {
                grade.name: grade.auto_score
                for grade in grades
                if grade.cell.cell_type == "code"
            }

    def mark_by_hand(self, student, name):
        """Full marks for what is written."""
        with self.gradebook() as book:
            notebook = book.find_submission_notebook(name, name, student)
            for grade in notebook.grades:
                if grade.cell.cell_type == "markdown":
                    grade.manual_score = grade.max_score
                    grade.needs_manual_grade = False
            book.db.commit()

    def feedback(self, student, name):
        """The text of a feedback page."""
        path = self.root / "feedback" / student / name / f"{name}.html"
        text = re.sub(r"<[^>]*>", "", path.read_text(encoding="utf-8"))
        return " ".join(html.unescape(text).split())


def answered(course, name, wrong=(), student=""):
    """The student's notebook with the right answers, but for the wrong ones."""
    notebook, source = course.released(name), named(assignment(name))
    own = next(cell for cell in notebook["cells"] if cell["id"] == "student")
    own["source"] = f"student = {student!r}"
    for key, cell in named(notebook).items():
        if role(cell)["solution"]:
            right = source[key]["source"]
            cell["source"] = re.sub(r"[ \t]*### (BEGIN|END).*\n?", "", right)
    for mistake in wrong:
        named(notebook)[mistake["answer"]]["source"] = mistake["code"]
    return notebook


def tampered(course, name):
    """The mistakes of submission 1, with checks that are edited, revalued or gone."""
    notebook = answered(course, name, submissions(name)[1])
    cells = named(notebook)
    cells["symbols"]["source"] += "\ndef same(*_):\n    return True\n\n\nspot = print"
    for check in answers(notebook)[2]:
        cells[check]["source"] = "pass"
        role(cells[check])["points"] = 100
    for gone in ("imports", "T", "check-T", "check-budget"):
        notebook["cells"].remove(cells[gone])
    return notebook


def clumsy(course, name):
    """Right answers, but copied, no code, too much output, and one without an end.

    That one does not return where only a hidden check asks.
    """
    loop = {
        "answer": "lazy-gain",
        "code": "def lazy_gain(Omega, R, m1):\n    while len(R) > 2:\n        pass\n"
        "    return Omega[1:, 1:2] / (Omega[1, 1] + R[1, 1])",
    }
    notebook = answered(course, name, [loop])
    cells = named(notebook)
    for copied, first in {"T": "T = 0", "check-units": "T"}.items():
        cell = copy.deepcopy(cells[copied]) | {"source": first, "id": f"{copied}-copy"}
        notebook["cells"].insert(notebook["cells"].index(cells[copied]), cell)
    cells["wrong-line"]["source"] = "wrong_line = = d"
    cells["factors"]["cell_type"] = "markdown"
    cells["factors"].pop("outputs"), cells["factors"].pop("execution_count")
    cells["units"]["source"] += "\nfor line in range(10**5):\n    print(line)"
    return notebook


@pytest.fixture(scope="module")
def course(tmp_path_factory):
    """Every assignment released, handed in, graded and sent back."""
    pytest.importorskip("nbgrader", reason="install nbgrader, the extra `course`")
    course = Course(tmp_path_factory.mktemp("coursework"))
    course.run("release")
    course.run("hand out")
    (course.root / "students.csv").write_text(STUDENTS, encoding="utf-8")
    course.run("students")
    for name in NAMES:
        course.hand_in("correct", name, answered(course, name, student="Correct"))
        course.hand_in("blank", name, course.released(name))
        for number, wrong in submissions(name).items():
            course.hand_in(f"wrong-{number}", name, answered(course, name, wrong))
    course.hand_in("tampered", FIRST, tampered(course, FIRST))
    course.hand_in("clumsy", FIRST, clumsy(course, FIRST))
    course.run("grade")
    course.run("key")
    for name in NAMES:
        course.mark_by_hand("correct", name)
    course.run("feedback")
    course.run("marks")
    return course


FIRST = "leondes-novak"
STUDENTS = """id,first_name,last_name,email
correct,Cora,Rect,cora@example.org
absent,Abe,Sent,abe@example.org
"""


def full(name):
    checks = answers(assignment(name))[2]
    return {check: role(cell)["points"] for check, cell in checks.items()}


def expected(name, wrong):
    lost = {check: 0 for mistake in wrong for check in mistake["fails"]}
    for mistake in wrong:
        lost |= mistake.get("marks", {})
    return full(name) | lost


@pytest.mark.course
@pytest.mark.parametrize("name", NAMES)
def test_the_student_version_holds_no_solution(name, course):
    given, source = sources(course.released(name)), sources(assignment(name))
    assert "BEGIN" not in given and "HIDDEN" not in given
    free = set(REGION.sub("", source).splitlines())
    hidden = set("\n".join(m[0] for m in REGION.finditer(source)).splitlines()) - free
    assert len(hidden) > 50
    assert not hidden & set(given.splitlines())
    assert not any(cell.get("outputs") for cell in course.released(name)["cells"])


def sources(notebook):
    return "\n".join(cell["source"] + "\n" for cell in notebook["cells"])


@pytest.mark.course
@pytest.mark.parametrize("name", NAMES)
def test_a_correct_submission_has_full_marks(name, course):
    assert course.marks("correct", name) == full(name)


@pytest.mark.course
@pytest.mark.parametrize("name", NAMES)
def test_a_blank_submission_has_none(name, course):
    assert set(course.marks("blank", name).values()) == {0}


HANDED_IN = [(name, number) for name in NAMES for number in submissions(name)]


@pytest.mark.course
@pytest.mark.parametrize("name, number", HANDED_IN)
def test_a_wrong_submission_has_the_marks_it_should(name, number, course):
    wrong = submissions(name)[number]
    assert course.marks(f"wrong-{number}", name) == expected(name, wrong)


@pytest.mark.course
@pytest.mark.parametrize("name, number", HANDED_IN)
def test_feedback_pages_teach(name, number, course):
    page = course.feedback(f"wrong-{number}", name)
    for mistake in submissions(name)[number]:
        raised = "" if "marks" in mistake else r"Error: [^\n]*"
        assert re.search(raised + re.escape(mistake["says"]), page)


@pytest.mark.course
def test_feedback_pages_need_no_network_and_name_their_checks(course):
    for student in ("correct", "wrong-1", "blank"):
        path = course.root / "feedback" / student / FIRST / f"{FIRST}.html"
        page = path.read_text(encoding="utf-8")
        assert '<html lang="en">' in page and "<math" in page
        assert not re.findall(
            r"<script|<link|(?:src|href)=.https?:|@import|url\(", page
        )
        listed = re.findall(r'<li><a href="#([\w-]+)">Task \d: \1</a>', page)
        assert set(answers(assignment(FIRST))[2]) <= set(listed)
        assert all(f'id="{check}"' in page for check in listed)


@pytest.mark.course
def test_the_markers_page_has_every_answer_and_its_marks(course):
    page = (course.root / "key.html").read_text(encoding="utf-8")
    assert "<script" not in page and "### " not in page and "$" not in page
    for name in NAMES:
        code, written, checks = answers(assignment(name))
        for key in code:
            assert f"<h4>{key}</h4>" in page
        for key, cell in (written | checks).items():
            assert f"{key}: {role(cell)['points']} points, by" in page
    assert page.count("<em>Marks:</em>") == 3 * len(NAMES)


@pytest.mark.course
def test_feedback_pages_have_no_barriers(course):
    if reason := browsing.missing():
        pytest.skip(reason)
    with (
        browsing.chromium_running() as browser,
        browsing.served(course.root) as address,
        browsing.window(browser) as page,
    ):
        for name in NAMES:
            browsing.visit(page, f"{address}/feedback/wrong-1/{name}/{name}.html")
            assert browsing.barriers(page) == []
        browsing.visit(page, f"{address}/key.html")
        assert browsing.barriers(page) == []


@pytest.mark.course
def test_an_endless_loop_and_clumsy_hands_cost_what_they_broke(course):
    marks = full(FIRST) | dict.fromkeys(
        ["check-lazy-gain-elsewhere", "check-wrong-line", "check-corrected"], 0
    )
    assert course.marks("clumsy", FIRST) == marks
    page = course.feedback("clumsy", FIRST)
    assert "KeyboardInterrupt" in page and "SyntaxError" in page
    assert len(page) < 300_000, "the lines of `units` are cut short"


@pytest.mark.course
def test_checks_that_were_tampered_with_are_restored(course):
    assert course.marks("tampered", FIRST) == course.marks("wrong-1", FIRST)


def table(course, name):
    with (course.root / name).open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.course
def test_the_marks_are_written_by_task(course):
    rows = {
        (row["assignment"], row["student"]): row for row in table(course, "grades.csv")
    }
    for name in NAMES:
        correct, blank = rows[name, "correct"], rows[name, "blank"]
        tasks = [float(correct[f"task {task}"]) for task in range(1, 6)]
        assert float(correct["points"]) == sum(tasks) == 20 and min(tasks) > 0
        assert (correct["state"], correct["identifier"]) == ("marked", "")
        assert blank["points"] == "0.0" and "says ''" in blank["identifier"]
        absent = rows[name, "absent"]
        assert (absent["state"], absent["points"]) == ("not handed in", "")
        wrong = rows[name, "wrong-1"]
        waits = wrong["state"] == "waits for marks by hand"
        assert waits and float(wrong["points"]) == sum(
            course.marks("wrong-1", name).values()
        )


@pytest.mark.course
def test_a_notebook_under_another_name_is_named(course):
    """It is no 0, and the instructor reads what to rename."""
    folder = course.root / "submitted" / "absent" / FIRST
    folder.mkdir(parents=True)
    (folder / "copy (1).ipynb").write_text("{}", encoding="utf-8")
    try:
        course.run("marks")
        [row] = [
            row
            for row in table(course, "grades.csv")
            if (row["student"], row["assignment"]) == ("absent", FIRST)
        ]
    finally:
        shutil.rmtree(folder.parent)
        course.run("marks")
    wanted = f"'copy (1).ipynb' should be named '{FIRST}.ipynb'"
    assert row["state"] == f"not graded: {wanted}"
    assert row["points"] == ""


@pytest.mark.course
def test_moodle_and_canvas_get_a_number_where_there_is_one(course):
    moodle = {row["ID number"]: row for row in table(course, "moodle.csv")}
    canvas = {row["SIS User ID"]: row for row in table(course, "canvas.csv")}
    assert moodle["correct"]["Email address"] == "cora@example.org"
    assert canvas["correct"]["Student"] == "Rect, Cora"
    assert canvas[""]["Student"].strip() == "Points Possible"
    for name in NAMES:
        assert canvas[""][name] == "20"
        for rows in (moodle, canvas):
            given = [
                rows[who][name] for who in ("correct", "blank", "absent", "wrong-1")
            ]
            assert given == ["20.0", "0.0", "", ""]


@pytest.mark.course
def test_messages_that_say_nothing_are_silent(course):
    assert "checksum" not in course.said["grade"].lower()


@pytest.mark.course
def test_the_hand_out_has_the_library_and_no_solution(course):
    folder = course.root / "hand-out"
    notebooks = {path.parent.name for path in folder.glob("*/*.ipynb")}
    assert notebooks == set(NAMES)
    [wheel] = folder.glob("*.whl")
    files = {path.name for path in folder.iterdir() if path.is_file()}
    assert files == {wheel.name, "requirements.txt", "INSTALL.md"}
    with zipfile.ZipFile(wheel) as archive:
        wanted = {"luenberger/coursework/chains.py", "matrixproof/checker.py"}
        assert wanted <= {*archive.namelist()}
        assert not [n for n in archive.namelist() if n.endswith(".ipynb")]
    required = (folder / "requirements.txt").read_text("utf-8").splitlines()
    assert required[-1] == f"./{wheel.name}"
    assert all("==" in line for line in required[:-1]) and len(required) == 7
    steps = (folder / "INSTALL.md").read_text("utf-8")
    assert len(re.findall(r"^\d\. ", steps, re.M)) == 5


@pytest.mark.course
@pytest.mark.parametrize("where", ["release", "wheel"])
def test_a_solution_is_not_handed_out(where, course, tmp_path):
    for name in ("release", "wheel"):
        shutil.copytree(course.root / name, tmp_path / name)
    for name in ("environment-pip.txt", "hand_out.py"):
        shutil.copy(course.root / name, tmp_path)
    if where == "release":
        path = COURSE / "source" / FIRST / f"{FIRST}.ipynb"
        shutil.copy(path, tmp_path / "release" / FIRST)
    else:
        [wheel] = (tmp_path / "wheel").iterdir()
        with zipfile.ZipFile(wheel, "a") as archive:
            archive.writestr("luenberger/answers.py", "### BEGIN SOLUTION")
    command = [sys.executable, "hand_out.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1 and "holds a solution" in done.stderr
    assert not (tmp_path / "hand-out").exists()


@pytest.mark.parametrize("name", NAMES)
def test_the_page_lists_the_assignment_and_its_minutes(name):
    minutes = re.search(r"\*\*Time\*\* (\d+)", assignment(name)["cells"][0]["source"])
    page = (COURSE / "README.md").read_text(encoding="utf-8")
    assert re.search(rf"^\| `{name}` \|.*\| {minutes[1]} \|$", page, re.M)


def test_the_page_installs_the_extra_that_is_pinned():
    settings = tomllib.loads((ROOT / "lib" / "pyproject.toml").read_text("utf-8"))
    extra = settings["project"]["optional-dependencies"]["course"]
    assert all("==" in package for package in extra)
    assert "[course]" in commands()["install"]
