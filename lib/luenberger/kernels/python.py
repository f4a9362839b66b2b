"""Lines of Python, in the part of it that numba compiles."""

from .program import Size
from .writer import Writer


class Python(Writer):
    """Python, in the part of it that numba compiles."""

    comment, stop, turns = "#", "", True

    def let(self, name: str, text: str) -> None:
        self.line(f"{name} = {text}")

    index = let

    def loop(self, index: str, start: Size, stop: Size) -> None:
        span = f"{stop}" if start == 0 else f"{start}, {stop}"
        self.line(f"for {index} in range({span}):")
        self.depth += 1

    def end(self) -> None:
        self.depth -= 1

    def check(self, condition: str) -> None:
        self.line(f"if {condition}:")
        self.depth += 1

    def inverse(self, pivot: str) -> str:
        return f"1.0 / {pivot} if {pivot} > 0.0 else 0.0"

    def need(self, text: str) -> None:
        self.line(f"if not {text}:")
        self.line("    ok = False")


class Tiled(Python):
    """The same, with sums of products as calls of `products`."""

    tiles = True
