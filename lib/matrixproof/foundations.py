"""What theorems rest on: hypotheses, inverses, symmetry, and lines that were typed."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import sympy as sp

from .contents import parts
from .dependence import declared
from .relations import Relation, Result
from .symbols import Symmetric
from .typeset import Show, latex, text
from .words import plain

TYPED = "inserted"  # how a derivation says that a line was not found but typed


@dataclass(frozen=True, repr=False)
class Foundation:
    """What a theorem or a page rests on, through all the chains that it cites.

    Attributes
    ----------
    relations : tuple of Relation
        Definitions, hypotheses and moments: what no chain proves.
    invertible : tuple of expression
        What is inverted in a formula, or was to find a solution.
    symmetric : tuple of MatrixSymbol
        Letters that must equal their transposes.
    held : tuple of symbol
        Letters that are constant although a relation ties them to what moves.
    inserted : tuple of (str, Line)
        Lines of derivations that were typed and not found, with the chain's title.
    """

    relations: tuple = ()
    invertible: tuple = ()
    symmetric: tuple = ()
    held: tuple = ()
    inserted: tuple = ()

    def said(self, show: Show) -> list[str]:
        """Each thing, set by `latex` or `text`."""
        found = [r.stated(show) for r in self.relations]
        for letters, word in (
            (self.invertible, "can be inverted"),
            (self.symmetric, "is symmetric"),
            (self.held, "is held constant"),
        ):
            said = rf"\text{{ {word}}}" if show is latex else f" {word}"
            found += [show(x) + said for x in letters]
        word = r"\text{Inserted }" if show is latex else "Inserted "
        return found + [f"{word}{x.sign} {x.body(show)}" for _, x in self.inserted]

    def __str__(self):
        return "\n".join(self.said(text)) or "nothing"

    __repr__ = __str__

    def _repr_markdown_(self):
        return "\n".join(f"- ${x}$" for x in self.said(latex)) or "nothing"


def chains_behind(chains: Iterable[Any]) -> Iterator[Any]:
    """Chains, and those whose results they cite, each once."""
    waiting, seen = list(chains), set()
    while waiting:
        chain = waiting.pop(0)
        if id(chain) not in seen:
            seen.add(id(chain))
            yield chain
            waiting += [r.chain for r in chain.relations if isinstance(r, Result)]


def foundation(chains: Iterable[Any], cited: Iterable[Relation] = ()) -> Foundation:
    """What chains rest on, and stages that cite these relations."""
    chains, cited = list(chains), list(cited)
    every = list(
        chains_behind([*chains, *(r.chain for r in cited if isinstance(r, Result))])
    )
    relations = [r for r in cited if not isinstance(r, Result)]
    relations += [r for c in every for r in c.relations if not isinstance(r, Result)]
    expressions = [e for chain in every for e in chain.expressions]
    expressions += [e for r in relations for e in r.expressions]
    inverted = [x for e in expressions for x in parts(plain(e)).inverted]
    inverted += [x for r in relations for x in getattr(r, "invertible", ())]
    inverted += [x for e in expressions for x in divisors(plain(e))]
    symmetric = [x for chain in chains for x in needed(chain)]
    lines = [(chain.title, line) for chain in every for line in chain.lines]
    held = [x for _, line in lines for x in getattr(line, "held", ())]
    inserted = [(title, x) for title, x in lines if TYPED in x.why]
    found = relations, inverted, symmetric, held, inserted
    return Foundation(*(tuple(dict.fromkeys(x)) for x in found))


def divisors(expr):
    """What numbers are divided by, where that may be zero."""
    powers = [x for x in expr.atoms(sp.Pow) if x.exp.is_negative]
    return sorted({x.base for x in powers if x.base.is_zero is not False}, key=str)


def needed(chain):
    """The letters that a chain takes to be symmetric, and does not hold without."""
    spare: tuple = ()
    for x in chain.supposes:
        if chain.holds_without(*spare, x):
            spare += (x,)
    kinds = [x for x in declared((), chain.expressions) if isinstance(x, Symmetric)]
    return [*(x for x in chain.supposes if x not in spare), *kinds]
