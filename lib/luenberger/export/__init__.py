"""Observers for elsewhere: C99 source, python-control and scipy.signal systems.

What turns an observer or a plant's filter into somebody else's object or source
enters here.  It uses `recursion`, `run`, the kernels and what is below them.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from numpy.typing import ArrayLike

from .. import certificate
from ..analysis.lightest import lightest as lightest
from ..analysis.step_cost import multiply_adds as multiply_adds
from ..kernels.c.numbers import require_c_type
from ..observer import Observer
from ..plant import Plant
from .c import filter as recursive
from .c import observer as constant
from .c.identifiers import identifier
from .c.source_and_header import signals, write_pair
from .control_systems import from_statespace as from_statespace
from .control_systems import require_beside
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

    >>> import tempfile, luenberger as lb
    >>> observer = lb.Observer([[0.5]], [[1]], [[2]], [[1]], [[1]], T=[[1]],
    ...                        L=[[1]], dt=1.0)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [path.name for path in lb.export.to_c(observer, folder, name="speed")]
    ['speed.c', 'speed.h']

    Two files, NAME.h and NAME.c, which allocate nothing, call nothing but math.h and
    compile without warnings.  A device calls ``NAME_init(state, x0)`` once.  For each
    sample it calls ``NAME_estimate(state, y, what)`` and then
    ``NAME_advance(state, u, y)``, which leads to the next one: u acts until then.

    A `Plant` becomes its `Filter`.  NaN in y means not measured.  ``NAME_init`` takes
    standard deviations beside x0, and ``NAME_variances(state, variances)`` says what
    the errors are.

    Parameters
    ----------
    source : Observer or Plant
        Discrete, constant in time and real.
    path : str or Path
        Folder for the files; made if it is not there.
    plant : Plant, optional
        Beside an observer: the names of its signals.
    m1, weight : optional
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

    Notes
    -----
    Functions return 0 where they did what they do, 1 where a number is not finite, and
    2 where a reading contradicts what a filter knows exactly; then the state is what it
    was.  With ``-DNAME_SELFTEST`` the source is a program that ends with 0 if it
    computes what Python does.  It warns where roundings in float add up to 0.1 % of z,
    in a slow mode; `rounding_error` measures them.  Source: Leondes and Novak (1974),
    (27), (33), (43); Bierman (1977), sections V.3 and VI.4.
    """
    require_beside(source, plant)
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
