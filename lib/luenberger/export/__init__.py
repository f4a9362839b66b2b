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
from .c import late as waiting
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
    late: int | Sequence[int | str] | None = None,
    horizon: int | None = None,
) -> list[Path]:
    r"""Write a constant observer, or a plant's time-varying filter, as C99.

    Two files, NAME.h and NAME.c, with ``NAME_init(state)`` and
    ``NAME_step(state, u, y, what)``.  They allocate nothing, call nothing but
    math.h, keep nothing outside `state`, and compile without warnings.

    - An `Observer` becomes :math:`z_{i+1} = F z_i + G u_i + D y_i`,
      :math:`\hat w_i = P z_i + V y_i + W u_i`, whatever method designed it.
    - A `Plant` becomes the filter of `filter_data` with its covariance recursion;
      NaN in y means not measured.  Its first sample is instant 1, with no input
      before it.

    Parameters
    ----------
    source : Observer or Plant
        Discrete, constant in time and real.
    path : str or Path
        Folder for the files; made if it is not there.
    plant : Plant, optional
        Beside an observer: the names of its signals, for the comments.
    m1 : int or sequence, optional
        Beside a plant: the accurate outputs, as in `filter_data`; default 0.
    weight : (n, n) array_like, optional
        Beside a plant: as in `reduced_order_filter`, but not "canonical".
    name : str
        A C identifier, of the files and functions.
    dtype : "double" or "float"
    late : int or sequence, optional
        Beside a plant: the outputs whose readings may arrive late, by index or name.
        Then there is ``NAME_arrived(state, output, age, y, what)`` as well, for a
        reading that was taken `age` samples ago, and m1 is 0.
    horizon : int, optional
        Beside `late`: how many samples a reading may be late.

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
        time or has dt = 0; if the plant
        varies with time, lacks Q, R or P0, or has noise-free outputs.

    Warns
    -----
    RuntimeWarning
        If a mode is so slow that roundings in float add up to 0.1 % of z.

    See Also
    --------
    rounding_error : what a float costs, measured.

    Notes
    -----
    Compile the source with ``-DNAME_SELFTEST`` for a main that compares a run with
    what Python computed and ends with 0 where they agree.

    With ``-DNAME_RESTRICT= -DNAME_LANES=1`` cppcheck's addon finds no required rule of
    MISRA C:2012 broken.  Without them the source uses `restrict`, which rule 8.14
    forbids, and rows that are padded for vectors.  Advisory rules that it breaks are
    2.4, 8.9, 12.1, 12.3, 15.5 and 18.4, and in the self-test 8.7.

    References
    ----------
    Leondes and Novak (1974), equations (9), (27), (33), (43), (44);
    papers/leondes_novak/derivation/marks.py, on_target.py, late_outputs.py.

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
    require_c_type(dtype)
    if isinstance(source, Plant):
        if plant is not None:
            raise ValueError("plant= goes with an observer; the source is a plant")
        if late is None and horizon is None:
            texts = recursive.texts(source, m1 or 0, weight, name, dtype)
        elif m1 or weight is not None:
            raise ValueError(
                "late goes with the Kalman filter: leave out m1 and weight"
            )
        else:
            texts = waiting.texts(source, late or 0, horizon, name, dtype)
    else:
        if m1 is not None or weight is not None:
            raise ValueError("m1 and weight go with a plant; the source is an observer")
        if late is not None or horizon is not None:
            raise ValueError("late goes with a plant; the source is an observer")
        certificate.require_real("C export", source)
        constant.require_exportable(source)
        texts = constant.texts(source, name, dtype, signals(source, plant))
    return write_pair(path, texts)
