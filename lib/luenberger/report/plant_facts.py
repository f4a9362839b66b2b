"""What a plant is like: modes, what the outputs show of them, and its noises.

Plain data, for `python -m luenberger check`.  Which methods apply to a plant is the
business of `compare`.
"""

import dataclasses
import itertools
from typing import Any

import numpy as np

from ..analysis import mean_square
from ..errors import CertificateError, DesignError
from ..numeric.factors import square_root
from ..numeric.linalg import RANK_TOL, UNIT_TOL, decaying, eigenvalues, null_directions
from ..numeric.staircase_form import conjugate, unobservable
from ..papers.leondes_novak.design import kalman_filter
from ..plant import Plant
from ..recursion.settings import setting

REPEATED = 3  # times that a mode of the unit circle may be, as position to acceleration
SCATTER = 1e-12  # rounding, of which a mode repeated k times feels the k-th root


@np.errstate(all="ignore")  # what overflows is refused by what it spoils
def examine(plant: Plant) -> dict[str, Any]:
    """Everything `check` says of a plant, as a dict of lists, numbers and strings.

    A value that cannot be had is None: modes of a plant that varies in time, noises
    of one without Q and R, a steady filter in continuous time.

    Parameters
    ----------
    plant : Plant

    Returns
    -------
    dict
        "name"; "time"; "signals"; "modes" with "stable"; "observability"; "noise";
        "multiplicative"; "at_first"; "steady_filter".

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0,
    ...                  Q=[[0.25, 0.5], [0.5, 1]], R=[[0]])
    >>> examine(plant)["observability"]["indices"]
    [2]
    >>> examine(plant)["noise"]["rank_Q"], examine(plant)["noise"]["perfect_outputs"]
    (1, ['y1'])
    """
    varies = plant.steps is not None
    modes = None if varies else _modes(eigenvalues(plant.A), plant.dt)
    return {
        "name": plant.name,
        "time": {
            "discrete": plant.dt > 0,
            "dt": plant.dt,
            "instants": plant.steps,
        },
        "signals": {
            "states": list(plant.state_names),
            "inputs": list(plant.input_names),
            "outputs": list(plant.output_names),
        },
        "modes": modes,
        "stable": None if modes is None else all(mode["decays"] for mode in modes),
        "observability": None if varies else _observability(plant),
        "noise": _noise(plant),
        "multiplicative": _multiplicative(plant),
        "at_first": None if plant.P0 is None else plant.at_first,
        "steady_filter": _steady_filter(plant),
    }


def _modes(values, dt):
    """The eigenvalues in order of speed, the slowest last, and whether each decays.

    One on the boundary does not, whichever side rounding puts it.
    """
    values = np.asarray(values, dtype=complex)
    size, decays = np.abs(values) if dt else values.real, decaying(values, dt > 0)
    order = np.lexsort((values.imag, values.real, size))
    return [
        {
            "real": float(values[k].real),
            "imag": float(values[k].imag),
            "decays": bool(decays[k]),
        }
        for k in order
    ]


def _observability(plant):
    hidden, sizes = unobservable(plant.A, plant.C, plant.dt)
    hidden = _modes(hidden, plant.dt)
    return {
        "indices": list(conjugate(sizes)),
        "unobservable": hidden,
        "detectable": all(mode["decays"] for mode in hidden),
        "redundant_outputs": plant.p - max(sizes, default=0),
    }


def _noise(plant):
    """Ranks of the covariances.  Where they vary in time, the least one is given."""
    if plant.Q is None or plant.R is None:
        return None
    perfect = _instants(plant.R).max(axis=0).diagonal() == 0
    return {
        "rank_Q": _rank(plant.Q),
        "rank_R": _rank(plant.R),
        "rank_joint": _rank(_joint(plant)),
        "perfect_outputs": [
            name for name, is_so in zip(plant.output_names, perfect) if is_so
        ],
        "undriven_on_unit_circle": _undriven(plant),
    }


def _instants(X):
    return X if X.ndim == 3 else X[None]


def _joint(plant):
    Q, R = _instants(plant.Q), _instants(plant.R)
    S = np.zeros((1, plant.n, plant.p)) if plant.S is None else _instants(plant.S)
    N = max(map(len, (Q, R, S)))
    Q, R, S = (np.broadcast_to(X, (N, *X.shape[1:])) for X in (Q, R, S))
    return np.block([[Q, S], [S.mT, R]])


def _rank(X):
    return min(len(one) - null_directions(one).shape[1] for one in _instants(X))


def _undriven(plant):
    """Modes on the unit circle that no noise moves, or None in continuous time.

    They are those of A - S R^-1 C, which is what is left once w is predicted from v.
    """
    if plant.steps is not None or not plant.dt or plant.is_complex:
        return None
    now = setting(plant)
    still, _ = unobservable(now.As.T, square_root(now.Qs).T, 1.0, RANK_TOL)
    return _modes(_on_circle(list(still)), plant.dt)


def _on_circle(modes):
    """Those on the unit circle, each once; the mean, of what is scattered about one."""
    if not modes:
        return []
    nearest = sorted(modes, key=lambda mode: abs(mode - modes[0]))
    for k in range(min(REPEATED, len(modes)), 0, -1):
        mean = sum(nearest[:k]) / k
        if max(abs(mode - mean) for mode in nearest[:k]) <= SCATTER ** (1 / k):
            break
    found = (z for z in (mean, *nearest[:k]) if abs(abs(z) - 1) <= UNIT_TOL)
    return [*itertools.islice(found, 1), *_on_circle(nearest[k:])]


def _multiplicative(plant):
    """Of noises that multiply the state: how strong they are beside what is stable."""
    pairs = plant.multiplicative
    if not pairs:
        return None
    known = plant.steps is None and plant.dt > 0
    scaling = mean_square.largest_scaling(plant.A, pairs) if known else None
    return {
        "pairs": len(pairs),
        "radius": mean_square.radius(plant.A, pairs) if known else None,
        "largest_scaling": None if scaling is None or np.isinf(scaling) else scaling,
        "mean_square_stable": scaling > 1 if known else None,
    }


def _steady_filter(plant):
    """Whether there is a steady Kalman filter, and if not why."""
    try:
        if plant.multiplicative:
            same = mean_square.equivalent_noise(plant)
            plant = dataclasses.replace(
                plant, Q=same.Q, R=same.R, S=same.S, multiplicative=()
            )
        kalman_filter(plant)
    except (DesignError, CertificateError) as error:
        return {"exists": False, "reason": str(error)}
    return {"exists": True, "reason": None}
