"""What rounding costs an observer on a device at most, proved for every instant."""

from __future__ import annotations

from collections.abc import Mapping

from ..arguments import expect, expect_as
from ..certificate import require_real
from ..errors import DesignError
from ..kernels.c.numbers import require_c_type
from ..observer import Observer
from ..plant import Plant
from .c.filter_words import filter_bound, signals_of
from .c.fit import fitted
from .c.observer import require_exportable
from .c.ranges import require_all
from .c.rounding_bound import RoundingBound, floating_bound
from .c.source_and_header import signals


def rounding_bound(
    source: Observer | Plant,
    *,
    plant: Plant | None = None,
    dtype: str = "float",
    bits: int | None = None,
    ranges: Mapping[str, float] | None = None,
) -> RoundingBound:
    r"""How far the C of `to_c` is from exact estimates at most, at every instant.

    With sizes taken entry by entry, what one step adds to the error of z is at most
    :math:`c + M |e|`: roundings of the matrices, readings and sums, in any order of
    the sums and with products rounded or not.  So :math:`|e| \le S (c + M |e|)` with
    :math:`S = \sum_k |F^k|`, and the estimate follows.  All sums have certificates.

    The filter of a plant computes its covariance and its gain as well.  A difference of
    covariances moves as :math:`F \Xi F'`, but for squares of what the gain is off, and
    a gain that is off by :math:`k` adds at most :math:`k |\nu|` to the error.  That
    bound takes that every output arrives at every sample.

    Parameters
    ----------
    source : Observer or Plant
        Constant, in discrete time.  Of a plant it is the bound of its Kalman filter.
    plant : Plant, optional
        Beside an observer: stable, with Q and R, for ranges of measurements that are
        not given.
    dtype : "float", "double" or "fixed"
        "fixed" goes with an observer.
    bits : 16 or 32, optional
        With "fixed".
    ranges : dict of str to float
        The largest size of inputs and measurements, by name.  Of measurements that are
        left out it is what the noises of a stable plant tell.

    Returns
    -------
    RoundingBound
        The bound of each estimate, and what it takes.

    Raises
    ------
    ValueError
        If a range is not known, or a number is beyond the range of float.
    DesignError
        If the source cannot be exported, so many bits do not suffice, or no bound was
        proved; it says why.

    See Also
    --------
    to_c : the source, whose header has this bound.
    rounding_error : what a record shows of it.

    References
    ----------
    export/derivation/rounding.py, filter_covariance.py, filter_rounding.py.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]])
    >>> observer = lb.kalman_filter(plant)
    >>> lb.export.rounding_bound(observer, ranges={"y1": 10.0})
    Rounding in float, proved:
    x1: off by at most 1.61e-06.
    This holds while |y1| <= 10.

    >>> plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[1]])
    >>> lb.export.rounding_bound(plant, ranges={"y1": 10.0})
    Rounding in float, proved:
    x1: off by at most 4.83e-06.
    This holds while |y1| <= 10.
    It takes that every output arrives at every sample from the first on.
    """
    expect(source=source)
    if isinstance(source, Plant):
        return _of_filter(source, plant, dtype, bits, ranges)
    observer = source
    if plant is not None:
        expect_as("plant=", "plant", plant)
    require_real("C export", observer)
    require_exportable(observer)
    named = signals(observer, plant)
    if dtype == "fixed":
        return fitted(observer, bits, named, plant, ranges)[1]
    require_floating(dtype, bits)
    found, sizes = floating_bound(observer, dtype, named, plant, ranges)
    require_all(sizes, named, plant)
    if found is None:
        raise DesignError(
            "no bound was proved: the observer forgets so slowly that roundings add up "
            "without a bound that was found; export double, or a faster observer"
        )
    return found


def _of_filter(
    source: Plant,
    plant: Plant | None,
    dtype: str,
    bits: int | None,
    ranges: Mapping[str, float] | None,
) -> RoundingBound:
    """The bound of a plant's filter."""
    require_beside(source, plant, dtype)
    require_floating(dtype, bits)
    require_real("C export", source)
    found, sizes = filter_bound(source, dtype, ranges)
    require_all(sizes, signals_of(source), source)
    if isinstance(found, str):
        raise DesignError(
            f"no bound was proved: {found}; export double, or the observer "
            "kalman_filter(plant), whose gain is constant"
        )
    return found


def require_beside(source: Plant, plant: Plant | None, dtype: str) -> None:
    """ValueError if what goes with an observer is given beside a plant."""
    if plant is not None:
        raise ValueError(
            "plant= goes with an observer, and the source is a plant: leave out plant="
        )
    if dtype == "fixed":
        raise ValueError(
            "dtype='fixed' goes with an observer, and the source is a plant: export "
            "reduced_order_filter(plant), whose gain is constant"
        )


def require_floating(dtype: str, bits: int | None) -> None:
    """ValueError unless `dtype` is a floating type of C, and `bits` is not given."""
    require_c_type(dtype)
    if bits is not None:
        raise ValueError(
            f"bits goes with dtype='fixed'; the dtype is {dtype!r}: leave out bits, or "
            "give dtype='fixed'"
        )
