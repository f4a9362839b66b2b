"""Every function says what it takes and gives, and the package says that it does.

mypy checks that what they say is true: `.ci/run` has it read [tool.mypy] of
lib/pyproject.toml.  Rooms listed there as not annotated yet are left out here too.
"""

import ast
import fnmatch
import pathlib
import tomllib

import pytest

LIB = pathlib.Path(__file__).parents[1] / "lib"
PROJECT = tomllib.loads((LIB / "pyproject.toml").read_text(encoding="utf-8"))["tool"]
NOT_YET = [
    pattern
    for part in PROJECT["mypy"]["overrides"]
    if part.get("ignore_errors")
    for pattern in part["module"]
]
FILES = [
    path.relative_to(LIB)
    for path in sorted((LIB / "luenberger").rglob("*.py"))
    if "templates" not in path.parts
]


def module(path):
    return ".".join(path.with_suffix("").parts).removesuffix(".__init__")


def done(path):
    """As mypy reads a pattern: a.* is a and what is in it."""
    name = module(path)
    return not any(
        fnmatch.fnmatchcase(f"{name}.", pattern) or name == pattern
        for pattern in NOT_YET
    )


def untyped(source):
    """Functions of which a parameter or the result has no annotation; self may not."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            given = node.args
            named = [*given.posonlyargs, *given.args, *given.kwonlyargs]
            named = [arg for arg in named if arg.arg not in ("self", "cls")]
            every = [*named, *filter(None, [given.vararg, given.kwarg])]
            if node.returns is None or not all(arg.annotation for arg in every):
                yield node.name


@pytest.mark.parametrize("path", [*filter(done, FILES)], ids=str)
def test_every_function_is_annotated(path):
    assert not list(untyped((LIB / path).read_text(encoding="utf-8")))


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("def f(x: int) -> int: ...", []),
        ("def f(x) -> int: ...", ["f"]),
        ("def f(*x, y: int) -> int: ...", ["f"]),
        ("def f(*, y) -> int: ...", ["f"]),
        ("async def f(x: int): ...", ["f"]),
        ("class A:\n    def f(self) -> None: ...", []),
        ("class A:\n    def f(self): ...", ["f"]),
        ("def f() -> None:\n    def g(): ...", ["g"]),
    ],
)
def test_this_test_reads_annotations(source, found):
    assert list(untyped(source)) == found


def test_the_package_says_that_it_is_typed():
    marker = LIB / "luenberger" / "py.typed"
    data = PROJECT["setuptools"]["package-data"]["luenberger"]
    assert marker.is_file() and marker.name in data
