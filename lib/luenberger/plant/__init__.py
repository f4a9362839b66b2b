"""The plant: checked once, read-only; continuous, discrete, or the one sampled.

What a plant is enters here; what is made of one does not.  It uses `period` for the
discrete plant of a continuous one, and `formats` for files.
"""

from .plant import Instant as Instant
from .plant import Plant as Plant
from .sampled import over_periods as over_periods
