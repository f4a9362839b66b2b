"""Numbers in sentences are those that the cells hold and print."""

import re

NUMBER = re.compile(r"(?<![\w.,^{])\d+\.\d+(?![\w.]*\d)")
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
    """Each number with a decimal point in a sentence that no cell holds or prints.

    It counts as held where a number of the code or of an output agrees to all digits of
    the sentence, as it stands or as per cent.
    """
    held = list(numbers_of_cells(notebook["cells"]))
    for cell in notebook["cells"]:
        if cell["cell_type"] != "markdown":
            continue
        sentence = NOT_RESULTS.sub(" ", "".join(cell["source"]))
        for found in NUMBER.finditer(sentence):
            if not is_held(found[0], held):
                around = sentence[max(0, found.start() - 60) : found.end() + 30]
                where = f"cell {cell.get('id')}: no cell gives {found[0]}"
                yield f"{where}: ... {' '.join(around.split())} ..."


def is_held(number, held):
    decimals = len(number.partition(".")[2])
    value, half = float(number), 0.5 * 10.0**-decimals * (1 + 1e-9)
    return any(abs(x - value) <= half or abs(100 * x - value) <= half for x in held)


def numbers_of_cells(cells):
    for cell in cells:
        if cell["cell_type"] == "code":
            yield from numbers("".join(cell["source"]))
        for output in cell.get("outputs", ()):
            yield from numbers("".join(output.get("text", "")))
            for kind, value in output.get("data", {}).items():
                if not kind.startswith("image/") and isinstance(value, str | list):
                    yield from numbers("".join(value))


def numbers(text):
    return map(float, IN_CODE.findall(text))
