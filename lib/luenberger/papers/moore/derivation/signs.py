"""Moore's remark: a functional with entries of one sign has no smaller observer.

The entries are those in the coordinates of (1) and (2); in any coordinates they are the
sequence `k A^i g`.  In continuous time a stable polynomial has only positive
coefficients, and then the recurrence would make a sum of terms of one sign vanish.
Some entries may even be zero.  The paper's example `k = C` needs no signs at all.  In
discrete time a stable polynomial may have negative coefficients, and the remark is
false.

Source: Moore (1973), the remark after (13); weak signs, `k = C` without signs and
discrete time are our own.
"""

from itertools import product

import sympy as sp

from matrixproof import Explicit, Page, ZeroMatrix
from matrixproof.explicit import Positive

from .letters import D_1, A, F, S, T, beta, c, kappa, letters, n, r
from .recurrence import at_sizes, named_beta, observable_form, recurrence_rows

letters = letters.here()
ones = letters("j", 1, n - r, "ones")
last = letters("l", n - r, 1, "the last column of the identity")


def stable_coefficients():
    """{roots: beta} of every polynomial up to order 5 whose roots have Re s < 0."""
    s_, found = sp.Symbol("s"), {}
    damping, squares = (sp.symbols(f"{x}_:3", positive=True) for x in "cd")
    roots = sp.symbols("a_:5", positive=True)
    for real, pairs in product((1, 0, 2, 3, 4, 5), (1, 0, 2)):
        if 1 <= real + 2 * pairs <= 5:
            factors = [s_ + a for a in roots[:real]]
            factors += [
                s_**2 + 2 * c_ * s_ + d_
                for c_, d_ in zip(damping[:pairs], squares[:pairs])
            ]
            coefficients = sp.Poly(sp.Mul(*factors), s_).all_coeffs()[:0:-1]
            found[f"{real} real, {pairs} pairs"] = {beta: sp.Matrix([coefficients])}
    return found


def positive_rows(size, order):
    beta_ = named_beta(order, positive=True)
    return {ones: sp.ones(1, size - order), S: recurrence_rows(beta_, size)}


def output_row(size, order):
    unit = sp.Matrix(size - order, 1, lambda i, _: int(i == size - order - 1))
    S_ = recurrence_rows(named_beta(order), size)
    return {S: S_, c: observable_form(size)[1], last: unit}


def discrete_observer():
    """The pole 1/2, and the sequence 1, 1/2."""
    half = sp.Rational(1, 2)
    A_, c_, alpha_ = observable_form(2)
    gain = -sp.Matrix([[half**2 + alpha_[1] * half + alpha_[0]]])
    T_ = sp.Matrix([[1, half]])
    return {S: sp.Matrix([[-half, 1]]), kappa: T_.T}, {
        T: T_, A: A_, F: sp.Matrix([[half]]), D_1: gain, c: c_
    }  # fmt: skip


RECURRENCE, OBSERVER = discrete_observer()
no_rows = ZeroMatrix(n - r, 1)


page = Page(letters=letters, source="Moore (1973), the remark after (13)")

page("""In continuous time a stable polynomial is a product of `s + a` for each real
    root and `s^2 + 2 c s + d` for each pair, all positive. Multiplied out, every
    coefficient is a sum of products of positive numbers.""")
says = "a stable polynomial has positive coefficients"
page(Positive("after 13", says, beta, 0, stable_coefficients()))

page("Then the rows of `S` add up to a row of positive numbers as well.")
says = "the rows of the recurrence add up to a positive row"
page(Positive("after 13", says, ones * S, 0, at_sizes(positive_rows)))

page("""If the sequence obeys the recurrence, that row times the sequence is zero. With
    all entries of one sign it could only be zero if every entry were. So there is no
    such observer, even if some entries are zero, where a single row need not
    contradict.""")
obeys = page.suppose(S * kappa, no_rows, "13")
start = letters.derive("after 13", "the sum of the rows as well", ones * S * kappa)
page(start.use(obeys))

page("""The paper's example is `k = C`: filtering the output itself. It is ruled out
    whatever the signs are, because the last row of the recurrence says 1 = 0.""")
says = "the output itself never obeys the recurrence"
page(Explicit("after 13", says, S * c.T, last, at_sizes(output_row)))

page("""In discrete time the remark is false: 1, 1/2 are both positive and obey the
    recurrence with the stable pole 1/2. The observer moves by `z_next = z/2 + D y`.""")
says = "a sequence of one sign in discrete time"
page(Explicit("after 13", says, S * kappa, no_rows, {"n = 2, r = 1": RECURRENCE}))
says = "its observer"
page(Explicit("after 13", says, T * A - F * T, D_1 * c, {"n = 2, r = 1": OBSERVER}))
