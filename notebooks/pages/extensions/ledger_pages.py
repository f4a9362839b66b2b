"""The ledger and its misprints as pages, with links to their evidence.

{ledger} is the table of entries and {misprints} the list of what the papers' pages
have wrong; both can be filtered.  What the ledger names in a notebook gets an
address when the notebook is read.
"""

import json
import tomllib
import zlib
from pathlib import Path

from broken_formulas import spaced
from chapters import words as sentence
from docutils import nodes
from sphinx import addnodes
from sphinx.util.docutils import SphinxDirective

from luenberger import ledger
from luenberger.ledger.evidence import derivation
from matrixproof import latex
from matrixproof.prose import plain

WORDS = Path(__file__).parents[1] / "misprints.toml"
FILTER = """<form class="filter" role="search" aria-label="{what}">
<label>Paper <select name="paper"><option value="">all</option>{papers}</select></label>
<label>Words <input type="search" name="words" autocomplete="off"></label>
{more}<output></output></form>"""
KIND = (
    '<label>Kind <select name="kind"><option value="">all</option>{}</select></label>'
)
SLIPS = '<label><input type="checkbox" name="misprinted"> misprinted only</label>'


def note_papers(env):
    """A page is built anew when the ledger changes."""
    for path in Path(ledger.__file__).parent.glob("entries/*.toml"):
        env.note_dependency(str(path))


def slug(entry):
    """The end of an entry's addresses."""
    number = entry.number.replace("'", " prime")
    return nodes.make_id(f"{entry.paper} {number}")


def link(label, text, docname):
    """A link to a label anywhere in these pages; one that is nowhere is a warning."""
    target = {"reftype": "ref", "reftarget": label, "refdomain": "std"}
    inner = nodes.inline("", text)
    return addnodes.pending_xref(
        "", inner, refdoc=docname, refexplicit=True, refwarn=True, **target
    )


def api_link(name, shown, docname):
    """A link to a public name."""
    target = {"reftype": "obj", "reftarget": name, "refdomain": "py"}
    shown = nodes.literal("", shown)
    return addnodes.pending_xref("", shown, refdoc=docname, refwarn=True, **target)


def step_label(pointer):
    """The address of "room.module: step", as `derivation_pages` gives it."""
    module, _, step = pointer.partition(": ")
    known = list(derivation(module).steps)
    return f"step-{nodes.make_id(module)}-{known.index(step) + 1}"


def statement(one, docname):
    """What is stated, in a paragraph; what it is called leads to its proof."""
    first, *rest = one.pieces(latex)
    shown = spaced([first, *(f"{{}}{piece}" for piece in rest)])
    if not one.proved:
        return nodes.paragraph("", "", nodes.Text(one.called(plain)), *shown)
    called = [link(step_label(one.pointer), plain(one.says), docname)]
    sizes = nodes.Text(f" ({one.sizes})" if one.sizes else "")
    return nodes.paragraph("", "", *called, nodes.Text(": "), *shown, sizes)


def notebook_link(entry, docname):
    if not entry.shown:
        return nodes.Text("")
    return link(f"shown-{slug(entry)}", entry.shown.partition(": ")[0], docname)


def target(document, label):
    """A place that {ref} and #label find."""
    place = nodes.target("", "", ids=[label], names=[label])
    document.note_explicit_target(place)
    return place


def lines(*paragraphs):
    return [nodes.paragraph("", "", *children) for children in paragraphs]


def form(what, parts, more=""):
    papers = "".join(
        f'<option value="{key}">{ledger.title(key)}</option>' for key in parts
    )
    text = FILTER.format(what=what, papers=papers, more=more)
    return nodes.raw("", text, format="html")


class Ledger(SphinxDirective):
    """Every entry as a row."""

    COLUMNS = {"equation": 2, "says": 8, "evidence": 4, "used, shown": 3}

    def run(self):
        note_papers(self.env)
        group = nodes.tgroup(cols=len(self.COLUMNS))
        group += [nodes.colspec(colwidth=width) for width in self.COLUMNS.values()]
        head = self.row(*([nodes.paragraph("", name)] for name in self.COLUMNS))
        group += nodes.thead("", head)
        group += nodes.tbody("", *(self.entry(entry) for entry in ledger.entries()))
        table = nodes.table("", group, classes=["ledger", "colwidths-given"])
        return [form("Filter the ledger", ledger.PARTS, SLIPS), table]

    def row(self, *cells):
        return nodes.row("", *(nodes.entry("", *cell) for cell in cells))

    def entry(self, entry):
        doc = self.env.docname
        number = nodes.strong("", entry.number)
        says = [sentence(entry.says.heading)] if entry.says.heading else []
        says += [statement(one, doc) for one in entry.says]
        for k, slip in enumerate(entry.misprints, 1):
            label = f"misprint-{slug(entry)}-{k}"
            says += lines([link(label, f"wrong {slip.where}", doc)])
        rest = [one for one in entry.proofs if one not in entry.says]
        proofs = [[link(step_label(p.pointer), p.pointer, doc)] for p in rest]
        proofs += [[nodes.literal("", test)] for test in entry.tests]
        shown = [api_link(entry.used, entry.used_by, doc)], [notebook_link(entry, doc)]
        row = self.row(
            [target(self.state.document, f"ledger-{slug(entry)}")]
            + lines([number], [nodes.Text(entry.source)]),
            says,
            lines([nodes.Text(entry.level)], *proofs),
            lines(*shown),
        )
        slipped = ["misprinted"] if entry.misprints else []
        row["classes"] += ["entry", f"of-{entry.paper}", *slipped]
        return row


class Misprints(SphinxDirective):
    """Every misprint, paper by paper: printed, correct, how one sees it, evidence."""

    def run(self):
        words = self.words()
        note_papers(self.env)
        self.env.note_dependency(str(WORDS))
        options = "".join(
            f'<option value="{kind}">{where}</option>'
            for kind, where in ledger.KINDS.items()
        )
        kinds = KIND.format(options)
        found = [form("Filter the misprints", ledger.PAPERS, kinds)]
        for paper in ledger.PAPERS:
            section = nodes.section(ids=[f"misprints-{nodes.make_id(paper)}"])
            self.state.document.note_explicit_target(section)
            section += nodes.title("", ledger.title(paper))
            for entry in ledger.entries(paper):
                for k, slip in enumerate(entry.misprints, 1):
                    key = (paper, entry.number, slip.printed)
                    if key not in words:
                        raise self.error(f"{WORDS.name} has no row for {key}")
                    section += self.one(entry, slip, k, words.pop(key))
            found.append(section)
        if words:
            raise self.error(f"{WORDS.name} has rows for no misprint: {list(words)}")
        return found

    def words(self):
        rows = tomllib.loads(WORDS.read_text(encoding="utf-8"))
        return {
            (paper, row["number"], row["printed"]): row
            for paper, of_paper in rows.items()
            for row in of_paper
        }

    def one(self, entry, slip, k, words):
        doc = self.env.docname
        label = f"misprint-{slug(entry)}-{k}"
        said = [
            (
                slip.where.capitalize(),
                [nodes.inline("", slip.printed, classes=["printed"])],
            ),
            ("Correct", self.inline(words["correct"])),
            ("How one sees it", self.inline(words["seen"])),
        ]
        proof = [link(f"ledger-{slug(entry)}", "the ledger's entry", doc)]
        if slip.tried:
            proof += [nodes.Text(", "), *tried_link(slip.tried, doc)]
        if entry.shown:
            proof += [nodes.Text(", notebook "), notebook_link(entry, doc)]
        said.append(("Evidence", proof))
        classes = ["entry", "misprint", f"of-{entry.paper}", f"is-{slip.kind}"]
        card = nodes.container(classes=classes)
        card += target(self.state.document, label)
        card += nodes.rubric("", f"{entry.number} · {slip.where}")
        fields = nodes.field_list()
        for name, body in said:
            body = nodes.field_body("", *lines(body))
            fields += nodes.field("", nodes.field_name("", name), body)
        card += fields
        return card

    def inline(self, text):
        """Markdown with mathematics, as the children of one paragraph."""
        paragraph = self.parse_text_to_nodes(text)
        return [child for node in paragraph for child in node.children]


def tried_link(pointer, docname):
    """Where the printed form is tried: a test, a step, or a row of an errata module."""
    module, _, _ = pointer.partition(": ")
    if pointer.startswith("tests/"):
        return [nodes.literal("", pointer)]
    try:
        return [link(step_label(pointer), pointer, docname)]
    except LookupError:
        return [nodes.Text("tried in "), link(tried_label(pointer), module, docname)]


def tried_label(pointer):
    """The address of a row of an errata module, as `derivation_pages` gives it."""
    return f"tried-{zlib.crc32(pointer.encode()):08x}"


def address_cells(app, docname, content):
    """Give an address to the paragraphs and the code that the ledger names."""
    shown = {e: e.shown.partition(": ") for e in ledger.entries() if e.shown}
    here = {e: words for e, (name, _, words) in shown.items() if name == docname}
    if not here:
        return
    note_papers(app.env)
    notebook = json.loads(content[0])
    labelled = []
    for k, cell in enumerate(notebook["cells"]):
        source = "".join(cell["source"])
        places = [(source.find(here[e]), f"(shown-{slug(e)})=\n") for e in here]
        places = sorted(place for place in places if place[0] >= 0)
        if places and cell["cell_type"] == "markdown":
            cell = cell | {"source": with_labels(source, places)}
        elif places:  # in a cell before
            before = {"cell_type": "markdown", "id": f"address-{k}", "metadata": {}}
            labels = "".join(label for _, label in places)
            labelled.append(before | {"source": labels})
        labelled.append(cell)
    content[0] = json.dumps(notebook | {"cells": labelled})


def with_labels(source, places):
    """Markdown with each label before the paragraph, or formula, of its place."""
    for place, label in reversed(places):
        blank = source.rfind("\n\n", 0, place)
        start = blank + 2 if blank >= 0 else 0
        source = source[:start] + label + source[start:]
    return source


def setup(app):
    app.add_directive("ledger", Ledger)
    app.add_directive("misprints", Misprints)
    app.connect("source-read", address_cells)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
