"""Moore's observers of a linear functional, without feedthrough from y.

Source: Moore (1973); papers/moore/derivation/observer.py.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ... import kernels
from ...arguments import expect
from ...numeric import Matrix, Vector, rationals
from ...numeric.validation import as_array, exact
from ...observer import Observer
from ...plant import Plant
from ...plant.estimates import Combinations, by_name
from ..certified import certified
from ..poles import arranged
from . import refusals
from .companion_chain import Chain, chain, factors_of
from .derivation import observer_input
from .realised import LOST_TOL, built
from .recurrences import OverRationals, Polynomials, functionals, polynomials

PATIENCE = 3  # orders that rounding spoils before others are left out


def functional_observer(
    plant: Plant,
    k: Combinations,
    *,
    order: int | None = None,
    poles: ArrayLike | None = None,
) -> Observer:
    r"""Observer of w = k x that does not pass y on to its estimate, of least order.

    A combination of a cart's position, velocity and acceleration, from its position.
    Without feedthrough the whole state takes three observer states, this takes two.

    >>> import luenberger as lb
    >>> plant = lb.Plant([[0, 1, 0], [0, 0, 1], [0, 0, 0]], [[0], [0], [1]],
    ...                  [[1, 0, 0]])
    >>> observer = lb.functional_observer(plant, [2, 3, -1])
    >>> observer.F, observer.D
    (array([[-13.,   1.],
           [-41.,   0.]]), array([[149.],
           [ 82.]]))
    >>> observer.exact["F"].tolist() == observer.F.tolist()
    True

    With V = 0 and W = 0 noise in y reaches the estimate only through the states.

    Parameters
    ----------
    plant : Plant
        Constant and real.  Modes that no output but k sees must be stable.
    k : (n,) or (q, n) array_like, dict of str to (n,) array_like, or str
        The functional, or several, perhaps by name; names of states and of
        `plant.estimates` stand for their rows.  Each row gets an observer of its own,
        side by side: one of all rows jointly may need fewer states.
    order : int, optional
        Number of states r for each row, 1 .. n; default the least.
    poles : (r,) array_like, optional
        For each row, in rad/s (dt == 0) or in the z-plane, closed under conjugation.
        They must be admissible; from some order on all are.

    Returns
    -------
    Observer
        Certified, V = 0 and W = 0 exactly.  Without `poles` it has the largest
        stability margin of its order.  Plant, k and poles (if any) in ints or Fractions
        give an observer in Fractions too, ``observer.exact``, up to 20 states.

    Raises
    ------
    DesignError
        No stable observer of the order asked for, or of any; poles that are not
        admissible, with the rows of the recurrence they violate; a plant that varies
        in time or is complex; rounding that would leave no digit.
    CertificateError
        If a pole asked for is not stable.
    ValueError
        k, order or poles of the wrong shape or kind.

    References
    ----------
    Moore (1973), (1)-(13); papers/moore/derivation/observer.py.
    """
    expect(plant=plant)
    k, called = by_name(k, plant)
    k = functionals(plant, k)
    poles = _poles(plant, poles, order)
    chains = [_chain(plant, row, order, poles) for row in k]
    return certified(_side_by_side(plant, k, chains), plant, called=called)


def _poles(plant: Plant, poles: ArrayLike | None, order: int | None) -> Vector | None:
    """The poles with conjugates side by side, in Fractions if they were given so."""
    if poles is None:
        if order is not None and not (
            isinstance(order, (int, np.integer)) and not isinstance(order, bool)
        ):
            raise ValueError(f"order must be an integer, got {order!r}")
        if order is not None and not 1 <= order <= plant.n:
            raise refusals.out_of_range(plant, order)
        return None
    found = exact(poles)
    if found is None or found.ndim != 1:
        found, _ = arranged(poles, as_array(poles).size, plant)
    if not 1 <= len(found) <= plant.n:
        raise refusals.out_of_range(plant, np.size(found))
    if order is not None and order != len(found):
        raise ValueError(
            f"order is {order!r}, but {len(found)} poles are given; leave order out"
        )
    return found


def _chain(plant: Plant, k: Vector, order: int | None, poles: Vector | None) -> Chain:
    """The observer of one row k, in the user's coordinates."""
    if poles is not None:
        return _with_poles(plant, k, poles)
    admissible = polynomials(plant, k)
    if order is None and not k.any():
        return chain(admissible.A, admissible.C, admissible.k, [])
    least, lost, r = np.inf, 0, 1 if order is None else order
    while r <= plant.n:
        recurrence, answer = admissible.answer(r)
        if recurrence.stable:
            factors = admissible.factors(answer, recurrence.dimension == r)
            found, error = built(admissible, factors, answer.roots * admissible.sigma)
            if error <= LOST_TOL:
                return found
            if admissible.exactly:  # floats may have better coordinates
                return _chain(plant, k.astype(float), order, None)
            least, lost = min(least, error), lost + 1
        if order is not None:
            break
        r = _next_order(r, lost, admissible)
    raise refusals.no_order(admissible, order, least if lost else None)


def _next_order(r: int, lost: int, admissible: Polynomials) -> int:
    """The order to try after r, when rounding has spoiled so many.

    It hardly stops doing so, but where any poles are possible: there the roots may
    coincide.
    """
    if lost <= PATIENCE or isinstance(admissible, OverRationals):
        return r + 1
    return max(len(admissible.found), r + 2 ** (lost - PATIENCE - 1))


def _with_poles(plant: Plant, k: Vector, poles: Vector) -> Chain:
    if k.dtype != poles.dtype:  # exact only together
        k, poles = k.astype(float), poles.astype(complex)
    admissible, floats = polynomials(plant, k), poles.astype(complex)
    if not admissible.admits(floats if poles.dtype != object else poles):
        raise refusals.poles(admissible, floats)
    found, error = built(admissible, factors_of(poles), floats)
    if error <= LOST_TOL:
        return found
    if admissible.exactly:
        return _with_poles(plant, k.astype(float), poles)
    raise refusals.no_order(admissible, len(poles), error)


def _side_by_side(plant: Plant, k: Matrix, chains: list[Chain]) -> Observer:
    """One observer of all rows: every chain has its own states."""
    exactly = all(one.F.dtype == object for one in chains)
    _, zero = rationals.makers(exactly)
    A, B, C, E = (plant.exact[s] if exactly else getattr(plant, s) for s in "ABCE")
    T = np.vstack([zero(0, plant.n), *(one.T for one in chains)])
    D = np.vstack([zero(0, plant.p), *(one.D for one in chains)])
    order, at = len(T), 0
    F, P = zero(order, order), zero(len(k), order)
    for i, one in enumerate(chains):
        here = slice(at, at + len(one.F))
        F[here, here], P[i, here] = one.F, one.P[0]
        at = here.stop
    T, D = (X if exactly else X.astype(float) for X in (T, D))
    return Observer(
        F=F,
        G=kernels.compiled(observer_input)(T=T, B=B, D=D, E=E)["G"],
        D=D,
        P=P,
        V=zero(len(k), plant.p),
        T=T,
        L=k if exactly else k.astype(float),
        z0=T.astype(float) @ plant.x0,
        dt=plant.dt,
    )
