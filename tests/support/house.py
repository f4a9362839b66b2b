"""The house of lib/ARCHITECTURE.md: its rooms, and which room a file is in."""

import ast
import pathlib
import re

ROOT = pathlib.Path(__file__).parents[2]
PACKAGE = ROOT / "lib" / "luenberger"
PAGE = (ROOT / "lib" / "ARCHITECTURE.md").read_text(encoding="utf-8")
ROOMS = {  # room: the rooms it may use; from the bottom floor up
    room: re.findall(r"`([^`]+)`", uses)
    for room, uses in re.findall(r"^\| `([^`]+)` \| .+ \| (.+) \|$", PAGE, flags=re.M)
}
FILES = sorted(path for path in PACKAGE.rglob("*.py") if "templates" not in path.parts)
DOOR = PACKAGE / "__init__.py"  # the public names come from everywhere


def relative(path):
    return path.relative_to(PACKAGE).as_posix()


def room_of(*parts):
    """The room of a module, given by the parts of its path; None for the top."""
    inner = ("/".join(parts[:k]) for k in range(len(parts), 0, -1))
    return next((room for room in inner if room in ROOMS), None)


def room_of_file(path):
    return room_of(*path.relative_to(PACKAGE).with_suffix("").parts)


def statements(node, inside=False):
    """The statements in a tree of Python, each with whether a function is around it."""
    inside |= isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    for name in ("body", "orelse", "finalbody", "handlers", "cases"):
        for one in getattr(node, name, ()):
            yield one, inside
            yield from statements(one, inside)


def is_module(parts):
    path = PACKAGE.joinpath(*parts)
    return path.with_suffix(".py").is_file() or (path / "__init__.py").is_file()
