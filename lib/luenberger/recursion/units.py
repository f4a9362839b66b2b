"""A plant and its split of the outputs in other units; see `balance`."""

from ..numeric import Vector
from ..numeric.balance import balanced
from .root_step import Move
from .settings import Setting


def in_units(now: Setting, states: Vector, outputs: Vector) -> Setting:
    """The setting of the plant whose state is x / states and output y / outputs."""
    x, y = states[:, None], outputs[:, None]
    move = now.move
    return now._replace(
        A=now.A / x * states, C=now.C / y * states,
        Q=now.Q / x / states, R=now.R / y / outputs,
        J=now.J / x * outputs, Gamma=now.Gamma / x * outputs, Phat=now.Phat / x,
        That=now.That * states, weight=now.whole_weight * x * states,
        blind=now.blind * y,
        V=now.V / y, deviation=now.deviation / outputs,
        move=Move(move.A / x * states, move.Q / x / states, move.G / x,
                  move.size / x * states),
    )  # fmt: skip


def natural(now: Setting) -> tuple[Vector, Vector]:
    """Units of the states and outputs in which the plant's numbers are of like size."""
    return balanced(now.As, now.C, now.Qs.diagonal(), now.R.diagonal())
