"""{derivations} writes out the derivations of one paper: idea, stages, every claim."""

import inspect
import re
from functools import partial
from importlib import import_module

from chapters import chapter
from docutils import nodes
from ledger_pages import target, tried_label
from sphinx.pycode import ModuleAnalyzer
from sphinx.util.docutils import SphinxDirective

from luenberger import ledger
from luenberger.ledger import evidence
from matrixproof.names import GREEK
from matrixproof.prose import as_latex

AUTHORS = {key: ledger.title(key).partition(" ")[0] for key in ledger.PAPERS}
AUTHORS["van_dooren"] = "Van Dooren"


def paper_of(module):
    """The paper that a derivation's source names first, or "ours"."""
    if not module.__name__.startswith("luenberger.papers."):
        return ledger.OURS
    source = inspect.getdoc(module).partition("Source:")[2]
    places = {key: source.find(name) for key, name in AUTHORS.items()}
    named = {key: place for key, place in places.items() if place >= 0}
    return min(named, key=named.get, default=ledger.OURS)


def modules(paper):
    """ "paper.module" of what a page shows, in the order of the rooms' front doors."""
    found = []
    for room in evidence.ROOMS:
        front = import_module(evidence.package(room))
        named = inspect.getdoc(front).partition("In reading order:")[2]
        for name in re.findall(r"`(\w+)`", named.partition("\n\n")[0]):
            if paper_of(evidence.module(f"{room}.{name}")) == paper:
                found.append(f"{room}.{name}")
    return found


def page_of(module):
    """The derivation of a module that reads as a page, or nothing."""
    derivation = getattr(module, "page", None)
    return derivation if getattr(derivation, "page", ()) else None


class Derivations(SphinxDirective):
    """A section for each module of a paper."""

    required_arguments = 1

    def run(self):
        return [self.section(name) for name in modules(self.arguments[0])]

    def section(self, name):
        module = evidence.module(name)
        full = module.__name__
        heading, _, rest = inspect.getdoc(module).partition("\n")
        section = nodes.section()
        section += nodes.title("", heading.rstrip("."))
        section["names"], section["ids"] = [], [f"derivation-{nodes.make_id(name)}"]
        section["names"].append(section["ids"][0])
        self.state.document.note_explicit_target(section)
        derivation = page_of(module)
        rest = with_formulas(rest) if derivation else rest
        section += self.parse_text_to_nodes(as_set(plain_bars(rest)))
        if derivation:
            section += chapter(derivation, partial(self.address, name, derivation))
        section += [self.whole(full, function) for function in self.shown(module)]
        section += self.rows(name, module)
        return section

    def whole(self, full, name):
        """A link to the module, and nothing else of its reference."""
        entry = f".. py:function:: {name}()\n"
        entry += f"   :module: {full}\n   :no-contents-entry:\n"
        return nodes.container("", *self.parse_text_to_nodes(entry), classes=["whole"])

    def address(self, pointer, derivation, step):
        """The place of a step, to which the ledger leads."""
        k = list(derivation.steps).index(step) + 1
        return target(self.state.document, f"step-{nodes.make_id(pointer)}-{k}")

    def rows(self, name, module):
        """What a page prints, each with an address, and what comes of it if said."""
        for place, why in tried(name, module).items():
            yield target(self.state.document, tried_label(f"{name}: {place}"))
            yield nodes.paragraph("", place, classes=["step"])
            if why:
                yield nodes.paragraph("", why)

    def shown(self, module):
        """`page`, or else the first function: its [source] leads to all the rest."""
        own = [
            name
            for name, value in vars(module).items()
            if callable(value) and not inspect.isclass(value) and name[0] != "_"
            if getattr(value, "__module__", "") == module.__name__
        ]
        return ["page"] if hasattr(module, "page") else own[:1]


def tried(name, module):
    """{place and what is printed: why it is wrong, where that is put in words}."""
    if hasattr(module, "entries"):
        return dict.fromkeys(module.entries(), "")
    rows = module.misprints() if hasattr(module, "misprints") else []
    return {f"{place} {printed}": why for place, printed, why in rows}


def with_formulas(text):
    """What stands between backquotes is a formula, but for the names of code."""
    return re.sub(
        r"(?<!`)`([^`\n]+)`(?!`)",
        lambda found: (
            found[0] if is_code(found[1]) else f":math:`{as_latex(found[1])}`"
        ),
        text,
    )


def is_code(name):
    return bool(re.fullmatch(r"[a-z]\w{2,}(\(\))?", name)) and name not in GREEK


def as_set(text):
    """What is indented in a docstring is shown as it is set: formulas, tables."""
    return re.sub(r"(?<!::)\n\n(?=    +\S)", "\n\n::\n\n", text)


def plain_bars(text):
    """|x| as it is meant, an absolute value, where reST would see a substitution."""
    return re.sub(r"(?<![|`])\|(?=[^|\s][^|\n`]*\|)([^|\n]*)\|", r"\|\1\|", text)


def write_bars_plainly(app, what, name, object, options, lines):
    for k, line in enumerate(lines):
        if "\\" not in line and not line.lstrip().startswith((">>>", "...")):
            lines[k] = plain_bars(line)


def keep_names_together(app, what, name, object, options, lines):
    """One entry for attributes that share one, where the last would be taken alone."""
    for k, line in enumerate(lines):
        if field := re.match(r":(ivar|vartype) ([\w, ]+):", line):
            names = field[2].replace(", ", ",\u200b")  # no space, yet it can break here
            lines[k] = f":{field[1]} {names}:{line[field.end() :]}"


def source_of_page(app, module):
    """The source of a module that has a page, and the line at which it begins."""
    if ".derivation." not in module or not page_of(import_module(module)):
        return None
    analyzer = ModuleAnalyzer.for_module(module)
    analyzer.find_tags()
    begins = analyzer.code.partition("\npage = ")[0].count("\n") + 2
    return analyzer.code, {**analyzer.tags, "page": ("other", begins, begins)}


def written_in(app, module, name):
    """The module itself, of a page: its class is of another."""
    return module if name == "page" else None


def setup(app):
    app.add_directive("derivations", Derivations)
    app.connect("viewcode-find-source", source_of_page)
    app.connect("viewcode-follow-imported", written_in)
    app.connect("autodoc-process-docstring", write_bars_plainly)
    app.connect("autodoc-process-docstring", keep_names_together)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
