"""Certificates as lemmas of Coq: what they say, and that Coq refuses damaged ones."""

import shutil
import subprocess
from importlib.resources import files

import pytest
from sympy import Symbol, Trace, sqrt

from matrixproof import BlockMatrix, Identity, Relation, letters, prove
from matrixproof.coq import HEAD, TAIL, NotWritten, lemma

A, B, M, S, x, y, H = letters("A:n*n B:n*n M:n*n S:n*n= x:n y:n H:p*n")
n = A.shape[0]
one = Identity(n)
s, t = Symbol("s", positive=True), Symbol("t")
grid = BlockMatrix([[A, one], [0 * A, B]])
squared = BlockMatrix([[A * A.T + one, B.T], [B, B * B.T]])
given = Relation("M A' = B'", M * A.T, B.T)
inverse = Relation("A M = I", A * M, one)

PROVED = {
    "inverses": prove((one + A * B).I * A, A * (one + B * A).I),
    "a relation, transposed": prove(A * M.T * H.T, B * H.T, [given]),
    "symmetric": prove((A * S * A.T).T, A * S * A.T, symmetric=[S]),
    "blocks": prove(grid * grid.T, squared),
    "traces": prove(Trace(A * S * B), Trace(B.T * S * A.T), symmetric=[S]),
    "a trace of sizes": prove(Trace(M * A), Trace(one), [inverse]),
    "a size": prove(n, Trace(A * M), [inverse]),
    "numbers": prove(s * (A + B / s) - t**2 * A, (s - t * t) * A + B),
    "halves": prove((A + A.T) / 2 + (A - A.T) / 2, A),
    "1 x 1": prove(x.T * y * (y.T * x), (y.T * x) * (x.T * y)),
}
# of the lemma or of its proof: what stands there, and what is put in its place
DAMAGED = {
    ("inverses", "inverse *m A = A", "inverse *m A = - A"),
    ("inverses", "inverse *m A = A *m inverse_2", "inverse *m A = inverse_2 *m A"),
    ("inverses", "(1%:M + B *m A) *m inverse_2", "(1%:M + A *m B) *m inverse_2"),
    ("inverses", "(- 1 : Scalar)", "(1 : Scalar)"),
    ("inverses", "around (inverse *m A) (1%:M)", "around (1%:M) (inverse *m A)"),
    ("a relation, transposed", "= B *m H^T", "= B^T *m H^T"),
    ("a relation, transposed", "(turned given)", "given"),
    ("symmetric", "S^T = S", "S^T = - S"),
    ("blocks", "1%:M *m B^T = B^T", "1%:M *m B^T = - B^T"),
    ("blocks", "B *m 1%:M = B", "B *m 1%:M = B^T"),
    ("traces", "B^T *m S *m A^T) :>", "S *m B^T *m A^T) :>"),
    ("a trace of sizes", "1%:M : 'M[Scalar]_(n, n)) :>", "M) :>"),
    ("numbers", "- ((t ^+ 2) *: A)", "+ ((t ^+ 2) *: A)"),
    ("numbers", "(nonzero : s != 0 :> Scalar)", "(nonzero : t != 0 :> Scalar)"),
    ("halves", "A - A^T", "A + A^T"),
    ("1 x 1", "y^T *m x *m x^T *m y", "y^T *m y *m x^T *m x"),
}


def test_a_lemma_supposes_what_its_certificate_cites_and_nothing_else():
    idle = Relation("B A = M", B * A, M)
    told = lemma("told", prove(A * M * A.T, A.T, [inverse, idle], symmetric=[S]))
    assert told.count("given") == 2 and "A *m M = 1%:M" in told
    assert "B" not in told.partition("Lemma")[2] and "symmetric" not in told


def test_names_are_words_of_coq_and_each_thing_has_its_own():
    i, word, up, down = letters("i:n*n forall:n*n X+:n*n X-:n*n")
    told = lemma("told", prove(i * (word + up) * down, i * up * down + i * word * down))
    declared = told.partition(": 'M[Scalar]_(n, n))")[0].rpartition("(")[2].split()
    assert sorted(declared) == ["X", "X_2", "forall_2", "i_2"]


def test_a_star_before_a_bracket_ends_no_comment():
    u, v = letters("u^*:n*n v^*:n*n")
    said = lemma("told", prove((v - u) * u, v * u - u * u)).partition("Lemma")[0]
    assert said.count("*)") == said.count("(*") == 1


def test_a_number_that_is_no_rational_function_is_not_written():
    proof = prove(sqrt(s) * (A + B), sqrt(s) * B + sqrt(s) * A)
    with pytest.raises(NotWritten, match=r"sqrt\(s\) is no rational function"):
        lemma("told", proof)


def test_a_sum_over_an_index_is_no_number_and_not_written():
    sum_i, A_i = letters("sum_i A_i:n*n")
    with pytest.raises(NotWritten, match="a sum over an index"):
        lemma("told", prove(B * (sum_i * A_i), sum_i * B * A_i))


@pytest.fixture(scope="module")
def refused(tmp_path_factory):
    """What Coq says against lemmas; empty where it accepts them."""
    if shutil.which("coqc") is None:
        pytest.skip("coqc is not installed (on Debian: coq, libcoq-mathcomp-algebra)")
    folder = tmp_path_factory.mktemp("coq")
    tactics = files("matrixproof").joinpath("words.v").read_text("utf-8")

    def run(name, text):
        (folder / f"{name}.v").write_text(text, encoding="utf-8")
        call = ["coqc", "-w", "none", "-Q", ".", "matrixproof", f"{name}.v"]
        return subprocess.run(call, cwd=folder, capture_output=True, text=True).stderr

    said = run("words", tactics)
    if "mathcomp" in said and "Cannot find" in said:
        pytest.skip("MathComp is not installed (on Debian: libcoq-mathcomp-algebra)")
    assert said == ""
    return lambda *lemmas: run("page", "\n\n".join([HEAD, *lemmas, TAIL]))


def test_coq_accepts_every_kind_of_proof(refused):
    told = [lemma(f"proof_{k}", proof) for k, proof in enumerate(PROVED.values())]
    assert refused(*told) == ""


@pytest.mark.parametrize(("kind", "right", "wrong"), sorted(DAMAGED))
def test_coq_refuses_a_damaged_one(kind, right, wrong, refused):
    told = lemma("proof", PROVED[kind])
    assert told.count(right) == 1, told
    said = refused(told.replace(right, wrong))
    assert "Error" in said and "Syntax error" not in said


def test_coq_refuses_what_does_not_follow_without_a_hypothesis(refused):
    told = lemma("proof", PROVED["symmetric"])
    lines = [line for line in told.splitlines() if "symmetric" not in line]
    lines[lines.index("  (A S : 'M[Scalar]_(n, n))")] += " :"
    assert "not a valid ring equation" in refused("\n".join(lines))
