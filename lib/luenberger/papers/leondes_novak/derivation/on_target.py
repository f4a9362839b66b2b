"""The filter in the order in which a device runs it: use the sample, then predict.

The step is that over a record, turned round: what belongs to the outputs of one instant
is used up at that instant, and nothing of it is kept.

Source: Leondes and Novak (1974), (27), (33), (43), (44); the order is our own.
"""

from dataclasses import replace
from functools import cache
from operator import methodcaller

from ....symbolic import Derivation, Relation
from .estimate import rho, rho_next, x_minus
from .letters import *
from .marks import arrived
from .marks import letters as marked
from .one_pass import TO_Z, filter_step, loop

device = loop.here(
    x="estimate",
    y="measurement",
    u="input",
    rho="what the estimate leaves of the measurement",
    Sigma="covariance of the error",
    x_minus="what was predicted for this sample",
    Omega="covariance of the error of that",
)
Omega_next = device("Omega_next", n, n, "the same for the next sample", symmetric=True)
x_minus_next = device("x_minus_next", n, 1, "what is predicted for the next sample")

HERE = {Sigma_next: Sigma, x_next: x, rho_next: rho, u_next: u}
AHEAD = {Omega: Omega_next, x_minus: x_minus_next}


def renamed(stage, names):
    """A stage, and the definitions that it rests on, in other letters."""
    put = methodcaller("xreplace", names)
    by = tuple(r.mapped(put) if isinstance(r, Relation) else r for r in stage.by)
    target, formula = put(stage.target), put(stage.formula)
    return replace(stage, target=target, formula=formula, by=by)


def definitions(stages):
    """The definitions that a stage list rests on, each once."""
    cited = (r for stage in stages.stages for r in stage.by)
    return tuple(dict.fromkeys(r for r in cited if isinstance(r, Relation)))


@cache
def update():
    """Omega, x_minus and the sample (y, u) of an instant to its Sigma, x and rho."""
    others = {stage.target for stage in TO_Z} | set(AHEAD)
    after = [stage for stage in filter_step().stages if stage.target not in others]
    return Derivation(
        (C, R, E, Gamma, u, y, Omega, x_minus),
        (*TO_Z, *(renamed(stage, HERE) for stage in after)),
        source=SOURCE,
        letters=device,
        says="what a sample does to what was predicted for it",
    )


@cache
def predict():
    """Sigma, x and the residual rho of an instant to Omega and x_minus of the next."""
    stages = [s for s in filter_step().stages if s.target in AHEAD]
    return Derivation(
        (A, As, Q, B, J, Sigma, x, rho, u),
        tuple(renamed(stage, AHEAD) for stage in stages),
        source=SOURCE,
        letters=device,
        says="what is predicted for the next sample",
    )


def in_turn(*parts, letters=device):
    """Stage lists one after the other; what one makes is given to the next."""
    given, stages = [], ()
    for part in parts:
        made = {stage.target for stage in stages}
        given += [s for s in part.given if s not in made and s not in given]
        stages += part.stages
    return Derivation(tuple(given), stages, source=SOURCE, letters=letters)


@cache
def complete_sample():
    """From one prediction to the next, where every output arrived."""
    return in_turn(update(), predict())


@cache
def partial_sample():
    """The update where some outputs did not arrive, from the plant's matrices."""
    return in_turn(arrived(), update(), letters=marked)


@cache
def marked_sample():
    """From one prediction to the next, where some outputs did not arrive.

    All matrices are the plant's, and those that arrived are marked.
    """
    return in_turn(arrived(), update(), predict(), letters=marked)


@cache
def sample_with_gain():
    """From one predicted state to the next with a gain that is known."""
    made = {stage.target for stage in TO_Z} | {Sigma, Omega_next}
    stages = [s for s in complete_sample().stages if s.target not in made]
    return Derivation(
        (A, B, J, C, E, K, u, y, x_minus),
        tuple(stages),
        source=SOURCE,
        letters=device,
        says="what a sample does to a predicted state, its gain being known",
    )


@cache
def derive():
    """The page."""
    page = (
        """Letters without a plus belong to the sample that has just come. The gain, the
        covariance and the estimate follow from it and from what was predicted for it.
        The equations are those of a step over a record, written one instant
        earlier.""",
        *definitions(update()),
        update(),
        "Then the next sample is predicted.",
        *definitions(predict()),
        predict(),
    )
    return Derivation(page=page, letters=device, source=f"{SOURCE}, (27), (43), (44)")
