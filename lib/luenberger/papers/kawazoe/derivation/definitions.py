"""Kawazoe's coordinates, and the state from p_M samples.

What holds for every size is proved in letters; what rests on the pattern of zeros and
ones in (11) and (14), at several patterns with a symbol for every other entry.

Source: Kawazoe (1978), sections II to IV.
"""

from functools import cache

from sympy import Matrix

from ....symbolic import BlockMatrix, Derivation, Explicit, Line
from . import form
from .letters import *


def over_patterns(values):
    """{"p = ..": values(p)} of each index pattern, one with a longer block first."""
    wanted = sorted(form.PATTERNS, key=lambda indices: indices != (3, 1))
    return {f"p = {indices}": values(indices) for indices in wanted}


def coordinates(indices):
    moved = form.coordinates(indices)
    size = sum(indices)
    Phi_, _ = form.structure(indices)
    return {P_A: moved.left, Phi: Phi_, P: form.named("P", size, size)}


def heads(indices):
    size, v = sum(indices), form.starts(indices)
    _, H_ = form.structure(indices)
    rows = form.named("P", size, size)
    return {H: H_, P: rows, C: rows.extract(v[:-1], list(range(size)))}


def window(indices):
    """The outputs of p_M samples, run symbol by symbol, and what makes them."""
    v, samples = form.starts(indices), max(indices)
    _, H_ = form.structure(indices)
    G_, E_, u_, w_, y_ = form.record(indices, samples)
    pairs = [(i, k) for i, size in enumerate(indices) for k in range(size)]
    stacked = Matrix([y_[k][i] - (E_[i, :] * u_[k])[0] for i, k in pairs])
    driven = Matrix([form.inputs_of_16(indices, i, k, G_, u_) for i, k in pairs])
    blocks = [
        form.toeplitz(G_[v[i] : v[i + 1], :], size, samples)
        for i, size in enumerate(indices)
    ]
    others = [k for k in range(sum(indices)) if k not in v[:-1]]
    tops = v[:-1]
    return {
        y_s: stacked,
        d_s: driven,
        w: w_,
        H: H_,
        w_t: w_.extract(tops, [0]),
        w_o: w_.extract(others, [0]),
        y_o: stacked.extract(others, [0]),
        Delta: Matrix.vstack(*blocks),
        u_p: Matrix.vstack(*u_[:-1]),
        Pi: Matrix(w_.rows, w_.rows, lambda k, j: int([*tops, *others][j] == k)),
    }


def of_window(*wanted):
    return over_patterns(lambda p: {letter: window(p)[letter] for letter in wanted})


def one_sample_less(indices):
    Phi_, H_ = form.structure(indices)
    v, longest = form.starts(indices), indices.index(max(indices))
    end = v[longest + 1] - 1
    rows = [H_ * Phi_**k for k in range(max(indices) - 1)]
    unit = Matrix(sum(indices), 1, lambda k, _: int(k == end))
    return {O_s: Matrix.vstack(*rows), b: unit}


PAGE = (
    "The plant, in discrete time.",
    is_x := define(x_next, A * x + B * u, "1"),
    is_y := define(y, C * x, "2"),
    """Coordinates are made of rows `C_i A^k`, taken in the order `C_1` to `C_m`,
    then those times `A`, and so on; a row that depends on rows before it is
    omitted. Sorted by output they are `P`.""",
    is_w := define(w, P * x, "8"),
    is_w_next := define(w_next, P * x_next, "8"),
    turned := define(P * A, Phi * P, "11"),
    is_G := define(G, P * B, "13"),
    read := define(C, H * P, "14"),
    moves := chain(
        "9",
        "the plant in these coordinates",
        w_next,
        Line(P * x_next, by=(is_w_next,)),
        Line(P * A * x + P * B * u, by=(is_x,)),
        Line(Phi * P * x + G * u, by=(turned, is_G)),
        Line(Phi * w + G * u, by=(is_w,)),
    ),
    chain(
        "10",
        "the measurement in these coordinates",
        y,
        Line(C * x, by=(is_y,)),
        Line(H * P * x, by=(read,)),
        Line(H * w, by=(is_w,)),
    ),
    chain(
        "26",
        "the way back",
        x,
        Line(P.I * P * x, why="P is invertible"),
        Line(P.I * w, by=(is_w,)),
    ),
    "The new pair is observable exactly if the old one is, power by power.",
    so_far := define(C * A_l, H * Phi_l * P),
    chain(
        "3",
        "the rows of both observability matrices",
        C * A_l * A,
        Line(H * Phi_l * P * A, by=(so_far,)),
        Line(H * Phi_l * Phi * P, by=(turned,)),
    ),
    """`A` takes each row of a block of `P` to the next. It takes the last one to a
    combination of all rows, whose coefficients `phi_ij` are the last row of that
    block of `Phi`; the order of the search makes more of them zero.""",
    Explicit("6, 11, 12", "the pattern", P_A, Phi * P, over_patterns(coordinates)),
    "The rows of `C` head the blocks.",
    Explicit("4, 14, 19", "the heads of the blocks", H * P, C, over_patterns(heads)),
    """A later output shows the state of the moment, and what the inputs since have
    added.""",
    later := define(w_l, Phi_l * w + s_l),
    powers := define(Phi_next, Phi * Phi_l),
    added := define(s_next, Phi * s_l + G * u),
    chain(
        "15",
        "one more sample",
        Phi * w_l + G * u,
        Line(Phi * Phi_l * w + Phi * s_l + G * u, by=(later,)),
        Line(Phi_next * w + s_next, by=(powers, added)),
    ),
    is_y_l := define(y_l, H * w_l, "10"),
    chain(
        "15",
        "a later output",
        y_l,
        Line(H * w_l, by=(is_y_l,)),
        Line(H * Phi_l * w + H * s_l, by=(later,)),
    ),
    """Take output `i` at `p_i` samples. The coefficients of `w` in these outputs
    are the identity, so there are `n` of them, and `p_1` to `p_m` add up to `n`.""",
    Explicit(
        "7, 16",
        "the coefficients of the state",
        K,
        Identity(n),
        over_patterns(lambda indices: {K: form.chains(indices)}),
    ),
    "So the state is these outputs, less what the inputs contribute.",
    Explicit(
        "16, 17",
        "the state from outputs and inputs",
        y_s - d_s,
        w,
        of_window(y_s, d_s, w),
    ),
    "The first entry of each block is an output of the moment. The others follow.",
    Explicit("18", "what is read", H * w, w_t, of_window(H, w, w_t)),
    Explicit(
        "20, 22, 24, 25",
        "what is computed",
        y_o - Delta * u_p,
        w_o,
        of_window(y_o, Delta, u_p, w_o),
    ),
    Explicit(
        "18, 23",
        "both together are the state",
        Pi * BlockMatrix([[w_t], [w_o]]),
        w,
        of_window(Pi, w_t, w_o, w),
    ),
    """That takes `p_M` samples, the largest of the indices. One sample less does
    not see the last entry of the longest block.""",
    Explicit(
        "21",
        "one sample less is not enough",
        O_s * b,
        ZeroMatrix(s, 1),
        over_patterns(one_sample_less),
    ),
)


@cache
def derive():
    """The page."""
    source = f"{SOURCE}, sections II to IV"
    return Derivation(page=PAGE, letters=letters, source=source)
