"""What a design computed, put into the relations of a page."""

import numpy as np
import sympy as sp
from worlds import Numbers

from matrixproof import Relation


def broken_relations(page, values, tol=1e-9):
    """How many relations of a page have all their letters in `values`; which fail.

    `values` has an array for each of some letters of the page.
    """
    shapes = [pair for s, X in values.items() for pair in zip(s.shape, X.shape)]
    sizes = {d: k for d, k in shapes if isinstance(d, sp.Symbol)}
    numbers = Numbers(sizes, values={s.name: X for s, X in values.items()})
    tried, failed = 0, []
    for item in page:
        if isinstance(item, Relation) and letters(item) <= set(values):
            tried += 1
            left, right = numbers.value(item.left), numbers.value(item.right)
            scale = 1 + np.abs(left).max(initial=0)
            if not np.allclose(left, right, rtol=0, atol=tol * scale):
                failed.append(item.name)
    return tried, failed


def letters(relation):
    return {s for side in relation for s in side.atoms(sp.MatrixSymbol)}
