"""A derivation that has a page, as a chapter: words, chains, code beside stages."""

import re

from broken_formulas import WIDE, apart, in_lines, spaced
from docutils import nodes
from sympy import MatrixBase

import luenberger as lb
from luenberger.kernels.text import numpy_source
from matrixproof import (
    BlockMatrix,
    Chain,
    Derivation,
    MatrixSymbol,
    Relation,
    Solve,
    latex,
    text,
)
from matrixproof.derivation import End, size, title, used_letters
from matrixproof.explicit import Construction, Counterexample
from matrixproof.lines import bare_number, cited_latex
from matrixproof.prose import typeset
from matrixproof.typeset import columns
from matrixproof.typeset import pieces as terms

SHORT = 10  # columns of what a chain begins with, to stand before the first sign
SEPARATOR = r",\; "
DISPLAYED = r"\displaystyle "
MARK = {True: "✓", False: "✗"}


def chapter(derivation, address):
    """The nodes of a page; `address` makes the place of a step by its title."""
    found = [*letters(derivation)]
    for item in derivation.page:
        if isinstance(item, str):
            found.append(words(item))
        elif isinstance(item, Relation):
            found.append(definition(item))
        elif isinstance(item, End):
            found.append(end(item))
        else:
            found.append(address(title(item)))
            found.append(step(item))
    return found


def words(string, classes=()):
    """A paragraph; what stands between backquotes is a formula."""
    children = []
    for is_latex, piece in typeset(" ".join(string.split())):
        children += spaced(in_lines(piece)) if is_latex else [nodes.Text(piece)]
    return nodes.paragraph("", "", *children, classes=list(classes))


def formula(source):
    return nodes.math("", source)


def letters(derivation):
    """What the letters stand for, folded."""
    yield nodes.raw(
        "", "<details class='letters'><summary>Letters</summary>", format="html"
    )
    rows = nodes.container(classes=["letters"])
    for symbol, says in used_letters(derivation).items():
        shape = size(symbol, derivation.letters, latex)
        rows += nodes.paragraph("", "", formula(latex(symbol)))
        rows += nodes.paragraph("", "", formula(shape))
        rows += words(says)
    yield rows
    yield nodes.raw("", "</details>", format="html")


def definition(relation):
    """An equation with its number."""
    number = bare_number(relation)
    left = relation.show(latex).removesuffix(latex(relation.right))
    word = nodes.Text(f"{relation.word} " if relation.word else "")
    shown = nodes.inline("", "", word, *broken(relation.right, left))
    row = nodes.paragraph("", "", shown, classes=["given"])
    if condition := relation.condition(latex):
        row += formula(condition)
    if number:
        row += nodes.inline("", f"({number})", classes=["number"])
    return row


def end(scope):
    """Where what is supposed in a scope ends, as a sentence."""
    parts = scope.stated(latex).split("$")
    made = [formula(x) if k % 2 else nodes.Text(x) for k, x in enumerate(parts)]
    return nodes.paragraph("", "", *made)


def step(item):
    """A chain, a construction, a counterexample or a stage list."""
    box = nodes.container(classes=["chain"])
    if isinstance(item, Derivation):
        box += caption("", item.says)
        box.extend(stages(item))
        return box
    box += caption(item.number, item.says)
    if isinstance(item, Chain):
        box += lines(item)
    elif isinstance(item, Counterexample):
        box += instance(item)
    elif isinstance(item, Construction):
        box += construction(item)
    else:
        box += evaluated(item)
    return box


def instance(item):
    """A counterexample: the claim, the values, the sides; it is checked."""
    values, left, right = item.said(latex)
    claim = rf"{latex(item.left)} \ne {latex(item.right)}"
    grid = nodes.container(classes=["lines"])
    grid += nodes.paragraph("", "", formula(claim), classes=["start"])
    grid += nodes.paragraph("", "", *spaced(values, "with "), classes=["start"])
    grid += nodes.paragraph("", classes=["left"])
    grid += nodes.paragraph("", "", formula(rf"{left} \ne {right}"), classes=["right"])
    return marked(grid, MARK[not item.check()])


def construction(item):
    """What is constructed, and what it satisfies for which reasons."""
    grid = nodes.container(classes=["lines"])
    for symbol, value in item.values.items():
        shown = formula(f"{latex(symbol)} = {latex(value)}")
        grid += nodes.paragraph("", "", shown, classes=["start"])
    grid += nodes.paragraph("", "", nodes.Text("satisfies"), classes=["left"])
    wanted = spaced([relation.show(latex) for relation in item.satisfies], "")
    grid += nodes.paragraph("", "", *wanted, classes=["right"])
    because = SEPARATOR.join(map(cited_latex, item.by))
    return marked(grid, MARK[not item.check()], because)


def evaluated(item):
    """A statement at explicit matrices, the first choice of them, and its mark."""
    claim = rf"{latex(item.left)} {item.sign} {latex(item.right)}"
    grid = nodes.container(classes=["lines"])
    grid += nodes.paragraph("", "", formula(DISPLAYED + claim), classes=["start"])
    chosen = next(iter(item.cases.values()), {})
    for symbol, value in chosen.items():
        shown = formula(DISPLAYED + upright(symbol, value))
        grid += nodes.paragraph("", "", shown, classes=["start"])
    grid += nodes.paragraph("", classes=["left"])
    grid += nodes.paragraph("", item.reason(), classes=["right"])
    return marked(grid, item.mark)


def upright(symbol, value):
    """A symbol and its value; a long row stands as a column."""
    if isinstance(value, MatrixBase) and value.rows == 1:
        if sum(columns(text(entry)) for entry in value) > WIDE:
            turned = latex(symbol) if "'" not in latex(symbol) else f"({latex(symbol)})"
            return f"{turned}' = {latex(value.T)}"
    return f"{latex(symbol)} = {latex(value)}"


def marked(grid, mark, because="", wide=False):
    """A line of a grid, ended by its mark and its reason; below it, if it is wide."""
    grid += nodes.paragraph("", mark, classes=["checked"])
    classes = ["reason", "below"][: 1 + wide]
    grid += nodes.paragraph("", "", *reason(because), classes=classes)
    return grid


def caption(number, says):
    row = words(says[0].upper() + says[1:], classes=["says"])
    if number:
        row += nodes.inline("", f"({number})", classes=["number"])
    return row


def lines(chain):
    """The lines as cells of a grid: what it begins with, what follows, mark, reason."""
    grid, start = nodes.container(classes=["lines"]), chain.start(latex)
    short = len(chain.start(text)) <= SHORT
    if not short:
        grid += nodes.paragraph("", "", *broken(chain.left), classes=["start"])
    for row, plain in zip(chain.rows(latex), chain.rows(text)):
        if not row.sign:  # what an operation is done to
            if short:
                grid += nodes.paragraph("", "", formula(start), classes=["start"])
            continue
        left = "" if row.left == start and not short else row.left
        cell = [formula(left)] if left else []
        grid += nodes.paragraph("", "", *cell, classes=["left"])
        first, *rest = row.pieces or (row.right,)
        body = spaced([f"{row.sign} {first}", *(f"{{}}{piece}" for piece in rest)])
        wide = columns(plain.right) + columns(plain.left if left else "") > WIDE
        grid += nodes.paragraph("", "", *body, classes=["right", "wide"][: 1 + wide])
        marked(grid, MARK[row.follows], row.reason, wide)
    return grid


def broken(expr, left=""):
    """An expression in pieces between which the page may break it, `left` before it."""
    if hasattr(expr, "show"):
        return [formula(expr.show(latex))]
    first, *rest = terms(expr, latex)
    return spaced([f"{left}{first}", *(f"{{}}{piece}" for piece in rest)])


def reason(source):
    """A reason: what it cites, in pieces that hold together on a page."""
    parts = source.split(SEPARATOR) if source else []
    for k, part in enumerate(parts, 1):
        comma = nodes.Text("," if k < len(parts) else "")
        yield nodes.inline("", "", *citation(part), comma, classes=["cite"])
        yield nodes.Text(" ")


def citation(part):
    """One of them: words as words, formulas as formulas."""
    plain = re.fullmatch(r"(?:\\text\{[^{}]*\})+", part)
    cited = re.fullmatch(r"\\text\{(\([^{}]*\)'?)\}\\; (.*)", part)
    if plain:
        said = "".join(re.findall(r"\{([^{}]*)\}", part))
        for is_latex, piece in typeset(re.sub(r"\\(.)", r"\1", said)):
            yield formula(piece) if is_latex else nodes.Text(piece)
    elif cited:
        yield nodes.Text(f"{cited[1]} ")
        yield from spaced(apart(cited[2]))
    else:
        yield from spaced(apart(part))


# -- stages and their code -------------------------------------------------------------


def stages(derivation):
    """Each stage with the line of NumPy, and the C, that is printed from it."""
    _, source = numpy_source(derivation)
    code = [line.strip() for line in source.splitlines()[1:-1]]
    for stage, line in zip(derivation.stages, code, strict=True):
        row = nodes.container(classes=["stage"])
        left = f"{latex(stage.target)} = "
        shown = nodes.paragraph(
            "", "", nodes.inline("", "", *broken(stage.expression, left))
        )
        if stage.equation:
            shown += nodes.inline("", stage.equation, classes=["number"])
        row += shown
        row += literal(line.partition("  #")[0], "python")
        yield row
        sizes = [d for s in (stage.target, *symbols_of(stage)) for d in s.shape]
        if stage.expression.atoms(BlockMatrix) or any(d.is_Add for d in sizes):
            continue  # C has no loops over blocks
        yield nodes.raw("", "<details class='c'><summary>C</summary>", format="html")
        yield literal(c_of(derivation, stage), "c")
        yield nodes.raw("", "</details>", format="html")


def literal(code, language):
    return nodes.literal_block(code, code, language=language)


def symbols_of(stage):
    """The matrix symbols on the right of a stage."""
    parts = stage.formula
    parts = (parts.N, parts.M) if isinstance(parts, Solve) else (parts,)
    return set().union(*(part.atoms(MatrixSymbol) for part in parts))


class Part(Derivation):
    """One stage of a derivation that is proved as a whole: alone it has no reasons."""

    def proved(self):
        return True


def c_of(derivation, stage):
    """The C of one stage, at any sizes."""
    given = tuple(sorted(symbols_of(stage), key=lambda symbol: symbol.name))
    alone = Part(given, (stage,), letters=derivation.letters)
    return lb.compile(alone, backend="c").source
