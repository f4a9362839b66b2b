"""The environment is the pinned one, also with extras installed on top of it."""

import importlib.metadata
import pathlib
import re
import tomllib

import pytest

ROOT = pathlib.Path(__file__).parents[1]
PINS = dict(
    re.findall(
        r"^([\w-]+)==([\d.]+)$",
        (ROOT / "environment-pip.txt").read_text(encoding="utf-8"),
        re.M,
    )
)
PROJECT = tomllib.loads((ROOT / "lib" / "pyproject.toml").read_text(encoding="utf-8"))
EXTRAS = PROJECT["project"]["optional-dependencies"]
TOOLS = (
    "browser",
    "course",
    "forge",
    "site",
    "types",
)  # extras that the first commands omit


@pytest.mark.parametrize("name", PINS)
def test_what_is_installed_is_what_is_pinned(name):
    assert importlib.metadata.version(name) == PINS[name]


@pytest.mark.parametrize("extra", TOOLS)
def test_an_extra_is_exact_and_leaves_the_pins_alone(extra):
    for requirement in EXTRAS[extra]:
        name, _, version = requirement.partition("==")
        assert re.fullmatch(r"[\d.]+", version)
        assert PINS.get(name, version) == version


def test_the_first_commands_install_no_tools():
    given = [line for extra in TOOLS for line in EXTRAS[extra]]
    assert not {line.partition("==")[0] for line in given} & PINS.keys()
