"""Observers for elsewhere: C99 source, python-control and scipy.signal systems.

What turns an observer or a plant's filter into somebody else's object or source
enters here.  It uses `recursion`, `run`, the kernels and what is below them.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from numpy.typing import ArrayLike

from .. import certificate
from ..arguments import expect, expect_as
from ..kernels.c.numbers import require_c_type
from ..observer import Observer
from ..plant import Plant
from .c import filter as recursive
from .c import observer as constant
from .c.identifiers import identifier
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
) -> list[Path]:
    r"""Write a constant observer, or a plant's time-varying filter, as C99.

    Two files, NAME.h and NAME.c.  They allocate nothing, call nothing but math.h, keep
    nothing outside `state`, and compile without warnings.  A device calls
    ``NAME_init(state, x0)`` once, and for each sample ``NAME_estimate(state, y, what)``
    and then ``NAME_advance(state, u, y)``, which leads to the next sample: u acts from
    this sample to the next, so it may hang on the estimate.  A function takes what it
    reads: an estimate takes u only where u is seen at once, in W or E.

    - An `Observer` becomes :math:`\hat w_i = P z_i + V y_i + W u_i` and
      :math:`z_{i+1} = F z_i + G u_i + D y_i`, whatever method designed it.
    - A `Plant` becomes its `Filter`, with the covariance as U D U' and one output after
      the other.  NaN in y means not measured.  Its first sample is instant 1, with no
      input before it.  ``NAME_init`` takes standard deviations beside x0, and
      ``NAME_variances(state, variances)`` says what the errors are.

    Parameters
    ----------
    source : Observer or Plant
        Discrete, constant in time and real.
    path : str or Path
        Folder for the files; made if it is not there.
    plant : Plant, optional
        Beside an observer: the names of its signals.
    m1 : int or sequence, optional
        Beside a plant: the accurate outputs, as in `Filter`; default 0.
    weight : (n, n) array_like or "canonical", optional
        Beside a plant: as in `Filter`.
    name : str
        A C identifier, of the files and functions.
    dtype : "double" or "float"
        What the device computes in.

    Returns
    -------
    list of Path
        NAME.c and NAME.h.

    Raises
    ------
    ValueError
        If the name is not an identifier or is reserved, a number is beyond the range
        of float or too small for it, or a file of this name is there and is not ours.
    DesignError
        If the observer is unstable, in float too if it is exported so, varies with
        time or has dt = 0; if the plant varies with time or lacks Q, R or P0.

    Warns
    -----
    RuntimeWarning
        If a mode is so slow that roundings in float add up to 0.1 % of z.

    See Also
    --------
    rounding_error : what a float costs, measured.

    Notes
    -----
    Functions return 0 where they did what they do, 1 where a number is not finite, and
    2 where a reading contradicts what a filter knows exactly.  After 1 and 2 the state
    is what it was.

    Compile the source with ``-DNAME_SELFTEST`` for a main that compares a run with
    what Python computed and ends with 0 where they agree.  Without fused products
    (``-ffp-contract=off``) the double C of a filter of up to 6 states has the bits of
    Python, where sums of several inputs are not rounded.

    cppcheck's addon finds no required rule of MISRA C:2012 broken.

    References
    ----------
    Leondes and Novak (1974), equations (27), (33) and (43); Bierman (1977), sections
    V.3 and VI.4.

    Examples
    --------
    >>> import tempfile, luenberger as lb
    >>> from luenberger.export import to_c
    >>> observer = lb.Observer([[0.5]], [[1]], [[2]], [[1]], [[1]], T=[[1]],
    ...                        L=[[1]], dt=1.0)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     source, header = to_c(observer, folder, name="speed")
    ...     print(source.name, header.name)
    ...     "speed_advance" in header.read_text()
    speed.c speed.h
    True
    """
    expect(source=source)
    if plant is not None:
        expect_as("plant=", "plant", plant)
        if isinstance(source, Plant):
            raise ValueError(
                "plant= goes with an observer, and the source is a plant: leave it out"
            )
    identifier(name)
    require_c_type(dtype)
    if isinstance(source, Plant):
        return write_pair(path, recursive.texts(source, m1 or 0, weight, name, dtype))
    if m1 is not None or weight is not None:
        raise ValueError("m1 and weight go with a plant; the source is an observer")
    certificate.require_real("C export", source)
    constant.require_exportable(source)
    named = signals(source, plant)
    return write_pair(path, constant.texts(source, name, dtype, named))
