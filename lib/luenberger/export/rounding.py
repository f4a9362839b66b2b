"""What an observer's C loses to rounding: compiled, run and compared on a record."""

from __future__ import annotations

import ctypes
import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..analysis.error_covariance import error_covariance
from ..arguments import expect
from ..certificate import require_match, require_real
from ..errors import DesignError
from ..kernels.c.library import library
from ..kernels.c.numbers import require_c_type
from ..numeric import Matrix, Vector
from ..numeric.validation import numbers
from ..observer import Observer
from ..plant import Plant
from ..run.estimate import estimate
from ..run.simulate import Run, simulate
from ..show import number
from .c.observer import require_exportable, texts, uses
from .c.selftest import driver
from .c.source_and_header import signals

NAME = "measured"
HELD = 100  # samples that a drawn input stays at a level
OTHERWISE = "export the source, and compare its estimates where there is one"


@dataclass(frozen=True, eq=False)
class RoundingError:
    """How far the estimates of exported C are from those of exact matrices in double.

    Attributes
    ----------
    dtype : str
        What the C computes in.
    largest, rms : (q,) ndarray
        Of the difference, over the record, in the units of each estimate.
    reached : (q,) ndarray
        How large each estimate was, at most.
    sigma : (q,) ndarray or None
        Steady standard deviation of each estimate's error; None where it is not known.
    names : tuple of str
        Of the estimates.
    record : str
        What it was measured on, with the largest of each input and output: signals
        that are larger are rounded more.
    """

    dtype: str
    largest: np.ndarray
    rms: np.ndarray
    reached: np.ndarray
    sigma: np.ndarray | None
    names: tuple
    record: str

    @property
    def worst(self) -> float | None:
        """The largest difference beside a standard deviation; None without these."""
        found = _over(self.largest, self.sigma)
        return None if found is None else float(found.max(initial=0.0))

    @property
    def sentences(self) -> list[str]:
        """What was measured, in words."""
        said = [f"Rounding in {self.dtype}, measured in compiled C on {self.record}:"]
        for k, name in enumerate(self.names):
            most, mean = number(self.largest[k], 3), number(self.rms[k], 3)
            size = number(self.reached[k], 3)
            one = f"{name}: off by at most {most}, rms {mean}, of up to {size}"
            if self.sigma is not None and self.sigma[k] > 0:
                part = 100 * self.largest[k] / self.sigma[k]
                one += f"; at most {number(part, 3)} % of its standard deviation"
            said.append(f"{one}.")
        return said

    def __repr__(self) -> str:
        return "\n".join(self.sentences)


def rounding_error(
    observer: Observer,
    plant: Plant,
    *,
    dtype: str = "float",
    steps: int = 10_000,
    seed: int = 8,
    u: ArrayLike | None = None,
    within: ArrayLike = 1.0,
) -> RoundingError:
    r"""Compile an observer's C, run it on a simulated record, and compare.

    The plant is simulated with its noises for `steps` samples.  Its readings pass
    through the C that `to_c` writes, in `dtype`, and through
    :math:`z_{i+1} = F z_i + G u_i + D y_i`, :math:`\hat w_i = P z_i + V y_i + W u_i`
    in double.  What differs is the rounding of constants, readings and sums.  It grows
    with the signals, so it holds for records like this one, and the result says how
    large their u and y are.

    Parameters
    ----------
    observer : Observer
        Constant, in discrete time.
    plant : Plant
        With Q and R, to simulate.
    dtype : "float" or "double"
    steps : int
        Length of the record, in samples.
    seed : int
        Of the noises, and of the inputs that are drawn.
    u : float or (N, m) array_like, optional
        The known input of the record; by default it is drawn.
    within : float or (m,) array_like, default 1
        How large each drawn input is at most, in its unit: levels between -within and
        within, each held for 100 samples.  Give what the device's inputs reach.

    Returns
    -------
    RoundingError
        The largest and the root mean square difference of each estimate, and the
        standard deviation to measure them by.

    Raises
    ------
    RuntimeError
        If there is no C compiler.
    DesignError
        If the observer cannot be exported, or the plant lacks Q or R.
    ValueError
        If a number is beyond the range of float.

    See Also
    --------
    to_c : the source.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]])
    >>> found = lb.export.rounding_error(lb.kalman_filter(plant), plant)
    >>> 1e-8 < found.worst < 1e-5
    True
    """
    expect(observer=observer, plant=plant)
    require_c_type(dtype)
    require_match(observer, plant)
    require_real("C export", observer, plant)
    require_exportable(observer)
    if plant.Q is None or plant.R is None:
        raise DesignError(
            "rounding is measured on a simulated record, and the plant lacks Q or R; "
            "give it both, or compare on a record of your own"
        )
    if isinstance(steps, bool) or not isinstance(steps, int | np.integer) or steps < 2:
        raise ValueError(f"steps must be a whole number above 1, got {steps!r}")
    said = ", the u that was given"
    if u is None:
        u, said = _levels(within, plant, int(steps), seed), ", u drawn"
    record = simulate(plant, observer, int(steps) - 1, u=u, seed=seed)
    exact = estimate(observer, record.y, record.u)
    gap = _run(observer, dtype, record.y, record.u) - exact
    return RoundingError(
        dtype,
        np.abs(gap).max(axis=0),
        np.sqrt((gap**2).mean(axis=0)),
        np.abs(exact).max(axis=0),
        _sigma(observer, plant),
        signals(observer, plant).what,
        f"a simulated record of {steps} samples, seed {seed}{said * (plant.m > 0)} "
        f"({_sizes(plant, record)})",
    )


def _levels(within: ArrayLike, plant: Plant, steps: int, seed: int) -> Matrix:
    """Inputs that are held for some samples, each at a level that is drawn."""
    size = numbers("within", within)
    if size.shape not in ((), (plant.m,)) or (size < 0).any():
        raise ValueError(
            f"within must be a number or {plant.m} of them, none negative, "
            f"got {within!r}"
        )
    rng = np.random.default_rng([seed, 1])  # not the stream of the noises
    levels = rng.uniform(-1, 1, (-(-steps // HELD), plant.m)) * size
    return np.repeat(levels, HELD, axis=0)[:steps]


def _sizes(plant: Plant, record: Run) -> str:
    """How large each input and each output of the record is at most."""
    names = (*plant.input_names, *plant.output_names)
    largest = np.abs(np.hstack([record.u, record.y])).max(axis=0)
    return ", ".join(f"|{a}| <= {number(x, 3)}" for a, x in zip(names, largest))


def _run(observer: Observer, dtype: str, y: Matrix, u: Matrix) -> Matrix:
    """The estimates of the compiled C."""
    kind = np.float64 if dtype == "double" else np.float32
    made = texts(observer, NAME, dtype, signals(observer))
    made |= {"driver.c": driver(NAME, dtype, uses(observer))}
    run = library(made, OTHERWISE).run
    inputs = (np.ascontiguousarray(X, kind) for X in (u, y))
    what = np.zeros((len(y), len(observer.P)), kind)
    pointers = [X.ctypes.data_as(ctypes.c_void_p) for X in (*inputs, what)]
    if refused := run(ctypes.c_int(len(y)), *pointers):
        raise DesignError(
            f"the C refused sample {refused} of the simulated record: a reading is "
            f"beyond the range of {dtype}; scale the units"
        )
    return what.astype(float)


def _sigma(observer: Observer, plant: Plant) -> Vector | None:
    """Steady standard deviations of the estimates, or None where there are none."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            Sigma = error_covariance(observer, plant, U=0 if plant.m else None)
    except ValueError:
        return None
    return np.sqrt(np.maximum(Sigma.diagonal(), 0))


def _over(size: Vector, sigma: Vector | None) -> Vector | None:
    if sigma is None:
        return None
    none = np.where(size > 0, np.inf, 0.0)
    return np.divide(size, sigma, out=none, where=sigma > 0)
