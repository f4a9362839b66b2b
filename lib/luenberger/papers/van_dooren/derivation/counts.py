"""What it costs: multiply-adds, counted loop by loop.

Each count is a sum over the loops of the algorithm; its leading term is the paper's
figure, and what is left shows how good a figure it is for small plants.

Source: Van Dooren (1984), (21)-(25), (34), remarks 2(a) and 2(b); the staircase as it
is done here and the pair as one complex row are our own.
"""

import sympy as sp

from matrixproof import Explicit, Page
from matrixproof.explicit import Positive

from .letters import letters, n
from .rows import patterns

letters = letters.here()
c_M = letters("c_M", 1, 1, "what (21) allows for one matrix, and one more")
k_M = letters("k_M", 1, n, "entries of each column of `M` on the diagonal and below")
d_M = letters("d_M", n, 1, "columns from each on: `n`, ..., `1`")


n, m, r = sp.symbols("n m r", integer=True, positive=True)
k, j = sp.symbols("k j", integer=True, nonnegative=True)


def loop(term, variable, times):
    """The sum of a term over a loop that runs so many times, from 0 on."""
    return sp.Sum(term, (variable, 0, sp.Add(times, -1, evaluate=False)))


def both_loops(term, inner, outer):
    return loop(loop(term, j, inner), k, outer)


COUNTS = {
    "one M_i": r * n**2,
    "all rows": (n - r) * r * n**2,
    "staircase": (3 * n + r) * n**2,
    "staircase, as done": sp.Rational(8, 3) * n**3,
    "G": n**2 * m + (n - r) * n * m,
    "[P V]": n**3 / 2,
    "pairs, doubled real systems": (n - r) * r * n**2 * 4,
    "pairs, complex rows": (n - r) * r * n**2 * 2,
}


def count(number, says, loops, figure, rest=None):
    """Write loops, the paper's figure, and what is left of lower order."""
    both = figure if rest is None else sp.Add(figure, rest, evaluate=False)
    page(Explicit(number, says, loops, both))


def patterned():
    """What (21) allows, entries on and below the diagonal, columns, of each pattern."""
    found = {}
    for name, p in patterns().items():
        for i in range(p.n - p.r):
            heights = [row - column + 1 for column, row in enumerate(p.leading(i))]
            found[f"{name}, row {i + 1}"] = {
                c_M: sp.Matrix([[p.r * p.n**2 + p.n * p.r + 1]]),
                k_M: sp.Matrix([heights]),
                d_M: sp.Matrix(range(p.n, 0, -1)),
            }
    return found


page = Page(letters=letters, source="Van Dooren (1984), (21)-(25), (34), remark 2")

page("""The matrix of one row has `r` entries below a diagonal. A reflector of `r`
    entries for column `j` is applied to the `n - j` columns from there on, with two
    multiply-adds for each entry it meets.""")
one = loop(2 * r * (n - j), j, n)
count("21", "the factors of one matrix", one, COUNTS["one M_i"], n * r)

page("""So it is on the patterns of these matrices, where a column of one that is
    triangular already costs less.""")
says = "what the entries of the patterns cost"
page(Positive("21, 22", says, c_M, 2 * k_M * d_M, patterned()))

page("There are `n - r` of them.")
every = loop(one, k, n - r)
count("22", "all rows", every, COUNTS["all rows"], (n - r) * n * r)

page("""The rest of a row is small beside this: a triangle, and the way back through the
    reflectors.""")
count("after 21", "one triangle", loop(j + 1, j, n), n**2 / 2, n / 2)
count("after 21", "the way back", loop(2 * r, j, n), 2 * r * n)

page("""In row `i` the first `i` columns are triangular already. Left alone, they save
    two thirds: with `r` small the count is a third of (22).""")
left = both_loops(2 * r * (n - k - j), n - k, n - r)
third = r * (n - r) * (n**2 + n * r + 3 * n + r**2 + 3 * r + 2) / 3
count("", "the columns that are not yet triangular", left, third)

page("""The staircase takes a reflector for each state, applied from the left to the
    columns that follow, from the right to all rows, and to `U`. The paper counts
    more.""")
turns = loop(2 * (n - j) ** 2 + 4 * n * (n - j), j, n)
done = COUNTS["staircase, as done"]
count("23", "the staircase", turns, done, 3 * n**2 + n / 3)
page(Positive("23", "the paper counts more", COUNTS["staircase"], done))

page("The gains: `U^* B`, then `T_U` times it, entry by entry.")
second = both_loops(n, m, n - r)
gain = sp.Add(both_loops(n, m, n), second, evaluate=False)
count("25", "the gain of the input", gain, COUNTS["G"])

page("""Here `T` itself is wanted. Once `T_U U^*` is there, the gain takes only the
    second product.""")
gain = sp.Add(both_loops(n, n, n - r), second, evaluate=False)
count("25", "the gain of the input by way of T", gain, (n - r) * n * (n + m))

page("Each of the `n` rows of `P`, `V` takes one triangle.")
triangles = both_loops(j + 1, n, n)
count("25", "the gains of the estimate", triangles, COUNTS["[P V]"], n**2 / 2)

page("""A pair takes a system with twice the rows and columns: reflectors of `2 r`
    entries on `2 n` columns.""")
pair, doubled = loop(4 * r * (2 * n - j), j, 2 * n), "pairs, doubled real systems"
count("after 33", "the factors for one pair", pair, 8 * r * n**2, 4 * r * n)
pairs = loop(pair, k, (n - r) / 2)
count("34", "all pairs", pairs, COUNTS[doubled], (n - r) * r * n * 2)

page("""In complex arithmetic the rows are those of (22), and each multiply-add costs
    four real ones: just as much. But one complex row serves both poles of a pair, so
    that only half of the rows are needed.""")
complex_ = both_loops(8 * r * (n - j), n, n - r)
says = "complex arithmetic costs as much"
count("remark 2(a)", says, complex_, COUNTS[doubled], (n - r) * n * r * 4)
complex_ = both_loops(8 * r * (n - j), n, (n - r) / 2)
half, says = COUNTS["pairs, complex rows"], "one complex row for a pair costs half"
count("remark 2(a)", says, complex_, half, (n - r) * n * r * 2)

page("""For more than three outputs, and many more states, the rows cost more than the
    staircase. Back substitution costs a triangle for each row, doubled in size for a
    pair, and `n^3` for all.""")
more = sp.Add(COUNTS["all rows"], -COUNTS["staircase"], evaluate=False)
says = "what the rows cost more than the staircase"
count("remark 2(b)", says, more, n**2 * ((r - 3) * n - r * (r + 1)))
triangle = loop(j + 1, j, 2 * n)
count("remark 2(b)", "back substitution for a pair", triangle, 2 * n**2, n)
triangles = both_loops(j + 1, n, n - r)
rest = (n - r) * n / 2 - r * n**2 / 2
count("remark 2(b)", "back substitution for all rows", triangles, n**3 / 2, rest)
