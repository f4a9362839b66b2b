"""A derivation as it is read: in a terminal, in a notebook."""

from textwrap import fill
from typing import Any

from .chains import framed
from .prose import markdown, plain
from .relations import Relation
from .typeset import latex, padded, text, width


def used_letters(derivation):
    """{symbol: meaning} of what stands on a page, in the order of the notation."""
    from .derivation import symbols

    here = symbols(derivation)
    named = {
        s.name: s for s in sorted(here, key=lambda s: str(getattr(s, "shape", "")))
    }  # of a letter's sizes, one
    meaning = derivation.letters.meaning.items()
    return {
        (s if s in here else named[s.name]): says
        for s, says in meaning
        if s.name in named
    }


def numbered(relation: Any) -> str:
    """The equation number of a relation, without brackets; or ""."""
    from .reasons import numbered

    return numbered(relation)[0].removeprefix("(").removesuffix(")")


def as_text(derivation):
    """A page for a terminal."""
    parts = [derivation.source]
    rows = [(text(s), plain(says)) for s, says in used_letters(derivation).items()]
    wide = max((width(s) for s in used_letters(derivation)), default=0)
    parts.append("\n".join(f"  {padded(s, wide)}  {says}" for s, says in rows))
    for item in derivation.page:
        if isinstance(item, str):
            parts.append(fill(" ".join(plain(item).split()), 88))
        elif isinstance(item, Relation):
            parts.append(f"  {item.stated(text)}  {shown_number(item)}".rstrip())
        else:
            parts.append(str(item))
    return "\n\n".join(filter(None, parts))


def size(symbol, letters, show):
    """Rows and columns of a symbol."""
    if not hasattr(symbol, "shape"):
        return r"\text{number}" if show is latex else "number"
    times = r" \times " if show is latex else " × "
    return times.join(show(letters.sizes.get(k, k)) for k in symbol.shape)


def shown_number(relation):
    number = numbered(relation)
    return f"({number})" if number else ""


def as_markdown(derivation):
    """A page for a notebook."""
    from .derivation import End

    rows = [
        f"- ${latex(s)}$, ${size(s, derivation.letters, latex)}$: {markdown(says)}"
        for s, says in used_letters(derivation).items()
    ]
    parts = ["\n".join(rows)]
    for item in derivation.page:
        if isinstance(item, str):
            parts.append(markdown(" ".join(item.split())))
        elif isinstance(item, End):
            parts.append(item.stated(latex))
        elif isinstance(item, Relation):
            parts.append(framed([item.stated(latex)], numbered(item)))
        else:
            parts.append(item._repr_latex_())
    return "\n\n".join(filter(None, parts))
