"""Chains that students hand in, marked line by line."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from matrixproof import Chain, Line, text
from matrixproof.words import ShapeError

from .given import described, require


@dataclass(frozen=True, repr=False)
class Marks:
    """What became of the lines of a chain.

    Attributes
    ----------
    right, wrong : int
        Lines that count: those that cite something or do something, and wrong ones.
        A line that only multiplies out is free.
    steps : int
        The lines of the model's chain that count.
    arrives : bool
        Whether it ends where it should.
    says : tuple of str
        What is wrong, in the order of the lines; the first one first.
    """

    right: int
    wrong: int
    steps: int
    arrives: bool
    says: tuple[str, ...] = ()

    def points(self, most: float) -> float:
        """Half points, `most` for a chain without a fault.

        >>> Marks(right=2, wrong=1, steps=3, arrives=False).points(3)
        2.0
        """
        if self.arrives and not self.wrong:
            return float(most)
        missing = 0 if self.wrong else 1  # it stops too early
        lines = max(self.steps, self.right + self.wrong + missing)
        return int(2 * most * self.right / lines) / 2

    def __str__(self) -> str:
        return "\n".join(self.says) or "every line follows from what it cites"


def mark_lines(
    answer: Any, left: Any, *, goal: Any = None, steps: int = 1,
    known: Sequence[Any] = (), free: Sequence[Any] = (),
    lessons: Mapping[str, Any] | None = None, symmetric: Iterable[Any] = (),
) -> Marks:  # fmt: skip
    """Mark a chain that a student has written, line by line.

    A line is right if it follows from the line before, right or wrong, by exactly what
    it cites.  So a slip costs one line.  A line that undoes a slip is right as well.

    Parameters
    ----------
    answer : list of Line, or Chain
    left : expression
        What the chain begins with.
    goal : expression, optional
        Where it should end.
    steps : int
        How many lines of the model's chain count; see `Marks`.
    known : sequence of Relation
        Definitions of the task: one that is missing beside a line is named.
    free : sequence of Relation
        What may be cited where it is not needed, such as all moments that are zero.
    lessons : dict of str to expression, optional
        What to say if a line is wrong and ends in this expression.
    symmetric : iterable of MatrixSymbol

    Returns
    -------
    Marks

    Raises
    ------
    AssertionError
        If it is no list of lines.
    """
    symmetric, lessons = tuple(symmetric), lessons or {}
    pardoned = {f"does not need {relation.show(text)}" for relation in free}
    lines, says = _lines(answer), []
    right = wrong = 0
    before, sound = left, True
    for k, line in enumerate(lines, 1):
        faults = [f for f in line.complaints(before, symmetric) if f not in pardoned]
        if faults and not sound:
            truths = [left] if goal is None else [left, goal]
            faults = [] if _equal(line.right, truths, known, symmetric) else faults
        if faults:
            says += [f"line {k} {fault}" for fault in faults]
            says += _reason(k, line, before, known, symmetric)
            says += [s for s, x in lessons.items() if _equal(line.right, [x])]
        wrong += bool(faults)
        right += not faults and (bool(line.cites) or type(line) is not Line)
        before, sound = line.right, sound and not faults
    arrives = goal is None or _equal(before, [goal], (), symmetric)
    if not arrives and not wrong:
        says.append(f"the chain ends with {text(before)}, and should go on")
    return Marks(right, wrong, steps, arrives, tuple(says))


def _lines(answer: Any) -> list[Line]:
    """A chain, or lines in anything that holds them."""
    if isinstance(answer, Chain | Line):
        answer = answer.lines if isinstance(answer, Chain) else [answer]
    wrong = f"expected a list of lines, [Line(...), ...], got {described(answer)}"
    require(isinstance(answer, Sequence) and not isinstance(answer, str), wrong)
    for k, line in enumerate(answer, 1):
        wrong = f"line {k}: expected Line(..., by=(...)), got {described(line)}"
        require(isinstance(line, Line), wrong)
    require(len(answer) > 0, "the chain has no lines")
    return list(answer)


def _reason(k, line, before, known, symmetric):
    """The one definition that a line lacks."""
    if type(line) is Line and not line.follows(before, line.by, symmetric):
        for relation in known:
            if line.follows(before, (*line.by, relation), symmetric):
                return [f"line {k} follows if it cites {relation.show(text)} too"]
    return []


def _equal(right, truths, known=(), symmetric=()):
    """Whether an expression is equal to one of others."""
    for truth in truths:
        try:
            if Line(right).follows(truth, tuple(known), tuple(symmetric)):
                return True
        except ShapeError:
            continue
    return False
