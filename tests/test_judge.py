"""The judge agrees with other oracles, and notices what is wrong."""

import json
from collections import Counter
from dataclasses import replace

import exact_filter
import numpy as np
import pytest
from exact_smoother import Batch, floats
from judge import adapter, checkout, exact, oracle, problems

SEEDS = range(300)
HARD = (  # each needs a line of its own, where it says why
    849,  # a row of R that repeats another one, to rounding
    1926,  # noises of outputs that cancel in a combination
    2490,  # what a state was made of two rows before
    3338,  # rounding of an innovation, which moves a noise
    9978,  # a reading less E u
    19963,  # a variance divided by that of an unknown start
)


def verdicts(seeds):
    """How often each column was counted, and the lines on what is bad."""
    results = [exact.one(seed) for seed in seeds]
    _, bad = exact.table(results)
    return Counter(c for *_, all_ in results for one in all_ for c in one.columns), bad


def test_the_library_is_right_on_problems_of_every_kind():
    """Twenty thousand more by `python tests/support/judge exact`."""
    found, bad = verdicts([*SEEDS, *HARD])
    assert bad == []
    assert found["calls"] > 1400 and found["contradictions"] > 200


# -- the oracle beside two that share no formula with it ------------------------------


def constant(seed):
    """A problem that the other oracles take, and its model as they read it."""
    p = replace(problems.problem(seed), product=False, arrival=None)
    zero = exact_filter.zeros(len(p.x0), len(p.C[0]))
    simple = not p.varying and p.u.shape[1] == 0
    W, H = p.W[0], p.H[0]
    S = W @ H.T if "S" in p.kinds else zero
    return (
        simple,
        p,
        exact_filter.Model(
            p.A[0],
            p.B[0],
            p.C[0],
            p.E[0],
            W @ W.T,
            H @ H.T,
            S,
            p.start @ p.start.T,
            p.x0,
        ),
    )


def test_the_oracle_is_the_recursion_in_rational_arithmetic():
    done = Counter()
    for seed in range(120):
        simple, p, model = constant(seed)
        if not simple:
            continue
        wanted = exact_filter.run(model, p.y, accurate=p.accurate, prior=p.prior)
        x, P = oracle.accurate(p)[:2] if p.accurate else oracle.answer(p)[:2]
        for found, of in zip((x, P), exact_filter.as_floats(wanted)):
            np.testing.assert_allclose(found, of, rtol=1e-14, atol=0)
        done[bool(p.accurate)] += 1
    assert min(done[True], done[False]) > 5


def test_the_oracle_smooths_as_one_batch_of_least_squares():
    done = 0
    for seed in range(60):
        simple, p, _ = constant(seed)
        if not simple or {"units 2^-30 to 2^30", "long gap"} & set(p.kinds):
            continue
        matrices, given = p.matrices()
        if any((exact_filter.rational(X) != Y).any() for X, Y in
               zip((*matrices, given["P0"]), (p.A[0], p.B[0], p.C[0], p.E[0],
                                              p.start @ p.start.T))):  # fmt: skip
            continue  # tenths are not what their floats are
        wanted = Batch(adapter.plant(*matrices, **given), p.y).smooth()
        found = oracle.answer(p)
        np.testing.assert_allclose(found.smooth_x, floats(wanted[0]), rtol=1e-13)
        np.testing.assert_allclose(found.smooth_P, floats(wanted[1]), rtol=1e-13)
        done += 1
    assert done > 5


# -- faults that the judge must notice ------------------------------------------------


def off_by(path, part):
    """A call of the adapter whose answer is off by a part of a deviation."""
    right = getattr(adapter, path)

    def moved(*args, **options):
        if path == "log_likelihood":
            return right(*args, **options) + part
        x, P = right(*args, **options)
        std = np.sqrt(np.einsum("kii->ki", P))
        return x + part * std, P

    return moved


def looser(path, part):
    """A call of the adapter whose covariance is a little too large."""
    right = getattr(adapter, path)

    def moved(*args, **options):
        x, P = right(*args, **options)
        return x, P * (1 + part)

    return moved


@pytest.mark.parametrize("path", ["filtered", "smoothed", "log_likelihood"])
def test_a_number_that_is_a_little_off_is_wrong(path, monkeypatch):
    monkeypatch.setattr(adapter, path, off_by(path, 1e-6))
    found, bad = verdicts(range(30))
    assert found["wrong"] > 5 and "wrong" in bad[0] and "--seed" in bad[0]


@pytest.mark.parametrize("path", ["filtered", "smoothed"])
def test_a_covariance_that_is_a_little_off_is_wrong(path, monkeypatch):
    monkeypatch.setattr(adapter, path, looser(path, 1e-6))
    assert verdicts(range(20))[0]["wrong"] > 5


def test_a_contradiction_that_is_not_told_is_missed(monkeypatch):
    right = adapter.filtered

    def silent(plant, y, *args, **options):
        try:
            return right(plant, y, *args, **options)
        except adapter.Refused:
            return np.zeros((len(y), plant.n)), np.zeros((len(y), plant.n, plant.n))

    monkeypatch.setattr(adapter, "filtered", silent)
    found, bad = verdicts(range(20))
    assert found["missed"] > 3 and any("missed: filter" in line for line in bad)


def test_a_refusal_without_a_reason_is_false(monkeypatch):
    def never(*args, **options):
        raise adapter.Refused(
            "at instant 1 the noise-free outputs ['y1'] contradict each other"
        )

    monkeypatch.setattr(adapter, "filtered", never)
    found, _ = verdicts(range(20))
    assert found["falsely refused"] >= 20 and found["misnamed"] > 0


@pytest.mark.parametrize("reason", ["digits", "undetermined"])
def test_other_refusals_are_for_other_problems(reason, monkeypatch):
    def never(*args, **options):
        raise adapter.Refused(reason)

    monkeypatch.setattr(adapter, "reason", str)
    monkeypatch.setattr(adapter, "log_likelihood", never)
    found, bad = verdicts(range(40))
    assert found["falsely refused"] > 30 and bool(found["lost digits"]) == (
        reason == "digits"
    )


def test_an_output_that_contradicts_nothing_is_misnamed(monkeypatch):
    right = adapter.where

    def others(error):
        instant, names = right(error)
        return instant, {j + 1 for j in names}

    monkeypatch.setattr(adapter, "where", others)
    assert verdicts(range(20))[0]["misnamed"] > 3
    monkeypatch.setattr(adapter, "where", lambda error: (1 + right(error)[0], {0}))
    assert verdicts(range(20))[0]["misnamed"] > 3


def test_an_error_that_is_no_refusal_is_wrong(monkeypatch):
    monkeypatch.setattr(adapter, "smoothed", lambda *args, **options: 1 / 0)
    found, bad = verdicts([0])
    assert found["wrong"] == 1 and "ZeroDivisionError" in bad[0]


# -- beside an older checkout ---------------------------------------------------------


def notebook(*outputs):
    cells = [
        {"id": name, "cell_type": "code", "execution_count": 3,
         "outputs": [{"text": text, "output_type": "stream", "execution_count": 7}]}
        for name, text in outputs
    ]  # fmt: skip
    return json.dumps({"cells": cells})


def test_a_notebook_is_compared_by_what_its_cells_show():
    old = notebook(("a", "1"), ("b", "2"))
    assert checkout.differing(old, old.replace(": 3", ": 4")) == ""
    found = checkout.differing(old, notebook(("a", "1.1"), ("c", "2")))
    assert found == "1 show something else, 1 are new, 1 are gone"


def test_a_ratio_is_the_median_of_turns(capsys):
    checkout.line("a row", [1.0, 2, 4], [2.0, 3, 8])
    assert "2.00  (1.75 to 2.00)" in capsys.readouterr().out
    checkout.line("a row", [1.0], [1.0], differs=0.5)
    assert "differ by 5e-01" in capsys.readouterr().out
