"""The ledger as one HTML page: no script, no request, filtered by style sheet alone."""

import html
import re
from collections.abc import Iterator
from pathlib import Path
from textwrap import dedent
from typing import Any

from matrixproof import Chain, latex

from ..formats import writing
from .records import PARTS, Entry, count, entries, find_paper, misprints, title

Papers = tuple[str, ...]

MATRIX = re.compile(r"\\begin\{bmatrix\}(.*?)\\end\{bmatrix\}")

HEAD = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy"
 content="default-src 'none'; style-src 'unsafe-inline'">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>The equation ledger</title>
<style>
body { max-width: 86em; margin: 2em auto; padding: 0 1em; color: #1a1a1a;
       font: 16px/1.5 system-ui, "Segoe UI", "Helvetica Neue", Arial, sans-serif; }
h1 { font-size: 1.7em; margin: 0 0 .4em; }
input { margin: 0 .3em 0 0; }
label { margin-right: 1.2em; white-space: nowrap; }
table { border-collapse: collapse; width: 100%; font-size: .9em; }
th { text-align: left; border-bottom: 2px solid #444; }
th, td { padding: .35em .7em .35em 0; vertical-align: top; }
td { border-bottom: 1px solid #ddd; }
code { font: .88em ui-monospace, Menlo, Consolas, monospace; overflow-wrap: anywhere; }
summary { cursor: pointer; }
summary::marker { color: #0072b2; }
.scrolls { overflow: auto hidden; padding: .15em 0; }
pre { overflow-x: auto; margin: .3em 0; }
table { table-layout: fixed; }
th:nth-child(1) { width: 10%; } th:nth-child(2) { width: 46%; }
th:nth-child(4) { width: 14%; }
.says, details { padding: .1em 0; overflow-x: auto; }
td p { margin: 0 0 .3em; }
.failed { color: #b00020; font-weight: bold; }
.slip { margin: .3em 0 0; padding-left: .6em; border-left: 3px solid #d55e00; }
.count { display: none; }
@media (max-width: 45em) { /* a row is a card */
  thead { display: none; }
  table, tbody, tr, td { display: block; }
  tr { border-bottom: 1px solid #444; padding: .4em 0; }
  td { border: 0; padding: .1em 0; overflow-wrap: anywhere; }
  label { white-space: normal; }
}
"""


def write(path: str | Path, paper: str | None = None, formulas: bool = True) -> None:
    """See `ledger.write_page`."""
    writing.write(path, render(paper, formulas))


def render(paper: str | None = None, formulas: bool = True) -> str:
    """The page as text."""
    papers = PARTS if paper is None else (find_paper(paper),)
    rows = [_row(e, formulas) for key in papers for e in entries(key)]
    body = [
        "<h1>The equation ledger</h1>",
        "<p>Every numbered equation of the papers, and the theorems that are in none, "
        "in our letters: what defines it and what is proved of it, for which sizes, "
        "what uses it, where a notebook shows it, and what is wrong in our scan, in "
        "print, or in the mathematics.</p>",
        *_controls(papers),
        "<main>",
        *_counts(papers),
        "<table><thead><tr><th>equation</th><th>says</th>"
        "<th>evidence</th><th>used by, shown in</th></tr></thead><tbody>",
        *rows,
        "</tbody></table></main>",
    ]
    style = "\n".join(_rules(papers))
    return f"{HEAD}{style}\n</style>\n</head>\n<body>\n" + "\n".join(
        [*body, "</body>", "</html>", ""]
    )


def _rules(papers: Papers) -> Iterator[str]:
    """A chosen paper hides the rows of the others; the counts go with it."""
    for key in ("all", *papers):
        plain = f"#{key}:checked ~ main"
        yield f"{plain} .count.{key} {{ display: block; }}"
        if key != "all":
            yield f"{plain} tr.entry:not(.{key}) {{ display: none; }}"
    yield "#slips:checked ~ main tr.entry:not(.misprinted) { display: none; }"


def _controls(papers: Papers) -> Iterator[str]:
    for key in ("all", *papers):
        name = "all" if key == "all" else html.escape(title(key))
        checked = " checked" if key == "all" else ""
        yield f'<input type="radio" name="paper" id="{key}"{checked}>'
        yield f'<label for="{key}">{name}</label>'
    yield '<input type="checkbox" id="slips">'
    yield '<label for="slips">misprinted only</label>'


def _counts(papers: Papers) -> Iterator[str]:
    for key in ("all", *papers):
        chosen = papers if key == "all" else (key,)
        total = sum(count(paper) for paper in chosen)
        slips = sum(len(misprints(paper)) for paper in chosen)
        yield (
            f'<p class="count {key}"><b>{total} entries</b>, {slips} misprints or '
            "losses of the scan</p>"
        )


def _row(entry: Entry, formulas: bool) -> str:
    slip = " misprinted" if entry.misprints else ""
    where = f"<code>{html.escape(entry.used_by)}</code>"
    where += f"<br>{html.escape(entry.shown.partition(': ')[0])}"
    faults = entry.check() if formulas else []
    level = html.escape(f"not proved: {faults[0]}" if faults else entry.level)
    cells = [
        f"{html.escape(entry.number)}<br><small>{html.escape(entry.source)}</small>",
        "".join([*_says(entry, formulas), *_slips(entry)]),
        (f'<b class="failed">{level}</b>' if faults else level) + _pointers(entry),
        where,
    ]
    inner = "".join(f"<td>{cell}</td>" for cell in cells)
    return f'<tr class="entry {entry.paper}{slip}">{inner}</tr>'


def _says(entry: Entry, formulas: bool) -> Iterator[str]:
    """What is stated, line by line; with formulas, each unfolds to its proof."""
    rows = list(entry.says.rows(_mathml if formulas else None))
    for row in rows[: -len(entry.says) or None]:
        yield f"<p>{row}</p>"
    for row, one in zip(rows[len(rows) - len(entry.says) :], entry.says, strict=True):
        if not (formulas and one.proved):
            yield f'<div class="says">{row}</div>'
            continue
        mark = " ✗" if one.check() else "" if one.sizes else " ✓"
        proof = "".join(_proof(one.item))
        yield f"<details><summary>{row}{mark}</summary>{proof}</details>"


def _pointers(entry: Entry) -> str:
    """Where its evidence stands."""
    found = (f"<div><code>{html.escape(one)}</code></div>" for one in entry.evidence)
    return f"<details><summary>evidence</summary>{''.join(found)}</details>"


def _slips(entry: Entry) -> Iterator[str]:
    for slip in entry.misprints:
        yield (
            f'<p class="slip">{slip.where.capitalize()}: {html.escape(slip.printed)}'
            f"<br>Correct: {html.escape(slip.correct)}</p>"
        )


def _proof(item: Any) -> Iterator[str]:
    """The lines of a chain as MathML; what else is proved as a terminal shows it."""
    if not isinstance(item, Chain):
        _, _, shown = str(item).partition("\n")
        yield f"<pre>{html.escape(dedent(shown))}</pre>"
        return
    for row in item.rows(latex):
        line = _mathml(f"{row.left} {row.sign} {row.right}")
        reason = f"<br><small>{_mathml(row.reason)}</small>" if row.reason else ""
        yield f'<div class="scrolls">{line}{reason}</div>'


def _mathml(latex: str) -> str:
    """LaTeX as MathML; braces keep the entries of a matrix of one column together."""
    from latex2mathml.converter import convert

    return convert(MATRIX.sub(_grouped, latex))


def _grouped(matrix: re.Match[str]) -> str:
    rows = (row.split(" & ") for row in matrix[1].split(r" \\ "))
    grouped = (" & ".join(f"{{{entry}}}" for entry in row) for row in rows)
    body = r" \\ ".join(grouped)
    return rf"\left[\begin{{matrix}}{body}\end{{matrix}}\right]"
