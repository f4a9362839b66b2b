"""Writes the marker's page: python key.py, in the folder of the course.

key.html has each task with its model answers, the checks and the marks by hand.  It
needs no network, and each assignment begins a sheet of its own when it is printed.
"""

import html
import json
import re
from pathlib import Path
from xml.etree import ElementTree

import bleach  # nbconvert brings it
from latex2mathml.converter import convert
from nbconvert.filters import markdown2html

HERE = Path(__file__).parent
FORMULA = re.compile(r"\$\$(.+?)\$\$|(?<![\\$\w])\$([^$\n`]+?)\$(?![\w$])", re.S)
BLOCKS = "br dd div dl dt h1 h2 h3 h4 h5 h6 hr p pre span sub sup"
TABLES = "table caption thead tbody tfoot tr th td"
TAGS = {*bleach.ALLOWED_TAGS, *BLOCKS.split(), *TABLES.split()}
ATTRIBUTES = {"*": ["class", "id"], "a": ["href", "title"], "th": ["scope"]}
MATH = "{http://www.w3.org/1998/Math/MathML}"
MATH_TAGS = set(
    "math mrow mi mn mo mtext mspace mfrac msqrt mroot msup msub msubsup munder mover "
    "munderover mtable mtr mtd mstyle mpadded menclose mphantom mmultiscripts".split()
)
REGION = re.compile(r"[ \t]*### (?:BEGIN|END).*\n?")
HEAD = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Model answers and marks</title>
<style>
body { color: #111; background: #fff; font: 1rem/1.4 sans-serif; margin: 1rem auto;
       max-width: 50rem; padding: 0 1rem; }
pre { background: #f4f4f4; overflow-x: auto; padding: 0.5rem; }
h4 { border-top: 1px solid #555; }
table { border-collapse: collapse; }
th, td { border: 1px solid #777; padding: 0.1rem 0.5rem; }
math[display="block"] { display: block; overflow-x: auto; }
@media print {
  section + section { break-before: page; }
  pre { background: #fff; border: 1px solid #999; white-space: pre-wrap; }
  body { font-size: 10pt; }
}
</style>
</head>
<body>
<main>
<h1>Model answers and marks</h1>
"""


def only_math(formula):
    """Whether MathML holds nothing else: the converter lets tags in a text pass."""
    try:
        parts = list(ElementTree.fromstring(formula).iter())
    except ElementTree.ParseError:
        return False
    tags = {part.tag.removeprefix(MATH) for part in parts}
    named = {name for part in parts for name in part.attrib}
    return tags <= MATH_TAGS and not any(
        name == "href" or name.startswith("on") for name in named
    )


def with_formulas(source):
    """Markdown as HTML, with MathML for its formulas, which needs no network.

    What a student writes may be anything: a formula that is not LaTeX is shown as it
    was written, and HTML that is more than a text needs, such as a script, as text.
    """
    found = []

    def token(match):
        display = "block" if match[1] else "inline"
        try:
            formula = convert(match[1] or match[2], display=display)
        except Exception:  # the converter has a score of them, IndexError among them
            return match[0]
        if not only_math(formula):
            return match[0]
        # what may scroll is reached with the keyboard
        found.append(formula.replace('"block">', '"block" tabindex="0">', 1))
        return f"formula{len(found) - 1}end"  # Markdown leaves it alone

    page = markdown2html(FORMULA.sub(token, source))
    page = bleach.clean(page, tags=TAGS, attributes=ATTRIBUTES)
    for number, formula in enumerate(found):
        page = page.replace(f"formula{number}end", formula)
    return page


def one_level_down(source):
    return re.sub(r"^#", "##", source, flags=re.M)


def part(cell):
    """What the marker sees of a cell."""
    role, source = cell["metadata"].get("nbgrader", {}), "".join(cell["source"])
    points = f": {role['points']:g} points" if role.get("grade") else ""
    name = html.escape(role.get("grade_id", ""))
    text = REGION.sub("", source)
    if role.get("solution") and cell["cell_type"] == "markdown":
        return f"<h4>{name}{points}, by hand</h4>\n{with_formulas(text)}"
    if role.get("solution"):
        return f'<h4>{name}</h4>\n<pre tabindex="0">{html.escape(text)}</pre>'
    if role.get("grade"):
        return f"<p>{name}{points}, by the machine</p>"
    return with_formulas(one_level_down(source)) if cell["cell_type"] != "code" else ""


def main():
    page = [HEAD]
    for path in sorted((HERE / "source").glob("*/*.ipynb")):
        cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
        page += ["<section>", *filter(None, map(part, cells)), "</section>"]
    page += ["</main>", "</body>", "</html>", ""]
    (HERE / "key.html").write_text("\n".join(page), encoding="utf-8")


if __name__ == "__main__":
    main()
