"""What reads formulas back: the same equation is known in any dress, another is not."""

import pytest
from entries import numbers
from formulas import equation, letters, parts, side

SAME = [
    ("z₊ = F z + G u", "G u + F z = z₊"),
    ("A (B + C) = D", "D = A B + A C"),
    ("(A B)' = C", "C' = A B"),
    ("-A = B C", "A = -B C"),
    ("tr(A B) = 1", "tr(B A) = 1"),
    ("E[v + w] = 0", "E[w] + E[v] = 0"),
    ("K M⁻¹ M = K", "K = K"),
    ("A² = B", "A A = B"),
    ("a ≤ b", "b ≥ a"),
    ("T = [-K₁  I - K₂ H₂]", "T = [-K₁  -K₂ H₂ + I]"),
    ("Σ[j = 0 .. n] j = n", "Σ[j=0..n] j = n"),
]
OTHER = [
    ("z₊ = F z + G u", "z₊ = F z - G u"),
    ("A B = C", "B A = C"),
    ("A' = B", "A = B"),
    ("a ≥ b", "b ≥ a"),
    ("a ≥ b", "a = b"),
    ("T = [K  I]", "T = [K; I]"),
    ("tr(A B) = 1", "tr(A B') = 1"),
    ("det(A) = b", "det(A) = -b"),
    ("T A - F T = D C", "T A = F T + D C"),  # said as it is proved
]


def read(string):
    (part,) = parts(string)
    return equation(*part)[0]


@pytest.mark.parametrize(("one", "other"), SAME)
def test_the_same_equation_is_known(one, other):
    assert read(one) == read(other)


@pytest.mark.parametrize(("one", "other"), OTHER)
def test_another_equation_is_another(one, other):
    assert read(one) != read(other)


def test_symmetric_letters_are_their_transposes():
    assert side("A Σ' A'", ["Σ"]) == side("A Σ A'", ["Σ"]) != side("A Σ' A'")


def test_letters_and_numbers_are_found():
    assert letters("x̂₊ = A x̂ + K_mv (y₊ - I x₋)") == {
        *("x̂₊", "A", "x̂", "K_mv", "y₊", "x₋")
    }
    assert parts("a = b = c") == [("a", "=", "b"), ("b", "=", "c")]
    assert numbers("(41–43, remark 2(a)) words") == {"41", "42", "43", "remark 2(a)"}
    assert numbers("(3.10') words") == {"3.10'"} and numbers("words") == set()
