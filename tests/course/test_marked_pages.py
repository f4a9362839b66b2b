"""What a student writes is shown on the pages for markers and students, and is text."""

import importlib.util
import pathlib

import pytest

COURSE = pathlib.Path(__file__).parents[2] / "notebooks" / "coursework"


@pytest.fixture(scope="module")
def with_formulas():
    pytest.importorskip("nbconvert", reason="needs the extra report")
    where = importlib.util.spec_from_file_location("key", COURSE / "key.py")
    program = importlib.util.module_from_spec(where)
    where.loader.exec_module(program)
    return program.with_formulas


ATTACKS = (
    "<script>alert(1)</script>",
    "<SCRIPT src=x></SCRIPT>",
    "<img src=x onerror=alert(1)>",
    '<p onclick="alert(1)">here</p>',
    "[here](javascript:alert(1))",
    '<a href="javascript:alert(1)">here</a>',
    "<iframe src=x></iframe>",
    r"$\text{<script>alert(1)</script>}$",
    r"$\text{<img src=x onerror=alert(1)>}$",
    r"$\text{</mtext><script>alert(1)</script><mtext>}$",
    r"$\href{javascript:alert(1)}{x}$",
    r"$$\text{<meta http-equiv='refresh' content='0'/>}$$",
)


@pytest.mark.parametrize("source", ATTACKS)
def test_nothing_that_a_student_writes_runs(source, with_formulas):
    page = with_formulas(source).lower()
    for tag in ("<script", "<img", "<iframe", "<meta", "<p on", 'href="java'):
        assert tag not in page
    assert "alert" in page or "src" in page or "refresh" in page or "here" in page


@pytest.mark.parametrize(
    "source",
    [r"$\left( x$", r"$\begin{bmatrix}1&2$", r"$x^2^3$", "$_$", r"$\text{a<b>}$"],
)
def test_a_formula_that_is_not_latex_is_shown_as_it_was_written(source, with_formulas):
    page = with_formulas(f"before {source} after $K = P C'$ end")
    assert "before" in page and "after" in page and page.count("<math") == 1
    shown = page.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")
    assert source in shown.replace("<em>", "_").replace("</em>", "_")


def test_what_a_text_needs_stays(with_formulas):
    text = "# Task\n\n*one* **two** `x < 1`\n\n- three\n\n"
    text += "| a | b |\n|-|-|\n| 1 | $x<2$ |\n"
    page = with_formulas(
        text + "\n```python\ny < 1\n```\n\n[page](https://example.org)\n"
    )
    for part in (
        '<h1 id="Task">', "<em>one</em>", "<strong>two</strong>",
        "<code>x &lt; 1</code>",
        "<li>three</li>", "<td>1</td>", "<mo>&#x0003C;</mo>", '<div class="highlight">',
        '<a href="https://example.org">page</a>',
    ):  # fmt: skip
        assert part in page, part
    block = with_formulas("$$K = P C'$$")
    assert 'display="block" tabindex="0"' in block
