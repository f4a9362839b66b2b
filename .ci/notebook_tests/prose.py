"""Each number in a sentence is tied to the cell that gives it.

A cell of Markdown holds in its metadata, under `quotes`, which cell gives each of its
numbers.  `tie` writes that at each refresh of the notebook; `complaints` finds a number
that was changed since, and a cell that gives another one now.  A number that no cell
gives, as one that is computed in the sentence itself, is tied `by hand`, with these
words in place of the cell.
"""

import re

KEY, BY_HAND = "quotes", "by hand"
NUMBER = re.compile(
    r"""(?<![\w.,^{]) ( \d+\.\d+ (?![\w.]*\d) | \d+ (?=\s*(?:\\?%|per\ cent)) )
    (?: \s*\\cdot\s*10\^\{?(?P<power>-?\d+)\}? )?
    (?P<share> \s*(?:\\?%|per\ cent) )?""",
    re.X,
)
IN_CODE = re.compile(r"\d*\.?\d+(?:[eE][-+]?\d+)?")
NOT_RESULTS = re.compile(
    r"""\\tag\{[^}]*\}              # the number of a formula
    | ```.*?```                     # code that is shown
    | \b(?:[Ss]ections?|version|NumPy|SymPy|SciPy|Python)\s[\d.]+
    | \(\d+\.\d+[a-z]?\)            # the number of somebody's equation
    """,
    re.S | re.X,
)


def complaints(notebook):
    gives = {cell.get("id"): cell for cell in notebook["cells"]}
    for cell in sentences(notebook):
        ties = cell["metadata"].get(KEY, {})
        for number, factors, around in quoted(cell):
            by = ties.get(number)
            if by == BY_HAND or by in gives and holds(gives[by], number, factors):
                continue
            why = f"cell {by} does not give" if by else "no cell is named for"
            yield f"cell {cell.get('id')}: {why} {number}: ... {around} ..."


def tie(notebook):
    """Name for each number the nearest cell that gives it; what is by hand stays."""
    cells = notebook["cells"]
    for cell in sentences(notebook):
        place = cells.index(cell)
        near = sorted(range(len(cells)), key=lambda k: (abs(k - place), k))
        old, ties = cell["metadata"].pop(KEY, {}), {}
        for number, factors, _ in quoted(cell):
            found = (cells[k]["id"] for k in near if holds(cells[k], number, factors))
            by_hand = BY_HAND if old.get(number) == BY_HAND else None
            if by := next(found, by_hand):
                ties[number] = by
        if ties:
            cell["metadata"][KEY] = ties


def sentences(notebook):
    """The cells of Markdown; not model answers, whose metadata students see."""
    for cell in notebook["cells"]:
        answer = cell["metadata"].get("nbgrader", {}).get("solution")
        if cell["cell_type"] == "markdown" and not answer:
            yield cell


def quoted(cell):
    """The numbers of a cell's sentences, what each may stand for, the words around."""
    text = NOT_RESULTS.sub(" ", "".join(cell["source"]))
    for found in NUMBER.finditer(text):
        around = text[max(0, found.start() - 60) : found.end() + 30]
        factors = [10.0 ** int(found["power"] or 0)] + [0.01] * bool(found["share"])
        yield found[1], factors, " ".join(around.split())


def holds(cell, number, factors):
    """Whether a cell of code has a number that agrees to all digits of the sentence."""
    decimals = len(number.partition(".")[2])
    value, half = float(number), 0.5 * 10.0**-decimals * (1 + 1e-9)
    return cell["cell_type"] == "code" and any(
        abs(x / factor - value) <= half for x in numbers_of(cell) for factor in factors
    )


def numbers_of(cell):
    yield from numbers("".join(cell["source"]))
    for output in cell.get("outputs", ()):
        yield from numbers("".join(output.get("text", "")))
        for kind, value in output.get("data", {}).items():
            if not kind.startswith("image/") and isinstance(value, str | list):
                yield from numbers("".join(value))


def numbers(text):
    return map(float, IN_CODE.findall(text))
