"""Imports point one way, as lib/ARCHITECTURE.md says."""

import ast
import re
import subprocess
import sys
from functools import cache

import pytest
from house import (
    DOOR,
    FILES,
    PACKAGE,
    PAGE,
    ROOMS,
    ROOT,
    module,
    parts_of,
    relative,
    room_of,
    room_of_file,
    statements,
)

EVERYWHERE = {"numpy", "scipy"}
SPECIAL = {
    "matrixproof": {"sympy"},
    "theory": {"sympy"},
    "derivation": {"sympy"},
    "kernels": {"sympy", "numpy"},
    "ledger": {"sympy"},
    "coursework": {"sympy", "numpy"},
    "plot": {"numpy", "matplotlib"},
}
# Optional packages: only inside a function of these rooms.
INSIDE_A_FUNCTION = {
    "comparison": {"pandas"},
    "export": {"control"},
    "formats": {"pandas", "pyarrow"},
    "run": {"tqdm"},
    "filtering": {"numba"},
    "kernels": {"numba"},
    "ledger": {"latex2mathml"},
    "show": {"matplotlib"},
    "report": {"matplotlib"},
}


def imports(source, package):
    """Rooms, outside names at module level, and outside names inside functions.

    `package` is the path of the module's package below luenberger, as a tuple.
    """
    rooms, outside, inside = set(), set(), set()
    for node, lazy in statements(ast.parse(source)):
        names = inside if lazy else outside
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            target = tuple((node.module or "").split(".")) if node.module else ()
            if node.level:
                target = package[: len(package) - (node.level - 1)] + target
            elif target[0] == "luenberger":
                target = target[1:]
            elif target[0] != "matrixproof":
                names.add(target[0])
                continue
            for alias in node.names:
                whole = (*target, alias.name)
                rooms.add(room_of(*(whole if module(*whole) else target)))
    standard = sys.stdlib_module_names
    return rooms, outside - standard, inside - standard


@cache
def read(path):
    package = parts_of(path)[:-1]
    return imports(path.read_text(encoding="utf-8"), package)


def used(room):
    """The rooms that a room's files import."""
    files = [path for path in FILES if path != DOOR and room_of_file(path) == room]
    assert files, f"lib/ARCHITECTURE.md has a room {room}, which is empty"
    return set().union(*(read(path)[0] for path in files)) - {room}


def test_imports_point_one_way():
    for path in FILES:
        name, (rooms, outside, inside) = relative(path), read(path)
        room = room_of_file(path)
        if path != DOOR:
            assert room, f"say in lib/ARCHITECTURE.md which room {name} is in"
            assert rooms <= {*ROOMS[room], room}, f"{name} in {room} imports {rooms}"
        kinds = [room or "", "derivation" if "derivation" in path.parts else ""]
        kinds += [kind.partition("/")[0] for kind in kinds]
        kind = next((kind for kind in kinds if kind in SPECIAL), kinds[2])
        assert outside <= SPECIAL.get(kind, EVERYWHERE), name
        optional = INSIDE_A_FUNCTION.get(kind, set())
        assert inside <= SPECIAL.get(kind, EVERYWHERE) | optional, name


def test_the_page_has_no_arrow_too_many():
    assert len(ROOMS) > 20
    assert {room: sorted(used(room)) for room in ROOMS} == {
        room: sorted(uses) for room, uses in ROOMS.items()
    }


def test_only_these_load_modules_by_name():
    """Whom the page says so of, and doors that load on demand."""
    found = {relative(path) for path in FILES if "import_module" in path.read_text()}
    assert found == {"__init__.py", "stage_list.py", "ledger/evidence.py"}


def test_no_room_uses_one_on_its_own_floor_or_above():
    order = list(ROOMS)
    for room, uses in ROOMS.items():
        assert set(uses) <= set(order[: order.index(room)]), room


def test_no_paper_uses_another():
    for room, uses in ROOMS.items():
        if room.startswith("papers/"):
            paper = room.split("/")[1]
            others = {use.split("/")[1] for use in uses if use.startswith("papers/")}
            assert others <= {paper}


@pytest.mark.parametrize("journey", PAGE.split("\n**")[1:], ids=lambda t: t[:20])
def test_what_a_journey_passes_is_there(journey):
    stops = re.findall(r"`([\w/]+\.py)` `(\w+)`", journey)
    assert len(stops) > 3
    for path, name in stops:
        tree = ast.parse((PACKAGE / path).read_text(encoding="utf-8"))
        there = {getattr(node, "name", None) for node in tree.body}
        there |= {
            target.id
            for node in tree.body
            if isinstance(node, ast.Assign)
            for target in node.targets
            if isinstance(target, ast.Name)
        }
        assert name in there, f"{path} has no {name}"


@pytest.mark.parametrize("folder", sorted(PACKAGE.glob("**/derivation")))
def test_a_front_door_names_its_pages_in_reading_order(folder):
    door = ast.get_docstring(ast.parse((folder / "__init__.py").read_text("utf-8")))
    named = door.partition("In reading order:")[2].partition("\n\n")[0]
    listed = re.findall(r"`(\w+)`", named)
    pages = {path.stem for path in folder.glob("*.py")} - {"__init__", "letters"}
    assert len(listed) == len(set(listed)) and set(listed) == pages


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("import sympy as sp", (set(), {"sympy"}, set())),
        ("from ...plant import Plant", ({"plant"}, set(), set())),
        ("from ... import kernels", ({"kernels"}, set(), set())),
        ("from .recurrences import functionals", ({"papers/moore"}, set(), set())),
        ("from .derivation import signs", ({"papers/moore/derivation"}, set(), set())),
        ("from luenberger.run import simulate", ({"run"}, set(), set())),
        ("from matrixproof.prose import plain", ({"matrixproof"}, set(), set())),
        ("import matrixproof", (set(), {"matrixproof"}, set())),
        ("def f():\n    import control", (set(), set(), {"control"})),
        (
            "class A:\n  def f():\n    if x: pass\n    else:\n      import control",
            (set(), set(), {"control"}),
        ),
        ("try:\n  pass\nexcept E:\n  import control", (set(), {"control"}, set())),
        ("import json", (set(), set(), set())),
    ],
)
def test_this_test_reads_imports(source, found):
    assert imports(source, ("papers", "moore")) == found


def test_importing_the_library_is_light():
    heavy = ("sympy", "matplotlib", "numba", "control", "nbformat", "IPython")
    heavy += ("concurrent.futures.process", "dask", "tqdm")
    heavy += ("scipy.optimize", "scipy.sparse.csgraph", "scipy.spatial", "scipy.fft")
    heavy += ("luenberger.plot", "luenberger.report", "luenberger.export")
    code = (
        "import sys, scipy.linalg\n"  # SciPy 1.15 loads its graphs here
        "before = {*sys.modules}\n"
        "import luenberger\n"
        "dir(luenberger), luenberger.__version__\n"
        f"print(*{{*sys.modules}} - before & {{*{heavy!r}}})"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert run.stdout.split() == []


def test_top_level_of_the_repository():
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True
    )
    if listed.returncode:
        pytest.skip("not a git checkout")
    top = {name.partition("/")[0] for name in listed.stdout.split("\0") if name}
    fixed = {"README.md", "environment-pip.txt", "notebooks", "lib", "tests"}
    assert {name for name in top if not name.startswith(".")} <= fixed
