"""What is wrong with a notebook as it is stored; nothing is run."""

import base64
import io
import json
import re
from pathlib import Path

from PIL import Image

from . import as_run, prose, slides

FOREIGN = {
    "an address in memory": r"0x[0-9a-fA-F]{6,}",
    "a path of one machine": r"(?<![\w.])/(home|root|tmp|usr|var|work|Users|opt)/",
    "a temporary file": r"ipykernel_\d|\\Users\\",
    "a time that was measured": r"\d ?(ns|µs|us|ms)\b|\d it/s|Wall time",
}
LONG_NUMBER = re.compile(r"(?<![\w.])\d*\.\d+")
MOST_DIGITS = 6
MOST_LINES = {False: 15, True: 25}  # True: a drawing that is folded, coursework


def main(paths):
    """Print what is wrong with each notebook; the exit status says whether any is."""
    found = [
        f"{path}: {words}"
        for path in paths
        for words in complaints(json.loads(Path(path).read_text(encoding="utf-8")))
    ]
    print(*found, sep="\n", end="\n" if found else "")
    return int(bool(found))


def complaints(notebook):
    """Everything that is wrong with a notebook (parsed JSON), in words."""
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    if [cell["execution_count"] for cell in cells] != list(range(1, len(cells) + 1)):
        yield "not saved after running every cell once, from top to bottom"
    if "language_info" in notebook["metadata"] or "widgets" in notebook["metadata"]:
        yield "saved with the interpreter's version or widget state: refresh it"
    if sum("assert " in "".join(cell["source"]) for cell in cells) < 3:
        yield "fewer than three cells assert anything"
    yield from as_run.complaints(notebook)
    yield from prose.complaints(notebook)
    yield from slides.complaints(notebook)
    for cell in cells:
        where = f"cell {cell.get('id')}: "
        yield from (where + words for words in cell_complaints(cell))


def cell_complaints(cell):
    source = "".join(cell["source"])
    tags = set(cell["metadata"].get("tags", []))
    lines = source.splitlines()  # "### ..." marks what nbgrader cuts out
    most = MOST_LINES["hide-input" in tags or "nbgrader" in cell["metadata"]]
    if sum(not line.strip().startswith(("###", "show(fig")) for line in lines) > most:
        yield f"more than {most} lines:\n{source}"
    if any(line.rstrip().endswith(";") for line in lines):
        yield f"a semicolon at the end of a line, which nbval ignores:\n{source}"
    if "NBVAL_" in source or any(tag.startswith("nbval-") for tag in tags):
        yield f"exempt from comparison:\n{source}"
    for output in cell["outputs"]:
        yield from output_complaints(output, "raises-exception" in tags)
        if "image/png" in output.get("data", {}):
            yield from picture_complaints(cell["metadata"], output)


def output_complaints(output, may_raise):
    if output["output_type"] == "stream" and output["name"] == "stderr":
        yield f"a warning is stored: {output['text']}"
    if output["output_type"] == "error" and not may_raise:
        yield f"raised {output['ename']} without the tag raises-exception"
    for text in texts(output):
        for what, pattern in FOREIGN.items():
            if found := re.search(pattern, text):
                yield f"{what} in an output: {found[0]!r} in {text[:200]}"
        for number in LONG_NUMBER.findall(text):
            if len(number.replace(".", "").strip("0")) > MOST_DIGITS:
                yield f"{number} has more than {MOST_DIGITS} digits: print it rounded"


def texts(output):
    """The texts of an output that nbval compares."""
    if "text" in output:
        yield "".join(output["text"])
    for kind, value in output.get("data", {}).items():
        if not kind.startswith("image/") and isinstance(value, str | list):
            yield "".join(value)


def picture_complaints(of_cell, output):
    """A picture has a caption, and its words are those that were read off it."""
    data, look = output["data"], output["metadata"].get("image/png", {})
    words = "".join(data.get("text/plain", ""))
    caption, *read = words.splitlines() or [""]
    if len(caption) < 30 or re.search(r"[$\\]", caption):
        yield f"a figure without a sentence for who cannot see it: {caption!r}"
    if not any(line.startswith(("x: ", "text ", "Panel")) for line in read):
        yield f"end the cell with `show(fig, caption)`: {words!r}"
    of_pages = of_cell.get("mystnb", {}).get("image", {}).get("alt")
    if not words == look.get("alt") == of_pages:
        yield f"the figure has other words: refresh the notebook: {words!r}"
    if words != written_in("".join(data["image/png"])):
        yield f"the stored picture is not the one that these words describe: {words!r}"


def written_in(png):
    """The description that a picture carries in itself; it was drawn with it."""
    try:
        with Image.open(io.BytesIO(base64.b64decode(png))) as picture:
            return picture.text.get("Description")
    except (OSError, ValueError, AttributeError):
        return None
