"""One model of everything that a page, a line or a claim rests on.

Each line can have a model of what it cites, while the page has none: A Y = I in one
chain and A Y = 2 I in another.  Then the page proves anything.  So one model is sought
in which all of it holds at once, the moments of random columns included.
"""

from collections import deque
from collections.abc import Iterable
from functools import lru_cache
from typing import Any

import sympy as sp

from .attempts import Model, models
from .dependence import letters
from .joint import Joint, NotLinear
from .relations import Moment, Relation
from .settings import Setting
from .typeset import text
from .words import Formula, Symbols, Values, plain

KNOWN: deque[tuple[frozenset, ...]] = deque(maxlen=200)  # what has a model
LIMIT = 160  # attempts to find a model, at generic sizes and at small ones
STRETCH = 40  # attempts until the other sizes are tried
SAID = "no model was found, within the limit of the search, in which {} at once"
MEND = (
    "change one of them, or, if all can hold, give a witness: exact values of letters "
    "from which the search finds the others, Derivation(..., witness={letter: value})"
)


@lru_cache(1000)
def one_model(
    relations: tuple[Relation, ...],
    symmetric: frozenset = frozenset(),
    also: tuple[Formula, ...] = (),
    witness: tuple[tuple[Any, Any], ...] = (),
) -> Model | None:
    """A `Model` of relations and moments, or None if none was found.

    Letters of the witness, of (letter, value) pairs, have those values.

    Raises
    ------
    NotLinear
        A relation is not linear in columns that may be random.

    Examples
    --------
    >>> from matrixproof import Identity, MatrixSymbol
    >>> from matrixproof.relations import Moment
    >>> n = sp.symbols("n", integer=True, positive=True)
    >>> w, one = MatrixSymbol("w", n, 1), Identity(n)
    >>> one_model((Moment("", w * w.T, one),)) is None
    False
    >>> one_model((Moment("", w * w.T, -one),)) is None
    True
    """
    moments = any(isinstance(r, Moment) for r in relations)
    ways = [Joint(relations, free) for free in (False, True)[: 1 + moments]]
    settings = [
        Setting(
            way.relations,
            symmetric.union(way.symmetric),
            (*also, *way.blocks.values()),
            dict(witness),
        )
        for way in ways
    ]
    turns = list(zip(ways, settings)) * 2
    for k in range(0, LIMIT, STRETCH):
        for turn, (way, setting) in enumerate(turns):
            small = turn >= len(ways)
            sizes = setting.small_sizes() if small else setting.generic_sizes()
            for found in models(setting, sizes, range(k, k + STRETCH)):
                if way.possible(found.world):
                    return found
    return None


def values_of(witness, symmetric):
    """{letter: its value}; a number stands for a matrix of one entry."""
    found = {}
    for letter, value in witness.items():
        if isinstance(letter, sp.MatrixSymbol):
            value = sp.ImmutableMatrix(value if hasattr(value, "__len__") else [value])
            if letter in symmetric and value != value.T:
                raise ValueError(f"{text(letter)} of the witness is not symmetric")
        found[letter] = value
    return found


def clashing(relations, symmetric=frozenset(), also=()):
    """Of relations without a model, some of which each is needed to have none."""
    needed = list(relations)
    for relation in relations:
        others = tuple(r for r in needed if r is not relation)
        if one_model(others, symmetric, also) is None:
            needed.remove(relation)
    return needed


def impossible(
    relations: Iterable[Relation],
    symmetric: Symbols = (),
    also: Iterable[Formula] = (),
    witness: Values | None = None,
) -> list[str]:
    """A complaint if no model was found, which names the relations that clash.

    A model of a page is one of its chains, too, and is not sought again.
    """
    relations, also = tuple(relations), tuple(also)
    known = frozenset(symmetric)
    sides = [plain(e) for e in (*(e for r in relations for e in r), *also)]
    occur = set().union(*map(letters, sides))  # before the end of a scope, not all
    values = values_of(witness or {}, known)
    given = tuple((x, value) for x, value in values.items() if x in occur)
    asked = frozenset(relations), known, frozenset(also)
    if not given and any(all(map(frozenset.issubset, asked, had)) for had in KNOWN):
        return []
    try:
        if one_model(relations, known, also, given) is not None:
            KNOWN.append(asked)
            return []
    except NotLinear as e:
        return [f"{e} is not linear in what may be random: {MEND}"]
    if given:
        return [SAID.format("all that the page says holds") + ", with this witness"]
    said = " and ".join(r.show(text) for r in clashing(relations, known, also))
    what = f"{said} hold" if said else "all that is inverted has an inverse"
    return [f"{SAID.format(what)}: {MEND}"]
