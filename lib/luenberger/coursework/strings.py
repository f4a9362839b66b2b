"""Mathematics that was written as text, and letters by their names."""

import re
from collections.abc import Mapping

import sympy as sp

from .given import described

PLAIN = str.maketrans(
    {"−": "-", "·": "*", "×": "*", "²": "**2", "³": "**3", "^": "**", "$": " "}
)
BRACKETS = str.maketrans("[]{}", "()()")
TOKEN = re.compile(r"(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+)|([^\W\d]\w*)|(\*\*|[-+*/(),])")
FUNCTIONS = ("sqrt", "log", "exp")
Letters = Mapping[str, sp.Symbol]


def parsed(string: str, known: Letters, wanted: str) -> sp.Expr:
    """What a string means, without signs for products too; of an equation, the right.

    Raises
    ------
    AssertionError
        If it cannot be read; `wanted` begins what is said then.
    """
    source = re.sub(r"_\{(\w+)\}", r"_\1", string.rpartition("=")[2])
    source = source.translate(PLAIN).translate(BRACKETS)
    values: dict[str, sp.Basic] = {}
    try:
        words = list(_words(source, known, values))
        return sp.sympify(" ".join(_multiplied(words)), locals=values, rational=True)
    except (sp.SympifyError, ValueError, TypeError, SyntaxError):
        raise AssertionError(f"{wanted}, got {described(string)}") from None


def _words(source, known, values):
    """Numbers, signs and names; a letter of the task has a name that cannot clash."""
    end = 0
    for token in TOKEN.finditer(source):
        if source[end : token.start()].strip():
            raise ValueError(source)
        end = token.end()
        if not token[2] or token[2] in FUNCTIONS:
            yield token[0]
            continue
        for letter in _letters(token[2], known):
            word = f"letter_{len(values)}"
            values[word] = letter
            yield word
    if source[end:].strip():
        raise ValueError(source)


def _letters(name, known):
    """The letter of a name, or the product of letters that it is."""
    if name == "pi":
        return [sp.pi]
    if letter := letter_of(name, known):
        return [letter]
    for k in range(len(name) - 1, 0, -1):
        if letter := letter_of(name[:k], known):
            return [letter, *_letters(name[k:], known)]
    raise ValueError(name)


def _multiplied(words):
    """A sign between neighbours that are multiplied."""
    before = ""
    for word in words:
        ends = before and (before[-1].isalnum() or before[-1] in ".)")
        begins = word[0].isalnum() or word[0] in ".("
        if ends and begins and before not in FUNCTIONS:
            yield "*"
        yield word
        before = word


def letter_of(name: str, known: Letters) -> sp.Symbol | None:
    """The letter of the task that is meant by a name, as it is or plainly written.

    >>> r_1, q, Q = sp.symbols("r_1 q Q")
    >>> known = {letter.name: letter for letter in (r_1, q, Q)}
    >>> [letter_of(name, known) for name in ("R1", "r_{1}", "Q", "x")]
    [r_1, r_1, Q, None]
    """
    for read in (str, _plain, lambda name: _plain(name).casefold()):
        found = [letter for own, letter in known.items() if read(own) == read(name)]
        if len(found) == 1:
            return found[0]
    return None


def _plain(name):
    return re.sub(r"[_{}\\]", "", name)
