"""Stage lists entry by entry, and in the C that a device runs: what they compute."""

import re
from fractions import Fraction

import numpy as np
import pytest
import sympy as sp
from exact_stages import SIZES, exact_inputs, exact_step

from luenberger import Observer
from luenberger.analysis.step_cost import MATRICES, SUMS, counts
from luenberger.kernels.c.file import File
from luenberger.kernels.c.step import write_step
from luenberger.kernels.c.writer import C
from luenberger.kernels.traced import traced
from luenberger.papers.leondes_novak.derivation import (
    error_recursion,
    gain_step,
    observer_matrices,
    observer_step,
)
from luenberger.papers.moore.derivation import companion_row


def exactly(found, given, names):
    """The statements in rational arithmetic: the matrices that have these names."""
    space = {e: given[name][k] for e, (name, k) in found.given.items()}
    for symbol, e in found.statements:
        space[symbol] = sp.nsimplify(e.subs(space), rational=True)

    def value(e):
        return space[e] if isinstance(e, sp.Symbol) else sp.Rational(e)

    return {
        k: sp.Matrix([[*map(value, row)] for row in found.entries[k]]) for k in names
    }


@pytest.mark.parametrize(
    "stages", [error_recursion, observer_matrices, observer_step, companion_row]
)
def test_scalars_are_those_of_the_stages(stages, monkeypatch):
    for name, size in dict(k=1, q=3).items():
        monkeypatch.setitem(SIZES, name, size)
    derivation = stages()
    given = exact_inputs(derivation, np.random.default_rng(8))
    wanted = exact_step(derivation, given)
    assert exactly(traced(derivation, list(wanted), SIZES), given, wanted) == wanted


def test_what_is_known_drops_out_and_changes_nothing():
    derivation, rng = error_recursion(), np.random.default_rng(2)
    given = exact_inputs(derivation, rng)
    given["F"] = sp.Matrix([[0, 1, 0], [0, 0, -1], [0, 0, 0]])
    given["D"], given["P"] = sp.zeros(3, 2), sp.eye(4)[:, :3]
    wanted = exact_step(derivation, given)
    known = {k: np.array(given[k].tolist(), float).tolist() for k in "FDP"}
    lean = traced(derivation, list(wanted), SIZES, known)
    assert exactly(lean, given, wanted) == wanted
    whole = traced(derivation, list(wanted), SIZES)
    assert len(lean.statements) < len(whole.statements) / 2
    assert {"R", "S"} & {name for name, _ in lean.given.values()} == {"R"}


def test_a_solve_has_no_scalars():
    with pytest.raises(TypeError, match="Kmv is solved for"):
        traced(gain_step(), ["K"], SIZES)


def observers():
    """Sparse and dense, with copies, minus ones, equal rows and rows of zeros."""
    rng = np.random.default_rng(5)
    values = np.array([0, 0, 0, 1, 1, -1, 0.5, -2])
    for r, p, m, q in [(0, 2, 1, 3), (1, 1, 0, 2), (3, 2, 2, 4), (20, 3, 2, 20)] * 3:
        shapes = dict(F=(r, r), G=(r, m), D=(r, p), P=(q, r), V=(q, p), W=(q, m))
        made = {k: rng.choice(values, size=shape) for k, shape in shapes.items()}
        if q > 2:
            for k in "PVW":
                made[k][1] = made[k][0]
        yield Observer(**made, T=np.zeros((r, 2)), L=np.zeros((q, 2)), dt=1.0)


class Counted(Fraction):
    """A number that counts the operations that it takes part in."""

    done = 0


def counted(name):
    def method(self, other):
        Counted.done += 1
        return Counted(getattr(Fraction, name)(self, Fraction(other)))

    return method


for name in ("add", "sub", "mul"):
    for one in (f"__{name}__", f"__r{name}__"):
        setattr(Counted, one, counted(one))
Counted.__neg__ = lambda self: Counted(Fraction.__neg__(self))


def in_python(lines):
    """C of a step as Python: its loops, sums and products are written alike."""
    out = []
    for line in lines:
        line = re.sub(r"^( *)(?:const )?double (\w+)(?!\w|\[)", r"\1\2", line)
        line = re.sub(r"^( *)double (\w+)\[(\d+)\];", r"\1\2 = [None] * \3", line)
        head = r"for \(int (\w) = 0; \w < (\d+); \w\+\+\) {"
        line = re.sub(head, r"for \1 in range(\2):", line).replace("state->z", "z")
        if line.strip() != "}" and "//" not in line:
            out.append(line.rstrip(";"))
    return "\n".join(out)


@pytest.mark.parametrize("scalars", [True, False])
def test_the_step_of_an_observer_and_what_it_costs(scalars):
    rng = np.random.default_rng(6)
    for observer in observers():
        to, file, (q, r) = C("double"), File("unit", "double"), observer.P.shape
        matrices = {k: getattr(observer, k) for k in MATRICES}
        sizes = dict(q=q, r=r, p=observer.D.shape[1], m=observer.G.shape[1])
        places = {"z": "state->z"}, {"w_hat": "what", "z_next": "moved"}
        write_step(observer_step(), sizes, matrices, file, to, *places, scalars=scalars)
        z, y, u = (
            [Counted(int(k), 3) for k in rng.integers(-9, 9, size=size)]
            for size in (r, sizes["p"], sizes["m"])
        )
        space = {k: [Counted(x) for x in X.ravel()] for k, X in file.tables.items()}
        space |= dict(z=z[:], y=y, u=u, what=[None] * q, moved=[None] * r)
        x = [np.array(one, dtype=object) for one in (z, y, u)]
        w, z_next = (
            sum(getattr(observer, k) @ v for k, v in zip(matrices, x))
            for matrices in ("PVW", "FDG")
        )
        Counted.done = 0
        exec("if True:\n" + (in_python(to.lines) or "    pass"), space)
        assert space["what"] == w.tolist() and space["moved"] == z_next.tolist()
        found = counts(observer)
        if all(one.scalars == scalars for one in found.values()):
            done = sum(one.operations for one in found.values())
            for own, _ in SUMS.values():  # what is tested to be finite
                first, *rest = (getattr(observer, k) for k in own)
                done -= len(first) + sum(X.shape[1] for X in rest if X.any())
            assert done == Counted.done
