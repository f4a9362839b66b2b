"""Observers for elsewhere: C99 source, python-control and scipy.signal systems."""

import numpy as np

from .. import certificate
from ..arrays import names
from ..errors import DesignError
from ..observer import Observer
from ..plant import Plant
from . import constant, recursive
from .files import write_pair
from .pair import Signals
from .words import identifier


def to_c(
    source, path, *, plant=None, m1=None, weight=None, name="observer", dtype="double"
):
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

    Returns
    -------
    list of Path
        NAME.c and NAME.h.

    Raises
    ------
    ValueError
        If the name is not an identifier or is reserved, a number is beyond the range
        of float, or a file of this name is there and is not ours.
    DesignError
        If the observer is unstable, varies with time or has dt = 0; if the plant
        varies with time, lacks Q, R or P0, or has noise-free outputs.

    Notes
    -----
    Compile the source with ``-DNAME_SELFTEST`` for a main that compares a run with
    what Python computed and ends with 0 where they agree.

    References
    ----------
    Leondes and Novak (1974), equations (9), (27), (33), (43), (44);
    derivations/one_pass.py, derivations/on_target.py.

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
    identifier(name)
    if dtype not in ("double", "float"):
        raise ValueError(f"dtype must be 'double' or 'float', got {dtype!r}")
    if isinstance(source, Plant):
        if plant is not None:
            raise ValueError("plant= goes with an observer; the source is a plant")
        texts = recursive.texts(source, m1 or 0, weight, name, dtype)
    elif isinstance(source, Observer):
        if m1 is not None or weight is not None:
            raise ValueError("m1 and weight go with a plant; the source is an observer")
        certificate.require_real("C export", source)
        constant.require_exportable(source)
        texts = constant.texts(source, name, dtype, _signals(source, plant))
    else:
        raise ValueError(
            f"source must be an Observer or a Plant, got {type(source).__name__}"
        )
    return write_pair(path, texts)


def to_control(observer, *, plant=None):
    """The observer as a python-control StateSpace from [u; y] to w^.

    Parameters
    ----------
    observer : Observer
        Constant.
    plant : Plant, optional
        For the names of the signals.

    Returns
    -------
    control.StateSpace
        Inputs named as the plant's inputs and outputs, states z1, z2, ..., outputs
        after what they estimate.  It starts from zero, not from z0: pass
        ``X0=observer.z0`` to a simulation.

    Raises
    ------
    DesignError
        If the observer varies with time.
    ImportError
        If python-control is not installed.

    Examples
    --------
    >>> import luenberger as lb
    >>> from luenberger.export import to_control
    >>> observer = lb.Observer([[0.5]], [[1]], [[2]], [[1]], [[1]], T=[[1]],
    ...                        L=[[1]], dt=1.0)
    >>> to_control(observer).input_labels, to_control(observer).dt
    (['u1', 'y1'], 1.0)
    """
    import control

    signals = _signals(observer, plant)
    u, y = _labels(signals.u), _labels(signals.y)
    if set(u) & set(y):
        u, y = [f"u {label}" for label in u], [f"y {label}" for label in y]
    return control.ss(
        *_matrices(observer),
        observer.dt,
        inputs=[*u, *y],
        outputs=[f"{label} estimate" for label in _labels(signals.what)],
        states=[f"z{k + 1}" for k in range(observer.order)],
    )


def to_scipy(observer):
    """The observer as a scipy.signal StateSpace from [u; y] to w^.

    Parameters
    ----------
    observer : Observer
        Constant.

    Returns
    -------
    scipy.signal.StateSpace
        The first m inputs are u, the others y.  It starts from zero, not from z0.

    Raises
    ------
    DesignError
        If the observer varies with time.

    Examples
    --------
    >>> import luenberger as lb
    >>> from luenberger.export import to_scipy
    >>> observer = lb.Observer([[0.5]], [[1]], [[2]], [[1]], [[1]], T=[[1]],
    ...                        L=[[1]], dt=1.0)
    >>> to_scipy(observer).B
    array([[1., 2.]])
    """
    import scipy.signal

    options = {"dt": observer.dt} if observer.dt else {}
    return scipy.signal.StateSpace(*_matrices(observer), **options)


def _matrices(o):
    """The four matrices from [u; y] to w^."""
    if o.steps is not None:
        raise DesignError(
            f"the observer has {o.steps} rows of gains, a StateSpace is constant; "
            "design without steps"
        )
    return o.F, np.hstack([o.G, o.D]), o.P, np.hstack([o.W, o.V])


def _signals(observer, plant):
    """Names of u, y and w^; of the plant, of the observer, or by number."""
    if plant is not None:
        certificate.require_match(observer, plant)
        observer = observer.named(plant)
    u = names("u input", observer.input_names, observer.G.shape[-1])
    y = names("y output", observer.output_names, observer.D.shape[-1])
    return Signals(u, y, observer.estimate_names)


def _labels(names):
    """Names that python-control takes, whose dot is between system and signal."""
    return [name.replace(".", "_") for name in names]
