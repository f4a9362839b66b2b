"""How long an observer remembers a wrong start."""

import numpy as np

from ..numeric import Matrix
from ..observer import Observer

LEFT = 0.01  # of a wrong start, when it counts as forgotten
ROUNDING = 1e-9  # of a product of matrices, beside its factors


def settling_time(observer: Observer) -> float:
    """Seconds until a wrong start has decayed to 1 % at the rate of the slowest pole.

    In discrete time whole samples.  Where every pole is next to zero it is the power
    of F that vanishes which counts.  Infinite if the observer is not stable.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=0.5)
    >>> settling_time(lb.reduced_order_observer(plant, [0.1]))  # 0.1^2 = 1 %
    1.0
    >>> settling_time(lb.deadbeat_observer(plant))
    0.5
    """
    poles = observer.poles
    if not poles.size:
        return 0.0
    if observer.dt == 0:
        rate = float(poles.real.max())
        return np.log(LEFT) / rate if rate < 0 else np.inf
    size = float(np.abs(poles).max())
    if size >= 1:
        return np.inf
    if size <= LEFT:
        return observer.dt * _vanishing(observer.F)
    return observer.dt * float(np.ceil(np.log(LEFT) / np.log(size) * (1 - 1e-12)))


def _vanishing(F: Matrix) -> int:
    """The least power of F that is rounding beside its factors, or 1 if none is."""
    size = float(np.linalg.norm(F))
    power = F = F / size if size > 0 else F
    for k in range(1, len(F) + 1):
        if np.linalg.norm(power) <= ROUNDING:
            return k
        power = power @ F
    return 1
