"""Units in which a filter is computed, so that those of the user play no part.

A tolerance that compares numbers of several states or outputs means nothing when one
of them is in light years.  Units are powers of two: a change of them does not round.
"""

import numpy as np

from .root_step import Move

SWEEPS = 50  # at most; a few are enough unless units differ along a long chain
EVEN = 2.0  # rows and columns that differ by less are left alone


def in_units(now, states, outputs):
    """The setting of the plant whose state is x / states and output y / outputs."""
    x, y = states[:, None], outputs[:, None]
    weight = np.eye(len(x)) if now.weight is None else now.weight
    move = now.move
    return now._replace(
        A=now.A / x * states, As=now.As / x * states, C=now.C / y * states,
        Q=now.Q / x / states, Qs=now.Qs / x / states, R=now.R / y / outputs,
        J=now.J / x * outputs, Gamma=now.Gamma / x * outputs, Phat=now.Phat / x,
        That=now.That * states, weight=weight * x * states, blind=now.blind * y,
        V=now.V / y, deviation=now.deviation / outputs,
        move=Move(move.A / x * states, move.Q / x / states, move.G / x,
                  move.size / x * states),
    )  # fmt: skip


def natural(now):
    """Units of the states and outputs in which the plant's numbers are of like size.

    A state's unit is such that what moves it, other states and noise, is as large as
    what it moves, other states and outputs; an output's unit is its own size.  This
    is the balancing of LAPACK's gebal, with noise and outputs taken along.
    """
    A = np.abs(now.As - np.diag(now.As.diagonal()))
    C, noise, sensor = np.abs(now.C), now.Qs.diagonal(), now.R.diagonal()
    states = np.ones(len(A))
    for _ in range(SWEEPS):
        even = True
        for i in range(len(A)):
            outputs = _sizes(C, sensor, states)
            moved = max((A[i] * states).max(), np.sqrt(noise[i]))
            seen = max((A[:, i] / states).max(), (C[:, i] / outputs).max(initial=0))
            found = _unit(moved, seen)
            if found is not None and not 1 / EVEN <= found / states[i] <= EVEN:
                states[i], even = found, False
        if even:
            break
    return states, _sizes(C, sensor, states)


def _unit(moved, seen):
    """The unit u for which moved / u = seen * u, or whichever there is, is 1."""
    if moved > 0 and seen > 0:
        return power_of_two(np.sqrt(moved) / np.sqrt(seen))
    if moved > 0 or seen > 0:
        return power_of_two(moved if moved > 0 else 1 / seen)
    return None


def _sizes(C, sensor, states):
    """Units of the outputs: the size of what they show and of their noise."""
    size = np.maximum((C * states).max(axis=1), np.sqrt(sensor))
    return power_of_two(np.where(size > 0, size, 1.0))


def power_of_two(size):
    return 2.0 ** np.round(np.log2(size))
