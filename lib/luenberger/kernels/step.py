"""A NumPy kernel from its text, which may have been kept: no SymPy here."""

from ..numeric.linalg import eye, solve_right, symmetrise

_NAMESPACE = dict(eye=eye, solve_right=solve_right, symmetrise=symmetrise)


def assemble(source, given):
    """The function ``step(**arrays)`` of a text, with its text and arguments."""
    namespace = dict(_NAMESPACE)
    exec("import numpy as np\n" + source, namespace)  # made by us, see cache
    step = namespace["step"]
    step.source, step.given = source, tuple(given)
    return step
