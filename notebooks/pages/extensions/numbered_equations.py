r"""Equation numbers that can be pointed at, and notebooks' numbers before their titles.

A notebook numbers an equation by \tag{16}, which JupyterLab shows as it stands.  Here
the tag becomes Sphinx's own number, so that the equation has an address and {eq} finds
it from any page; "(16)" in the prose of the same page becomes a link to it.
"""

import re

from docutils import nodes
from sphinx.transforms import SphinxTransform

TAG = re.compile(r"\s*\\tag\{([^}]*)\}")
MENTION = re.compile(r"\(([\w.]+(?:[–-][\w.]+)?(?:, [\w.]+)*)\)")
QUIET = (nodes.title, nodes.reference, nodes.literal, nodes.literal_block, nodes.raw)


class NumberEquations(SphinxTransform):
    """Gives tagged equations their addresses and links the mentions of them."""

    default_priority = 300

    def apply(self):
        found = {}
        for block in list(self.document.findall(nodes.math_block)):
            if tag := TAG.search(block.astext()):
                address = self.number(block, tag[1])
                for part in parts(tag[1]):
                    found.setdefault(part, address)
        for text in list(self.document.findall(nodes.Text)):
            ancestor = text.parent
            while ancestor is not None and not isinstance(ancestor, QUIET):
                ancestor = ancestor.parent
            formula = isinstance(text.parent, nodes.math | nodes.math_block)
            if ancestor is None and not formula:
                if new := linked(text, found):
                    text.parent.replace(text, new)

    def number(self, block, number):
        """Numbers the formula and returns its address."""
        formula = TAG.sub("", block.astext())
        block.clear()
        block += nodes.Text(formula)
        doc = self.env.docname
        label = f"{doc}:{number}"
        while nodes.make_id(f"equation-{label}") in self.document.ids:
            label += " again"  # two formulas may bear one number
        name = nodes.make_id(f"equation-{label}")  # where {eq} looks for it
        block["ids"].append(name)
        self.document.ids[name] = block
        block["docname"], block["label"] = doc, label
        block["number"], block["no-wrap"] = number, False
        self.env.domains.math_domain.equations[label] = (doc, number)
        return name


def parts(tag):
    """The tag itself, and each number that it spans: "6–8" has 6, 7 and 8."""
    yield tag
    for part in tag.split(", "):
        first, dash, last = part.partition("–")
        stem, dot, low = first.rpartition(".")
        high = last.rpartition(".")[2]
        yield part
        if dash and low.isdigit() and high.isdigit():
            yield from (f"{stem}{dot}{k}" for k in range(int(low), int(high) + 1))


def linked(text, found):
    """The text with links, or nothing where it mentions no equation of the page."""
    pieces, end = [], 0
    for mention in MENTION.finditer(text):
        target = found.get(mention[1])
        if target:
            pieces.append(nodes.Text(text[end : mention.start()]))
            link = nodes.reference("", mention[0], refid=target, internal=True)
            pieces.append(link)
            end = mention.end()
    return [*pieces, nodes.Text(text[end:])] if pieces else []


class NumberTitles(SphinxTransform):
    """Puts a notebook's number before its title, as the notebooks name each other."""

    default_priority = 300

    def apply(self):
        number = re.match(r"(\d\d)-", self.env.docname)
        title = next(iter(self.document.findall(nodes.title)), None)
        if number and title is not None:
            title.insert(0, nodes.Text(f"{number[1]}  "))


def setup(app):
    app.add_transform(NumberEquations)
    app.add_transform(NumberTitles)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
