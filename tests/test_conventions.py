"""What forges, editors and citation managers read is valid and agrees with the rest."""

import json
import re
import tomllib
from importlib.util import find_spec
from pathlib import Path

import pytest

from luenberger import ledger

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PROJECT = tomllib.loads((ROOT / "lib" / "pyproject.toml").read_text(encoding="utf-8"))
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
FORMS = sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml"))
CITATION = ROOT / "lib" / "CITATION.cff"
SCHEMAS = {
    **dict.fromkeys(WORKFLOWS, "vendor.github-workflows"),
    **dict.fromkeys(FORMS, "vendor.github-issue-forms"),
    ROOT / ".github" / "ISSUE_TEMPLATE" / "config.yml": "vendor.github-issue-config",
    CITATION: "vendor.citation-file-format",
}
needs_checker = pytest.mark.skipif(
    find_spec("check_jsonschema") is None,
    reason='no check of schemas without check-jsonschema: install -e "./lib[forge]"',
)


def refused(path, schema):
    """What the published schema says against a file; empty if nothing."""
    from check_jsonschema import main
    from click.testing import CliRunner

    arguments = ["--builtin-schema", schema, "--force-filetype", "yaml", str(path)]
    done = CliRunner().invoke(main, arguments)
    return done.output or str(done.exception) if done.exit_code else ""


@needs_checker
@pytest.mark.parametrize("path", SCHEMAS, ids=lambda path: path.name)
def test_a_file_meets_its_published_schema(path):
    assert not refused(path, SCHEMAS[path])


@needs_checker
@pytest.mark.parametrize(
    "path, line",
    [(WORKFLOWS[0], "runs-on: "), (FORMS[-1], "label: "), (CITATION, "title: ")],
    ids=lambda given: getattr(given, "name", given),
)
def test_a_file_without_a_line_does_not(path, line, tmp_path):
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    gone = next(k for k, text in enumerate(lines) if text.lstrip().startswith(line))
    damaged = tmp_path / path.name
    damaged.write_text("".join(lines[:gone] + lines[gone + 1 :]), encoding="utf-8")
    assert refused(damaged, SCHEMAS[path])


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.name)
def test_a_workflow_runs_what_everybody_runs(path):
    commands = re.findall(r"run: (\S+)", path.read_text(encoding="utf-8"))
    assert set(commands) == {".ci/run"}


def test_the_lanes_of_the_workflow_are_lanes_of_the_script():
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    for path in WORKFLOWS:
        for lane in re.findall(r"which: (--\w+)", path.read_text(encoding="utf-8")):
            assert f"#   .ci/run {lane} " in script


def test_the_workflow_covers_the_supported_pythons():
    given = re.search(r"python: (\[.*\])", WORKFLOWS[-1].read_text(encoding="utf-8"))
    assert json.loads(given[1]) == ["3.11", "3.12", "3.13"]
    assert "Python 3.11 to 3.13" in README
    assert PROJECT["project"]["requires-python"] == ">=3.11"


def test_the_hooks_use_the_pinned_linter():
    hooks = (ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8")
    pins = (ROOT / "environment-pip.txt").read_text(encoding="utf-8")
    used = set(re.findall(r"ruff==[\d.]+", hooks))
    assert used == set(re.findall(r"^ruff==[\d.]+", pins, re.M))


def test_other_places_install_what_the_readme_installs():
    binder = (ROOT / ".binder" / "requirements.txt").read_text(encoding="utf-8").split()
    assert binder == ["-r", "../environment-pip.txt"]
    container = ROOT / ".devcontainer" / "devcontainer.json"
    made = json.loads(container.read_text(encoding="utf-8"))["postCreateCommand"]
    assert f"{made} && .venv/bin/python -m pytest" in README


def test_the_citation_names_this_version_and_every_paper():
    text = CITATION.read_text(encoding="utf-8")
    assert f"\nversion: {PROJECT['project']['version']}\n" in text
    papers = [ledger.title(paper) for paper in ledger.PAPERS]
    assert len(papers) == 6
    for paper in papers:
        names, year = re.fullmatch(r"(.*) \((\d+)\)", paper).groups()
        if names == "Hsia":
            continue  # this project holds its last page only, without the title
        assert f"year: {year}" in text
        for name in names.split(" and "):
            assert f"family-names: {name}" in text
