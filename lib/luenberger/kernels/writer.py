"""Lines of code in a language with loops: what `loops` asks of Python and of C."""

from collections.abc import Callable

from .program import Factor, Size


class Writer:
    """Lines of code in a language with loops; indented by four."""

    comment = stop = ""  # what a comment begins with, and a statement ends with
    turns = False  # a transpose on the right is copied, so that loops run along rows
    tiles = False  # sums of products are calls, see `tiles`

    def __init__(self, depth: int = 1) -> None:
        self.lines: list[str] = []
        self.depth = depth

    def line(self, text: str) -> None:
        self.lines.append("    " * self.depth + text)

    def let(self, name: str, text: str) -> None:
        """A scalar that changes."""
        raise NotImplementedError

    def index(self, name: str, text: str) -> None:
        """A whole number that does not change."""
        raise NotImplementedError

    def array(self, name: str, length: Size) -> None:
        """Room for numbers."""
        raise NotImplementedError

    def loop(self, index: str, start: Size, stop: Size) -> None:
        raise NotImplementedError

    def end(self) -> None:
        """End of a loop or a condition."""
        raise NotImplementedError

    def check(self, condition: str) -> None:
        """What follows, up to `end`, only where a condition holds."""
        raise NotImplementedError

    def need(self, text: str) -> None:
        """Note a failure unless the condition holds."""
        raise NotImplementedError

    def inverse(self, pivot: str) -> str:
        """1 / pivot, or 0 where the pivot is zero."""
        raise NotImplementedError

    def set(self, target: str, text: str, sign: str = "=") -> None:
        self.line(f"{target} {sign} {text}" + self.stop)

    def fill(self, target: str, text: str, length: Size, sign: str = "=") -> None:
        """target = text for each i, which stands in them."""
        self.loop("i", 0, length)
        self.set(target, text, sign)
        self.end()


def bounds(
    to: Writer, step: Factor, size: Size, at: Callable[[str, str, str], str], place: str
) -> None:
    """What each pivot of a factor must be above; -1 for what is known exactly."""
    to.loop("i", 0, size)
    unit = at(step.matrix, "i", "i")
    unit = step.unit(unit, at(step.beside, "i", "i") if step.beside else "")
    to.set(f"{place}[i]", f"{step.tol!r} * {unit}" if step.tol else "0.0")
    if step.known:
        to.check(f"{unit} == 0.0")
        to.let("q", "0.0")
        to.loop("j", 0, size)
        to.check(f"{at(step.matrix, 'i', 'j')} != 0.0")
        to.set("q", "1.0")
        to.end()
        to.end()
        to.check("q == 0.0")
        to.set(f"{place}[i]", "-1.0")
        to.end()
        to.end()
    to.end()


def entry(name: str, *parts: tuple[int | str, int | str]) -> str:
    """An entry of an array: parts of the index, each a number of strides.

    A number of entries is ("j", 1) or (1, "j"); what is zero is left out.
    """
    texts = []
    for count, stride in parts:
        count, stride = str(count), str(stride)
        if "0" in (count, stride):
            continue
        if count == "1" or stride == "1":
            texts.append(stride if count == "1" else count)
        else:
            texts.append(f"{count} * {stride}")
    return f"{name}[{' + '.join(texts) or '0'}]"


def pointer(array: str, *parts: tuple[str, str]) -> str:
    """A pointer to an entry."""
    text = entry(array, *parts)
    index = text[len(array) + 1 : -1]
    return array if index == "0" else f"{array} + {index}"
