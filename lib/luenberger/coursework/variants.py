"""Numbers of a task that differ from student to student."""

import hashlib
from collections.abc import Sequence
from typing import TypeVar

Number = TypeVar("Number")


def pick(student: str, of: str, among: Sequence[Number]) -> Number:
    """One of several values, always the same for a student.

    Parameters
    ----------
    student : str
        An identifier; case, spaces and signs do not count.
    of : str
        What is drawn, so that several draws of a student are independent.
    among : sequence

    Examples
    --------
    >>> pick("ab-12", "factor", [2, 3, 5]) == pick(" AB12", "factor", [2, 3, 5])
    True
    """
    drawn = hashlib.sha256(f"{identifier(student)}/{of}".encode()).digest()
    return among[int.from_bytes(drawn[:8], "big") % len(among)]


def identifier(student: object) -> str:
    """A student's identifier as it counts.

    >>> identifier(" Müller-12 ")
    'müller12'
    """
    return "".join(letter for letter in str(student).casefold() if letter.isalnum())
