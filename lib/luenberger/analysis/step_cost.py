"""What one constant observer costs on a device, counted from the step that it runs."""

from typing import NamedTuple

from ..kernels import lowered
from ..kernels.program import Program
from ..observer import Observer
from ..papers.leondes_novak.derivation import observer_step

MATRICES = "FGDPVW"
DOUBLE = 8  # bytes


class StepCost(NamedTuple):
    """What one observer costs on a device, in doubles."""

    multiply_adds: int  # of a step
    bytes: int  # of its state and constants


def step_cost(observer: Observer) -> StepCost:
    """Count the C that `export.to_c` would write for a constant, real observer.

    Short observers are written as scalars, where zeros and copies cost nothing and
    equal expressions are computed once; long and dense ones as loops, which multiply
    by zeros too.

    Examples
    --------
    >>> import luenberger as lb
    >>> step_cost(lb.Observer([[0.5]], [[1]], [[2]], [[0], [1]], [[1], [2]],
    ...                       T=[[-2, 1]], L=[[1, 0], [0, 1]]))
    StepCost(multiply_adds=5, bytes=32)
    """
    known = {k: getattr(observer, k).tolist() for k in MATRICES}
    cost = step_program(observer).cost(step_sizes(observer), known)
    return StepCost(cost.terms, DOUBLE * (observer.order + cost.constants))


def step_program(observer: Observer) -> Program:
    """The step from z, y and u to w_hat and z_next, without matrices that vanish."""
    zero = [k for k in MATRICES if not getattr(observer, k).any()]
    return lowered(observer_step, ["w_hat", "z_next"], zero=zero)


def step_sizes(observer: Observer) -> dict[str, int]:
    """The sizes of `step_program` by name."""
    q, r = observer.P.shape
    return dict(q=q, r=r, p=observer.D.shape[1], m=observer.G.shape[1])
