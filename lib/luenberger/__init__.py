"""Reduced-order observers: derived in SymPy, compiled to NumPy, certified.

>>> import luenberger as lb
>>> plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0,
...                  Q=[[1/3, 1/2], [1/2, 1]], R=[[0]])
>>> observer = lb.reduced_order_filter(plant, m1=1)   # z+ = F z + G u + D y
>>> lb.certify(observer, plant).worst < 1e-14         # T+ A = F T + D C, ...
True
"""

from importlib import import_module

from . import sampling as sampling
from .analysis import error_covariance as error_covariance
from .analysis import multiply_adds as multiply_adds
from .certificate import Certificate as Certificate
from .certificate import certify as certify
from .certificate import residuals as residuals
from .compare import compare as compare
from .designs.canonical import ObservabilityForm as ObservabilityForm
from .designs.canonical import observability_form as observability_form
from .designs.deadbeat import deadbeat_observer as deadbeat_observer
from .designs.fixed_order import fixed_order_filter as fixed_order_filter
from .designs.fixed_order import fixed_order_search as fixed_order_search
from .designs.functional import functional_observer as functional_observer
from .designs.reconstruction import reconstruct_state as reconstruct_state
from .designs.staircase import reduced_order_observer as reduced_order_observer
from .designs.trace_minimisation import kalman_filter as kalman_filter
from .designs.trace_minimisation import reduced_order_filter as reduced_order_filter
from .ensemble import Ensemble as Ensemble
from .ensemble import monte_carlo as monte_carlo
from .errors import CertificateError as CertificateError
from .errors import DesignError as DesignError
from .filtering import Filtered as Filtered
from .filtering import filter_data as filter_data
from .observer import Observer as Observer
from .optimality import Optimality as Optimality
from .optimality import optimality as optimality
from .plant import Plant as Plant
from .recorded import estimate as estimate
from .simulate import Run as Run
from .simulate import simulate as simulate
from .stairs import Staircase as Staircase
from .stairs import staircase as staircase
from .sweep import Sweep as Sweep
from .sweep import sweep as sweep

_ON_DEMAND = ("export", "plot", "report")  # the last two import matplotlib


def __getattr__(name):
    if name in _ON_DEMAND:
        return import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
