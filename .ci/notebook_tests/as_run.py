"""The order of cells and the code that were run, as a fingerprint."""

import hashlib
import json

KEY = "as_run"  # in the notebook's metadata


def fingerprint(notebook):
    """What a notebook's outputs belong to: its cells in their order, and their code.

    Execution counts can be written by hand, and a notebook whose cells were moved may
    still run.  Sentences are left out, so that they can be mended without a run.
    """
    cells = [
        (cell["cell_type"], cell.get("id"), "".join(cell["source"]))
        if cell["cell_type"] == "code"
        else (cell["cell_type"], cell.get("id"))
        for cell in notebook["cells"]
    ]
    return hashlib.sha256(json.dumps(cells).encode()).hexdigest()[:16]


def complaints(notebook):
    ids = [cell.get("id") for cell in notebook["cells"]]
    if None in ids or len(set(ids)) < len(ids):
        yield "a cell without an id of its own"
    if notebook["metadata"].get(KEY) != fingerprint(notebook):
        yield "cells were moved or changed since the notebook was run: refresh it"
