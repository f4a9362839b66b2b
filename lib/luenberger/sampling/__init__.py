"""Adaptive sampling: Hsia's laws, the sampled loop without approximation, and the
time-varying discrete plant that uneven instants make.

>>> from luenberger import Plant, sampling
>>> plant = Plant([[0, 1], [0, 0]], [[0], [1]], [[100, 10]])     # 10 (s + 10) / s^2
>>> run = sampling.simulate(sampling.periodic(0.04), plant, 1.2)
>>> run.samples, round(run.E, 4)
(30, 0.0596)
"""

from .discrete import discretise as discretise
from .laws import Law as Law
from .laws import absolute as absolute
from .laws import bounded as bounded
from .laws import linear as linear
from .laws import periodic as periodic
from .laws import quadratic as quadratic
from .laws import root as root
from .loop import Response as Response
from .loop import simulate as simulate
from .references import ramp as ramp
from .references import sine as sine
from .references import step as step
