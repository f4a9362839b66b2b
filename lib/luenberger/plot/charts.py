"""Charts of decisions: one question below another, with advice beside each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.patches import Ellipse, FancyArrowPatch, Rectangle

Point = tuple[float, float]
ROW = 0.75  # from one question to the next, in inches
QUESTION, ADVICE = 2.15, 1.75  # widths of boxes
BESIDE = 2.65  # where advice begins
BADGE = 0.26  # width of the circle with the number of a box
LINE, MARGIN = 0.18, 0.18  # heights of a line of text, and of what is around it
LETTERS = 11  # points
LONGEST = {QUESTION: 24, ADVICE: 18}  # letters of a line that a box has room for
OTHER = {"yes": "no", "no": "yes"}


def decision_chart(
    questions: Sequence[tuple[str, str, str]], last: str, ax: Axes | None = None
) -> Axes:
    r"""Questions from top to bottom; one answer leads to advice, one further down.

    Each box of advice has a number, from 1, so that a text below the figure can name
    it.  The chart is tall, and legible on a telephone: a figure 4.8 inches wide, with
    0.75 for each question and for the last box, has letters of 11 points.

    Parameters
    ----------
    questions : list of (question, answer, advice)
        The answer, "yes" or "no", that leads to the advice.  The other one leads to
        the next question.
    last : str
        The advice after the last question.

    Raises
    ------
    ValueError
        If there is no question, an answer is not "yes" or "no", or a text has more
        than two lines, or more than 24 letters in a line (advice: 18).

    Examples
    --------
    >>> import luenberger as lb
    >>> ax = lb.plot.decision_chart(
    ...     [("Are Q and R known?", "no", "choose the poles")], "Kalman filter"
    ... )
    >>> [text.get_text() for text in ax.texts]
    ['Are Q and R known?', 'choose the poles', '1', 'no', 'yes', 'Kalman filter', '2']
    """
    if not questions:
        raise ValueError("a chart has at least one question")
    ax = ax or plt.gca()
    for k, (question, answer, advice) in enumerate(questions):
        if answer not in OTHER:
            raise ValueError(f"{answer!r} after {question!r} must be 'yes' or 'no'")
        y, following = -k * ROW, questions[k + 1][0] if k + 1 < len(questions) else last
        _box(ax, (0, y), QUESTION, question, "white")
        _advice(ax, (BESIDE, y), k + 1, advice)
        _way(ax, (QUESTION, y), (BESIDE - BADGE / 2, y), answer)
        ends = y - _high(question) / 2, y - ROW + _high(following) / 2
        _way(ax, (QUESTION / 2, ends[0]), (QUESTION / 2, ends[1]), OTHER[answer])
    _advice(ax, (0, -len(questions) * ROW), len(questions) + 1, last)
    ax.set(xlim=(-0.2, BESIDE + ADVICE + 0.1))
    ax.set(ylim=(-(len(questions) + 0.5) * ROW, ROW / 2))
    ax.set_aspect("equal")
    ax.axis("off")
    return ax


def _high(text: str) -> float:
    return LINE * (1 + text.count("\n")) + MARGIN


def _box(ax: Axes, left: Point, wide: float, text: str, fill: str) -> None:
    """A text in a box; `left` is the middle of the box's left edge."""
    lines, (x, y) = text.split("\n"), left
    if len(lines) > 2 or max(map(len, lines)) > LONGEST[wide]:
        raise ValueError(
            f"{text!r} must have at most two lines of {LONGEST[wide]} letters"
        )
    look: dict[str, Any] = dict(fc=fill, ec="black", zorder=2, label=text)
    ax.add_patch(Rectangle((x, y - _high(text) / 2), wide, _high(text), **look))
    where: dict[str, Any] = dict(ha="center", va="center", fontsize=LETTERS, zorder=3)
    ax.text(x + wide / 2, y, text, **where)


def _advice(ax: Axes, left: Point, k: int, text: str) -> None:
    """A shaded box with its number in a circle on the left edge."""
    _box(ax, left, ADVICE, text, "#cfe6f5")
    ax.add_patch(Ellipse(left, BADGE, BADGE, fc="black", zorder=4, label=f"{k}"))
    where: dict[str, Any] = dict(ha="center", va="center", color="white", zorder=5)
    ax.text(*left, f"{k}", fontsize="small", **where)


def _way(ax: Axes, start: Point, end: Point, answer: str) -> None:
    """An arrow with the answer that takes it: to the right, or down."""
    look: dict[str, Any] = dict(arrowstyle="-|>", mutation_scale=10, shrinkA=0)
    look |= dict(color="black", lw=1, shrinkB=0, zorder=1, label=answer)
    ax.add_patch(FancyArrowPatch(start, end, **look))
    x, y = (start[0] + end[0]) / 2, (start[1] + end[1]) / 2
    if start[0] == end[0]:
        ax.text(x + 0.08, y, answer, ha="left", va="center", fontsize=LETTERS)
    else:
        ax.text(x, y + 0.03, answer, ha="center", va="bottom", fontsize=LETTERS)
