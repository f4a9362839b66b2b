"""The exact state from as few samples as possible, window by window."""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import ArrayLike

from ...arguments import expect
from ...formats import dataframes
from ...numeric import Matrix
from ...numeric.balance import evened
from ...numeric.validation import as_array, exact, matrix
from ...plant import Plant
from ..certified import CONDITION_WARNING
from .form import ObservabilityForm, find_form, require_discrete, solve_left


def reconstruct_state(
    plant: Plant,
    y: ArrayLike,
    u: ArrayLike | None = None,
    *,
    at: str = "start",
    selection: str = "interleaved",
) -> Matrix:
    r"""The exact state from every p_M consecutive samples of a record.

    >>> import luenberger as lb
    >>> plant = lb.Plant([[1, 1], [0, 1]], [[0], [1]], [[1, 0]], dt=1.0)
    >>> reconstruct_state(plant, [[0], [2], [5], [9]], [[1], [1], [1], [1]])
    array([[0., 2.],
           [2., 3.],
           [5., 4.]])

    .. math:: x_k = P^{-1} w_k, \qquad
              w_k = [y_{1,k} \ldots y_{1,k+p_1-1}\; y_{2,k} \ldots]'
                    - \Delta\,[u_k \ldots u_{k+p_M-2}]' .

    Parameters
    ----------
    plant : Plant
        Discrete, constant, observable; feedthrough, singular A and redundant outputs
        (of which an independent set is used) are allowed.
    y : (N, p) array_like
        Measurements at consecutive instants, N >= p_M.
    u : (N, m) array_like, optional
        Known inputs at the same instants, default zero.
    at : "start" or "end"
        Which state of its window a row of the result is.
    selection : "interleaved" or "largest"
        As in `observability_form`.

    Returns
    -------
    (N - p_M + 1, n) ndarray
        Row k uses the samples k .. k + p_M - 1 and is the state x[k] at the window's
        first sample (``at="start"``), or x[k + p_M - 1] at its last
        (``at="end"``: what is known now).  Without noise it is exact, to about
        cond(P) eps; object arrays of Fractions when the plant is exact and y is
        given with Fractions.

    Raises
    ------
    DesignError
        Continuous or time-varying plant; unobservable plant, with its hidden modes.
    ValueError
        Shapes that do not agree, missing values, fewer than p_M samples.

    Warns
    -----
    RuntimeWarning
        When the condition number of P, rows and columns scaled, exceeds 1e10.

    References
    ----------
    Kawazoe (1978), equations (15)-(26), with (25) corrected;
    papers/kawazoe/derivation/reconstruction.py.
    """
    expect(plant=plant)
    require_discrete(plant)
    if at not in ("start", "end"):
        raise ValueError(f"at must be 'start' or 'end' of the window, got {at!r}")
    y, u, exactly = _record(plant, y, u)
    form, outputs = find_form(plant, selection, None, exactly)
    given = plant.exact if exactly and plant.exact else vars(plant)
    A, B, E = (given[k] for k in "ABE")
    windows = len(y) - form.samples + 1
    if windows < 1:
        raise ValueError(
            f"the state needs {form.samples} consecutive samples (the largest "
            f"observability index), y has {len(y)}"
        )
    w = known_part(form, (y - u @ E.T)[:, outputs], u, windows)
    if not exactly:
        _warn_of_lost_digits(form.P)
    x = solve_left(w, form.P.T)
    for k in range(form.samples - 1 if at == "end" else 0):
        x = x @ A.T + u[k : k + windows] @ B.T
    return x


def _warn_of_lost_digits(P: Matrix) -> None:
    cond = np.linalg.cond(evened(P)[0])
    if not cond <= CONDITION_WARNING:
        warnings.warn(
            f"cond(P) = {cond:.1e}, rows and columns scaled: up to "
            f"{min(np.log10(cond), 16):.0f} of 16 digits of the state are lost. Try "
            "selection='largest', an exact plant and record, or deadbeat_observer.",
            RuntimeWarning,
            stacklevel=3,
        )


def known_part(form: ObservabilityForm, y: Matrix, u: Matrix, windows: int) -> Matrix:
    """w of (17) for each window: outputs less what the inputs did, (22)-(25)."""
    columns, start = [], 0
    for i, size in enumerate(form.indices):
        for k in range(size):
            column = y[k : k + windows, i]
            for j in range(k):  # row k of (25): g_{v+k}, ..., g_{v+1}
                column = column - u[j : j + windows] @ form.G[start + k - 1 - j]
            columns.append(column)
        start += size
    return np.stack(columns, axis=1)


def _record(
    plant: Plant, y: ArrayLike, u: ArrayLike | None
) -> tuple[Matrix, Matrix, bool]:
    """y and u as matrices, and whether they and the plant are rational."""
    y = _column(dataframes.ordered("y", y, plant.output_names), plant.p)
    if u is None:
        u = np.zeros((len(y), plant.m), int)
    else:
        u = _column(dataframes.ordered("u", u, plant.input_names), plant.m)
    exactly = plant.exact is not None and object in (y.dtype, u.dtype)
    if exactly:
        fractions = exact(y), exact(u)
        exactly = all(X is not None for X in fractions)
    if exactly:
        y, u = fractions
    _same_rows(y, u, plant)
    if not exactly:
        y, u = (
            matrix("y", y, cols=plant.p, field=complex),
            matrix("u", u, cols=plant.m, field=complex),
        )
    return y, u, exactly


def _column(signal: ArrayLike, width: int) -> Matrix:
    array = as_array(signal)
    return array[:, None] if array.ndim == 1 and width == 1 else array


def _same_rows(y: Matrix, u: Matrix, plant: Plant) -> None:
    for name, X, width in (("y", y, plant.p), ("u", u, plant.m)):
        if X.ndim != 2 or X.shape[1] != width:
            raise ValueError(f"{name} must be (N, {width}), got {X.shape}")
    if len(y) != len(u):
        raise ValueError(f"y has {len(y)} rows but u has {len(u)}")
