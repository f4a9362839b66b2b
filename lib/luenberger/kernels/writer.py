"""Lines of code in a language with loops: what `loops` asks of Python and of C."""


class Writer:
    """Lines of code in a language with loops; indented by four."""

    has_blas = False  # with `multiply`, the product of two views into an array
    turns = False  # a transpose on the right is copied, so that loops run along rows

    def __init__(self, depth=1):
        self.lines, self.depth = [], depth

    def line(self, text):
        self.lines.append("    " * self.depth + text)

    def let(self, name, text):
        """A scalar that changes."""
        raise NotImplementedError

    def loop(self, index, start, stop):
        raise NotImplementedError

    def end(self):
        """End of a loop or a condition."""
        raise NotImplementedError

    def need(self, text):
        """Note a failure unless the condition holds."""
        raise NotImplementedError

    def set(self, target, text, sign="="):
        self.line(f"{target} {sign} {text}" + self.stop)

    def fill(self, target, text, length):
        """target = text for each i, which stands in them."""
        self.loop("i", 0, length)
        self.set(target, text)
        self.end()
