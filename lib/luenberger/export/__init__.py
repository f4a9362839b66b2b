"""Observers for elsewhere: C99 source, python-control and scipy.signal systems.

What turns an observer or a plant's filter into somebody else's object or source
enters here.  It uses `recursion`, `run`, the kernels and what is below them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from numpy.typing import ArrayLike

from .. import certificate
from ..arguments import expect, expect_as
from ..observer import Observer
from ..plant import Plant
from .bound import require_beside, require_floating
from .bound import rounding_bound as rounding_bound
from .c import filter as recursive
from .c import fixed, guard
from .c import observer as constant
from .c.fit import fitted
from .c.identifiers import identifier
from .c.rounding_bound import RoundingBound as RoundingBound
from .c.source_and_header import signals, write_pair
from .control_systems import from_statespace as from_statespace
from .control_systems import to_control as to_control
from .control_systems import to_scipy as to_scipy
from .rounding import RoundingError as RoundingError
from .rounding import rounding_error as rounding_error


def to_c(
    source: Observer | Plant,
    path: str | Path,
    *,
    plant: Plant | None = None,
    m1: int | Sequence[int | str] | None = None,
    weight: ArrayLike | str | None = None,
    name: str = "observer",
    dtype: str = "double",
    bits: int | None = None,
    ranges: Mapping[str, float] | None = None,
    update: str = "joseph",
) -> list[Path]:
    r"""Write a constant observer, or a plant's time-varying filter, as C99.

    Two files, NAME.h and NAME.c, with ``NAME_init(state)`` and
    ``NAME_step(state, u, y, what)``.  They allocate nothing, call nothing but
    math.h, keep nothing outside `state`, and compile without warnings.

    - An `Observer` becomes :math:`z_{i+1} = F z_i + G u_i + D y_i`,
      :math:`\hat w_i = P z_i + V y_i + W u_i`, whatever method designed it.
    - A `Plant` becomes its `Filter` with the covariance recursion;
      NaN in y means not measured.  Its first sample is instant 1, with no input
      before it.

    Parameters
    ----------
    source : Observer or Plant
        Discrete, constant in time and real.
    path : str or Path
        Folder for the files; made if it is not there.
    plant : Plant, optional
        Beside an observer: the names of its signals, and what its noises tell of the
        ranges of measurements.
    m1 : int or sequence, optional
        Beside a plant: the accurate outputs, as in `Filter`; default 0.
    weight : (n, n) array_like, optional
        Beside a plant: as in `reduced_order_filter`, but not "canonical".
    name : str
        A C identifier, of the files and functions.
    dtype : "double", "float" or "fixed"
        "fixed" is an observer in whole numbers: places are chosen so that nothing can
        overflow, and a reading beyond its range is cut to it, which a step reports.
    bits : 16 or 32, optional
        With "fixed": of each signal and weight; sums have twice as many.
    ranges : dict of str to float, optional
        The largest size of inputs and measurements, by name.  Of measurements that are
        left out it is what a stable plant with Q and R tells: six standard deviations
        at rest in its noises, and what the inputs add.
    update : "joseph" or "guarded"
        Beside a plant: how a sample with every output changes the covariance.
        "joseph" is :math:`(I - K C) \Omega (I - K C)' + K R K'`, which holds for any
        gain, so that errors of the gain do not grow in it.  "guarded" is
        :math:`\Omega - K C \Omega` where rounding can move no entry of that by more
        than 1e-8 (float: 1e-4) of the root of its two variances, and else the same as
        "joseph", at the price of both.  m1 is 0 then.

    Returns
    -------
    list of Path
        NAME.c and NAME.h.

    Raises
    ------
    ValueError
        If the name is not an identifier or is reserved, a number is beyond the range
        of float or too small for it, a file of this name is there and is not ours, or
        with "fixed" a range is not known, or update goes with something else.
    DesignError
        If the observer is unstable, in float too if it is exported so, varies with
        time or has dt = 0; if so many bits do not suffice; if the plant
        varies with time, lacks Q, R or P0, or has noise-free outputs; with "guarded"
        if an output has a variance in R of less than 1e-200 (float: 1e-25).

    Warns
    -----
    RuntimeWarning
        If a mode is so slow that roundings in float add up to 0.1 % of z.

    See Also
    --------
    rounding_bound : what rounding costs at most, proved.
    rounding_error : what a float costs, measured.

    Notes
    -----
    Compile the source with ``-DNAME_SELFTEST`` for a main that compares a run with
    what Python computed and ends with 0 where they agree.

    The header says how far rounding moves each estimate at most, proved for every
    instant: within the ranges, or for each unit of a signal where they are not known.
    Of a plant's filter it takes that every output arrives at every sample, and the
    header says why where nothing was proved: of outputs that are treated as exact, of a
    mode that has no noise and does not decay.  With "guarded" the header has the bound
    of one step in the short form instead.

    With ``-DNAME_RESTRICT= -DNAME_LANES=1`` cppcheck's addon finds no required rule of
    MISRA C:2012 broken.  Without them the source uses `restrict`, which rule 8.14
    forbids, and rows that are padded for vectors.  Advisory rules that it breaks are
    2.4, 8.9, 12.1, 12.3, 15.5 and 18.4, in the self-test 8.7, and in whole numbers 2.5.

    References
    ----------
    Leondes and Novak (1974), equations (9), (27), (33), (43), (44);
    papers/leondes_novak/derivation/marks.py, on_target.py and short_form.py;
    export/derivation/rounding.py, filter_covariance.py and filter_rounding.py.

    Examples
    --------
    >>> import tempfile, luenberger as lb
    >>> from luenberger.export import to_c
    >>> observer = lb.Observer([[0.5]], [[1]], [[2]], [[1]], [[1]], T=[[1]],
    ...                        L=[[1]], dt=1.0)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     source, header = to_c(observer, folder, name="speed")
    ...     print(source.name, header.name)
    ...     "speed_step" in header.read_text()
    speed.c speed.h
    True
    """
    expect(source=source)
    if plant is not None:
        expect_as("plant=", "plant", plant)
    identifier(name)
    if dtype != "fixed":
        require_floating(dtype, bits)
    if isinstance(source, Plant):
        require_beside(source, plant, dtype)
        choices = m1, weight, update, ranges
        return write_pair(path, _filter(source, name, dtype, *choices))
    if update != "joseph":
        raise ValueError(
            "update goes with a plant, and an observer has no covariance: leave it out"
        )
    if m1 is not None or weight is not None:
        raise ValueError("m1 and weight go with a plant; the source is an observer")
    certificate.require_real("C export", source)
    constant.require_exportable(source)
    named = signals(source, plant)
    if dtype == "fixed":
        texts = fixed.texts(
            source, name, named, *fitted(source, bits, named, plant, ranges)
        )
    else:
        texts = constant.texts(source, name, dtype, named, plant, ranges)
    return write_pair(path, texts)


def _filter(
    plant: Plant,
    name: str,
    dtype: str,
    m1: int | Sequence[int | str] | None,
    weight: ArrayLike | str | None,
    update: str,
    ranges: Mapping[str, float] | None,
) -> dict[str, str]:
    """The two files of a plant's filter."""
    if update not in guard.WAYS:
        raise ValueError(f"update must be 'joseph' or 'guarded', got {update!r}")
    if update == "guarded" and (m1 or weight is not None):
        raise ValueError(
            "update='guarded' goes with the Kalman filter: leave out m1 and weight"
        )
    return recursive.texts(plant, m1 or 0, weight, name, dtype, update, ranges)
