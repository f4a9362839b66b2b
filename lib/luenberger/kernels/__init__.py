"""Stage list -> callable.  The only place that turns symbols into code.

A stage list comes as its `StageList`, from a paper's front door.  It is compiled at
the first call, and the same callable is returned afterwards.  Deriving the text takes
a few tenths of a second, SymPy's import included, so it is `kept` for the next
process.

What writes code from a stage list enters here, nothing that knows a plant or a paper.
It uses `matrixproof`, `stage_list` and `numeric`.
"""

import functools

from ..numeric import Matrices
from ..stage_list import StageList
from .step import Step


@functools.cache
def compiled(stages: StageList, *outputs: str, stacks: bool = False) -> Step:
    """A stage list as a NumPy function, pruned to `outputs`.

    Parameters
    ----------
    stages : StageList
    *outputs : str
        What is wanted of that which it computes; everything, if nothing is named.
    stacks : bool
        Leading axes broadcast.  Without it the matrices are matrices, which takes
        half the time.

    Returns
    -------
    callable
        ``step(**arrays) -> dict of arrays``; `step.given` are the names of the
        arrays, `step.source` is the text.
    """
    from . import kept
    from .step import assemble

    def make() -> tuple[str, list[str]]:
        from .text import numpy_source

        given, text = numpy_source(stages(), outputs, flat=not stacks)
        return text, list(given)

    return assemble(*kept.derived(("numpy", stages, outputs, stacks), make))


def run(
    stages: StageList, have: Matrices, *outputs: str, stacks: bool = False
) -> Matrices:
    """`compiled`, called with what it needs of the matrices in `have`, by name."""
    step = compiled(stages, *outputs, stacks=stacks)
    return step(**{name: have[name] for name in step.given})
