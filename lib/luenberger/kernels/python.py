"""Lines of Python, in the part of it that numba compiles."""

from .program import Size
from .writer import View, Writer


class Python(Writer):
    """Python, in the part of it that numba compiles."""

    comment, stop, has_blas, turns = "#", "", True, True

    def let(self, name: str, text: str) -> None:
        self.line(f"{name} = {text}")

    index = let

    def loop(self, index: str, start: Size, stop: Size) -> None:
        span = f"{stop}" if start == 0 else f"{start}, {stop}"
        self.line(f"for {index} in range({span}):")
        self.depth += 1

    def end(self) -> None:
        self.depth -= 1

    def need(self, text: str) -> None:
        self.line(f"if not {text}:")
        self.line("    ok = False")

    def multiply(self, target: str, left: View, right: View) -> None:
        (a, *shape, turned), (b, *other, other_turned) = left, right
        made = shape[turned], other[not other_turned]
        a, b = f"{a}.reshape({tuple(shape)})", f"{b}.reshape({tuple(other)})"
        a, b = a + ".T" * turned, b + ".T" * other_turned
        self.line(f"np.dot({a}, {b}, {target}.reshape({made}))")


class Banded(Python):
    """The same, with sums of products in bands: more to compile, and faster."""

    bands = True
