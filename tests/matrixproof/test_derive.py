"""Operations find lines that are right: by the checker, and by explicit matrices."""

import random
from dataclasses import replace

import pytest
import sympy as sp
from sympy import Matrix, Rational, Trace

from luenberger.papers.haddad_bernstein.derivation import (
    augmented,
    cost,
    gradients,
    stationarity,
)
from luenberger.papers.haddad_bernstein.derivation.letters import both, plant
from luenberger.papers.hsia.derivation import laws
from luenberger.papers.kawazoe.derivation import form
from luenberger.papers.leondes_novak.derivation import (
    canonical_gain,
    huddle,
    quadratic,
    stochastic_system,
)
from luenberger.smoothing.derivation import next_state
from matrixproof import (
    BlockMatrix,
    Chain,
    Identity,
    Line,
    MatrixSymbol,
    Relation,
    ZeroMatrix,
    derive,
    letters,
    prove,
    refute,
)
from matrixproof.models import evaluate
from matrixproof.operators import Gradient
from matrixproof.proofs import Unproved
from matrixproof.relations import Moment

SEEDS = range(8)
SIZES = {"n": 2, "m": 3}
NAMES = "A:n*n B:n*m C:m*n D:m*m S:n*n= R:m*m="
A, B, C, D, S, R = LETTERS = letters(NAMES)
X, F, G, H, T = letters("X:n*m F:n*n G:n*m H:m*n T:n*n=")
dX, x, u, v, Z, dZ = letters("dX:n*m x:n u:m v:n Z:2n*2n dZ:2n*2n")
n, m = B.shape


# -- random expressions, and their values ---------------------------------------------


def matrix(rng, rows, cols):
    return Matrix(rows, cols, lambda i, j: Rational(rng.randint(-4, 4), 2))


def values(rng, *more):
    """Explicit matrices for the letters, symmetric ones for those that are."""
    found = {}
    for letter in (*LETTERS, *more):
        rows, cols = (int(sp.sympify(s).subs({n: 2, m: 3})) for s in letter.shape)
        drawn = matrix(rng, rows, cols)
        found[letter] = drawn + drawn.T if letter.T == letter else drawn
    return found


def drawn(rng, rows, cols, depth=2, leaves=LETTERS):
    """A random expression of a shape: sums, products, transposes, inverses, numbers."""
    fits = [e for e in leaves if e.shape == (rows, cols)]
    fits += [e.T for e in leaves if e.shape == (cols, rows)]
    fits += [e.I for e in (A, D) if e in leaves and e.shape == (rows, cols)]
    fits += [Identity(n)] * (rows == cols == n)
    if depth == 0:
        return rng.choice(fits)
    kind = rng.choice(["sum", "sum", "product", "product", "transpose", "number"])
    again = lambda a, b: drawn(rng, a, b, depth - 1, leaves)  # noqa: E731
    if kind == "sum":
        return again(rows, cols) + again(rows, cols)
    if kind == "product":
        inner = rng.choice([n, m])
        return again(rows, inner) * again(inner, cols)
    if kind == "transpose":
        return again(cols, rows).T
    return rng.choice([-1, 2, Rational(-1, 3)]) * again(rows, cols)


def agree(derivation, known):
    """Whether the line that was found has the value of the line before it."""
    before = [derivation.left, *(line.right for line in derivation.lines)]
    return evaluate(before[-2], known) == evaluate(before[-1], known)


def holds(derivation, known):
    """The checker finds nothing but wide lines, and both sides have one value."""
    assert [x for x in derivation.check() if "wide" not in x] == [], derivation
    assert agree(derivation, known), derivation


def attempted(operation, *args):
    """What an operation makes, or None where there is nothing to be done."""
    try:
        return operation(*args)
    except ValueError as e:
        assert "nothing changes" in str(e)


def seeded(seed, *more):
    rng = random.Random(seed)
    known = values(rng, *more)
    while known[A].det() == 0 or known[D].det() == 0:
        known |= {A: matrix(rng, 2, 2), D: matrix(rng, 3, 3)}
    return rng, known


# -- operations that leave a line what it is ------------------------------------------


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("operation", ["expand", "factor"])
@pytest.mark.parametrize("scalar", [False, True])
def test_a_line_is_written_otherwise(operation, scalar, seed):
    rng, known = seeded(seed)
    found = None
    while found is None:
        start = drawn(rng, n, n, 3)
        start = derive(Trace(start) if scalar else start)
        found = attempted(getattr(start, operation))
        if scalar and operation == "factor":
            return
    holds(found, known)


@pytest.mark.parametrize("seed", SEEDS)
def test_blocks_are_put_in_and_multiplied(seed):
    W, Z, K, L = letters("W:n+m*n+m Z:n+m*n K:n*n L:m*n")
    rng, known = seeded(seed)
    grid = [[drawn(rng, a, b, 1) for b in (n, m)] for a in (n, m)]
    column = [[drawn(rng, n, n, 1)], [drawn(rng, m, n, 1)]]
    meant = (W, BlockMatrix(grid)), (Z, BlockMatrix(column))
    start = rng.choice([Z.T * W * Z, Trace(W * Z * Z.T), W * Z + 2 * Z, W.T])
    found = derive(start).multiply(*(pair for pair in meant if start.has(pair[0])))
    assert len(found.lines) == 2
    for letter, right in meant:
        known[letter] = evaluate(right, known)
    holds(found, known)


def test_blocks_that_make_a_known_matrix_are_that():
    one, none = Identity(n), 0 * A
    turn = Z, BlockMatrix([[none, -one], [one, none]])
    found = derive(Z * Z.T - Z.T * Z).multiply(turn)
    assert found.right == ZeroMatrix(*Z.shape)
    assert derive(Z.T * Z).multiply(turn).right == Identity(Z.shape[0])
    assert derive(2 * Z.T * Z).multiply(turn).right.has(sp.BlockMatrix)
    assert found.check() == []


@pytest.mark.parametrize("seed", SEEDS)
def test_what_is_collected_stands_in_brackets(seed):
    rng, known = seeded(seed, x, u)
    known[v] = matrix(rng, 2, 1)
    start = sum(
        (drawn(rng, n, c.rows, 1) * c for c in (x, u, v, x, u)), ZeroMatrix(n, 1)
    )
    found = derive(start).collect(x, u)
    holds(found, known)
    for column in (x, u):
        others = {c: known[c] if c is column else 0 * known[c] for c in (x, u, v)}
        alone = evaluate(found.brackets[column] * column, known | others)
        assert alone == evaluate(start, known | others)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_transpose_is_one(seed):
    rng, known = seeded(seed)
    start = drawn(rng, n, m, 2)
    found = derive(start).transpose()
    assert found.check() == []
    assert evaluate(found.right, known) == evaluate(start, known).T


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("first", [None, A, B.T])
def test_a_trace_is_rotated(first, seed):
    rng, known = seeded(seed)
    found = None
    while found is None:
        start = derive(Trace(drawn(rng, n, n, 2)) - Trace(drawn(rng, m, m, 2))).right
        try:
            found = derive(start).cyclic(first)
        except ValueError as e:
            assert "nothing changes" in str(e)
            continue
        if found.check():  # multiplying out is enough
            assert found.check() == ["line 1 does not need that the trace is cyclic"]
            assert agree(found, known)
            found = None
    holds(found, known)
    if first is not None:
        inside = [t.arg.args for t in found.right.atoms(Trace) if t.arg.has(first)]
        assert all(first in args[:2] for args in inside if first in args)


# -- operations that use what is known ------------------------------------------------


def defined(rng, known, *shapes):
    """Definitions of new letters, whose values are those of their right sides."""
    found = []
    for letter in shapes:
        right = drawn(rng, *letter.shape, 1)
        if letter.T == letter:
            right = right + right.T
        known[letter] = evaluate(right, known)
        found.append((letter, right))
    return found


@pytest.mark.parametrize("seed", SEEDS)
def test_definitions_are_put_in(seed):
    rng, known = seeded(seed)
    meant = defined(rng, known, F, G, T)
    start = F * drawn(rng, n, n, 1) + G * drawn(rng, m, n, 1) - T
    holds(derive(start).put(*meant), known)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("scalar", [False, True])
def test_definitions_are_recognised_where_they_stand(scalar, seed):
    rng, known = seeded(seed)
    right = 2 * S * B - C.T if seed % 2 else rng.choice([A * B * R, C.T * D, A.T * B])
    known[G] = evaluate(right, known)
    around = drawn(rng, n, n, 0), drawn(rng, m, n, 0)
    known |= {F: matrix(rng, 2, 2), H: matrix(rng, 3, 2)}
    line = around[0] * right * around[1] - 3 * (F * right * H).T + A
    start = derive(Trace(line) if scalar else line)
    start = attempted(start.expand) or start
    found = start.fold((G, right))
    holds(found, known)
    assert found.right.has(G)
    assert not found.right.has(R)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("scalar", [False, True])
def test_a_product_of_a_definition_is_the_letter_less_the_rest(scalar, seed):
    rng, known = seeded(seed)
    right = A * S * A.T + B * R * B.T
    known[T] = evaluate(right, known)
    line = A * S * A.T - 2 * drawn(rng, n, n, 0)
    start = derive(Trace(line) if scalar else line)
    found = start.fold((T, right))
    holds(found, known)
    assert found.right.has(T) and found.right.has(R)


@pytest.mark.parametrize("seed", SEEDS)
def test_an_equation_between_blocks_is_one_for_each_block(seed):
    rng, known = seeded(seed)
    new = BlockMatrix([[A * T * A.T + S, A * B], [B.T * A.T, R]])
    old = BlockMatrix([[T, X], [X.T, H * H.T]])
    # T = A T A' + S and X = A B at these values
    known |= {A: sp.diag(0, 0), X: sp.zeros(2, 3), H: matrix(rng, 3, 2)}
    known |= {T: known[S], R: known[H] * known[H].T}
    both = Relation("both", old, new)
    found = derive(F * X + T * B).put(both)
    known |= {F: matrix(rng, 2, 2)}
    assert agree(found, known) and not found.right.has(X)
    assert found.right == F * A * B + (A * T * A.T + S) * B
    assert found.check() == []
    back = derive(Trace(F * (T - A * T * A.T))).fold(both)
    assert agree(back, known) and back.check() == []
    assert back.right == Trace(F * S) or back.right == Trace(S * F)


def test_a_number_is_factored_without_a_minus_in_front():
    t = sp.Symbol("t")
    found = derive(Trace(A * B * C) - t * Trace(A * B * C)).factor()
    assert found.right == (1 - t) * Trace(A * B * C)
    assert found.check() == []


def test_blocks_are_recognised_as_a_whole():
    is_Z = Relation("Z", Z, BlockMatrix([[A, F], [F, S]]))
    shown = derive(Z * Z).put(is_Z)
    assert derive(BlockMatrix([[A, F], [F, S]])).fold(is_Z).right == Z
    back = shown.multiply().by(Z * Z, is_Z)
    assert back.check() == [] and back.right == Z * Z
    with pytest.raises(Unproved, match=r"not proved \[1,1\]: it is false"):
        shown.by(Z, is_Z)


def test_a_derivation_begins_with_a_relation_or_a_chain():
    is_F = Relation("F = A + S", F, A + S)
    start = derive(is_F, symmetric=[S])
    assert (start.left, start.right, start.relations) == (F, A + S, (is_F,))
    again = derive(derive(F * B).put(is_F).expand())
    assert again.left == F * B and again.right == A * B + S * B
    assert start.check() == again.check() == []
    blocks = derive(Relation("Z", Z, BlockMatrix([[A, F], [F, S]])))
    assert blocks.check() == []


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("scalar", [False, True])
def test_relations_are_used_from_left_to_right(scalar, seed):
    rng, known = seeded(seed)
    left = rng.choice([C * A, C * A.T * B * C, C * S + D * C, C * S - 2 * H])
    known |= {H: matrix(rng, 3, 2)}
    known[X] = evaluate(left, known).T
    line = drawn(rng, n, m, 0) * left * drawn(rng, n, n, 0) + left.T * D * C - A
    start = derive(Trace(line) if scalar else line)
    found = start.use((left, X.T))
    holds(found, known)
    assert found.right.has(X)


def test_a_trace_that_is_not_rewritten_stands_as_it_did():
    found = derive(Trace(A * B * C) - Trace(D * C * F * B)).use((A * B, G))
    assert D * C * F * B in [t.arg for t in found.right.atoms(Trace)]
    assert found.check() == []


def test_the_trace_of_what_becomes_an_identity_is_its_size():
    found = derive(Trace(A) + 3 * Trace(B * H)).use((B * H, Identity(n)))
    assert found.right == Trace(A) + 3 * n
    assert found.check() == []


def test_a_sum_that_does_not_stand_is_solved_for_its_longest_product():
    found = derive(F * A * B).use((A * B + G, X))
    assert found.right == F * X - F * G
    assert found.check() == []


@pytest.mark.parametrize("seed", SEEDS)
def test_the_engine_says_what_an_equality_needs(seed):
    rng, known = seeded(seed)
    meant = defined(rng, known, F, G, T)
    start = drawn(rng, n, n, 1) * F * drawn(rng, n, n, 1) + drawn(rng, n, n, 2)
    found = derive(start).by(start.xreplace(dict(meant[:1])), *map(tuple, meant))
    holds(found, known)
    assert [r.left for r in found.lines[0].by] == [F]


def test_a_typed_line_says_so_and_is_checked():
    whole = Relation("(5) B H = I", B * H, Identity(n))
    found = derive(A).insert(A * B * H, whole)
    assert found.lines[-1].why == "inserted"
    assert found.check() == []
    assert derive(A).insert(B * H * A.T, whole).check() != []


# -- operations that do something to a line -------------------------------------------


def population(rng, known, *columns):
    """Columns that take four pairs of values, and their moments by counting."""
    samples = [
        {c: matrix(rng, *(int(s) for s in sp.Matrix(known[c]).shape)) for c in columns}
        for _ in range(4)
    ]

    def mean(e):
        total = (evaluate(e, known | sample) for sample in samples)
        return sum(total, 0 * evaluate(e, known | samples[0])) / len(samples)

    return mean


@pytest.mark.parametrize("seed", SEEDS)
def test_an_expectation_is_the_mean_over_samples(seed):
    P, Q, L, xm = letters("P:n*n= Q:m*m= L:n*m xm:n")
    rng, known = seeded(seed, x, u)
    mean = population(rng, known, x, u)
    known |= {P: mean(x * x.T), Q: mean(u * u.T), L: mean(x * u.T), xm: mean(x)}
    moments = [Moment("", a, b) for a, b in ((x * x.T, P), (u * u.T, Q), (x * u.T, L))]
    start = (A * x + B * u) * (drawn(rng, n, n, 1) * x - 2 * C.T * u).T
    if seed % 2:
        start = Trace(R * (C * x + D * u) * (C * x - u).T)
    found = derive(start).expect(*moments, Moment("", x, xm))
    assert found.check() == []
    assert evaluate(found.right, known) == mean(start)
    used = {r.right for r in found.lines[0].moments}
    assert xm not in used
    assert P in used


def moved(expr, known, direction):
    """The derivative of an expression as X moves, by an exact fourth difference."""
    at = {
        k: evaluate(expr, known | {X: known[X] + k * direction}) for k in (-2, -1, 1, 2)
    }
    return (8 * (at[1] - at[-1]) - (at[2] - at[-2])) / 12


@pytest.mark.parametrize("seed", SEEDS)
def test_a_gradient_is_the_slope_in_every_direction(seed):
    rng, known = seeded(seed, X)
    weight, other = drawn(rng, m, m, 1), drawn(rng, m, n, 1)
    start = Trace(X * weight * X.T * A) + Trace(other * X) - 2 * Trace(A.T * X * C)
    found = derive(start).gradient(X)
    assert found.check() == []
    for _ in range(3):
        direction = matrix(rng, 2, 3)
        slope = (evaluate(found.right, known).T * direction).trace()
        assert slope == moved(start, known, direction)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_gradient_is_taken_in_blocks(seed):
    """The slope in a letter for blocks, shown in each block."""
    K, K_1, K_2, M, N = letters("K:n*n+m K_1:n*n K_2:n*m M:n+m*n+m= N:n*n+m")
    M_1, M_2, M_3, N_1, N_2 = letters("M_1:n*n= M_2:n*m M_3:m*m= N_1:n*n N_2:n*m")
    blocks = (
        (K, BlockMatrix([[K_1, K_2]])),
        (M, BlockMatrix([[M_1, M_2], [M_2.T, M_3]])),
        (N, BlockMatrix([[N_1, N_2]])),
    )
    found = derive(Trace(K * M * K.T) - 2 * Trace(N * K.T)).gradient(K)
    found = found.multiply(*blocks)
    assert found.check() == []
    rng, known = seeded(seed, K_1, K_2, M_1, M_2, M_3, N_1, N_2)
    opened = derive(Trace(K * M * K.T) - 2 * Trace(N * K.T)).multiply(*blocks).right
    for block, of in zip(found.right.blocks, (K_1, K_2)):
        assert evaluate(block, known) == evaluate(
            derive(opened).gradient(of).right, known
        )


@pytest.mark.parametrize("seed", SEEDS)
def test_a_differential_is_what_moves(seed):
    rng, known = seeded(seed, X)
    start = X * drawn(rng, m, n, 1) * X * D + drawn(rng, n, n, 0) * X - B
    found = derive(start).differential({X: dX})
    assert found.check() == []
    direction = matrix(rng, 2, 3)
    change = moved(start, known, direction)
    assert evaluate(found.right, known | {dX: direction}) == change


# -- what comes out -------------------------------------------------------------------

FORMS = {
    "behind": lambda K, d: K * d[0] - d[1],
    "before": lambda K, d: d[2] * K - d[1],
    "around": lambda K, d: A * K * d[0] - A * d[1] - A * K,
    "between": lambda K, d: 2 * A * K * D - C.T * R * D,
    "transposed": lambda K, d: d[0].T * K.T * S - d[1].T * S,
    "not square": lambda K, d: C * K * H - C * d[1] * H - H,
    "a bracket before": lambda K, d: S * K + 2 * K - d[1],
    "a bracket behind": lambda K, d: A * K * D - A * K - A * d[1],
    "alone": lambda K, d: 3 * K - d[1],
    "to be inverted": lambda K, d: A * K * d[0] - S * d[1],
}


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("form", FORMS)
def test_a_solution_solves_the_line_and_the_line_says_it(form, seed):
    rng, known = seeded(seed, X, H)
    while known[S].det() == 0:
        known[S] = values(rng)[S]
    parts = drawn(rng, m, m, 1), drawn(rng, n, m, 1), drawn(rng, n, n, 1)
    line = FORMS[form](X, parts)
    solved = derive(line).solve(X)
    assert same_solutions(line, solved.left - solved.right, known)
    assert set(solved.invertible) <= {A, D, S}
    assert A in solved.invertible or form not in INVERTED


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("form", FORMS)
def test_a_solution_is_a_chain_where_the_line_is_zero(form, seed):
    rng, _ = seeded(seed)
    parts = drawn(rng, m, m, 1), drawn(rng, n, m, 1), drawn(rng, n, n, 1)
    line = FORMS[form](X, parts)
    zero_letter = MatrixSymbol("E_0", *line.shape)
    start = derive(Relation("E_0", zero_letter, line))
    zero = Relation("E_0 = 0", zero_letter, ZeroMatrix(*line.shape))
    chain, solved = start.solved(X, zero, "33", "the solution"), start.solve(X)
    assert (chain.left, chain.right) == (solved.left, solved.right)
    assert [x for x in chain.check() if "wide" not in x] == []
    assert chain.title == "(33) the solution" and zero in chain.lines[0].by


INVERTED = "around", "a bracket behind", "to be inverted"


def same_solutions(*expressions):
    """Whether two expressions, linear in X, vanish for the same X: by elimination."""
    *expressions, known = expressions
    reduced = []
    for expr in expressions:
        at_zero = evaluate(expr, known | {X: sp.zeros(2, 3)}).vec()
        units = [sp.eye(6)[k, :].reshape(2, 3) for k in range(6)]
        slopes = [evaluate(expr, known | {X: e}).vec() - at_zero for e in units]
        table = sp.Matrix.hstack(*slopes, at_zero).rref()[0]
        reduced.append([row for row in table.tolist() if any(row)])
    return reduced[0] == reduced[1]


def test_a_letter_stands_for_the_unknown_and_what_is_inverted_is_said():
    found = derive(2 * A * (X * R - B)).solve(X, "33", name=G)
    assert (found.left, found.right) == (G * R, B)
    assert found.invertible == (A,)
    assert str(found) == "(33) G R = B, if A can be inverted"
    assert r"\text{if } A" in found._repr_latex_()


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("scalar", [False, True])
def test_a_quadratic_is_completed_to_a_square(scalar, seed):
    rng, known = seeded(seed, X)
    best = G
    known[best] = matrix(rng, 2, 3)
    weight, linear = D.T * D + 2 * R if seed % 2 else R, H.T
    known[H] = (known[best] * evaluate(weight, known)).T
    line = A - X * linear.T - linear * X.T + X * weight * X.T
    if scalar:
        line = Trace(S * (X * weight * X.T)) - 2 * Trace(S * linear * X.T) + Trace(A)
    found = derive(line).square(X, (best * weight, linear))
    holds(found, known)
    squares = [e for e in found.right.atoms(sp.MatAdd) if e == X - best]
    assert squares
    assert not (found.right.subs(X - best, B)).has(X)


ROOTS = {
    "a square": (A, lambda: (X - B) * (X - B).T, (), (X - B)),
    "a letter": (A, lambda: 4 * (X - B) * R * (X - B).T, (R,), None),
    "two letters": (Trace(A), lambda: Trace(S * X * R * X.T), (R, S), None),
    "within": (A, lambda: B * D * R * (B * D).T, (R,), None),
    "turned": (D, lambda: X.T * S * X / 4, (S,), None),
}


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", ROOTS)
def test_what_is_dropped_is_a_square(name, seed):
    rest, term, roots, _ = ROOTS[name]
    rng, known = seeded(seed, X)
    found = derive(rest + term()).drop(*roots)
    assert found.check() == []
    assert found.right == rest
    for relation in found.lines[0].by:  # the roots that the machine made
        factor = next(iter(relation.right.atoms(sp.MatrixSymbol)))
        known[factor] = matrix(rng, *known[relation.left].shape)
        known[relation.left] = evaluate(relation.right, known)
    change = evaluate(found.left, known) - evaluate(found.right, known)
    root = evaluate(found.lines[0].root, known)
    square = root * root.T
    assert change == (square.trace() if rest == Trace(A) else square)


def test_a_term_is_dropped_by_its_letter_where_there_are_several():
    line = derive(S + B * R * B.T + X * R * X.T)
    with pytest.raises(ValueError, match="several terms are squares"):
        line.drop(R)
    found = line.drop(R, of=X)
    assert found.right == S + B * R * B.T
    assert found.check() == []


@pytest.mark.parametrize(
    "line",
    [
        A + X * R * B.T,
        A - X * R * X.T,
        Trace(A * B * C),
        A + B * D * B.T,
        S + B * B.T * A.T * A,  # a square in a trace alone
    ],
)
def test_what_may_be_negative_is_not_dropped(line):
    with pytest.raises(ValueError, match="no term is a square"):
        derive(line).drop(R)


@pytest.mark.parametrize("seed", SEEDS)
def test_terms_that_end_alike_are_matched(seed):
    rng, known = seeded(seed)
    line = drawn(rng, n, n, 1) * A * B + drawn(rng, n, m, 1) * C * B
    found = derive(line).match(F * A * B + G * C * B, "14", "15", enough=True)
    assert [r.left for r in found] == [F, G]
    assert [r.name[:4] for r in found] == ["(14)", "(15)"]
    known |= {r.left: evaluate(r.right, known) for r in found}
    assert evaluate(F * A * B + G * C * B, known) == evaluate(line, known)


def test_coefficients_are_compared_where_the_letters_may_be_anything():
    line = derive(A * B * X.T * v + T * v + B * D * u)
    found = line.match(F * v + G * u, "14", "15")
    assert [str(r) for r in found] == [
        "Suppose (14) F = A B X' + T, for every v",
        "Suppose (15) G = B D, for every u",
    ]
    again = derive(F * v + G * u).use(*found)
    assert again.check() == [] and len(again.lines[-1].by) == 2
    both = line.collect(v, u).vanishing("9")
    assert [str(r) for r in both] == [
        "Suppose (9) A B X' + T = 0, for every v",
        "Suppose B D = 0, for every u",
    ]
    assert derive(A * v - F * v).collect(v).vanishing()[0].show(str) == "A = F"
    gone = derive(line.right).use(*both)
    assert gone.check() == [] and gone.right.is_ZeroMatrix


@pytest.mark.parametrize(
    ("said", "find"),
    [
        ("T is not free: a coefficient", lambda: derive(A * T * T).match(F * T)),
        (
            "x is not free: v = A x ties it to v",
            lambda: derive(F * x + A * v, known=[(v, A * x)]).match(A * x + F * v),
        ),
        (
            "x is not free: F = x v' ties it to F; say enough=True",
            lambda: derive(A * x, known=[(F, x * v.T)]).match(F * x),
        ),
        ("B u is no letter", lambda: derive(A * B * u).match(F * B * u)),
        (
            "x is not free: a coefficient",
            lambda: derive(A * x * x.T * x).collect(x).vanishing(),
        ),
        ("nothing was collected", lambda: derive(A * x).vanishing()),
    ],
)
def test_what_is_not_free_is_not_compared(said, find):
    """A T T = F T does not say that F is A T: it may hold for this T alone."""
    with pytest.raises(ValueError, match=said):
        find()


# -- what is refused ------------------------------------------------------------------

twice = Relation("A B = B", A * B, B)
REFUSED = {
    "the line has no letter T": lambda: derive(A).put((T, S)),
    "A B = B does not say what a letter is: `use` it": lambda: derive(A * B).put(twice),
    "the line has no A B: it is A S": lambda: derive(A * S).use((A * B, G)),
    "the line has no S B + F B: it is A B": lambda: derive(A * B).fold(
        (G, S * B + F * B)
    ),
    "X = B does not say that G = 0": lambda: derive(Relation("G", G, A * X)).solved(
        X, (X, B)
    ),
    "nothing changes: the line is A B already": lambda: derive(A * B).expand(),
    "the line has no blocks: it is A B": lambda: derive(A * B).multiply(),
    "the line has no x: it is A v": lambda: derive(A * v).collect(x),
    "nothing in the line is random: A B": lambda: derive(A * B).expect((x * x.T, S)),
    "E[x x'] is not among the moments": lambda: derive(x * x.T).expect((x, v)),
    "the line has no X: it is tr(A)": lambda: derive(Trace(A)).gradient(X),
    "only a trace has a gradient in a matrix, and the line is A X": lambda: derive(
        A * X
    ).gradient(X),
    "the line takes F for constant, which F = X C ties to X: put that in first, or say "
    "that it is held": lambda: derive(Trace(F * X * C), known=[(F, X * C)]).gradient(X),
    "the line has no X: it is A B": lambda: derive(A * B).differential({X: dX}),
    "the line is not linear in X: it is X R X'": lambda: derive(X * R * X.T).solve(X),
    "the line is not linear in A: it is A F - F A": lambda: derive(A * F - F * A).solve(
        A
    ),
    "the line is not linear in A: it is A⁻¹ F - S": lambda: derive(A.I * F - S).solve(
        A
    ),
    "the line has no X: it is A": lambda: derive(A).solve(X),
    "the line is no quadratic in X whose slope vanishes where G R = B: it is X C": (
        lambda: derive(X * C).square(X, (G * R, B))
    ),
    "A in the line ends like no term of G C": lambda: derive(B * R * C + A).match(
        G * C
    ),
}


@pytest.mark.parametrize("says", REFUSED)
def test_what_cannot_be_done_is_refused_in_a_sentence(says):
    with pytest.raises((TypeError, ValueError)) as refused:
        REFUSED[says]()
    assert str(refused.value) == says


def test_a_letter_that_the_derivation_makes_depend_is_not_held():
    """By what was put in before, and not only by what is said to be known."""
    start = derive(Trace(G * H)).put((G, X * R)).insert(Trace(F + X * C), why="any")
    start.gradient(X)
    start = derive(Trace(F + G * H)).put((G, X * R)).use((F, X * C))
    with pytest.raises(ValueError, match=r"takes H for constant, which H = X' A"):
        replace(start, known=(Relation("H = X' A", H, X.T * A),)).gradient(X)


def test_a_derivation_never_changes():
    start = derive(F * B)
    one, other = start.put((F, A + S)), start.put((F, A - S))
    assert start.lines == ()
    assert (one.right, other.right) == ((A + S) * B, (A - S) * B)
    assert len(one.expand().lines) == 2
    assert len(one.lines) == 1
    assert one.expand().collect(B).brackets == {B: A + S}
    assert one.brackets == {}


# -- the checker guards every operation -----------------------------------------------

DAMAGED = {
    "put": lambda: derive(F * B).put((F, A + S)),
    "use": lambda: derive(A * B * C + S).use((A * B, G)),
    "fold": lambda: derive(A * B * C + S).fold((G, A * B)),
    "by": lambda: derive(A * B * C + S).by(G * C + S, (A * B, G)),
    "insert": lambda: derive(A).insert(A * F, (F, Identity(n))),
    "expand": lambda: derive(A * (S + F)).expand(),
    "multiply": lambda: derive(Z * Z).multiply((Z, BlockMatrix([[A, F], [F, S]]))),
    "factor": lambda: derive(A * S + A * F).factor(),
    "collect": lambda: derive(A * x + S * v + F * x).collect(x),
    "transpose": lambda: derive(A * F).transpose(),
    "cyclic": lambda: derive(Trace(B * C * S)).cyclic(C),
    "expect": lambda: derive(A * x * x.T).expect((x * x.T, S)),
    "gradient": lambda: derive(Trace(X * R * X.T)).gradient(X),
    "differential": lambda: derive(A * X).differential({X: dX}),
    "square": lambda: derive(X * R * X.T - X * H - H.T * X.T).square(X, (G * R, H.T)),
    "drop": lambda: derive(S + X * R * X.T).drop(R),
}


@pytest.mark.parametrize("name", DAMAGED)
def test_a_line_that_is_damaged_is_noticed(name):
    found = DAMAGED[name]()
    assert found.check() == []
    *before, last = found.lines
    wrong = replace(found, lines=(*before, replace(last, right=2 * last.right)))
    assert wrong.check() != []
    if last.by:
        unfounded = replace(found, lines=(*before, replace(last, by=())))
        assert unfounded.check() != []


# -- derivations of the papers --------------------------------------------------------


def test_the_gain_is_found():
    """Leondes and Novak (27)-(33): the slope, the gain, and that none does better."""
    q, begin = quadratic, quadratic.letters.derive
    error = begin("27", "any gain", q.e_next * q.e_next.T).put(q.is_e_next)
    error = error.expect(q.is_e_minus, q.is_R, q.fresh).fold(q.is_Sigma_next)
    cov = begin("27-29", "quadratic", q.Sigma_next).put(q.is_Sigma_next, q.is_Y)
    cov = cov.expand().fold(q.is_M).fold(q.is_N)
    slope = begin("32", "its slope", Trace(q.W_e * q.Sigma_next)).put(cov).gradient(q.K)
    gain = slope.solve(q.K, "33", name=q.Kmv)
    best = cov.square(q.K, gain).drop(q.root_M)
    assert [x.check() for x in (error, cov, slope, best)] == [[]] * 4
    assert slope.right == 2 * q.W_e * (q.K * q.M - q.N)
    assert tuple(gain) == tuple(q.is_Kmv)
    assert gain.invertible == (q.W_e,)
    assert best.right == q.Omega - q.N * q.Kmv.T
    assert best.lines[-1].sign == "≥"


def test_the_coupled_equations_are_found_as_a_pair():
    """Leondes and Novak (32): the gradient in both gains, shown in each."""
    c = canonical_gain
    quadratic_ = c.trace_of(c.K_low)
    slope = c.letters.derive("32", "both gains", quadratic_)
    slope = slope.gradient(c.K_low, held=(c.M, c.N_low))
    gains = slope.solve(c.K_low, "33", name=c.K_star)
    equation = c.K_low * c.M - c.N_low
    pair = c.letters.derive("32", "in each gain", equation)
    pair = pair.multiply(c.is_K_low, c.M_blocks, c.N_blocks).factor()
    assert slope.check() == pair.check() == []
    assert slope.right == 2 * equation
    assert tuple(gains) == tuple(c.is_K_star)
    assert gains.invertible == ()
    assert pair.right.blocks[0] == (
        c.K_1 * (c.Omega_11 + c.R_11)
        + c.K_2 * (c.R_21 + c.H_2 * c.Omega_21)
        - c.Omega_21
    )
    best = c.letters.derive("33", "no gains do better", quadratic_)
    best = best.square(c.K_low, gains).drop(c.root)
    assert best.check() == []


def test_luenbergers_conditions_and_huddles_solution_are_found():
    """Leondes and Novak (7)-(15)."""
    h, s, begin = huddle, stochastic_system, huddle.letters.derive
    error = begin("7, 8", "what drives the error", h.eps_next).put(h.follows_next)
    error = error.put(h.moves, s.plant).put(h.follows, s.measured).collect(h.x, h.u)
    assert error.brackets == {
        h.x: h.F * h.T + h.D * h.C - h.T_next * h.A,  # (9)
        h.u: h.G + h.D * h.E - h.T_next * h.B,  # (10)
    }
    estimate = begin("12", "the error of an estimate", h.e).put(h.is_e, h.estimate)
    estimate = estimate.put(h.follows, s.measured).collect(h.x, h.u)
    assert estimate.brackets[h.x] == h.P * h.T + h.V * h.C - h.I  # (13)
    between = begin("14, 15", "put (13) behind", h.T_next * h.A)
    between = between.insert(h.T_next * h.A * (h.P * h.T + h.V * h.C), h.unbiased)
    found = between.expand().match(h.F * h.T + h.D * h.C, "14", "15", enough=True)
    assert [(r.name, *r) for r in found] == [(r.name, *r) for r in (h.is_F, h.is_D)]
    seen = begin("11, 14, 15", "as the prediction does", h.eps_next)
    seen = seen.put(h.error_equation).put(*found).fold(h.error).factor()
    assert seen.right == h.T_next * (h.A * h.e - s.w)
    assert [x.check() for x in (error, estimate, between, seen)] == [[]] * 4


def test_the_optimal_projection_is_found():
    """Haddad and Bernstein (4.8)-(4.11) to (3.10)-(3.13), from the cost by blocks."""
    s, begin = stationarity, stationarity.letters.derive
    in_gains, in_cost = gradients.constraint.right, gradients.output.right
    Ae = begin("4.8", "in A_e", in_gains).gradient(s.Ae).put(s.is_Q12, s.is_P12)
    is_Ae = Ae.factor().solve(s.Ae, "3.10'")
    Be = begin("4.9", "in B_e", in_gains).gradient(s.Be, held=[s.Ae])
    Be = Be.put(s.next_split, s.split).put(s.is_Q12, s.is_P12, s.is_Qe).put(is_Ae)
    is_Be = Be.factor().solve(s.Be, "3.11")
    Ce = begin("4.10", "in C_e", in_cost).gradient(s.Ce).put(s.is_Q12)
    is_Ce = Ce.factor().solve(s.Ce, "3.12")
    De = begin("4.11", "in D_e", in_cost).gradient(s.De, held=[s.Ce])
    De = De.put(s.split, s.is_Qxy, s.is_Q1).put(s.is_Q12, s.is_Qe).put(is_Ce)
    is_De = De.factor().solve(s.De, "3.13")
    assert [x.check() for x in (Ae, Be.factor(), Ce.factor(), De.factor())] == [[]] * 4
    given = s.is_Ae, s.is_De
    for found, known in zip((is_Ae, is_De), given):
        assert found.left == known.left
        assert derive(found.right - known.right).expand().right.is_ZeroMatrix
    assert tuple(is_Be) == (s.Be * s.V2s, s.Gam * s.Qs)
    assert tuple(is_Ce) == (s.Ce, s.L * s.G.T - s.De * s.C * s.G.T)
    assert [r.invertible for r in (is_Ae, is_Be, is_Ce, is_De)] == [
        (s.P2, s.Q2),
        (s.P2,),
        (plant.R, s.Q2),
        (plant.R,),
    ]


def test_the_blocks_of_the_lagrangian_are_multiplied():
    """Haddad and Bernstein (4.6): the gradient in A_e without a letter for a block."""
    a, k, b = augmented, cost, both
    line = a.letters.derive("4.6", "", Trace(b.Pt * (a.At * a.Qt * a.At.T + a.Vt)))
    slope = line.multiply(k.is_Pt, a.is_At, a.is_Qt, a.is_Vt).gradient(a.Ae)
    assert all(
        "wide" in fault for fault in slope.check()
    )  # two lines that need letters
    wanted = b.P12.T * a.A * a.Q12 + b.P2 * (a.Be * a.C * a.Q12 + a.Ae * a.Q2)
    rest = derive(slope.right - 2 * wanted, symmetric=a.letters.symmetric).expand()
    assert rest.right == ZeroMatrix(*a.Ae.shape)


@pytest.mark.parametrize("law", laws.LAWS)
def test_the_laws_of_sampling_are_found(law):
    """Hsia, Table II: where the slope of each cost vanishes."""
    cost_ = laws.periods.derive(laws.number(law), "its slope", laws.LAWS[law][laws.J])
    slope = cost_.gradient(laws.T)
    assert slope.check() == []
    found = slope.solve(laws.T)
    assert (found.left, found.invertible) == (laws.T, ())
    assert sp.simplify(found.right - laws.LAWS[law][laws.T_s]) == 0


def test_the_smoother_is_found():
    """Rauch, Tung and Striebel: the gain of a known next state, and the recursion."""
    s, begin = next_state, next_state.letters.derive
    error = (s.e - s.X * s.e_minus_next) * (s.e - s.X * s.e_minus_next).T
    cov = begin("", "any gain", error).expect(s.is_Sigma, s.both, s.ahead)
    slope = begin("", "its slope", Trace(cov.right)).gradient(s.X)
    gain = slope.solve(s.X, name=s.G)
    assert tuple(gain) == tuple(s.is_G)
    best = cov.square(s.X, gain).drop(s.root)
    short = begin("", "with the best gain", s.D).put(s.squares).expand()
    short = short.fold(s.is_Omega, s.is_T).use(s.is_G)
    assert short.right == s.Sigma - s.G * s.T
    step = begin("", "the recursion", s.Sigma_s).put(s.is_Sigma_s, s.short).factor()
    assert step.right == s.Sigma + s.G * (s.Sigma_s_next - s.Omega_next) * s.G.T
    assert [x.check() for x in (cov, slope, best, short, step)] == [[]] * 5


def test_the_canonical_form_is_found():
    """Kawazoe (11): from the order of the search, with one line that is inserted."""
    k = form
    split = (k.E_0.T * k.E_0 + k.E_p.T * k.E_p) * k.P * k.A
    found = k.letters.derive("11", "", k.P * k.A).insert(split, k.whole).expand()
    found = found.use(k.goes_on, k.ends).fold(k.is_Z, k.is_Phi)
    assert found.right == k.Phi * k.P and found.check() == []
    assert [line.right for line in found.lines] == [x.right for x in k.turned.lines]


# -- letters of one's own -------------------------------------------------------------


def test_letters_are_declared_by_their_sizes():
    K, Q, c, t, E = letters("K_low:n-r*2p Q:n*n= c:n t E:2*3")
    assert str(K.shape) == "(n - r, 2*p)"
    assert (Q.T, c.shape[1], E.shape) == (Q, 1, (2, 3))
    assert t.is_real
    assert derive(E * E.T).transpose().check() == []


def test_a_letter_that_is_symmetric_is_so_for_the_engine():
    """Without saying so again: in a proof, in a model, and in a chain by hand."""
    assert prove(C * S, (S * C.T).T).check()
    found = refute(A, A.T * S)
    assert found[S] == found[S].T
    assert (
        Chain("", "", C * S, [Line((S * C.T).T, why="transposed twice")]).check() == []
    )
    with pytest.raises(Unproved):
        prove(C * A, (A * C.T).T)


@pytest.mark.parametrize(
    ("declared", "says"),
    [
        ("C:p*n=", "C is (p, n), not square: it is not symmetric"),
        ("A:n*", "'' in 'A:n*' is no size: write A:n*m"),
        ("A:n*n A:m*m", "the letter A is taken"),
        ("A:n/2", "'n/2' in 'A:n/2' is no size"),
        ("A:n*n*m", "'A:n*n*m' has 3 sizes"),
        ("é:n*n", "the name 'é' has"),
    ],
)
def test_letters_that_cannot_be_declared(declared, says):
    with pytest.raises(ValueError) as refused:
        letters(declared)
    assert says in str(refused.value)


# -- slips ----------------------------------------------------------------------------

meant = Relation("F = A + S", F, A + S)
in_blocks = Relation("Z", Z, BlockMatrix([[A, F], [F, S]]))
SLIPS = {
    "lines are given in a list, also a single one: [Line(...)]": lambda: Chain(
        "", "", F, Line(A + S, by=(meant,))
    ),
    "line 1 of chain (3) is a list; write its lines one after the other": lambda: Chain(
        "3", "", F, [[Line(A + S, by=(meant,))]]
    ),
    "F = A + S is one relation where several are meant: write (relation,), with a "
    "comma": lambda: Line(A + S, by=meant),
    "a list of relations stands where one is meant: write them one after the other": (
        lambda: derive(F).put([meant])
    ),
}


@pytest.mark.parametrize("says", SLIPS)
def test_a_slip_is_said_in_a_sentence(says):
    with pytest.raises(TypeError) as refused:
        SLIPS[says]()
    assert str(refused.value) == says


@pytest.mark.parametrize(
    ("left", "line", "says"),
    [
        (F, Line(Z), "line 1 cannot be checked: claim: shapes (n, n) and (2*n, 2*n)"),
        (F, Line(0.5 * F), "line 1 cannot be checked: 0.5 is a float, which is not"),
    ],
)
def test_a_line_that_cannot_be_read_is_shown_and_says_why(left, line, says):
    chain = Chain("", "", left, [line])
    (fault,) = chain.check()
    assert says in fault
    assert r"\times" in chain._repr_latex_()
    assert len(str(chain).splitlines()) == 3


def test_a_step_that_is_unknown_has_near_ones():
    page = quadratic.page
    with pytest.raises(
        KeyError, match=r"near it are '\(32\) the gradient in the gain'"
    ):
        page.steps["(32) the gradient of the gain"]


def test_the_gradient_of_the_logarithm_of_a_determinant():
    C, P, R, X = letters("C:p*n P:n*n= R:p*p= X:n*n")
    M = C * P * C.T + R
    cost = sp.log(sp.Determinant(M)) + sp.Trace(P * C.T * C)
    assert derive(sp.log(sp.Determinant(M))).gradient(P).right == C.T * M.I * C
    assert not derive(cost).gradient(P).check()
    assert not Gradient(X.T.I, of=X).complaints(sp.log(sp.Determinant(X)), ())
    assert Gradient(X.I, of=X).complaints(sp.log(sp.Determinant(X)), ())
    with pytest.raises(TypeError, match="not linear in traces"):
        derive(sp.log(sp.Determinant(X)) * sp.Trace(X)).gradient(X)
