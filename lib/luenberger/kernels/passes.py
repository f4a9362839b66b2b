"""One pass through a program in loops: its arrays, its steps, and where results go."""

from collections.abc import Mapping

from .loops import Places, arrays, write, write_definite
from .program import Program, Size, Sizes
from .writer import Writer

Results = Mapping[str, tuple[str, Size]]


def write_pass(
    program: Program,
    sizes: Sizes,
    writer: Writer,
    places: Places | None,
    results: Results,
) -> None:
    """Write one pass: its arrays, the steps and tests, and copies of the results.

    Parameters
    ----------
    program : Program
    sizes : dict of str to int or str
        A size that is not known yet is the text that stands for it.
    writer : Writer
    places : dict of str to str
        What matrices are called, where not by their own name.
    results : dict of str to (str, length)
        Arrays that take the results, and their lengths.
    """
    for name, length in arrays(program, sizes, writer).items():
        writer.array(places.get(name, name), length)
    write(program, sizes, writer, places=places)
    write_definite(program, sizes, writer, places)
    for name, (place, length) in results.items():
        operand = program.results[name]
        if operand is None:
            writer.fill(f"{place}[i]", "0.0", length)
            continue
        source = places.get(operand.name, operand.name)
        rows, cols = program.shape(operand.name, sizes)
        if not operand.turned or 1 in (rows, cols):
            writer.fill(f"{place}[i]", f"{source}[i]", length)
            continue
        writer.loop("i", 0, cols)
        writer.loop("j", 0, rows)
        writer.set(f"{place}[i * {rows} + j]", f"{source}[j * {cols} + i]")
        writer.end()
        writer.end()
