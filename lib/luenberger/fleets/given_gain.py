"""Records with the same gaps: a covariance that is found once, estimates side by side.

What is side by side takes one and the same gain in each row.  The columns of a gain are
zero for outputs that did not arrive.
"""

from typing import Any

import numpy as np

from .. import kernels
from ..kernels.panels import Panels, fits, in_panels
from ..numeric import Matrix, Vector
from ..papers.leondes_novak.derivation import estimate_step, sample_with_gain
from ..recursion.state import flat, leading_on
from .block import Block
from .records import Records
from .whole import Whole

WIDTH = 64  # records side by side in NumPy: products of one size have the same bits
GIVEN = Panels(
    kernels.Recursion(
        sample_with_gain,
        carried=(("x_minus_next", "x_minus"),),
        rows=(("y", "y", 0), ("u", "u", 0)),
        written=(("xs", "x", "vector"),),
    )
)


def share(out: Block, records: Records, which: Vector, whole: Whole | None) -> None:
    """Filter some records, those with the same gaps together."""
    for members in records.alike(which):
        s = int(members[0])
        state, found = records.fleet.alone(records, s)
        out.put(members, found, state.Sigma)
        estimates(out.x, records, members, found.K, whole)


def estimates(
    x: Matrix, records: Records, members: Vector, K: Matrix, whole: Whole | None
) -> None:
    """Write the estimates of records with the same gaps and the gains K (N, n, p)."""
    if whole is not None and whole.once("fits", lambda: _fits(whole)):
        in_lanes(x, records, members, K, whole)
        return
    for k in range(0, len(members), WIDTH):
        some = members[k : k + WIDTH]
        x[some] = side_by_side(records, some, K)


def in_lanes(
    x: Matrix, records: Records, members: Vector, K: Matrix, whole: Whole
) -> None:
    """The same in compiled code."""
    J = records.told(int(members[0]))
    run = whole.once(("given", len(J) > 1), lambda: _code(whole, len(J) > 1))
    M, N, n = x.shape
    matrices = whole.matrices
    given = records.read | {name: matrices[name] for name in "ABCE"}
    given |= dict(J=J, K=flat(kernels.plain_array(K)), xs=x.reshape(M, N * n))
    run(**given, x_minus=whole.first["x_minus"], who=members, rows=N)


def _fits(whole: Whole) -> bool:
    return fits(GIVEN, whole.stacks.sizes)


def _code(whole: Whole, told: bool) -> Any:
    """Compiled code, where J changes or not."""
    changing = {"K"} | (set("ABCE") if whole.varying else set())
    changing |= {"J"} if told else set()
    known = whole.known(A="A", B="B", C="C", E="E")
    known += (("J", whole.stacks.known("J", whole.stacks.cross)),)
    return in_panels(GIVEN, whole.stacks.sizes, known, frozenset(changing))


def side_by_side(records: Records, members: Vector, K: Matrix) -> Matrix:
    """The estimates (M, N, n) of at most `WIDTH` records, in NumPy."""
    settings, y, u = records.settings, records.y[members], records.u[members]
    M, N, p = y.shape
    ys, us = np.zeros((N, p, WIDTH)), np.zeros((N, u.shape[2], WIDTH))
    ys[:, :, :M], us[:, :, :M] = y.transpose(1, 2, 0), u.transpose(1, 2, 0)
    x = np.repeat(settings.plant.x0[:, None], WIDTH, axis=1)
    before = np.repeat(records.fleet.u0[:, None], WIDTH, axis=1)
    rho, found = np.zeros((0, WIDTH)), np.empty((N, len(x), WIDTH))
    step, setting, arrived = kernels.compiled(estimate_step), None, ~np.isnan(y[0])
    for k, seen in enumerate(arrived):
        _, A, B, J = leading_on(settings.plant, setting)
        setting = settings.at(k + 1, None if seen.all() else seen)
        moved = step(
            A=A, B=B, C=setting.C, E=setting.E, J=J, K=K[k][:, seen], x=x, rho=rho,
            u=before, y=ys[k][seen], u_next=us[k],
        )  # fmt: skip
        x, rho, before = moved["x_next"], moved["rho_next"], us[k]
        found[k] = x
    return found[:, :, :M].transpose(2, 0, 1)
