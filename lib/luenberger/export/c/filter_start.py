"""The maps of a filter and its first state, in the numbers of a device."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...errors import DesignError
from ...filtering import passes
from ...filtering.maps import Settings
from ...filtering.pack import FEW, begin
from ...filtering.passes import Maps
from ...kernels.c.numbers import representable
from ...numeric import Matrices, Vector

MOST = 6  # outputs of which each choice has matrices of its own
NAMES = dict(M="A", B="A", G="Q", r="R")  # of maps, as a user knows them
MOVING = ("M", "B", "X", "O")  # maps that hang on which outputs arrived


class Start:
    """What a device has of a filter.

    Attributes
    ----------
    maps : Maps
        Of a sample with every output.
    mix : list of list of float
        What combines its readings.
    few : bool
        Whether it is written as statements.
    correlated : bool
        Whether readings are combined, so that their noises are not correlated.
    state : dict of str to ndarray
        z, V, D and met ahead of the first sample.
    """

    def __init__(self, settings: Settings, real: str) -> None:
        self.settings, self.plant, self.real = settings, settings.plant, real
        every, R = np.ones(self.plant.p, dtype=bool), self.plant.at(0).covariances()[1]
        self.maps = self.at(every)
        self.mix = self.narrow("R", settings.at(1, every)[1]).tolist()
        alone = settings.way == "nothing"
        self.few = alone and self.plant.n <= FEW
        self.correlated = alone and bool((R - np.diag(R.diagonal())).any())
        self.state = self._state()

    def _state(self) -> Matrices:
        plant, n = self.plant, self.plant.n
        end = begin(self.settings, np.zeros(plant.m))
        z, V, D, E, e = (X.copy() for X in end.state)
        met = np.abs(z[:n])
        if not plant.at_first:
            M, B, G, X, _, _, _, d = self.settings.at(0, end.seen)[0]
            wide = B.shape[1] + G.shape[1] + (len(e) if X.shape[1] else 0)
            passes.predict.on()(
                M, B, G, X, d, np.zeros(n), z, V, D, E, e, np.zeros((n, wide)),
                np.zeros(wide), np.zeros(n), met, np.zeros((0, n)), np.zeros(wide),
            )  # fmt: skip
        found = dict(z=z, V=V, D=D, met=met)
        return {k: self.narrow("P0", X) for k, X in found.items()}

    def narrow(self, name: str, X: Any) -> np.ndarray:
        """The matrix in the numbers of the device."""
        return representable(name, X, self.real)

    def at(self, seen: Vector) -> Maps:
        """The maps of a sample, by what arrives."""
        found = self.settings.at(1, seen)[0]._asdict()
        return Maps(**{k: self.narrow(NAMES.get(k, k), X) for k, X in found.items()})

    def patterns(self) -> tuple[list[int], list[int], list[Maps]]:
        """For each output its bit, for each sum of bits which maps, and the maps.

        Where no noise is shared with the next state, only outputs that are treated as
        exact have a bit: whether others arrive changes no matrix.
        """
        p, S, found = self.plant.p, self.plant.S, dict[bytes, tuple[int, Maps]]()
        told = isinstance(self.settings.weight, str) or (S is not None and np.any(S))
        which = range(p) if told else sorted(self.settings.accurate)
        if len(which) > MOST:
            raise DesignError(
                "noisy outputs are treated as exact, and the matrices of a sample hang "
                f"on which of {len(which)} outputs arrive: too many choices for a "
                "device. Leave out m1, or treat outputs without noise as exact."
            )
        bits, at = [0] * p, []
        for k, j in enumerate(which):
            bits[j] = 2**k
        for code in range(2 ** len(which)):
            maps = self.at(np.array([not bit or bool(bit & code) for bit in bits]))
            key = b"".join(getattr(maps, k).tobytes() for k in MOVING)
            at.append(found.setdefault(key, (len(found), maps))[0])
        return bits, at, [maps for _, maps in found.values()]
