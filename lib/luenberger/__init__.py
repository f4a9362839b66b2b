"""Reduced-order observers: derived in SymPy, compiled to NumPy, certified.

>>> import luenberger as lb
>>> plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0,
...                  Q=[[1/3, 1/2], [1/2, 1]], R=[[0]])
>>> observer = lb.reduced_order_filter(plant, m1=1)   # z+ = F z + G u + D y
>>> lb.certify(observer, plant).worst < 1e-14         # T+ A = F T + D C, ...
True
"""

from typing import TYPE_CHECKING

from . import sampling
from .analysis.error_covariance import error_covariance
from .analysis.optimality import optimality
from .certificate import certify
from .comparison import candidates, compare, vary
from .errors import CertificateError, DesignError
from .identification.fit import fit_noise
from .observer import Observer
from .papers.haddad_bernstein.design import fixed_order_filter
from .papers.kawazoe.deadbeat import deadbeat_observer
from .papers.leondes_novak.design import kalman_filter, reduced_order_filter
from .papers.moore.design import functional_observer
from .papers.van_dooren.design import reduced_order_observer
from .plant import Plant
from .run.estimate import estimate
from .run.filter import Filter
from .run.monte_carlo import monte_carlo
from .run.record import Record
from .run.simulate import simulate

__all__ = [
    "CertificateError",
    "DesignError",
    "Filter",
    "Observer",
    "Plant",
    "Record",
    "candidates",
    "certify",
    "compare",
    "compile",
    "deadbeat_observer",
    "error_covariance",
    "estimate",
    "export",
    "fit_noise",
    "fixed_order_filter",
    "functional_observer",
    "kalman_filter",
    "monte_carlo",
    "optimality",
    "plot",
    "reduced_order_filter",
    "reduced_order_observer",
    "sampling",
    "simulate",
    "vary",
]

if TYPE_CHECKING:  # or a type checker would take every name for one of these
    from . import export, plot
    from .kernels.compiling import compile

    __version__: str
else:

    def __getattr__(name: str) -> object:
        """What takes time to load, when it is asked for."""
        if name in ("export", "plot", "report"):  # export and plot take time
            from importlib import import_module

            return import_module(f".{name}", __name__)
        if name == "compile":  # SymPy takes time
            from .kernels.compiling import compile

            return compile
        if name == "__version__":
            from importlib.metadata import version

            return version("luenberger")
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    def __dir__() -> list[str]:
        return __all__
