"""What is lowered for the printers is kept, and the next process reads it back."""

import numpy as np
import pytest

import luenberger as lb
from luenberger import kernels
from luenberger.kernels import lowering
from luenberger.kernels.program import Factor
from luenberger.papers.leondes_novak.derivation import (
    complete_sample,
    observer_step,
)

STATES = ("x", "Sigma", "x_minus_next", "Omega_next")
TESTED = [Factor("Sigma", 0.0, "Omega", True)]
QUESTIONS = {
    "zeros": (observer_step, ["w_hat", "z_next"], dict(zero=["G", "W"])),
    "symmetry": (observer_step, ["w_hat"], dict(symmetric=["V"])),
    "pivots": (complete_sample, STATES, dict(definite=TESTED, same=[("As", "A")])),
}


@pytest.fixture
def forget(tmp_path, monkeypatch):
    """Begin as a new process does, in a folder of its own."""
    monkeypatch.setenv("LUENBERGER_CACHE", str(tmp_path))
    forget = kernels.program_of.cache_clear
    forget()
    yield forget
    forget()


@pytest.mark.parametrize("stages, outputs, options", QUESTIONS.values(), ids=QUESTIONS)
def test_what_is_kept_is_what_was_lowered(
    forget, monkeypatch, stages, outputs, options
):
    wanted = lowering.lower(stages(), outputs, **options)
    assert kernels.lowered(stages, outputs, **options) == wanted
    forget()
    monkeypatch.delattr(lowering, "lower")
    assert kernels.lowered(stages, outputs, **options) == wanted


def test_each_question_has_its_own_answer(forget):
    """What vanishes, what is symmetric and what is wanted are all asked for."""
    asked = [
        (["w_hat", "z_next"], {}),
        (["w_hat"], {}),
        (["w_hat"], dict(zero=["V"])),
        (["w_hat"], dict(symmetric=["V"])),
    ]
    found = [kernels.lowered(observer_step, one, **more) for one, more in asked]
    assert all(a != b for k, a in enumerate(found) for b in found[:k])
    forget()
    again = [kernels.lowered(observer_step, one, **more) for one, more in asked]
    assert again == found


def test_counts_of_multiply_adds_come_without_deriving(forget, monkeypatch):
    observer = lb.Observer(
        [[0.5]], [[1]], [[2]], [[0], [1]], [[1], [2]], T=[[-2, 1]], L=np.eye(2)
    )
    assert lb.multiply_adds(observer) == 5
    forget()
    monkeypatch.delattr(lowering, "lower")
    assert lb.multiply_adds(observer) == 5
