"""Records with gaps of their own: each has its covariance, and records are lanes."""

from dataclasses import replace
from typing import Any

import numpy as np

from .. import kernels
from ..kernels.panels import Panels, fits, in_panels
from ..kernels.program import Factor
from ..numeric import Matrices, Vector
from ..numeric.factors import SAFE
from ..papers.leondes_novak.derivation import marked_sample
from .block import Block
from .given_gain import estimates
from .records import Records
from .whole import Whole

MANY = 8  # records with the same gaps from which on their covariance is found once
OWN = Panels(
    kernels.Recursion(
        marked_sample,
        carried=(("Omega_next", "Omega"), ("x_minus_next", "x_minus")),
        rows=(("y", "y", 0), ("u", "u", 0)),
        written=(("xs", "x", "vector"), ("variances", "Sigma", "diagonal")),
        symmetric=("Q_all", "R_all", "Omega"),
        definite=(Factor("Sigma", SAFE, "Omega", known=True),),
        zero=("S_all", "Taken"),
    ),
    marks=("Seen", "y"),
    watched="Sigma",
)
MATRICES = (("covariances", "Sigma", "matrix"), ("gains", "K", "matrix"))
KEPT = replace(
    OWN,
    recursion=replace(OWN.recursion, written=OWN.recursion.written + MATRICES),
)
NAMES = dict(A="A", B="B", Q_all="Q", C_all="C", E_all="E", R_all="R")


def does(whole: Whole) -> bool:
    """Whether panels do the plant: independent noises, no accurate outputs, small."""
    stacks = whole.stacks
    if stacks.cross or stacks.accurate:
        return False
    return bool(whole.once("fits own", lambda: fits(OWN, stacks.sizes)))


def own(out: Block, records: Records, which: Vector, whole: Whole) -> Vector:
    """Filter some records; return those in which a pivot fails, which are not done."""
    group = records.groups(which)
    few = np.bincount(group, minlength=1)[group] < MANY
    left = [_each(out, records, which[few], whole)]
    if not few.all():
        left += _once(out, records, list(records.alike(which[~few])), whole)
    return np.sort(np.concatenate(left))


def _each(out: Block, records: Records, which: Vector, whole: Whole) -> Vector:
    """Each with its own covariance; the same return."""
    if not len(which):
        return which
    M, N, n = out.x.shape
    own = out.variances.reshape(M, -1)
    found: Matrices = dict(xs=out.x.reshape(M, -1), variances=own)
    panels, last = OWN, np.empty((M, n * n))
    if out.K is None:
        last = out.P.reshape(M, -1)
    else:
        panels = KEPT
        found |= dict(covariances=out.P.reshape(M, -1), gains=out.K.reshape(M, -1))
    failed, least, most = _run(panels, records, whole, which, found, last)
    good = which[~failed[which]]
    out.back[good] = 0
    records.grown(good, out.variances, good, least, most)
    return which[failed[which]]


def _once(
    out: Block, records: Records, many: list[Vector], whole: Whole
) -> list[Vector]:
    """The covariance of the first of each group, and estimates of all; the same return.

    As the arithmetic is that of records by themselves, so are the bits.
    """
    first = np.array([members[0] for members in many])
    (_, N, p), n, G = records.y.shape, out.x.shape[2], len(first)
    found: Matrices = {k: np.empty((G, N * n)) for k in ("xs", "variances")}
    found |= dict(covariances=np.empty((G, N * n * n)), gains=np.empty((G, N * n * p)))
    last, left = np.empty((G, n * n)), []
    failed, least, most = _run(KEPT, records, whole, np.arange(G), found, last, first)
    variances = found["variances"].reshape(G, N, n)
    for g, members in enumerate(many):
        if failed[g]:
            left.append(members)
            continue
        records.grown(members[:1], variances, np.array([g]), least, most)
        K = found["gains"][g].reshape(N, n, p)
        out.share(members, variances[g])
        if out.K is None:
            out.P[members] = last[g].reshape(n, n)
        else:
            out.P[members] = found["covariances"][g].reshape(N, n, n)
            out.K[members] = K
        estimates(out.x, records, members, K, whole)
    return left


def _run(
    panels: Panels, records: Records, whole: Whole, who: Vector, found: Matrices,
    last: Any, those: Vector | None = None,
) -> tuple[Vector, Vector, Vector]:  # fmt: skip
    """Run rows `who` of what is found; which failed, least and largest variances.

    Row k is of the record k, or of ``those[k]``.
    """
    rows, n = len(last), whole.stacks.plant.n
    read = dict(records.read)
    if those is not None:
        read |= {k: read[k][those] for k in ("which_y", "which_u")}
    failed, least = np.zeros(rows, dtype=bool), np.zeros((rows, n))
    most = np.zeros((rows, n))
    matrices = whole.matrices
    given = read | {to: matrices[name] for to, name in NAMES.items()}
    given |= whole.first | found
    given |= dict(failed=failed, least=least, most=most, last=last)
    run = whole.once(("own", panels is KEPT), lambda: _code(panels, whole))
    run(**given, who=who, rows=records.fleet.rows)
    return failed, least, most


def _code(panels: Panels, whole: Whole) -> Any:
    """Compiled code for the plant."""
    off = ~np.eye(whole.stacks.plant.p, dtype=bool)
    known = whole.known(**NAMES)
    known += (("Seen", kernels.entries_known(off, np.zeros_like(off))),)
    changing = frozenset(NAMES) if whole.varying else frozenset()
    return in_panels(panels, whole.stacks.sizes, known, changing)
