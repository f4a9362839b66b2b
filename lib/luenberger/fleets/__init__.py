"""Many records of one plant, filtered together as far as they share a covariance.

The covariance does not depend on what is measured, only on which outputs arrive.  So
records without gaps have one, which is found once; their estimates then go on side by
side, and so do those of other records with the same gaps.  Records with gaps of their
own are lanes of compiled code, or columns in NumPy, each with its covariance.  Which
way a record takes, and its bits, do not depend on the records beside it.

What is done with many records at once enters here.  It uses `recursion` and what is
below it.
"""

import numpy as np

from ..numeric import Matrix
from .block import Block
from .fleet import Fleet
from .given_gain import share
from .in_numpy import many
from .own_gain import does, own
from .records import Records


def filter_block(
    fleet: Fleet, y: Matrix, u: Matrix, history: bool = False, first: int = 0,
    out: Block | None = None, complete: bool = False,
) -> Block:  # fmt: skip
    """Filter records y (M, N, p) with inputs u (M, N, m), NaN where not measured.

    If they are `complete`, nothing is missing; else something may be.  What is found is
    written to `out`, if that is given, and returned.  All rows have the gain of the
    full recursion: where it has settled is not asked.  A record is by itself where some
    outputs carry no noise, as these may contradict what is known of its state.

    Raises
    ------
    DesignError
        As `filter_data`; it names the record, counted from `first`.
    """
    out = Block.empty(fleet.settings, y.shape, history) if out is None else out
    records = Records(fleet, y, u, first, complete)
    every = np.arange(len(y))
    if fleet.settings.noise_free or not fleet.rows:
        for s in every.tolist():
            state, found = records.one(s, history)
            out.x[s] = found.x
            out.put(every[s : s + 1], found, state.Sigma)
        return out
    whole, compile = fleet.whole, fleet.compile
    lanes = whole is not None and (not compile or does(whole))
    if whole is not None and lanes and not records.complete:
        gaps = records.gaps.any(axis=1)
        left = (own if compile else many)(out, records, every[gaps], whole)
        every = np.sort(np.concatenate([every[~gaps], left]))
    share(out, records, every, whole if compile else None)
    return out
