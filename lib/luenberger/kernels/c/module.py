"""A lowered program in the body of a C function, its constants written into it.

Written so, a function allocates nothing and calls nothing.  It gives up, returning 1,
as soon as a pivot shows that a matrix is not definite; compile it without -ffast-math,
which would let the tests of pivots be dropped.
"""

from dataclasses import dataclass, replace

from ...numeric import Matrices
from .. import cost
from ..loops import Places
from ..passes import Results, write_pass
from ..program import Cost, Factor, Program, Sizes
from ..scalars import Inverse, Let, Straight
from . import rows
from .file import File
from .panels import Panels
from .tables import PaddedRows
from .writer import C

FLOAT_TOL = 1e-6  # a pivot relative to its diagonal: float has 1.2e-7


@dataclass
class Module(File):
    """A file whose functions are programs."""

    def __post_init__(self) -> None:
        self.panels = Panels(PaddedRows(self.name, self.real))

    def steps(
        self,
        program: Program,
        sizes: Sizes,
        to: C,
        constants: Matrices,
        places: Places,
        results: Results,
    ) -> Cost:
        """Write one pass of `program`; return its `Cost`.

        Parameters
        ----------
        program : Program
        sizes : dict of str to int
        to : C
        constants : dict of str to ndarray
            Given matrices that never change; zeros and ones in them cost nothing
            where the pass is short enough to be written as scalars.
        places : dict of str to str
            C names of the other given matrices, where they are not their own.
        results : dict of str to (str, int)
            C arrays that take the results, and their lengths.
        """
        if self.real == "float":
            steps = (
                replace(one, tol=FLOAT_TOL) if isinstance(one, Factor) else one
                for one in program.steps
            )
            program = replace(program, steps=tuple(steps))
        constants = {k: X for k, X in constants.items() if k in program.given}
        known = {k: X.tolist() for k, X in constants.items()}
        straight = cost.straight(program, sizes, known)
        if straight is not None:
            _scalars(straight, program, sizes, to, places, results)
            return straight.cost
        if rows.fits(program, sizes):
            padded = self.panels.rows
            padded.given.update(constants)
            before = padded.constants()
            found = rows.write(
                program, sizes, to, self.panels, constants, places, results
            )
            return found + Cost(constants=padded.constants() - before)
        own = {k: f"{self.name}_{k}" for k in constants}
        new = {k: X for k, X in constants.items() if own[k] not in self.tables}
        self.tables.update((own[k], X) for k, X in new.items())
        write_pass(program, sizes, to, {**own, **places}, results)
        return cost.loops(program, sizes, {k: known[k] for k in new})

    def table_lines(self) -> list[str]:
        """The tables as C declarations, and the functions that loops share."""
        lines = super().table_lines()
        return [*lines, *self.panels.rows.lines(), "", *self.panels.lines()]


def _scalars(
    straight: Straight,
    program: Program,
    sizes: Sizes,
    to: C,
    places: Places,
    results: Results,
) -> None:
    for name, entries in straight.given.items():
        _, cols = program.shape(name, sizes)
        for i, j, entry in entries:
            if entry in straight.used:
                to.constant(entry, f"{places.get(name, name)}[{i * cols + j}]")
    for one in straight.statements:
        if isinstance(one, Inverse):
            to.constant(one.name, to.inverse(one.pivot))
        elif isinstance(one, Let):
            to.constant(one.name, one.text)
        else:
            known = " && ".join(f"!({name} != 0.0)" for name in one.unless)
            to.need(f"({one.text}) || ({known})" if known else one.text)
    for name, (place, length) in results.items():
        operand, flat = program.results[name], [0.0] * length
        if operand is not None:
            table = straight.entries[operand.name]
            table = zip(*table) if operand.turned else table
            flat = [entry for row in table for entry in row]
        for k, entry in enumerate(flat):
            to.set(f"{place}[{k}]", entry)
