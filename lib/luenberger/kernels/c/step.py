"""A stage list in the body of a C function, its constants written into the file.

Written so, a function allocates nothing and calls nothing.
"""

from collections.abc import Mapping
from dataclasses import replace

import sympy as sp

from matrixproof import Derivation

from ...numeric import Matrices
from ..pieces import Piece, Sum, pieces, read_by
from ..printing import C99
from ..text import symbols_in
from ..traced import traced
from .any_size import Loops
from .file import File
from .writer import C


def write_step(
    derivation: Derivation,
    sizes: Mapping[str, int],
    constants: Matrices,
    file: File,
    to: C,
    places: Mapping[str, str],
    results: Mapping[str, str],
    *,
    scalars: bool,
) -> None:
    """Write one pass through the stages that `results` need.

    Parameters
    ----------
    derivation : Derivation
        Proved.
    sizes : dict of str to int
    constants : dict of str to ndarray
        Given matrices that never change; what a matrix of zeros multiplies is left
        out, and in scalars so is what single zeros and ones multiply.
    file : File
        Takes the tables that loops read.
    to : C
    places : dict of str to str
        C names of the other given matrices, where they are not their own.
    results : dict of str to str
        C arrays that take the results, apart from what is given.
    scalars : bool
        One line for each entry, not loops.
    """
    if scalars:
        _scalars(derivation, sizes, constants, to, places, results)
    else:
        _loops(derivation, sizes, constants, file, to, places, results)


def _scalars(
    derivation: Derivation,
    sizes: Mapping[str, int],
    constants: Matrices,
    to: C,
    places: Mapping[str, str],
    results: Mapping[str, str],
) -> None:
    known = {name: X.tolist() for name, X in constants.items()}
    found, printer = traced(derivation, list(results), sizes, known), C99()
    for symbol, (name, k) in found.given.items():
        to.constant(symbol.name, f"{places.get(name, name)}[{k}]")
    for symbol, e in found.statements:
        to.constant(symbol.name, printer.doprint(e))
    for name, array in results.items():
        flat = [e for row in found.entries[name] for e in row]
        for k, e in enumerate(flat):
            to.set(f"{array}[{k}]", str(e))


def _loops(
    derivation: Derivation,
    sizes: Mapping[str, int],
    constants: Matrices,
    file: File,
    to: C,
    places: Mapping[str, str],
    results: Mapping[str, str],
) -> None:
    zero = {name for name, X in constants.items() if not X.any()}
    turned = {name: f"{name}_T" for name in constants}
    found = [_prepared(one, zero, turned) for one in pieces(derivation, list(results))]
    names = {name: f"{file.name}_{name}" for name in (*constants, *turned.values())}
    loops = Loops({**names, **places, **results}, sizes, file.real)
    found = [one for one in found if loops.length(one.target) != "0"]
    for name, length in loops.arrays(found).items():
        if name not in results.values():
            to.array(name, length)
    for line in loops.lines(found):
        to.line(line)
    read = {s.name for one in found for s in read_by(one)}
    for name, X in constants.items():
        tables = {name: X, turned[name]: X.T}
        file.tables.update((names[k], tables[k]) for k in tables if k in read)


def _prepared(piece: Piece, zero: set[str], turned: Mapping[str, str]) -> Piece:
    """A sum without the terms that vanish; what multiplies a vector is kept turned."""
    if not isinstance(piece, Sum):
        return piece
    terms = []
    for term in piece.terms:
        left, *right = term.factors
        if any(s.name in zero for f in term.factors for s in symbols_in(f)):
            continue
        if right and piece.target.shape[1] == 1 and getattr(left, "name", "") in turned:
            left = sp.MatrixSymbol(turned[left.name], *left.shape[::-1]).T
        terms.append(replace(term, factors=(left, *right)))
    return replace(piece, terms=tuple(terms))
