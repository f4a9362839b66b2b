"""Parameters of a test of which every two values meet, not every combination."""

from itertools import combinations, product

import pytest


def every_pair(*, indirect=(), **values):
    """`pytest.mark.parametrize` with few rows that hold every pair of two values.

    Use it where the code treats parameters two at a time at most.  Each row is the one
    of all combinations that adds most pairs; the first of several.
    """
    names = list(values)
    places = list(combinations(range(len(names)), 2))
    ranges = [range(len(values[name])) for name in names]

    def pairs(row):
        return {(i, row[i], j, row[j]) for i, j in places}

    every, rows = list(product(*ranges)), []
    missing = set().union(*map(pairs, every))
    while missing:
        rows.append(max(every, key=lambda row: len(missing & pairs(row))))
        missing -= pairs(rows[-1])
    found = [[values[name][k] for name, k in zip(names, row)] for row in sorted(rows)]
    ids = ["-".join(map(str, row)) for row in found]
    return pytest.mark.parametrize(names, found, ids=ids, indirect=list(indirect))
