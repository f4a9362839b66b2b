r"""A certificate as a lemma of Coq and MathComp, for its kernel to accept or not.

The lemma says what was proved, as it was written: brackets stay, blocks are multiplied
block by block, and its matrices have sizes that are any natural numbers, over any
`numFieldType`, such as the reals.  Its hypotheses are the relations, inverses and
symmetries that the certificate cites, and nothing else: that X is the inverse of M is
M X = 1, X M = 1, or both.  A number that is divided by is not zero.

A certificate says that left - right is a sum of c u (l - r) v, where l = r is known.
The proof is that sum.  `entry_of` multiplies the claim out and takes an entry of it.
`term_of` does the same to u l v = u r v, and adds c times its difference to the right
side, which changes nothing.  Then the sides are equal as polynomials whose letters
are the entries of words, and `ring` cancels; it knows nothing of matrices.  In a
trace the letters are traces of words.  The tactics are in `words.v`, which each page
of lemmas loads.

Nothing of the prover is trusted, and nothing of the checker; what is trusted is that
the lemma says the same as the formula, which its comment repeats.

>>> from matrixproof import letters, prove
>>> A, B, C = letters("A:n*m B:m*k C:n*k")
>>> print(lemma("page", prove(A * B * C.T, C * C.T, given=[(A * B, C)])))
(* A*B*C.T = C*C.T *)
Lemma page
  (k m n : nat)
  (A : 'M[Scalar]_(n, m))
  (B : 'M[Scalar]_(m, k))
  (C : 'M[Scalar]_(n, k))
  (given : A *m B = C :> 'M[Scalar]_(n, k)) :
  A *m B *m C^T = C *m C^T :> 'M[Scalar]_(n, n).
Proof.
  entry_of i j.
  term_of i j (1 : Scalar) (around (1%:M) (C^T) given).
  ring.
Qed.
"""

import re
from itertools import accumulate

import sympy as sp

from .algebra import Blocks, Traces, beside
from .families import sums
from .proofs import Proof
from .statements import read

TAKEN = (  # words of Coq, and names that the proofs use
    "i j Scalar as at by else end exists fix for forall fun if in is let match of "
    "return then where with Prop Set Type"
).split()
HEAD = """\
From matrixproof Require Import words.
Section Page.
Variable Scalar : numFieldType.
Add Field scalars : (numbers Scalar).
"""
TAIL = "End Page.\n"


class NotWritten(Exception):
    """A proof that has no lemma; the message says why."""


def lemma(name: str, proof: Proof) -> str:
    """The lemma of a proof, and its proof, in Coq.

    Raises
    ------
    NotWritten
        A number in it is no rational function of letters, it has a sum over an index,
        or the certificate rests on p q = c I having q p = c I.
    """
    numbers = (c for _, terms in proof.statement.every_side for c in terms.values())
    if any(sums(c) for c in numbers):
        raise NotWritten("it has a sum over an index")
    said = f"{proof.left} = {proof.right}".replace("*)", "* )").replace("(*", "( *")
    return f"(* {said} *)\n" + Writer(proof).lemma(name)


class Writer:
    """Names of the letters of one proof, and formulas with them."""

    def __init__(self, proof):
        self.proof, self.statement = proof, proof.statement
        told = proof.left, proof.right, proof.given, proof.symmetric
        self.free = read(*told)[1]
        self.names = {}  # ("letter", its name in the statement): its name in Coq, ...
        self.apart = {}  # what is divided by: (name of the hypothesis, formula)
        self.cited = {}  # (kind, key) of a fact: (name of the hypothesis, formula)
        self.sizes = sp.Tuple(*self.statement.sizes.values()).atoms(sp.Symbol)

    def named(self, kind, key, wanted):
        """The name of a thing; one of its own, that is a word of Coq's alphabet."""
        if (kind, key) not in self.names:
            wanted = re.sub(r"\W+", "_", wanted, flags=re.ASCII).strip("_")
            wanted = name = wanted if wanted[:1].isalpha() else f"x{wanted}"
            taken, k = {*TAKEN, *self.names.values()}, 1
            while name in taken:
                k += 1
                name = f"{wanted}_{k}"
            self.names[kind, key] = name
        return self.names[kind, key]

    # -- sizes and numbers ------------------------------------------------------------

    def size(self, d):
        """A size: a sum stays one; what may be negative has a letter of its own."""
        d = sp.expand(d)
        terms = sp.Add.make_args(d)
        if d.is_Integer:
            return str(d)
        if len(terms) > 1 and all(x.is_Symbol or x.is_Integer and x > 0 for x in terms):
            return " + ".join(map(self.size, terms))
        return self.named("size", d, str(d).replace("-", "minus ").replace("+", "plus"))

    def kind(self, shape):
        return f"'M[Scalar]_({self.size(shape[0])}, {self.size(shape[1])})"

    def number(self, c):
        """A rational function of letters that are numbers, and of sizes."""
        c = sp.sympify(c)
        if c.is_Integer and c >= 0:
            return f"{c}%:R" if c > 1 else str(c)
        if c.is_Integer:
            return f"- {self.number(-c)}"
        if c.is_Symbol:
            size = c in self.sizes
            return f"{self.size(c)}%:R" if size else self.named("number", c, c.name)
        if c.is_Rational:
            return f"{bracketed(self.number(c.p))} / {self.divisor(sp.Integer(c.q))}"
        if c.is_Add or c.is_Mul:
            sign = " + " if c.is_Add else " * "
            return sign.join(bracketed(self.number(x)) for x in c.args)
        if c.is_Pow and c.exp.is_Integer:
            base = self.divisor(c.base) if c.exp < 0 else bracketed(self.number(c.base))
            power = f"({base} ^+ {abs(c.exp)})" if abs(c.exp) > 1 else base
            return f"{power}^-1" if c.exp < 0 else power
        raise NotWritten(f"{c} is no rational function of letters")

    def divisor(self, base):
        if base not in self.apart:
            name = self.named("nonzero", base, "nonzero")
            self.apart[base] = name, self.number(base)
        return bracketed(self.number(base))

    # -- words and sums ---------------------------------------------------------------

    def letter(self, letter):
        name, transposed = letter
        wanted = "inverse" if name[0] == "(" else name.replace("^-1", "_inverse")
        return self.named("letter", name, wanted) + "^T" * transposed

    def word(self, word):
        return " *m ".join(map(self.letter, word)) or "1%:M"

    def total(self, terms):
        """The sum of (coefficient, formula) pairs."""
        found = ""
        for c, formula in terms:
            minus = sp.sympify(c).could_extract_minus_sign()
            c = -c if minus else c
            if minus or c != 1:
                formula = bracketed(formula)
            if c != 1:
                formula = f"{bracketed(self.number(c))} *: {formula}"
                formula = f"({formula})" if minus else formula
            if found and not minus and formula.startswith("- "):
                minus, formula = True, formula[2:]
            front = (" - " if minus else " + ") if found else "- " if minus else ""
            found += front + formula
        return found

    def plain(self, value):
        """What has been multiplied out: words with coefficients."""
        return self.side(self.free.side(value))

    def side(self, side):
        shape, terms = side
        found = self.total([(c, self.word(w)) for w, c in terms.items()])
        return found or f"(0 : {self.kind(shape)})"

    # -- formulas as they are written, block by block ---------------------------------

    def blocks(self, expr):
        """(normal form, rows of formulas) of a matrix; one row of one without blocks.

        The normal form tells how it is partitioned.
        """
        value = self.free.normal(expr)
        plain = self.grid(value)
        found = plain
        if isinstance(expr, sp.BlockMatrix):
            found = [[self.blocks(x)[1][0][0] for x in y] for y in expr.blocks.tolist()]
        elif isinstance(expr, sp.MatAdd):
            found = self.sum(value, [self.blocks(x) for x in expr.args])
        elif isinstance(expr, sp.MatMul):
            found = self.product(expr)
        elif isinstance(expr, sp.Transpose):
            columns = zip(*self.blocks(expr.arg)[1])
            found = [[f"{bracketed(x)}^T" for x in column] for column in columns]
        same = (len(found), len(found[0])) == (len(plain), len(plain[0]))
        return value, found if same else plain  # blocks without a row are left out

    def grid(self, value):
        rows = value.entries if isinstance(value, Blocks) else [[value]]
        return [[self.plain(x) for x in row] for row in rows]

    def spread(self, value, grid, whole):
        """The blocks of what stands beside blocks: c I and 0 are partitioned alike."""
        if not isinstance(whole, Blocks) or isinstance(value, Blocks):
            return grid
        return self.grid(Blocks.spread(value, whole.rows, whole.cols))

    def sum(self, whole, parts):
        grids = [self.spread(*part, whole) for part in parts]
        return [
            [self.total([(1, x) for x in cell]) for cell in zip(*rows)]
            for rows in zip(*grids)
        ]

    def product(self, expr):
        numbers = [x for x in expr.args if not x.is_Matrix]
        first, *others = (self.blocks(x) for x in expr.args if x.is_Matrix)
        for second in others:
            first = self.fitted(first, second, 0), self.fitted(second, first, 1)
            (one, before), (two, behind) = first
            first = (
                one @ two,
                [
                    [
                        self.total([(1, times(*pair)) for pair in zip(row, column)])
                        for column in zip(*behind)
                    ]
                    for row in before
                ],
            )
        c = sp.Mul(*numbers)
        return [[self.total([(c, x)]) for x in row] for row in first[1]]

    def fitted(self, part, other, axis):
        """A factor in blocks where the one beside it is."""
        (value, grid), whole = part, other[0]
        if not isinstance(whole, Blocks) or isinstance(value, Blocks):
            return part
        value = beside(value, (whole.cols if axis else whole.rows), axis)
        single = len(value.rows) == len(value.cols) == 1
        return value, grid if single else self.grid(value)

    def trace(self, formula):
        return f"\\tr {bracketed(formula)}"

    def scalar(self, expr):
        """A sum of numbers and of traces."""
        expr = sp.sympify(expr)
        if expr.is_Add:
            return " + ".join(map(self.scalar, expr.args))
        inside = [x for x in sp.Mul.make_args(expr) if x.has(sp.Trace)]
        if not inside:
            return bracketed(self.number(expr))
        if isinstance(inside[0], sp.Trace):
            value, grid = self.blocks(inside[0].arg)
            parts = [grid[k][k] for k in range(len(grid))]
            sizes = value.rows if isinstance(value, Blocks) else value.shape
            found = " + ".join(
                self.trace(f"{x} : {self.kind((d, d))}" if "1%:M" in x else x)
                for x, d in zip(parts, sizes)
            )
        else:
            found = self.scalar(inside[0])
        c = expr / inside[0]
        return found if c == 1 else f"{bracketed(self.number(c))} * ({found})"

    def equations(self, left, right):
        """An equation as it is written: a formula for each block."""
        value = self.free.normal(left)
        if isinstance(value, Traces):
            return [f"{self.scalar(left)} = {self.scalar(right)} :> Scalar"]
        nothing = isinstance(right, int) and right == 0
        both = [
            self.blocks(left),
            (0 * value, self.grid(0 * value)) if nothing else self.blocks(right),
        ]
        whole = next((x for x, _ in both if isinstance(x, Blocks)), value)
        grids = [self.spread(*side, whole) for side in both]
        parted = isinstance(whole, Blocks)
        rows = whole.rows if parted else whole.shape[:1]
        columns = whole.cols if parted else whole.shape[1:]
        return [
            f"{x} = {y} :> {self.kind((d, e))}"
            for d, *row in zip(rows, *grids)
            for e, x, y in zip(columns, *row)
        ]

    # -- the certificate --------------------------------------------------------------

    def fact(self, kind, key):
        """What shows l = r: a lemma of `words.v`, or a hypothesis."""
        if kind == "number":
            rule = "numbers_commute" if key[1] else "number_turned"
            return f"({rule} {' '.join(f'({self.word(x)})' for x in key if x)})"
        if (kind, key) not in self.cited:
            if kind == "given":
                formula, divided = self.given[key]
                self.apart |= divided
            elif kind == "symmetric":
                formula = f"{self.letter((key, True))} = {self.letter((key, False))}"
            elif kind in ("right inverse", "left inverse"):
                base = self.side(self.statement.inverses[key])
                y = self.letter((key, False))
                pair = (base, y) if kind == "right inverse" else (y, base)
                formula = f"{times(*pair)} = 1%:M"
            else:
                raise NotWritten("it rests on q p = c I, where p q = c I is proved")
            name = self.named(kind, key, kind)
            self.cited[kind, key] = name, formula
        return self.cited[kind, key][0]

    def term(self, trace, c, u, fact, v):
        """The step of a proof for one term of the certificate."""
        kind, key, transposed = fact
        if kind == "cyclic":
            known = f"(cyclic ({self.word(u)}) ({self.word(v)}))"
        elif kind == "turned":
            known = f"(trace_turned ({self.word(u)}))"
        else:
            known = self.fact(kind, key)
            known = f"(turned {known})" if transposed else known
            number = kind == "given" and self.statement.given[key][0][0] is None
            if trace and not number or u or v:
                around = f"({self.word(u)}) ({self.word(v)})"
                known = f"({'trace_' * trace}around {around} {known})"
        step = "trace_term_of" if trace else "term_of i j"
        return f"{step} ({self.number(c)} : Scalar) {known}."

    def relations(self):
        """{name in the statement: (formula, what it divides by)} of what is given."""
        found = []
        for relation in self.proof.given:
            self.apart = {}
            formulas = self.equations(relation.left, relation.right)
            found += [(formula, self.apart) for formula in formulas]
        self.apart = {}
        names = [*self.statement.given]
        for name in names[len(found) :]:  # the blocks of an inverse
            left, right = self.statement.given[name]
            sides = f"{self.side(left)} = {self.side(right)}"
            found.append((f"{sides} :> {self.kind(left[0])}", {}))
        return dict(zip(names, found))

    def lemma(self, name):
        """All of it: letters, hypotheses, claim and proof."""
        self.given = self.relations()
        claims = self.equations(self.proof.left, self.proof.right)
        proofs = []
        for claim, terms in self.proof.certificates.items():
            trace = self.statement.sides(claim)[0][0] is None
            start = "trace_of." if trace else "entry_of i j."
            proofs.append([start, *(self.term(trace, *term) for term in terms)])
        known = self.apart.items()
        zero = [
            f"have {x} : {f} != 0 :> Scalar by rewrite pnatr_eq0."
            for c, (x, f) in known
            if c.is_Integer
        ]
        end = "field; repeat split; nonzero." if known else "ring."
        bodies = ["\n  ".join([*zero, *steps, end]) for steps in proofs]
        body = f"  {bodies[0]}"
        if len(bodies) > 1:
            body = "\n".join(["  repeat apply: conj.", *(f"- {x}" for x in bodies)])
        supposed = [
            f"{x} : {f} != 0 :> Scalar" for c, (x, f) in known if not c.is_Integer
        ]
        supposed += [f"{x} : {formula}" for x, formula in self.cited.values()]
        head = [*self.binders(" ".join([*supposed, *claims, body])), *supposed]
        first = "\n  ".join([f"Lemma {name}", *(f"({x})" for x in head)])
        goal = " /\\\n  ".join(claims)
        return f"{first} :\n  {goal}.\nProof.\n{body}\nQed."

    def binders(self, text):
        """The letters that occur, with what they are; those of one kind together."""
        atoms = {name: atom for (atom, _), name in self.free.names.items()}
        used, letters = set(re.findall(r"\w+", text)), {}
        for (what, key), name in [*self.names.items()]:
            if what == "letter" and name in used:
                letters.setdefault(self.kind(atoms[key].shape), []).append(name)
        used |= set(re.findall(r"\w+", " ".join(letters)))
        found = []
        for what, kind in (("size", "nat"), ("number", "Scalar")):
            names = sorted(
                x for (w, _), x in self.names.items() if w == what and x in used
            )
            found += [f"{' '.join(names)} : {kind}"] if names else []
        return [
            *found,
            *(f"{' '.join(names)} : {kind}" for kind, names in letters.items()),
        ]


def bracketed(formula):
    """A formula as a factor; one that is a word of a letter or in brackets stays."""
    depths = [*accumulate((x == "(") - (x == ")") for x in formula)]
    closed = formula[0] == "(" and 0 not in depths[:-1]
    return formula if closed or " " not in formula else f"({formula})"


def times(first, second):
    """A product; one of letters needs no brackets on the left."""
    single = all(x == "*m" or x[0].isalnum() for x in first.split())
    return f"{first if single else bracketed(first)} *m {bracketed(second)}"
