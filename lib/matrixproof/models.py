"""Explicit rational matrices that satisfy relations, and claims refuted by them.

A set of relations that no matrices satisfy proves anything, so every set in use is
given a model.  A claim that is false has a model of the relations in which its sides
differ, and such a model says more than a residual does.

The search takes sizes from 1 to 3 and one symbol after the other.  Every relation is
solved, exactly, as soon as it is linear in what is left; what remains free is drawn
at random, always in the same way.  A relation that is never linear is searched.

Source: our own.
"""

from collections.abc import Iterable, Mapping
from typing import Any

import sympy as sp

from .attempts import Model, models, paired
from .contents import parts
from .exact import World, as_matrix, as_table, constant, rational
from .relations import Given, named
from .settings import FIRST, Setting
from .systems import System, Unsolvable
from .words import Formula, Symbols, Values, plain

PATIENT, QUICK = 150, 90  # attempts to find a model, and to refute


class NoModel(ValueError):
    """No matrices were found that satisfy the relations, so nothing can be tried."""


def model(
    relations: Given, symmetric: Symbols = (), also: Iterable[Formula] = ()
) -> Values | None:
    """Explicit rational matrices that satisfy relations exactly.

    Parameters
    ----------
    relations : iterable of Relation or (left, right)
        Equations between matrix expressions, or between scalars.
    symmetric : iterable of MatrixSymbol
        Symbols equal to their transpose; positive definite where nothing else is asked.
    also : iterable of expression
        Their symbols get a value, too, and what they invert is invertible.

    Returns
    -------
    dict of symbol to ImmutableMatrix, or None
        A value for every matrix symbol, and a number for every scalar that is not a
        size.  What is inverted is invertible.  None says that none was found with
        sizes from 1 to 3 (to k + 1 where a k-th power occurs): the relations may
        contradict each other, and then they prove anything.

    Notes
    -----
    Of several models the one with the fewest symbols that are zero is taken.
    The search is deterministic.

    Examples
    --------
    >>> from sympy import symbols
    >>> from matrixproof import Identity, MatrixSymbol
    >>> n, p = symbols("n p", integer=True, positive=True)
    >>> A, B = MatrixSymbol("A", p, n), MatrixSymbol("B", n, p)
    >>> found = model([(A * B, Identity(p))])
    >>> found[A] * found[B] == Identity(found[A].rows).as_explicit()
    True
    >>> T = MatrixSymbol("T", n, n)
    >>> model([(T * T, T), (T * T, 2 * T), (T, Identity(n))]) is None
    True
    """
    found = instance(relations, symmetric, also)
    return None if found is None else found.matrices()


def instance(relations, symmetric=(), also=()):
    """The same as a `Model`, which knows its sizes as well."""
    setting = Setting(named(relations), symmetric, also)
    best = None
    for found in models(setting, setting.generic_sizes(), PATIENT):
        if best is None or found.zeros < best.zeros:
            best = found
        if best.zeros <= setting.stated_zeros:
            break
    return best


def possible(relations, symmetric=(), sides=()):
    """Whether matrices were found that satisfy the relations, with every inverse."""
    relations = named(relations)
    sides = [plain(side) for side in sides]
    if not relations and not any(parts(s).inverted or parts(s).partial for s in sides):
        return True
    setting = Setting(relations, symmetric, sides)
    plainest = any(of_ones(setting, sizes) for sizes in setting.small_sizes()[:FIRST])
    return plainest or instance(relations, symmetric, sides) is not None


def of_ones(setting, sizes):
    """Whether identities, ones and their like satisfy everything."""
    world = World(sizes, {}, full=setting.full)
    for s, shape in setting.unknowns.items():
        if shape is None:
            world.of[s] = constant(1)
        elif not isinstance(s, tuple):
            rows, cols = map(world.size, shape)
            world.of[s] = [
                [constant(int(i == j)) for j in range(cols)] for i in range(rows)
            ]
    try:
        Model(setting, world)
    except (Unsolvable, ArithmeticError):
        return False
    return True


def refute(
    left: Formula, right: Formula, given: Given = (), symmetric: Symbols = ()
) -> Values | None:
    """Matrices that satisfy the relations, but not `left = right`.

    Parameters
    ----------
    left, right : expression
        Both sides; a right side of 0 fits every left side.
    given : iterable of Relation or (left, right)
    symmetric : iterable of MatrixSymbol

    Returns
    -------
    dict of symbol to ImmutableMatrix, or None
        The counterexample, of small sizes.  None if the sides agree on every model
        that was tried, which is no proof.

    Raises
    ------
    NoModel
        No model of the relations was found: they may contradict each other.

    Examples
    --------
    A right inverse is not a left inverse, unless the matrices are square.

    >>> from sympy import symbols
    >>> from matrixproof import Identity, MatrixSymbol
    >>> n, p = symbols("n p", integer=True, positive=True)
    >>> A, B = MatrixSymbol("A", p, n), MatrixSymbol("B", n, p)
    >>> found = refute(B * A, Identity(n), given=[(A * B, Identity(p))])
    >>> found[B] * found[A] == Identity(found[A].cols).as_explicit()
    False
    """
    found = denial(left, right, given, symmetric)
    return None if found is None else found.matrices()


def denial(left, right, given, symmetric=()):
    """The same as a `Model`."""
    setting = Setting(named(given), symmetric, (left, right))
    tried = False
    for found in models(setting, setting.small_sizes(), QUICK):
        tried = True
        if not found.agree(left, right):
            return found
    if not tried:
        raise NoModel(
            "no small rational matrices were found that satisfy the relations "
            f"{', '.join(r.name for r in setting.relations) or '(none)'}: they may "
            "contradict each other, or what is inverted may be singular"
        )
    return None


def evaluate(expr: Formula, values: Mapping[Any, Any]) -> Any:
    """The exact value of an expression at explicit matrices.

    Parameters
    ----------
    expr : expression
        A matrix expression or a scalar one.
    values : dict of symbol to explicit matrix
        With a number for every scalar; the sizes follow from the shapes.

    Returns
    -------
    ImmutableMatrix or Rational

    Raises
    ------
    ZeroDivisionError
        Something that is inverted is singular.

    Examples
    --------
    >>> from sympy import Matrix, symbols
    >>> from matrixproof import Identity, MatrixSymbol
    >>> n = symbols("n", integer=True, positive=True)
    >>> A = MatrixSymbol("A", n, n)
    >>> evaluate((A + Identity(n)).I, {A: Matrix([[1, 1], [0, 1]])})
    Matrix([
    [1/2, -1/4],
    [  0,  1/2]])
    """
    world = world_of(values)
    value = world.value(expr)
    if isinstance(value, dict):
        return sp.Rational(value.get((), 0))
    return as_matrix(value, world.shape(expr))


def differ(left, right, values):
    """Whether two expressions have different values; a right side of 0 fits any left.

    >>> from sympy import Matrix, symbols
    >>> from matrixproof import MatrixSymbol
    >>> n = symbols("n", integer=True, positive=True)
    >>> A = MatrixSymbol("A", n, n)
    >>> differ(A, A.T, {A: Matrix([[0, 1], [0, 0]])})
    True
    """
    world = world_of(values)
    return any(x != y for x, y in paired(world.value(left), world.value(right)))


def world_of(values):
    """Explicit matrices as a `World`; the sizes are solved from their shapes."""
    values = {
        s: x if isinstance(s, sp.Symbol) else sp.ImmutableMatrix(x)
        for s, x in values.items()
    }
    of = {
        s: constant(rational(x)) if isinstance(s, sp.Symbol) else as_table(x)
        for s, x in values.items()
    }
    return World(sizes_of(values)[0], of)


def sizes_of(values):
    """The sizes that the shapes of values give, and those that they leave open.

    What is left open is small.

    >>> n, m = sp.symbols("n m", integer=True, positive=True)
    >>> sizes_of({sp.MatrixSymbol("A", n - m, 1): sp.ones(2, 1)})
    ({m: 1, n: 3}, [m, n])
    """
    system, names = System(), set()
    try:
        for symbol in filter(lambda s: hasattr(s, "shape"), values):
            for size, number in zip(symbol.shape, values[symbol].shape):
                if (gap := sp.sympify(size - number)) != 0:
                    system.require(linear(gap))
                    names |= gap.free_symbols
        return fitting(system, sorted(names, key=str))
    except Unsolvable as e:
        why = str(e) or "the shapes of these matrices do not fit"
        raise ValueError(why) from None


def fitting(system, names):
    """{size: its value} of positive sizes that solve a system, and the open ones."""
    free = [s for s in names if s not in system.solved]
    for value in range(1, 10):
        tried = system.copy()
        for s in free:
            tried.fix(s, value)
        sizes = {s: tried.solved[s].get((), 0) for s in names}
        if all(size >= (1 if free else 0) for size in sizes.values()):
            if part := [s for s, size in sizes.items() if size != int(size)]:
                raise Unsolvable(f"{part[0]} = {sizes[part[0]]} is no size")
            return sizes, [s for s in names if set(system.reduced({(s,): 1})) - {()}]
    raise Unsolvable


def linear(expr):
    """A SymPy expression, linear in its symbols, as a polynomial of `systems`."""
    found = sp.expand(expr).as_coefficients_dict()
    return {
        () if symbol == 1 else (symbol,): rational(c) for symbol, c in found.items()
    }
