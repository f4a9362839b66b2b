"""The guarded short form of exported C, beside exact rationals."""

import ctypes
import shutil
import subprocess
from fractions import Fraction

import generators
import numpy as np
import pytest

import luenberger as lb
from luenberger.export import to_c
from luenberger.export.c import guard

GCC = shutil.which("gcc") or shutil.which("cc")
needs_compiler = pytest.mark.skipif(GCC is None, reason="there is no C compiler")

# one step of the short form alone, then one of the device
ALONE = """
#include <string.h>
#include "unit.c"
static int one(const REAL *Omega, const REAL *y, REAL *out, REAL *what, int all)
{
    static const REAL u[1] = {0};
    unit_state state;
    memset(&state, 0, sizeof state);
    memcpy(state.Omega, Omega, sizeof state.Omega);
    memcpy(state.Sigma, Omega, sizeof state.Omega);
    int code = all ? unit_step(&state, u, y, what) : unit_short(&state, u, y, what);
    memcpy(out, &state, sizeof state);
    return code;
}
int quick(const REAL *Omega, const REAL *y, REAL *state, REAL *what)
{ return one(Omega, y, state, what, 0); }
int whole(const REAL *Omega, const REAL *y, REAL *state, REAL *what)
{ return one(Omega, y, state, what, 1); }
int record(int N, const REAL *y, REAL *out, REAL *what)
{
    static const REAL u[1] = {0};
    unit_state state;
    int code = 0;
    unit_init(&state);
    for (int k = 0; k < N; k++)
        code |= unit_step(&state, u, y + k * unit_outputs, what + k * unit_estimates);
    memcpy(out, &state, sizeof state);
    return code;
}
"""


class Alone:
    """The export of a plant without inputs: `quick` and `whole` from any Omega."""

    def __init__(self, folder, source, dtype="double"):
        self.dtype = dtype
        self.kind = np.dtype(np.float64 if dtype == "double" else np.float32)
        self.C, self.R = (X.astype(self.kind) for X in (source.C, source.R))
        self.p, self.n = self.C.shape
        to_c(source, folder, name="unit", update="guarded", dtype=dtype)
        self.loops = "unit_larger(" in (folder / "unit.c").read_text()
        (folder / "alone.c").write_text(ALONE.replace("REAL", dtype))
        options = "-std=c99 -shared -fPIC -o".split()
        done = folder / "alone.so"
        subprocess.run([GCC, *options, done, folder / "alone.c", "-lm"], check=True)
        self.library = ctypes.CDLL(str(done))

    def call(self, name, Omega, y=None):
        """What a step from x_minus = 0 returns, its estimate, Sigma and next Omega."""
        n, y = self.n, np.zeros(self.p) if y is None else y
        Omega, y = (np.ascontiguousarray(X, self.kind) for X in (Omega, y))
        state, what = np.full(n + 2 * n * n, 7, self.kind), np.full(n, 7, self.kind)
        code = getattr(self.library, name)(*map(pointer, (Omega, y, state, what)))
        ahead, Sigma = state[n:].reshape(2, n, n)
        return code, what, Sigma, ahead

    def record(self, y):
        """Whether a step of a record was refused, the estimates, and Sigma."""
        n, N = self.n, len(y)
        state, what = np.empty(n + 2 * n * n, self.kind), np.empty((N, n), self.kind)
        code = self.library.record(N, *map(pointer, (y, state, what)))
        return code, what, state[n + n * n :].reshape(n, n)

    def gain(self, Omega):
        """The gain that the short form computes, bit by bit: x^ of unit readings."""
        columns = [self.call("quick", Omega, e)[1] for e in np.eye(self.p)]
        return np.stack(columns, axis=1)

    def bound(self, Omega, K):
        """At most so far each entry is from the covariance that the gain leaves."""
        w, r = (
            guard.MORE * np.sqrt(X.diagonal().astype(float)) for X in (Omega, self.R)
        )
        K, C = np.abs(K.astype(float)), np.abs(self.C.astype(float))
        b = w + K @ (C @ w + r)
        return guard.bound(self.n, self.p, self.dtype) * np.outer(b, b)

    def errors(self, Omega, Sigma, K):
        """Entries of Sigma less what the gain leaves, computed in rationals."""
        return np.abs(exact(Sigma) - left_by(K, self.C, Omega, self.R)).astype(float)

    def plain(self, Omega):
        """Sigma in the short form without a guard, and its gain."""
        N = Omega @ self.C.T
        K = np.linalg.lstsq(self.C @ N + self.R, N.T, rcond=None)[0].T
        return Omega - K @ N.T, K

    def lost(self, Omega):
        """Does the plain short form err by more than the guard tolerates?"""
        Sigma, K = self.plain(Omega)
        wrong = self.errors(Omega, Sigma, K).diagonal()
        return (wrong > guard.TOLERANCE[self.dtype] * Sigma.diagonal()).any()


def pointer(X):
    return X.ctypes.data_as(ctypes.c_void_p)


def plant(n=3, p=2, **options):
    """A plant without inputs; its sizes are those of C, if that is given."""
    p, n = np.shape(options.get("C", np.eye(p, n)))
    given = dict(C=np.eye(p, n), Q=np.eye(n), R=np.eye(p), P0=np.eye(n), dt=1.0)
    given |= {"A": np.eye(n) / 2 + 0.3 / n, "B": None} | options
    return lb.Plant(**given)


def exact(X):
    return np.array([Fraction(float(x)) for x in np.ravel(X)], object).reshape(X.shape)


def left_by(K, C, Omega, R):
    """The covariance that a gain leaves, in rationals."""
    K, C, Omega, R = map(exact, (K, C, Omega, R))
    Y = exact(np.eye(len(K))) - K @ C
    return Y @ Omega @ Y.T + K @ R @ K.T


def outputs(kind, n, p, rng, digits):
    """C and R: as they come, of tiny noise, in units far apart, or all but equal."""
    C, h = rng.normal(size=(p, n)), rng.normal(size=(p, p))
    R = h @ h.T + 0.1 * np.eye(p)
    if kind == "tiny noise":
        R = R * 10.0 ** -rng.uniform(digits / 2, digits)
    if kind == "units":
        D = np.diag(10.0 ** rng.uniform(-6, 6, size=p))
        C, R = D @ C, D @ R @ D
    if kind == "the same twice":
        C[1:] = C[:1] * (1 + 1e-7 * rng.normal(size=(p - 1, n)))
    return dict(C=C, R=(R + R.T) / 2)


def covariances(n, rng, count, kind):
    """Covariances of any rank and size, in units far apart, some states known."""
    for k in range(count):
        H = rng.normal(size=(n, rng.integers(1, n + 1))) * 10.0 ** rng.uniform(-3, 3)
        if k % 3 == 0:
            H *= 10.0 ** rng.uniform(-3, 3, size=(n, 1))
        if k % 4 == 0:
            H[rng.integers(n)] = 0
        X = (H @ H.T).astype(kind)
        yield np.triu(X) + np.triu(X, 1).T


SIZES = {"scalars": (3, 2), "one": (1, 1), "loops": (6, 3)}
FORMS = "short", "complete"
KINDS = "as they come", "tiny noise", "units", "the same twice"


def untouched(what, Omega, Sigma, ahead):
    assert (what == 7).all() and (Sigma == Omega).all() and (ahead == Omega).all()


@needs_compiler
@pytest.mark.parametrize("dtype", ["double", "float"])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("n, p", SIZES.values(), ids=SIZES)
def test_no_step_errs_by_more_than_its_bound(n, p, kind, dtype, tmp_path):
    rng = np.random.default_rng(1)
    digits = 12 if dtype == "double" else 5
    one = Alone(tmp_path, plant(**outputs(kind, n, p, rng, digits)), dtype)
    part, taken, lost, joseph = 0.0, 0, 0, 0
    assert one.loops == (n == 6)
    for Omega in covariances(n, rng, 24, one.kind):
        code, what, Sigma, ahead = one.call("quick", Omega)
        if code:
            lost += one.lost(Omega)
            untouched(what, Omega, Sigma, ahead)
            again, *found = one.call("whole", Omega)
            if again:  # M is singular to working precision
                untouched(found[0], Omega, *found[1:])
            joseph += not again
            continue
        taken += 1
        K = one.gain(Omega)
        wrong, bound = one.errors(Omega, Sigma, K), one.bound(Omega, K)
        root = np.sqrt(Sigma.diagonal().astype(float))
        assert (wrong <= bound).all()
        assert (bound <= 1.03 * guard.TOLERANCE[dtype] * np.outer(root, root)).all()
        assert (Sigma == Sigma.T).all()
        known = Omega.diagonal() == 0
        assert (Sigma[known] == 0).all() and (Sigma.diagonal()[~known] > 0).all()
        rest = np.ix_(~known, ~known)
        part = max(part, (wrong[rest] / bound[rest]).max(initial=0))
    if kind == "as they come":
        assert taken > (12 if dtype == "double" else 4)
        assert part > 1e-3  # the bound is no larger than it must be by far
    if kind == "tiny noise" and n > 1:
        assert lost and joseph  # what the guard is for


@needs_compiler
def test_what_the_guard_refuses_takes_the_form_for_any_gain(tmp_path):
    """A sensor that is perfect, all but: the short form has no right digit."""
    one = Alone(tmp_path, plant(C=[[1.0, 0, 0]], R=[[1e-16]]))
    Omega = np.array([[1e4, 10, 1], [10, 1, 0.1], [1, 0.1, 1]])
    assert not 0.5e-16 < one.plain(Omega)[0][0, 0] < 2e-16
    code, *found = one.call("quick", Omega, [1.0])
    assert code
    untouched(found[0], Omega, *found[1:])
    code, what, Sigma, _ = one.call("whole", Omega, [1.0])
    assert not code
    wanted = left_by(what[:, None], one.C, Omega, one.R).astype(float)
    root = np.sqrt(Omega.diagonal())
    assert (np.abs(Sigma - wanted) <= 1e-14 * np.outer(root, root)).all()
    assert what[0] == 1.0


@needs_compiler
@pytest.mark.parametrize("n, p", SIZES.values(), ids=SIZES)
def test_what_cannot_be_bounded_is_refused(n, p, tmp_path):
    """No covariance, a variance of next to nothing, not a number; zero is known."""
    one = Alone(tmp_path, plant(C=np.ones((p, n))))
    assert one.loops == (n == 6)
    assert one.call("quick", np.eye(n))[0] == 0
    assert one.call("quick", 1e-190 * np.eye(n))[0] == 0
    assert one.call("quick", 1e-210 * np.eye(n))[0]
    assert one.call("quick", np.nan * np.eye(n))[0]
    assert one.call("quick", -np.eye(n))[0]
    code, what, Sigma, _ = one.call("quick", np.zeros((n, n)), np.ones(p))
    assert code == 0 and (what == 0).all() and (Sigma == 0).all()
    for i in range(n):
        for j in range(i):
            Omega = np.eye(n)
            Omega[i, j] = Omega[j, i] = 1.01
            assert one.call("quick", Omega)[0] == 0
            Omega[i, j] = Omega[j, i] = 1.03
            assert one.call("quick", Omega)[0]


@needs_compiler
@pytest.mark.parametrize("R", [1.0, 1e-10])
@pytest.mark.parametrize("P0", [0.0, 1e6])
def test_a_tracker_over_a_record(R, P0, tmp_path):
    """Whichever form a step takes, the record is filtered as in Python."""
    A, g = np.array([[1, 0.01], [0, 1]]), np.array([[5e-5], [0.01]])
    source = lb.Plant(A, None, [[1.0, 0]], Q=1e-2 * g @ g.T, R=[[R]],
                      P0=P0 * np.eye(2), dt=0.01)  # fmt: skip
    y = generators.record(np.random.default_rng(6), source, 2000)[0]
    y[5::50] = np.nan
    code, found, Sigma = Alone(tmp_path, source).record(y)
    wanted = lb.Filter(source).run(y)
    assert not code
    scale = np.sqrt(wanted.P.diagonal())
    assert (np.abs(found[1000:] - wanted.x[1000:]) <= 1e-6 * scale).all()
    np.testing.assert_allclose(Sigma, wanted.P, rtol=1e-9)


def text(folder, source, **options):
    code, header = to_c(source, folder, **options)
    return code.read_text(), header.read_text()


def test_the_form_for_any_gain_is_the_default(tmp_path):
    plain, header = text(tmp_path, plant())
    assert "_short(" not in plain and "Guarded" not in header
    assert (plain, header) == text(tmp_path, plant(), update="joseph")


def test_the_header_says_what_the_guard_is(tmp_path):
    code, header = text(tmp_path, plant(), update="guarded")
    tried = (f"refused = observer_{form}(state, u, y, what);" for form in FORMS)
    assert " if (refused != 0) { ".join(tried) in " ".join(code.split())
    assert f"{guard.bound(3, 2, 'double'):.2g} b[i] b[j]" in header
    assert "more than 1e-08 of the root" in header
    _, header = text(tmp_path, plant(), update="guarded", dtype="float")
    assert "more than 0.0001 of the root" in header


def test_nothing_is_subtracted_where_the_outputs_see_nothing(tmp_path):
    code, _ = text(tmp_path, plant(C=np.zeros((2, 3))), update="guarded")
    assert "_short(" not in code


def test_definiteness_is_tested_in_either_form(tmp_path):
    still = plant(2, 1, Q=np.diag([1.0, 0]), A=np.diag([0.5, 1.0]))
    code, _ = text(tmp_path, still, update="guarded")
    short = code.partition("int observer_short")[2].partition("return 0;")[0]
    assert "Sigma_1_1 > 0.0" in short or "Sigma_d1 > 0.0" in short


def test_what_does_not_go_with_it_is_refused(tmp_path):
    def refused(match, source=None, **options):
        with pytest.raises((ValueError, lb.DesignError), match=match):
            to_c(source or plant(), tmp_path, **options)
        assert not list(tmp_path.iterdir())

    refused("update must be 'joseph' or 'guarded', got 'fast'", update="fast")
    refused("leave out m1", update="guarded", m1=1)
    refused("leave out m1 and weight", update="guarded", weight=np.eye(3))
    refused("goes with a plant", lb.kalman_filter(plant()), update="guarded")
    noise = plant(R=np.diag([1e-250, 1.0]))
    refused(r"at least 1e-200, and those of \['y1'\]", noise, update="guarded")
