"""What is to be estimated of a plant: combinations of its states, by name."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import few, short
from ..numeric import Matrix, Vector
from ..numeric.combinations import combinations
from ..numeric.validation import ReadOnly, names, vector

if TYPE_CHECKING:
    from .plant import Plant

Combinations = ArrayLike | Mapping[str, ArrayLike]  # rows, rows by name, or names


class Estimates(ReadOnly, Mapping[str, Vector]):
    """Rows of numbers by name, in order; read-only.

    Examples
    --------
    >>> found = Estimates({"torque (Nm)": [0, 120]}, 2)
    >>> list(found), found["torque (Nm)"]
    (['torque (Nm)'], array([  0., 120.]))
    """

    rows: dict[str, Vector]

    def __init__(self, given: Any, n: int) -> None:
        given = {} if given is None else given
        if not isinstance(given, Mapping):
            raise ValueError(
                "estimates must be combinations of the states by name, such as "
                f"{{'torque (Nm)': [...]}}, got {short(given)}"
            )
        names("w estimate", given, len(given))
        rows = {k: vector(f"estimates[{k!r}]", row, n) for k, row in given.items()}
        self._fill(rows=rows)

    def __getitem__(self, name: str) -> Vector:
        return self.rows[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        return repr(self.rows)


def by_name(value: Any, plant: Plant) -> tuple[Any, tuple[str, ...] | None]:
    """Combinations of states as rows, and what they are called, if anything.

    They are given as rows, as rows by name, or as names of states and of
    `plant.estimates`.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], state_names=["s", "v"])
    >>> by_name({"twice": [2, 0]}, plant)
    ([[2, 0]], ('twice',))
    >>> by_name("v", plant)
    ([array([0., 1.])], ('v',))
    """
    if isinstance(value, Mapping):
        return list(value.values()), names("w estimate", value, len(value))
    asked = [value] if isinstance(value, str) else value
    if not isinstance(asked, list | tuple) or not any(
        isinstance(one, str) for one in asked
    ):
        return value, None
    known = _known(plant)
    return [_row(one, known) for one in asked], names("w estimate", asked, len(asked))


def asking(plant: Plant, k: Combinations | None) -> Plant:
    """The plant with the combinations k for its estimates; as it is without them."""
    if k is None:
        return plant
    given, called = by_name(k, plant)
    rows = combinations("k", given, plant.n)
    named = called or [f"row {j + 1} of k x" for j in range(len(rows))]
    return replace(plant, estimates=Estimates(dict(zip(named, rows)), plant.n))


def _known(plant: Plant) -> dict[str, Vector]:
    states: Iterable[Matrix] = np.eye(plant.n)
    return dict(zip(plant.state_names, states)) | dict(plant.estimates or {})


def _row(name: object, known: dict[str, Vector]) -> Vector:
    if not isinstance(name, str) or name not in known:
        raise ValueError(
            f"there is no estimate or state {short(name)}; there are {few([*known])}"
        )
    return known[name]
