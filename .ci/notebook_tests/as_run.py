"""The order of cells and the code that were run, as a fingerprint of each cell."""

import hashlib
import itertools
import json

KEY = "as_run"  # in the notebook's metadata


def fingerprint(notebook):
    """What a notebook's outputs belong to: its cells in their order, and their code.

    Execution counts can be written by hand, and a notebook whose cells were moved may
    still run.  Sentences are left out, so that they can be mended without a run.
    """
    return " ".join(map(of_cell, notebook["cells"]))


def of_cell(cell):
    source = "".join(cell["source"]) if cell["cell_type"] == "code" else None
    known = json.dumps([cell["cell_type"], cell.get("id"), source])
    return hashlib.sha256(known.encode()).hexdigest()[:6]


def complaints(notebook):
    cells = notebook["cells"]
    ids = [cell.get("id") for cell in cells]
    if None in ids or len(set(ids)) < len(ids):
        yield "a cell without an id of its own"
    was = notebook["metadata"].get(KEY, "").split()
    pairs = itertools.zip_longest(was, map(of_cell, cells))
    moved = next((k for k, (then, now) in enumerate(pairs) if then != now), None)
    if moved is not None:
        where = f"cell {ids[moved]}" if moved < len(ids) else "the last cell"
        yield f"{where}: moved or changed since the notebook was run: refresh it"
