"""A comparison in Markdown, in LaTeX and as a data frame."""

import sys

import numpy as np
import pytest

import luenberger as lb
from luenberger.show import Table

NASTY = "a|b_c*d$e&f#g%h~i^j<k>[l]{m}\\n`"


@pytest.fixture(scope="module")
def table():
    plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0,
                     Q=[[0.25, 0.5], [0.5, 1]], R=[[0.01]],
                     output_names=["range_1|near"])  # fmt: skip
    methods = ["Kalman filter", "Leondes-Novak filter", "functional observer"]
    return lb.compare(plant, methods=methods)


def test_markdown_has_every_design_and_the_recommended_one_in_bold(table):
    head, rule, *lines = table.to_markdown().splitlines()
    assert len(lines) == len(table.designs)
    columns = head.count(" | ") + 1
    assert rule.count(":") == columns == len(table.table.header)
    for line, one in zip(lines, table.designs):
        assert line.count(" | ") + 1 == columns, "a name has split a cell"
        assert ("**" in line) == (one is table.chosen)
    assert "range\\_1\\|near" in table.to_markdown()


def test_latex_has_every_design_and_the_recommended_one_in_bold(table):
    lines = [one for one in table.to_latex().splitlines() if one.endswith(r"\\")]
    assert len(lines) == 1 + len(table.designs)
    assert {line.count(" & ") for line in lines} == {len(table.table.header) - 1}
    bold = [r"\textbf" in line for line in lines[1:]]
    assert bold == [one is table.chosen for one in table.designs]
    assert r"range\_1\textbar{}near" in table.to_latex()


def test_every_sign_of_a_markup_is_escaped():
    shown = Table(["x"], [[NASTY]])
    cell = shown.to_markdown().splitlines()[-1][2:-2]
    assert cell.replace("\\", "") == NASTY.replace("\\", "")
    assert all(f"\\{sign}" in cell for sign in "|_*$#~<>[]{}\\`")
    cell = shown.to_latex().splitlines()[4]
    assert all(f"\\{sign}" in cell for sign in "_$&#%{}")
    for name in ("asciitilde", "asciicircum", "less", "greater", "bar", "backslash"):
        assert rf"\text{name}{{}}" in cell
    two = Table(["x"], [["first\nsecond"]])
    assert "first second" in two.to_markdown() and "first second" in two.to_latex()


def test_numbers_are_flush_right_and_empty_cells_stay_empty():
    shown = Table(["name", "n"], [["a", 1], ["", -2]], marked=[1])
    assert shown.to_markdown().splitlines()[1:] == [
        "| :--- | ---: |", "| a | 1 |", "|  | **-2** |"]  # fmt: skip
    assert shown.to_latex().startswith("\\begin{tabular}{lr}")


def test_a_frame_has_every_attempt_with_its_figures(table):
    frame = table.to_frame()
    assert len(frame) == len(table) and list(frame.columns) == [*table.rows()[0]]
    assert frame.loc[frame.recommended, "label"].tolist() == [table.chosen.label]
    kalman = frame[frame.method == "Kalman filter"].iloc[0]
    assert np.isclose(kalman.error_trace, table.find("Kalman filter").trace)
    refused = frame[frame.method == "functional observer"].iloc[0]
    assert "needs k" in refused.refusal and np.isnan(refused.error_trace)


def test_without_pandas_a_frame_says_what_to_do(table, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match=r"pip install pandas, or take rows\(\)"):
        table.to_frame()
