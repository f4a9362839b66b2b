"""Names and comments from outside that have a place in C source, and their dangers.

A module is named by its user, and signals by whoever wrote the plant's file.  A name
may be a word of C, and a comment may end early; both are refused or made harmless.
"""

import re
from collections.abc import Sequence

LONGEST = 24  # C99 tells external names apart by 31 characters, and _state is added
KEYWORDS = frozenset(
    "auto break case char const continue default do double else enum extern float for "
    "goto if inline int long register restrict return short signed sizeof static "
    "struct switch typedef union unsigned void volatile while main "
    # of C++, where the header may be included
    "alignas alignof and asm bool catch class compl concept consteval constexpr "
    "decltype delete dynamic_cast explicit export false friend mutable namespace new "
    "noexcept not nullptr operator or private protected public requires static_assert "
    "template this throw thread_local true try typeid typename using virtual wchar_t "
    "xor".split()
)
HEADERS = frozenset(
    "assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp "
    "signal stdarg stdbool stddef stdint stdio stdlib string tgmath time wchar "
    "wctype".split()
)


def identifier(name: object) -> None:
    """Raise ValueError unless `name` can begin the names of a C module."""
    if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name):
        raise ValueError(
            f"name must be a C identifier, a letter and then letters, digits or "
            f"underscores, got {name!r}"
        )
    for taken, what in (
        (name in HEADERS, "the name of a standard header"),
        (name in KEYWORDS, "a word of C"),
        ("__" in name, "reserved in C"),
    ):
        if taken:
            raise ValueError(f"name {name!r} is {what}; take another, e.g. 'my_{name}'")
    if len(name) > LONGEST:
        raise ValueError(
            f"name {name!r} has {len(name)} characters; compilers need tell apart no "
            f"more than 31, of which _state takes 6: take at most {LONGEST}"
        )


def quoted(text: str) -> str:
    """Any text as one quoted line of printable ASCII."""
    text = text.encode("unicode_escape").decode("ascii")
    return '"' + text.replace('"', "'") + '"'


def comment(lines: Sequence[str]) -> list[str]:
    """Lines of ASCII as one C comment, without marks and trigraphs inside."""
    found = []
    for k, line in enumerate(lines):
        for pair in ("*/", "/*", "//", "??"):
            while pair in line:
                line = line.replace(pair, f"{pair[0]} {pair[1]}")
        found.append(f"{' *' if k else '/*'} {line}".rstrip())
    return [*found, " */"]
