"""Bounds on rounding of exported filters hold on a million steps, in any order."""

from fractions import Fraction

import filter_runs
import generators
import numpy as np
import pytest
from rounding_runs import PATTERNS, per_unit

import luenberger as lb
from luenberger.errors import DesignError
from luenberger.export import rounding_bound, to_c
from luenberger.export.c import filter_bound, filter_words
from luenberger.export.c.computed import Computed, passed
from luenberger.export.c.rounding_bound import upward
from luenberger.export.c.window import Window
from luenberger.export.derivation import gains, grows, strays
from luenberger.kernels import run
from luenberger.kernels.c import library
from luenberger.kernels.program import Assign, Factor, Operand, Program, Term
from luenberger.numeric.rounded import Rounded

needs_compiler = pytest.mark.skipif(
    library.compiler() is None, reason="there is no C compiler"
)
needs_digits = pytest.mark.skipif(
    np.finfo(np.longdouble).eps > 2e-19, reason="long double is double here"
)
STEPS = 1_000_000


def tracker(drive=0.1, **changes):
    given = dict(Q=np.diag([0, drive]), R=[[0.5]], P0=np.eye(2), dt=0.5)
    return lb.Plant([[1, 0.5], [0, 1]], [[0], [1]], [[1, 0]], **given | changes)


def known():
    """Its last state is known exactly: no noise drives it, and it starts known."""
    A = [[0.9, 0.2, 0], [0, 0.7, 0.3], [0, 0, 0.8]]
    return lb.Plant(
        A, [[0], [0], [1]], [[1, 0, 0]], Q=np.diag([0.1, 0.2, 0]), R=[[0.3]],
        P0=np.diag([1.0, 1.0, 0]), x0=[0.1, 0.2, 0.3], dt=1.0,
    )  # fmt: skip


def coupled():
    """Noises that are correlated, and an input that is measured."""
    return tracker(
        Q=[[0.2, 0.1], [0.1, 0.3]], S=[[0.1], [0.2]], E=[[0.7]], x0=[3.0, 1 / 3]
    )


PLANTS = {
    "one state": (
        lb.Plant([[0.3]], None, [[1.7]], Q=[[1]], R=[[1]], P0=[[9]], dt=1.0),
        20,
    ),
    "tracker": (tracker(x0=[3.0, 1 / 3]), 100),
    "accurate sensor": (tracker(R=[[1e-6]]), 100),
    "correlated noises": (coupled(), 100),
    "a state known exactly": (known(), 100),
    "three states": (generators.plant(np.random.default_rng(3), 3, 1), 100),
    "six states": (generators.plant(np.random.default_rng(3), 6, 3), 3000),
}  # fmt: skip
ONCE = {"three states": "float", "six states": "double"}  # they take longest
RUNS = [
    (name, dtype)
    for name in PLANTS
    for dtype in ("float", "double")
    if ONCE.get(name, dtype) == dtype
]


def sizes(plant):
    """Ranges, none of them a number that float has exactly."""
    inputs = {name: 1.1 + i for i, name in enumerate(plant.input_names)}
    return inputs | {name: 7.3 * (i + 1) for i, name in enumerate(plant.output_names)}


@needs_compiler
@needs_digits
@pytest.mark.parametrize("name, dtype", RUNS)
def test_a_bound_holds_on_a_million_steps_and_is_not_vacuous(
    name, dtype, tmp_path, without_a_bound
):
    (plant, most), looser = PLANTS[name], {"float": 1, "double": 8}[dtype]
    ranges = sizes(plant)
    bound = rounding_bound(plant, dtype=dtype, ranges=ranges).largest
    steps = STEPS // len(PATTERNS)
    found = filter_runs.gaps(plant, tmp_path, ranges, steps=steps, dtype=dtype)
    assert list(found) == list(PATTERNS)
    for pattern, gap in found.items():
        assert (gap <= bound).all(), f"{pattern}: {gap} is beyond {bound}"
    worst = np.max(list(found.values()), axis=0)
    assert (worst > 0).all() and (bound <= most * looser * worst).all()


# -- any order of the sums -------------------------------------------------------------


class Narrow:
    """A program in float32, sums in any order, products fused or not."""

    def __init__(self, program, given, rng, fused):
        self.program, self.rng, self.fused = program, rng, fused
        self.have = {k: X.astype(np.float32) for k, X in given.items()}

    def step(self, **given):
        have = self.have | {k: X.astype(np.float32) for k, X in given.items()}
        for step in self.program.steps:
            if isinstance(step, Assign):
                have[step.target] = self.assigned(step, have)
            elif not isinstance(step, Factor):
                N, M = self.of(step.right, have), have[step.matrix]
                have[step.target] = np.array([self.solved(M, row) for row in N])
        return {k: have[op.name] for k, op in self.program.results.items()}

    @staticmethod
    def of(operand, have):
        return have[operand.name].T if operand.turned else have[operand.name]

    def assigned(self, step, have):
        terms = []
        for term in step.terms:
            parts = [self.of(one, have) for one in term.factors]
            terms.append((np.float32(term.scale), parts))
        rows, cols = terms[0][1][0].shape[0], terms[0][1][-1].shape[1]
        made = np.zeros((rows, cols), np.float32)
        for i in range(rows):
            for j in range(cols):
                made[i, j] = self.sum(terms, i, j)
        return np.triu(made) + np.triu(made, 1).T if step.symmetric else made

    def sum(self, terms, i, j):
        products = []
        for scale, parts in terms:
            if len(parts) == 1:
                products.append((scale, parts[0][i, j]))
            else:
                pairs = zip(parts[0][i], parts[1][:, j])
                products += [(scale * a, b) for a, b in pairs if a and b]
        return self.added(np.float32(0), products)

    def added(self, total, products):
        for k in self.rng.permutation(len(products)):
            a, b = products[k]
            if self.fused:
                total = np.float32(float(total) + float(a) * float(b))
            else:
                total = total + a * b
        return total

    def solved(self, M, row):
        """row M^-1 by L d L', with 1 / d."""
        p = len(M)
        L, d = np.eye(p, dtype=np.float32), np.zeros(p, np.float32)
        for i in range(p):
            u = np.zeros(p, np.float32)
            for j in range(i):
                u[j] = self.added(M[i, j], [(-u[k], L[j, k]) for k in range(j)])
                L[i, j] = u[j] * (np.float32(1) / d[j])
            d[i] = self.added(M[i, i], [(-u[k], L[i, k]) for k in range(i)])
        f = np.zeros(p, np.float32)
        for j in range(p):
            f[j] = self.added(row[j], [(-L[j, k], f[k]) for k in range(j)])
        f = f * (np.float32(1) / d)
        for j in reversed(range(p)):
            f[j] = self.added(f[j], [(-L[k, j], f[k]) for k in range(j + 1, p)])
        return f


def exact_rows(plant, readings):
    """Estimates in double: their own rounding is nothing beside that of float."""
    As, B, C, E, J, Q, R, Omega, x = filter_runs.exact_filter(plant)
    rows = []
    for one in readings:
        u, known = one[: plant.m], one[plant.m :] - E @ one[: plant.m]
        K = np.linalg.solve(C @ Omega @ C.T + R, C @ Omega).T
        x = x + K @ (known - C @ x)
        rows.append(x)
        x = As @ x + B @ u + J @ known
        Y = np.eye(plant.n) - K @ C
        Omega = As @ (Y @ Omega @ Y.T + K @ R @ K.T) @ As.T + Q
    return np.array(rows)


@pytest.mark.parametrize("fused", [False, True], ids=["rounded products", "fused"])
@pytest.mark.parametrize("plant, most", PLANTS.values(), ids=PLANTS)
def test_any_order_of_a_sum_is_within_the_bound(plant, most, fused):
    rng, ranges = np.random.default_rng(2), sizes(plant)
    bound = rounding_bound(plant, ranges=ranges).largest
    s = np.array(list(ranges.values()))
    readings = s * np.where(rng.random((60, len(s))) < 0.5, -1.0, 1.0)
    pair = filter_words.pair(plant, 0, "float")
    device = Narrow(pair.program, pair.device, rng, fused)
    Omega, x = pair.device["Omega"], pair.device["x"][:, None]
    for row, wanted in zip(readings, exact_rows(plant, readings), strict=True):
        now = dict(u=row[: plant.m, None], y=row[plant.m :, None])
        made = device.step(Omega=Omega, x_minus=x, **now)
        assert (np.abs(made["x"][:, 0] - wanted) <= bound).all()
        Omega, x = made["Omega_next"], made["x_minus_next"]


# -- its parts -------------------------------------------------------------------------


def of(*names):
    return tuple(Operand(k) for k in names)


def exactly(X):
    return [[Fraction(one) for one in row] for row in np.asarray(X, float).tolist()]


def times(X, Y):
    return [[sum(a * b for a, b in zip(row, col)) for col in zip(*Y)] for row in X]


def less(X, Y, sign=-1):
    return [[a + sign * b for a, b in zip(*rows)] for rows in zip(X, Y)]


def turned(X):
    return [list(row) for row in zip(*X)]


@pytest.mark.parametrize("seed", range(20))
def test_matrices_of_a_device_are_within_their_bounds(seed):
    """Z = O - K N' and S = Z - Z C' K': exactly, and in float32 in any order."""
    rng = np.random.default_rng(seed)
    n, p = 3, 2
    given = dict(O=rng.normal(size=(n, n)), K=rng.normal(size=(n, p)))
    given |= dict(N=rng.normal(size=(n, p)), C=rng.normal(size=(p, n)))
    one, minus = Fraction(1), Fraction(-1)
    K, N, C = (Operand(k, True) for k in "KNC")
    steps = (
        Assign("Z", (Term(one, of("O")), Term(minus, (Operand("K"), N)))),
        Assign("t", (Term(one, (Operand("Z"), C)),)),
        Assign("S", (Term(one, of("Z")), Term(minus, (Operand("t"), K)))),
    )
    shapes = {k: X.shape for k, X in given.items()}
    program = Program(tuple(given), shapes, steps, {"S": Operand("S")}, frozenset())
    wide = {k: 0.01 * rng.random(X.shape) for k, X in given.items()}
    off = {k: 2.0**-24 * (np.abs(X) + wide[k]) for k, X in given.items()}
    known = {k: Computed.of(X, wide[k], off[k]) for k, X in given.items()}
    found, _ = passed(program, known, "float", None, {})
    signs = {k: rng.choice([-1, 1], size=X.shape) for k, X in given.items()}
    there = {k: X + wide[k] * signs[k] for k, X in given.items()}
    O, K, N, C = (exactly(there[k]) for k in "OKNC")
    Z = less(O, times(K, turned(N)))
    exact = less(Z, times(times(Z, turned(C)), turned(K)))
    S = found["S"]
    made = Narrow(program, there, rng, fused=seed % 2).step()["S"]
    for gap, most in ((S.value, S.wide), (made, S.off)):
        gaps = zip(less(exact, exactly(gap)), exactly(most))
        assert all(abs(a) <= b for row in gaps for a, b in zip(*row))


def test_a_copy_and_a_zero_are_not_rounded():
    X = Computed.of(np.array([[0.1, 0.0], [3.0, 0.7]]), wide=np.eye(2)[::-1] * 0.0)
    program = Program(
        ("X", "A"), {}, (Assign("Y", (Term(Fraction(1), of("A", "X")),)),),
        {"Y": Operand("Y")}, frozenset(),
    )  # fmt: skip
    A = Computed.of(np.array([[1.0, 0.0], [0.0, 0.5]]))
    found, _ = passed(program, dict(X=X, A=A), "float", None, {})
    assert (found["Y"].off[:, 0] < 1e-36).all() and found["Y"].off[0, 1] == 0
    B = Computed.of(np.array([[1.0, 0.0], [0.0, 0.3]]))
    found, _ = passed(program, dict(X=X, A=B), "float", None, {})
    assert found["Y"].off[1, 0] == pytest.approx(0.9 * 2.0**-24, rel=2e-3)


@pytest.mark.parametrize("length", [3, 50])
def test_a_window_holds_what_was_added_and_moved(length):
    """Differences and errors of random steps, moved by changing F."""
    rng = np.random.default_rng(length)
    n, c, As = 3, 2, rng.normal(size=(3, 3)) / 2
    window = Window(As, 1, c, length)
    Xi, e, x, more = np.zeros((n, n)), np.zeros((n, c)), np.zeros((n, c)), {}
    C, whole = rng.normal(size=(2, n)), Rounded.of(np.eye(n))
    for k in range(40):
        new = dict(
            squares=rng.random((1, n, n)), spreads=rng.random((1, n, n)),
            errors=rng.random((n, c)), through=rng.random((n, c)),
            reached=rng.random((n, c)),
        )  # fmt: skip
        for name in ("squares", "spreads"):
            new[name] = new[name] + new[name].swapaxes(1, 2)
        inputs = rng.normal(size=(n, c))
        signs = {k: rng.choice([-1.0, 1.0], size=X.shape) for k, X in new.items()}
        drawn = {k: X * signs[k] for k, X in new.items()}
        for name in ("squares", "spreads"):
            upper = np.triu(drawn[name][0])
            drawn[name] = upper + np.triu(upper, 1).T
        Xi = Xi + drawn["squares"] + As @ drawn["spreads"] @ As.T
        e = e + drawn["errors"] + As @ drawn["through"]
        x = x + drawn["reached"] + inputs
        total = {k: X + more.get(k, 0.0) for k, X in new.items()}
        window.add(**total, inputs=inputs)
        far = window.square(whole, Rounded.of(C))[0]
        assert (np.abs(Xi @ C.T) <= far).all()
        assert (np.abs(C @ e) <= window.error(Rounded.of(C))).all()
        assert (np.abs(C @ x) <= window.reach(Rounded.of(C))).all()
        F = rng.normal(size=(n, n)) * (0.3 if k % 2 else 0.6)
        more = window.move(Rounded.of(F))
        Xi, e, x = F @ Xi @ F.T, F @ e, F @ x
    assert len(window.moves) < length + 1


@pytest.mark.parametrize("length", [2, 50])
def test_a_window_is_sharp_where_nothing_cancels(length):
    """Without a minus sign the bound is the sum itself, what is older included."""
    rng = np.random.default_rng(1)
    n, As, whole = 2, rng.random((2, 2)), Rounded.of(np.eye(2))
    window, more = Window(As, 1, 1, length), {}
    Xi, e, x = np.zeros((1, n, n)), np.zeros((n, 1)), np.zeros((n, 1))
    F, one = 0.4 * rng.random((n, n)), np.ones((n, 1))
    for _ in range(12):
        new = dict(squares=np.ones((1, n, n)), errors=one, reached=one)
        window.add(
            **{k: X + more.get(k, 0.0) for k, X in new.items()},
            spreads=np.ones((1, n, n)), through=one, inputs=one,
        )  # fmt: skip
        Xi = Xi + 1 + As @ np.ones((n, n)) @ As.T
        e, x = e + one + As @ one, x + 2 * one
        np.testing.assert_allclose(window.square(whole, whole), Xi, rtol=1e-6)
        np.testing.assert_allclose(window.error(whole), e, rtol=1e-6)
        np.testing.assert_allclose(window.reach(whole), x, rtol=1e-6)
        more = window.move(Rounded.of(F))
        Xi, e, x = F @ Xi @ F.T, F @ e, F @ x


def test_what_a_step_adds_by_hand():
    """One state and one output, as numbers."""
    one = {k: np.array([[X]]) for k, X in SCALAR.items()}
    found = {k: X.item() for k, X in (run(gains, one) | run(grows, one)).items()}
    assert found["k_o"] == (0.5 + 1) * 2
    assert found["k_r"] == (0.25 + (4 + 3) * 0.125) * 3
    assert found["k_f"] == found["k_o"] + found["k_r"]
    assert found["l_s"] == 7 * 5 * 7 + 6 * (0.5 + 1) + 11
    found = {k: X.item() for k, X in run(strays, one).items()}
    assert found["k_d"] == 13 + 17
    assert found["a_s"] == 13 * 19 * 23 + (13 + 17) * 29 + 31
    assert found["z_s"] == 37 * 17 * 29


SCALAR = dict(
    g_s=0.5, X_K=1.0, V_o=2.0, N_o=0.25, G_s=4.0, E_s=0.125, V_f=3.0, k_o=6.0, k_r=7.0,
    M_s=5.0, r_ts=11.0, k_f=13.0, k_e=17.0, C_s=19.0, e_s=23.0, nu_s=29.0, r_xs=31.0,
    As_s=37.0,
)  # fmt: skip


def test_roundings_are_counted():
    """Of a sum of three products three each, of a solution as the page says."""
    X, A = (
        Computed.of(np.array([[0.3], [0.7], [0.1]])),
        Computed.of(np.full((1, 3), 3.0)),
    )
    program = Program(
        ("X", "A"), {}, (Assign("Y", (Term(Fraction(1), of("A", "X")),)),),
        {"Y": Operand("Y")}, frozenset(),
    )  # fmt: skip
    found, _ = passed(program, dict(X=X, A=A), "float", None, {})
    assert found["Y"].off.item() == pytest.approx(3 * 3.3 * 2.0**-24, rel=2e-3)
    search = filter_bound.Search(filter_words.pair(tracker(), 0, "float"))
    pair = search.pair
    one, two = Computed.of(np.array([[4.0]])), Computed.of(np.array([[4.0, 1], [1, 9]]))
    assert pair.elimination(one).item() == pytest.approx(2 * 4 * 2.0**-24, rel=2e-3)
    wanted = 10 * 2.0**-24 * np.array([[4, 6], [6, 9]])
    np.testing.assert_allclose(pair.elimination(two), wanted, rtol=2e-3)
    np.testing.assert_allclose(search.ds[:, :-1], 2.0**-24 * np.eye(2), rtol=2e-3)
    gap = np.abs(pair.device["Omega"] - pair.exact["Omega"])
    first = search.start(5)
    assert gap.any() and (first.squares[0, 0] == gap).all()
    assert (first.errors[0, :, -1] == np.abs(pair.device["x"] - pair.exact["x"])).all()


@pytest.mark.parametrize("seed", range(5))
def test_gains_are_within_their_bounds(seed):
    """The best gain of a covariance near by, and one that a matrix near by gives."""
    rng = np.random.default_rng(seed)
    plant = generators.plant(rng, 4, 2)
    pair = filter_words.pair(plant, 0, "float")
    Omega, C, R = pair.exact["Omega"], pair.exact["C"], pair.exact["R"]
    gain = pair.gain(Omega)
    far = 1e-4 * np.abs(Omega)
    seen = np.abs(gain.Y.value) @ far @ np.abs(C).T
    here = filter_bound.Around(
        Omega, np.stack([far, far]), np.stack([seen, seen]), *[np.zeros((4, 1))] * 3
    )
    N, M = Omega @ C.T, C @ Omega @ C.T + R
    dN, dM = 1e-5 * np.abs(N), 1e-5 * np.abs(M)
    near = Computed.of(M, np.abs(C) @ far @ np.abs(C).T, dM)
    sizes = pair.gains(Computed.of(N, far @ np.abs(C).T, dN), near, gain.G, here)
    for _ in range(200):
        half = np.triu(far * rng.choice([-1, 1], size=far.shape))
        there = Omega + half + np.triu(half, 1).T
        N_f, M_f = there @ C.T, C @ there @ C.T + R
        K_o = np.linalg.solve(M_f, N_f.T).T
        E = dM * rng.choice([-1, 1], size=dM.shape)
        K_f = np.linalg.solve((M_f + E).T, (N_f + dN * rng.choice([-1, 1], dN.shape)).T)
        assert (np.abs(K_o - gain.G) <= sizes["k_o"]).all()
        assert (np.abs(K_o - gain.G) <= sizes["k_e"]).all()
        assert (np.abs(K_f.T - K_o) <= sizes["k_r"]).all()
    assert (sizes["k_o"] < 1e-2 * np.abs(gain.G).max()).all()
    assert (sizes["E_s"] == dM + pair.elimination(near)).all()


# -- units -----------------------------------------------------------------------------


@pytest.mark.parametrize("unit", [2.0**20, 1e6, 1e-6])
def test_a_bound_is_in_the_units_of_its_state(unit):
    T = np.diag([1.0, unit])
    one, down = tracker(), np.linalg.inv(T)
    other = lb.Plant(
        T @ one.A @ down, T @ one.B, one.C @ down, Q=T @ one.Q @ T, R=one.R,
        P0=T @ one.P0 @ T, dt=0.5,
    )  # fmt: skip
    found, scaled = (
        rounding_bound(plant, ranges=sizes(one)).largest for plant in (one, other)
    )
    part = 1e-3 if unit == 2.0**20 else 1.0  # constants are rounded otherwise
    np.testing.assert_allclose(scaled / T.diagonal(), found, rtol=part)
    readings = lb.Plant(
        one.A, one.B, unit * one.C, Q=one.Q, R=unit**2 * one.R, P0=one.P0, dt=0.5
    )
    ranges = {"u1": 1.1, "y1": 7.3 * unit}
    scaled = rounding_bound(readings, ranges=ranges).largest
    np.testing.assert_allclose(scaled, found, rtol=part)


# -- words, and what has no bound ------------------------------------------------------


def test_the_header_says_the_bound_within_ranges_or_for_each_signal(tmp_path):
    plant, ranges = tracker(), {"u1": 2.0, "y1": 10.0}
    bound = rounding_bound(plant, ranges=ranges)
    _, header = to_c(plant, tmp_path, dtype="float", ranges=ranges)
    text = header.read_text()
    assert '"u1" is at most 2.0 in size' in text
    for name, value in zip(("x1", "x2"), bound.largest):
        assert f'"{name}": {upward(value)}\n' in text
        assert f"{name}: off by at most {upward(value)}." in bound.sentences
    plain = " ".join(text.replace(" *", "").split())
    for said in (repr(bound), plain):
        assert "It takes that every output arrives at every sample" in said
    assert "filter_rounding.py" in plain and "without rounding" in plain
    assert "nothing else of what -ffast-math allows." in plain
    _, header = to_c(plant, tmp_path, dtype="float")
    for name, value in zip(("x1", "x2"), bound.largest):
        each = per_unit(header, name)
        total = each[None] + each["u1"] * 2 + each["y1"] * 10
        assert value <= total <= 1.02 * value


def test_ranges_of_measurements_follow_from_the_noises_of_a_stable_plant():
    plant = lb.Plant([[0.5]], None, [[2.0]], dt=1.0, Q=[[3]], R=[[4]], P0=[[1]])
    found = rounding_bound(plant)
    size = dict(found.ranges)["y1"]
    assert size == pytest.approx(6 * np.sqrt(2 * 2 * 3 / (1 - 0.25) + 4), rel=1e-5)
    assert "'y1' is 6 standard deviations of the plant" in found.source
    with pytest.raises(ValueError, match="the range of 'u1', 'y1' is not known"):
        rounding_bound(tracker())


CASES = {
    "outputs that are treated as exact": (tracker(), dict(m1=1)),
    "has no noise to drive it": (tracker(Q=np.zeros((2, 2))), {}),
    "may take it for rounding": (
        lb.Plant([[0.5, 0], [0, 0.9]], None, [[1, 1]], Q=np.diag([0, 1.0]), R=[[1]],
                 P0=np.eye(2), dt=1.0), {},
    ),
    "too close to singular": (
        lb.Plant(np.eye(2) / 2, None, np.array([[1, 1], [1, 1 + 1e-5]]), Q=np.eye(2),
                 R=1e-10 * np.eye(2), P0=np.eye(2), dt=1.0), {},
    ),
    "leave the range of float": (
        lb.Plant([[0.5]], None, [[1]], Q=[[3e38]], R=[[1]], P0=[[1]], dt=1.0), {},
    ),
}  # fmt: skip


@pytest.mark.parametrize("why", CASES)
def test_the_header_says_why_there_is_no_bound(why, tmp_path):
    plant, given = CASES[why]
    _, header = to_c(plant, tmp_path, dtype="float", **given)
    said = " ".join(header.read_text().replace(" *", "").split())
    assert "No bound on rounding was proved: " in said and why in said
    if not given:
        with pytest.raises(DesignError, match=f"no bound was proved: .*{why}"):
            rounding_bound(plant, ranges=sizes(plant))


@pytest.mark.parametrize(
    "limit, why",
    [
        (dict(MOST=3), "has not forgotten an error after 3 steps"),
        (dict(SPARE=1.0, TRIES=1), "add up faster than the filter forgets"),
        (dict(FORGOTTEN=2.0, MOST=2), "has not settled after 2 steps"),
    ],
)
def test_a_search_that_takes_too_long_says_so(limit, why, monkeypatch):
    for name, value in limit.items():
        monkeypatch.setattr(filter_bound, name, value)
    with pytest.raises(DesignError, match=why):
        rounding_bound(tracker(), ranges={"u1": 1.0, "y1": 1.0})


def test_what_goes_with_an_observer_is_refused():
    with pytest.raises(ValueError, match="plant= goes with an observer"):
        rounding_bound(tracker(), plant=tracker())
    with pytest.raises(ValueError, match="dtype='fixed' goes with an observer"):
        rounding_bound(tracker(), dtype="fixed", bits=16)
