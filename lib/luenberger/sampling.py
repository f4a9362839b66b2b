"""Adaptive sampling: Hsia's laws, the sampled loop without approximation, and the
time-varying discrete plant that uneven instants make.

>>> from luenberger import Plant, sampling
>>> plant = Plant([[0, 1], [0, 0]], [[0], [1]], [[100, 10]])     # 10 (s + 10) / s^2
>>> run = sampling.simulate(sampling.periodic(0.04), plant, 1.2)
>>> run.samples, round(run.E, 4)
(30, 0.0596)
"""

from .papers.hsia.laws import Law as Law
from .papers.hsia.laws import absolute as absolute
from .papers.hsia.laws import bounded as bounded
from .papers.hsia.laws import linear as linear
from .papers.hsia.laws import periodic as periodic
from .papers.hsia.laws import quadratic as quadratic
from .papers.hsia.laws import root as root
from .papers.hsia.loop import Response as Response
from .papers.hsia.loop import simulate as simulate
from .papers.hsia.references import ramp as ramp
from .papers.hsia.references import sine as sine
from .papers.hsia.references import step as step
from .run.discretise import discretise as discretise
