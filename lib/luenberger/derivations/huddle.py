"""Luenberger's conditions, the error equation, and Huddle's solution.

Source: Leondes and Novak (1975), section II.
"""

from .recursions import (  # noqa: F401  (offered under this module's name)
    decorrelation,
    error_recursion,
    observer,
)
