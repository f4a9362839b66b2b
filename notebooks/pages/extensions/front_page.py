"""What the first page shows of the rest: a figure of a notebook, a chain, its code."""

import base64
import hashlib
import json
from html import escape
from importlib import import_module
from pathlib import Path

from chapters import step
from docutils import nodes
from sphinx.util.docutils import SphinxDirective


class NotebookFigure(SphinxDirective):
    """The figure of a notebook with a caption that begins as given, in its words."""

    required_arguments = 1
    has_content = True

    def run(self):
        name, caption = self.arguments[0], " ".join(self.content)
        path = Path(self.env.srcdir) / f"{name}.ipynb"
        self.env.note_dependency(str(path))
        data = figure(json.loads(path.read_text(encoding="utf-8")), caption)
        png = base64.b64decode("".join(data["image/png"]))
        file = f"{hashlib.sha256(png).hexdigest()[:16]}.png"
        folder = Path(self.env.app.outdir) / "_images"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / file).write_bytes(png)
        words = "".join(data["text/plain"])
        html = f'<img src="_images/{file}" alt="{escape(words)}" class="front">'
        return [nodes.raw("", html, format="html")]


def figure(notebook, caption):
    """The data of the one output whose words begin with the caption."""
    outputs = (o for cell in notebook["cells"] for o in cell.get("outputs", ()))
    found = [
        o["data"]
        for o in outputs
        if "image/png" in o.get("data", {})
        and "".join(o["data"]["text/plain"]).startswith(caption)
    ]
    if len(found) != 1:
        raise ValueError(f"{len(found)} figures, not one, have the caption {caption!r}")
    return found[0]


class ProofAndCode(SphinxDirective):
    """A step of a derivation, "paper.module: title", as its chapter shows it."""

    required_arguments = 1
    final_argument_whitespace = True

    def run(self):
        place, _, title = self.arguments[0].partition(": ")
        paper, _, rest = place.partition(".")
        module, _, function = rest.partition(".")
        loaded = import_module(f"luenberger.papers.{paper}.derivation.{module}")
        if function:
            return [step(getattr(loaded, function))]
        return [step(loaded.page.steps[title])]


def setup(app):
    app.add_directive("notebook-figure", NotebookFigure)
    app.add_directive("step", ProofAndCode)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
