"""Plants and observers as python-control and scipy.signal systems, and back."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike

from ..arguments import expect
from ..certificate import certify, require_real
from ..errors import DesignError
from ..formats import statespace
from ..numeric.linalg import eigenvalues, modes
from ..numeric.validation import matrix
from ..observer import Observer
from ..plant import Plant
from .c.source_and_header import signals

SHARED_TOL = 1e-12  # of the largest pole: two poles this close are the same one
LOST_TOL = 1e-9  # relative to L: what rounding may cost it


def to_control(source: Observer | Plant, *, plant: Plant | None = None) -> Any:
    """A plant, or an observer from [u; y] to w^, as a python-control StateSpace.

    >>> import luenberger as lb
    >>> from luenberger.export import to_control
    >>> observer = lb.Observer([[0.5]], [[1]], [[2]], [[1]], [[1]], T=[[1]],
    ...                        L=[[1]], dt=1.0)
    >>> to_control(observer).input_labels, to_control(observer).dt
    (['u1', 'y1'], 1.0)

    Parameters
    ----------
    source : Observer or Plant
        Constant and real.
    plant : Plant, optional
        Beside an observer: whose names to use instead of its own.

    Returns
    -------
    control.StateSpace
        Of an observer: inputs named as the plant's inputs and outputs, states z1,
        z2, ..., outputs after what they estimate.  It starts from zero, not from z0:
        pass ``X0=observer.z0`` to a simulation.  Of a plant: u to y, without the
        noise; `Plant.from_statespace` is the way back.  Names are kept, but for a
        dot, which python-control puts between system and signal: it becomes "_".

    Raises
    ------
    DesignError
        If the source varies with time, is complex, or is a plant without inputs,
        which python-control does not have.
    ImportError
        If python-control is not installed.

    See Also
    --------
    from_statespace : an observer from a StateSpace
    """
    require_beside(source, plant)
    import control

    given = _matrices(source)
    require_real("python-control", source)
    if isinstance(source, Plant):
        if source.m == 0:
            raise DesignError(
                "the plant has no known inputs, and python-control has no systems "
                "without inputs. Give the plant a B with a column of zeros."
            )
        u, y, x = map(
            _labels, (source.input_names, source.output_names, source.state_names)
        )
    else:
        u, y, what = map(_labels, signals(source, plant))
        if set(u) & set(y):
            u, y = [f"u {label}" for label in u], [f"y {label}" for label in y]
        u, y = [*u, *y], [f"{label} estimate" for label in what]
        x = [f"z{k + 1}" for k in range(source.order)]
    return control.ss(*given, source.dt, inputs=u, outputs=y, states=x)


def to_scipy(source: Observer | Plant) -> Any:
    """A plant, or an observer from [u; y] to w^, as a scipy.signal StateSpace.

    >>> import luenberger as lb
    >>> from luenberger.export import to_scipy
    >>> observer = lb.Observer([[0.5]], [[1]], [[2]], [[1]], [[1]], T=[[1]],
    ...                        L=[[1]], dt=1.0)
    >>> to_scipy(observer).B
    array([[1., 2.]])

    Parameters
    ----------
    source : Observer or Plant
        Constant.

    Returns
    -------
    scipy.signal.StateSpace
        Of an observer: the first m inputs are u, the others y.  It starts from zero,
        not from z0.  Of a plant: u to y.

    Raises
    ------
    DesignError
        If the source varies with time.
    """
    expect(source=source)
    import scipy.signal

    options = {"dt": source.dt} if source.dt else {}
    return scipy.signal.StateSpace(*_matrices(source), **options)


def from_statespace(
    sys: Any, plant: Plant, *, T: ArrayLike | None = None, L: ArrayLike | None = None
) -> Observer:
    r"""A StateSpace from [u; y] to w^ as an observer of this plant, certified.

    >>> import luenberger as lb
    >>> from luenberger.export import from_statespace, to_scipy
    >>> plant = lb.Plant([[1, 1], [0, 1]], [[0], [1]], [[1, 0]], dt=1.0)
    >>> sys = to_scipy(lb.reduced_order_observer(plant, [0.5]))
    >>> observer = from_statespace(sys, plant)
    >>> observer.L, observer.T
    (array([[1., 0.],
           [0., 1.]]), array([[ 0.5, -1. ]]))

    A state space says what it computes and not what that estimates.  Its F and D
    determine T where F shares no pole with A, because then :math:`TA - FT = DC` has
    one solution; and T determines :math:`L = PT + VC`.  So every stable filter of
    [u; y] estimates something, if its G and W are those that T needs.

    Parameters
    ----------
    sys : control.StateSpace or scipy.signal.StateSpace
        With m + p inputs, u before y, as `to_control` and `to_scipy` make it.
    plant : Plant
        Constant, of the same dt; the source of names.
    T : (r, n) array_like, optional
        What the states track; needed where F has a pole of A.
    L : (q, n) array_like, optional
        What the outputs estimate, to be checked; default what they do estimate.

    Returns
    -------
    Observer
        With a certificate below 1e-9 on this plant; it starts from T x0.

    Raises
    ------
    DesignError
        If the sizes or dt do not agree, the plant varies with time, or F and A are
        so close in a pole that T cannot be computed.
    CertificateError
        If the system is not an observer of L x on this plant, with the residual that
        says why: another plant, a G or W that leaks the input, or an unstable F.

    References
    ----------
    Van Dooren (1984), equations (3)-(5); papers/van_dooren/derivation/theorem.py.
    """
    expect(sys=sys, plant=plant)
    if plant.steps is not None:
        raise DesignError("the plant varies with time, a StateSpace is constant")
    same = statespace.read(sys, plant.dt)  # not a Plant: it may have no states
    F, gains, P, through = (np.atleast_2d(same[name]) for name in "ABCE")
    if gains.shape[1] != plant.m + plant.p:
        raise DesignError(
            f"the system has {gains.shape[1]} inputs; [u; y] of this plant are "
            f"{plant.m} + {plant.p}"
        )
    (G, D), (W, V) = (np.hsplit(X, [plant.m]) for X in (gains, through))
    T = _tracked(F, D, P, V, plant) if T is None else matrix("T", T, cols=plant.n)
    if L is None:
        L = P @ T + V @ plant.C
        whole = np.rint(L)  # rows that pick a state pick it, without rounding
        L = np.where(np.abs(L - whole) <= LOST_TOL * np.abs(L).max(initial=1), whole, L)
    observer = Observer(F, G, D, P, V, T, L, W, z0=T @ plant.x0, dt=plant.dt)
    certify(observer, plant).require()
    return observer.named(plant)


def require_beside(source: Observer | Plant, plant: Plant | None) -> None:
    """Raise unless it is a plant, or an observer with perhaps its plant beside it."""
    expect(source=source)
    if plant is not None:
        expect(plant=plant)
        if isinstance(source, Plant):
            raise ValueError(
                "plant= goes with an observer, and the source is a plant: leave it out"
            )


def _tracked(
    F: np.ndarray, D: np.ndarray, P: np.ndarray, V: np.ndarray, plant: Plant
) -> np.ndarray:
    """T of T A - F T = D C; one refinement tells how many of its digits are lost."""
    A, C = plant.A, plant.C
    if not F.size:
        return np.zeros((0, plant.n))
    with np.errstate(all="ignore"):
        T = scipy.linalg.solve_sylvester(-F, A, D @ C)
        change = scipy.linalg.solve_sylvester(-F, A, D @ C - (T @ A - F @ T))
        lost, size = np.linalg.norm(P @ change), np.linalg.norm(P @ T + V @ C)
    of_F, of_A = eigenvalues(F), eigenvalues(A)
    gaps = np.abs(of_F[:, None] - of_A)
    shared = gaps.min(initial=np.inf) <= SHARED_TOL * np.abs(of_A).max()
    if shared or not lost <= LOST_TOL * size:
        near = of_F[np.argmin(gaps.min(axis=1))]
        raise DesignError(
            "what the system tracks cannot be computed: its pole at "
            f"{modes(np.array([near]))} is one of the plant's, or too close to one, so "
            "T A - F T = D C does not determine T. Pass T."
        )
    return T + change


def _matrices(o: Observer | Plant) -> tuple[np.ndarray, ...]:
    """A, B, C, D of the state space."""
    kind, rows, cure = "observer", "rows of gains", "design without steps"
    if isinstance(o, Plant):
        kind, rows, cure = "plant", "rows", "take one A, B, C, E"
    if o.steps is not None:
        raise DesignError(
            f"the {kind} has {o.steps} {rows}, a StateSpace is constant; {cure}"
        )
    if isinstance(o, Plant):
        return o.A, o.B, o.C, o.E
    return o.F, np.hstack([o.G, o.D]), o.P, np.hstack([o.W, o.V])


def _labels(names: Any) -> list[str]:
    """Names that python-control takes, whose dot is between system and signal."""
    found = []
    for name in names:
        label = name.replace(".", "_")
        while label in found or label != name and label in names:
            label += "_"
        found.append(label)
    return found
