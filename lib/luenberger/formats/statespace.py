"""What a python-control or scipy.signal state space says, as parameters of a plant."""

from typing import Any

INTENSITIES = {  # of python-control and MATLAB: in continuous and in discrete time
    "QN": ("Q = G QN G'", "Q = G QN G'"),
    "RN": (
        "R = RN / dt for readings every dt seconds: R is of one reading, and RN in "
        "continuous time an intensity",
        "R = RN",
    ),
    "NN": ("no S: sampling a plant that has one is refused", "S = G NN"),
}


def read(sys: Any, dt: float | None = None, **options: Any) -> dict[str, Any]:
    """A, B, C, E, dt and names of a system, by the names that `Plant` has for them.

    `dt` is for a system that leaves it open; `options` are those of `Plant`.
    """
    if not all(hasattr(sys, name) for name in "ABCD"):
        raise ValueError(
            f"a {type(sys).__name__} has no A, B, C, D; convert it to a state space "
            "first: control.ss(sys), or sys.to_ss() in scipy.signal"
        )
    found = dict(A=sys.A, B=sys.B, C=sys.C, E=sys.D, dt=period(sys, dt))
    for kind in ("state", "input", "output"):
        labels = getattr(sys, f"{kind}_labels", None)
        if labels is not None:
            found[f"{kind}_names"] = tuple(labels)
    for theirs, ours in INTENSITIES.items():
        if theirs in options:
            given = ours[found["dt"] > 0]
            raise TypeError(f"{theirs} is not a covariance of Plant; give {given}")
    return found | options


def period(sys: object, wanted: float | None) -> float:
    """The dt of a system, or `wanted` where True or None leaves it open."""
    dt = getattr(sys, "dt", None)
    if dt is None and type(sys).__module__.startswith("scipy."):
        dt = 0.0  # that is how SciPy says continuous time
    if dt is not None and dt is not True:
        if wanted is not None and wanted != dt:
            raise ValueError(
                f"the system has dt = {dt:g}, but dt = {wanted!r} is given"
            )
        return dt
    if wanted is None:
        raise ValueError(
            f"the system's dt is {dt!r}: it does not say whether time is continuous, "
            "or how long a step is. Pass dt=, 0 or in seconds."
        )
    if dt is True and wanted == 0:
        raise ValueError(
            "the system's dt is True: it is in discrete time, so dt = 0 cannot be "
            "meant. Pass dt= in seconds."
        )
    return wanted
