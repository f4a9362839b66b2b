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
from ..numeric import Matrix
from ..numeric.validation import numbers
from ..observer import Observer
from ..plant import Plant
from ..run.estimate import estimate
from ..run.record import Record
from ..run.simulate import simulate
from ..show import number
from .c.observer import require_exportable, texts, uses
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
        if self.sigma is None:
            return None
        none = np.where(self.largest > 0, np.inf, 0.0)
        parts = np.divide(self.largest, self.sigma, out=none, where=self.sigma > 0)
        return float(parts.max(initial=0.0))

    @property
    def sentences(self) -> list[str]:
        """What was measured, in words."""
        said = [f"Rounding in {self.dtype}, measured in compiled C on {self.record}:"]
        for k, name in enumerate(self.names):
            most, mean, size = (
                number(X[k], 3) for X in (self.largest, self.rms, self.reached)
            )
            one = f"{name}: off by at most {most}, rms {mean}, of up to {size}"
            if self.sigma is not None and self.sigma[k] > 0:
                part = number(100 * self.largest[k] / self.sigma[k], 3)
                one += f"; at most {part} % of its standard deviation"
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
    """Compile an observer's C, run it on a simulated record, and compare.

    >>> import luenberger as lb
    >>> plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]])
    >>> found = lb.export.rounding_error(lb.kalman_filter(plant), plant)
    >>> 1e-8 < found.worst < 1e-5
    True

    The plant is simulated with its noises for `steps` samples.  Its readings pass
    through the C that `to_c` writes, in `dtype`, and through `estimate` in double.
    What differs is the rounding of constants, readings and sums.  It grows with the
    signals, so it holds for records like this one; the result says how large they are.

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
    if u is None:  # levels that are held, each drawn
        size, said = numbers("within", within), ", u drawn"
        if size.shape not in ((), (plant.m,)) or (size < 0).any():
            raise ValueError(
                f"within must be a number or {plant.m} of them, none negative, "
                f"got {within!r}"
            )
        rng = np.random.default_rng([seed, 1])  # not the stream of the noises
        levels = rng.uniform(-1, 1, (-(-steps // HELD), plant.m)) * size
        u = np.repeat(levels, HELD, axis=0)[:steps]
    record = simulate(plant, observer, int(steps) - 1, u=u, seed=seed)
    exact = estimate(observer, Record(record.y, record.u))
    gap = _run(observer, dtype, record.y, record.u) - exact
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            Sigma = error_covariance(observer, plant.with_input(0))
        sigma = np.sqrt(np.maximum(Sigma.diagonal(), 0))
    except ValueError:  # there is none that is steady
        sigma = None
    reached = np.abs(np.hstack([record.u, record.y])).max(axis=0)
    sizes = ", ".join(
        f"|{name}| <= {number(x, 3)}"
        for name, x in zip((*plant.input_names, *plant.output_names), reached)
    )
    return RoundingError(
        dtype,
        np.abs(gap).max(axis=0),
        np.sqrt((gap**2).mean(axis=0)),
        np.abs(exact).max(axis=0),
        sigma,
        signals(observer, plant).what,
        f"a simulated record of {steps} samples, seed {seed}{said * (plant.m > 0)} "
        f"({sizes})",
    )


def _run(observer: Observer, dtype: str, y: Matrix, u: Matrix) -> Matrix:
    """The estimates of the compiled C."""
    kind = np.float64 if dtype == "double" else np.float32
    made = library(texts(observer, NAME, dtype, signals(observer)), OTHERWISE)
    rows = {k: np.ascontiguousarray(X, kind) for k, X in dict(u=u, y=y).items()}
    rows["what"] = np.zeros((len(y), len(observer.P)), kind)
    state = ctypes.create_string_buffer(8 * max(observer.order, 1))
    getattr(made, f"{NAME}_init")(state, None)
    calls = []
    for use in uses(observer)[1:]:
        call = getattr(made, f"{NAME}_{use.name}")
        call.argtypes = [ctypes.c_void_p] * (1 + len(use.arguments))
        given = [rows[k] for k in use.arguments]
        calls.append((call, [(X.ctypes.data, X.strides[0]) for X in given]))
    for k in range(len(y)):
        for call, given in calls:
            if call(state, *(start + k * stride for start, stride in given)):
                raise DesignError(
                    f"the C refused sample {k + 1} of the simulated record: a reading "
                    f"is beyond the range of {dtype}; scale the units"
                )
    return rows["what"].astype(float)
