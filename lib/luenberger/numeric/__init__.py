"""Linear algebra on plain arrays: ranks, forms, roots, exact rationals, checks.

What computes with arrays and numbers, and refuses what cannot be computed, enters
here; it knows nothing of plants.  It uses `errors`, NumPy and SciPy.
"""

import numpy as np

Matrix = np.ndarray  # two axes, or a stack (N, ., .); real, complex or of Fractions
Vector = np.ndarray  # one axis
Matrices = dict[str, np.ndarray]  # by name
