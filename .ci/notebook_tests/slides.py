"""Marks that make slides of a lesson: python -m notebook_tests.slides NOTEBOOK ...

A heading of the first or second level begins a slide.  What no longer fits on it goes
on below, and imports and solutions are left out.  Marks `fragment` and `notes`, which
an author gives, stay.
"""

import json
import math
import re
import sys
from pathlib import Path

LINES = 22  # of text on a slide
WIDTH = 100  # letters in a line of text
PICTURE = 15  # lines
KEPT = ("fragment", "notes")


def mark(notebook):
    """Write `slide_type` into the metadata of cells; others stay where they are."""
    for cell, kind in zip(notebook["cells"], kinds(notebook), strict=True):
        cell["metadata"].pop("slideshow", None)
        if kind:
            cell["metadata"]["slideshow"] = {"slide_type": kind}


def complaints(notebook):
    """What is wrong with the marks of a notebook that has any."""
    marks = [slide_type(cell) for cell in notebook["cells"]]
    if any(marks) and marks != kinds(notebook):
        yield "slides are marked as for other cells: refresh it"


def slide_type(cell):
    return cell["metadata"].get("slideshow", {}).get("slide_type", "")


def kinds(notebook):
    """For each cell slide, subslide, skip, or nothing where it goes on."""
    found, used = [], 0.0
    for cell in notebook["cells"]:
        needed = height(cell)
        if left_out(cell):
            found.append("skip")
        elif re.match(r"##? ", source(cell)):
            found.append("slide")
            used = needed
        elif slide_type(cell) in KEPT:
            found.append(slide_type(cell))
            used += needed
        elif used + needed > LINES:
            found.append("subslide")
            used = needed
        else:
            found.append("")
            used += needed
    return found


def source(cell):
    return "".join(cell["source"])


def left_out(cell):
    """Whether a cell is a solution, or the imports at the start."""
    imports = cell["cell_type"] == "code" and re.match("(import|from) ", source(cell))
    return bool(imports) or "solution" in cell["metadata"].get("tags", [])


def height(cell):
    """About how many lines of a slide a cell takes, with its outputs."""
    if cell["cell_type"] == "markdown":
        return text(source(cell)) + 1
    hidden = "hide-input" in cell["metadata"].get("tags", [])
    own = 0 if hidden else source(cell).count("\n") + 2
    return own + sum(map(shown, cell["outputs"]))


def text(words):
    lines = sum(math.ceil(len(line) / WIDTH) for line in words.splitlines())
    return lines + words.count("$$") / 2 + words.count(r"\\")


def shown(output):
    """The lines of one output."""
    data = output.get("data", {})
    if "image/png" in data:
        return PICTURE
    if "text/latex" in data:
        return 2 + 1.5 * "".join(data["text/latex"]).count(r"\\")
    if "text/html" in data:
        return 1.5 * "".join(data["text/html"]).count("<tr")
    plain = output.get("text", data.get("text/plain", output.get("traceback", "")))
    return "".join(plain).count("\n") + 1


def main(paths):
    for path in map(Path, paths):
        notebook = json.loads(path.read_text(encoding="utf-8"))
        mark(notebook)
        text = json.dumps(notebook, indent=1, ensure_ascii=False) + "\n"
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
