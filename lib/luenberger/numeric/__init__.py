"""Linear algebra on plain arrays: ranks, forms, roots, exact rationals, checks.

What computes with arrays and numbers, and refuses what cannot be computed, enters
here; it knows nothing of plants.  It uses `errors`, NumPy and SciPy.
"""

import numpy as np
from numpy.typing import ArrayLike

Matrix = np.ndarray  # two axes, or a stack (N, ., .); real, complex or of Fractions
Vector = np.ndarray  # one axis
Given = ArrayLike | None  # an argument that may be left out
Matrices = dict[str, np.ndarray]  # by name
