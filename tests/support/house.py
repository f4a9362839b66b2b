"""The house of lib/ARCHITECTURE.md: its rooms, and which room a file is in.

`matrixproof` is a package of its own, and here the room on the ground.
"""

import ast
import pathlib
import re

ROOT = pathlib.Path(__file__).parents[2]
LIB = ROOT / "lib"
PACKAGE, ENGINE = LIB / "luenberger", LIB / "matrixproof"
PAGE = (LIB / "ARCHITECTURE.md").read_text(encoding="utf-8")
ROOMS = {  # room: the rooms it may use; from the bottom floor up
    room: re.findall(r"`([^`]+)`", uses)
    for room, uses in re.findall(r"^\| `([^`]+)` \| .+ \| (.+) \|$", PAGE, flags=re.M)
}
FILES = [*sorted(PACKAGE.rglob("*.py")), *sorted(ENGINE.rglob("*.py"))]
FILES = [path for path in FILES if "templates" not in path.parts]
DOOR = PACKAGE / "__init__.py"  # the public names come from everywhere


def parts_of(path):
    """The parts of a path below luenberger; others begin with their package."""
    return path.relative_to(PACKAGE if PACKAGE in path.parents else LIB).parts


def relative(path):
    return "/".join(parts_of(path))


def room_of(*parts):
    """The room of a module, given by the parts of its path; None for the top."""
    inner = ("/".join(parts[:k]) for k in range(len(parts), 0, -1))
    return next((room for room in inner if room in ROOMS), None)


def room_of_file(path):
    return room_of(*parts_of(path.with_suffix("")))


def statements(node, inside=False):
    """The statements in a tree of Python, each with whether a function is around it."""
    inside |= isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    for name in ("body", "orelse", "finalbody", "handlers", "cases"):
        for one in getattr(node, name, ()):
            yield one, inside
            yield from statements(one, inside)


def module(*parts):
    """The file of a module, or None."""
    path = (LIB if parts[:1] == (ENGINE.name,) else PACKAGE).joinpath(*parts)
    files = (path / "__init__.py", path.with_suffix(".py"))
    return next((file for file in files if file.is_file()), None)
