"""The gain of least error trace, step by step.

Source: Leondes and Novak (1975), section III.
"""

from .recursions import (  # noqa: F401  (offered under this module's name)
    estimate_step,
    gain_step,
    steady_gradient,
    step_differential,
)
