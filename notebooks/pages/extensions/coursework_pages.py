"""Writes on the page of the coursework what each assignment asks, and no answers."""

import json
import re
from pathlib import Path

SOURCE = Path(__file__).parents[2] / "coursework" / "source"
PAGE = "pages/coursework"


def asks(notebook):
    """The text of an assignment as a student reads it, its headings one level down.

    Code is left out: the checks are of use only where they run.
    """
    for cell in notebook["cells"]:
        if cell["cell_type"] == "markdown":
            answer = cell["metadata"].get("nbgrader", {}).get("solution")
            text = "*Your answer in words.*" if answer else "".join(cell["source"])
            text = re.sub(r"^#", "##", text, flags=re.M)
            yield text.replace("](../../../", "](../")


def list_assignments(app, docname, content):
    if docname == PAGE:
        app.env.note_dependency(str(SOURCE))  # assignments that come or go
        for path in sorted(SOURCE.glob("*/*.ipynb")):
            app.env.note_dependency(str(path))
            notebook = json.loads(path.read_text(encoding="utf-8"))
            content[0] += "\n\n" + "\n\n".join(asks(notebook))


def setup(app):
    app.connect("source-read", list_assignments)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
