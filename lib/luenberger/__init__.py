"""Reduced-order observers: derived in SymPy, compiled to NumPy, certified.

>>> import luenberger as lb
>>> plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0,
...                  Q=[[1/3, 1/2], [1/2, 1]], R=[[0]])
>>> observer = lb.reduced_order_filter(plant, m1=1)   # z+ = F z + G u + D y
>>> lb.certify(observer, plant).worst < 1e-14         # T+ A = F T + D C, ...
True
"""

from importlib import import_module
from typing import TYPE_CHECKING

from . import interrupts as interrupts  # before all that takes time
from . import sampling as sampling
from .analysis.constant_parameter import white_noise_factor as white_noise_factor
from .analysis.error_covariance import error_covariance as error_covariance
from .analysis.optimality import Optimality as Optimality
from .analysis.optimality import optimality as optimality
from .analysis.step_cost import multiply_adds as multiply_adds
from .certificate import Certificate as Certificate
from .certificate import certify as certify
from .certificate import residuals as residuals
from .compare import compare as compare
from .compare.robust_table import Robustness as Robustness
from .compare.robustness import robustness as robustness
from .compare.sweep import Sweep as Sweep
from .compare.sweep import sweep as sweep
from .errors import CertificateError as CertificateError
from .errors import DesignError as DesignError
from .identification.fit import NoiseFit as NoiseFit
from .identification.fit import fit_noise as fit_noise
from .identification.identifiability import Identifiability as Identifiability
from .identification.identifiability import identifiability as identifiability
from .identification.whiteness import Whiteness as Whiteness
from .identification.whiteness import whiteness as whiteness
from .numeric.staircase_form import Staircase as Staircase
from .numeric.staircase_form import staircase as staircase
from .observer import Observer as Observer
from .papers.haddad_bernstein.design import fixed_order_filter as fixed_order_filter
from .papers.haddad_bernstein.design import fixed_order_search as fixed_order_search
from .papers.kawazoe.deadbeat import deadbeat_observer as deadbeat_observer
from .papers.kawazoe.form import ObservabilityForm as ObservabilityForm
from .papers.kawazoe.form import observability_form as observability_form
from .papers.kawazoe.reconstruction import reconstruct_state as reconstruct_state
from .papers.leondes_novak.design import kalman_filter as kalman_filter
from .papers.leondes_novak.design import reduced_order_filter as reduced_order_filter
from .papers.moore.design import functional_observer as functional_observer
from .papers.van_dooren.design import reduced_order_observer as reduced_order_observer
from .plant import Plant as Plant
from .run.estimate import estimate as estimate
from .run.filter import Filter as Filter
from .run.filter import Filtered as Filtered
from .run.monte_carlo import Ensemble as Ensemble
from .run.monte_carlo import monte_carlo as monte_carlo
from .run.record import Record as Record
from .run.simulate import Run as Run
from .run.simulate import simulate as simulate
from .run.smoothed import Smoothed as Smoothed

_ON_DEMAND = {  # export takes time; plot and report import matplotlib
    "export": "export",
    "plot": "plot",
    "report": "report",
    "measurements": "run.measurements",  # named by notebooks of earlier reports
    "results": "report.result_files",
}

if TYPE_CHECKING:  # or a type checker would take every name for one of these
    from . import export as export
    from . import plot as plot
    from . import report as report
    from .kernels.compiling import compile as compile
    from .report import result_files as results  # noqa: F401
    from .run import measurements as measurements

    __version__: str
else:

    def __getattr__(name):
        if name in _ON_DEMAND:
            return import_module(f".{_ON_DEMAND[name]}", __name__)
        if name == "compile":  # SymPy takes time
            from .kernels.compiling import compile

            return compile
        if name == "__version__":
            from importlib.metadata import version

            return version("luenberger")
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    def __dir__():
        more = {*_ON_DEMAND, "compile", "__version__"} - {"measurements"}
        return sorted({*globals(), *more})
