"""Compiled code gives what NumPy gives, or hands the row over to it.

Most tests run the generated code as plain Python, which is the same text; those
marked "numba" compile it.
"""

import dataclasses

import generators
import numpy as np
import pytest
from every_pair import every_pair
from generators import holes, integer_plant
from in_full import in_full
from in_numpy import rows_by_hand

import luenberger as lb
from luenberger import kernels
from luenberger.kernels import numba as printer
from luenberger.recursion.filter_pass import Pass
from luenberger.recursion.filter_stacks import Block, stacks_of
from luenberger.recursion.predicted import by_predictions
from luenberger.recursion.settings import Settings
from luenberger.recursion.state import History, start

numba = pytest.importorskip("numba", reason="numba is an optional extra")

FORMS = ["scalars", "loops", "large"]
TRACKER = lb.Plant(
    [[1, 1, 0.5], [0, 1, 1], [0, 0, 1]],
    None,
    [[1, 0, 0], [0, 1, 0]],
    dt=1.0,
    Q=np.diag([0.0, 0, 1]),
    R=np.diag([0.25, 4]),
    P0=[[0.25, 0.375, 0.25], [0.375, 1.6875, 1.625], [0.25, 1.625, 2.75]],
)


def both(plant, y, u=None, **options):
    """The filter by compiled code and by NumPy, and whether it ran compiled."""
    wanted = in_full(plant, y, u, backend="numpy", **options)
    found = in_full(plant, y, u, backend="numba", **options)
    return found, wanted


def agree(found, wanted, tol=1e-12):
    for name in ("x", "std", "P", "K"):
        a, b = getattr(found, name), getattr(wanted, name)
        assert a.shape == b.shape
        assert generators.relative(a, b) < tol, name
    np.testing.assert_array_equal(found.P, found.P.mT)


@every_pair(
    kind=["S = 0", "S", "varying", "varying, S"],
    m1=[0, 1, [0, 2], 3],
    form=FORMS,
    gaps=[False, True],
    indirect=["form"],
)
def test_generated_code_is_the_numpy_filter(kind, gaps, m1, form, monkeypatch):
    rng, cross, N = np.random.default_rng(12), kind.endswith("S"), 25
    if kind.startswith("varying"):
        plant = generators.varying(rng, 4, 3, N, m=2, cross=cross)
    else:
        plant = generators.plant(rng, 4, 3, m=2, cross=cross)
    y, u, u0 = generators.record(rng, plant, N)
    y = holes(rng, y) if gaps else y
    wanted = in_full(plant, y, u, u0=u0, m1=m1, backend="numpy")
    rows = rows_by_hand(monkeypatch)
    found = in_full(plant, y, u, u0=u0, m1=m1, backend="numba")
    agree(found, wanted, 1e-11)
    from_prediction = by_predictions(Settings(plant, m1))
    assert len(rows) == (not from_prediction)  # the first row


@pytest.mark.parametrize("kind", ["S = 0", "S", "varying, S"])
def test_generated_code_agrees_with_rational_arithmetic(kind, form):
    rng, cross = np.random.default_rng(5), kind.endswith("S")
    make = generators.varying if kind.startswith("v") else generators.plant
    size = (3, 2, 8) if kind.startswith("v") else (3, 2)
    plant = make(rng, *size, m=1, cross=cross)
    y, u, u0 = generators.record(rng, plant, 8)
    y[4, 0] = np.nan
    x, P = generators.exact(plant, y, u, u0)
    run = in_full(plant, y, u, u0=u0, backend="numba")
    assert generators.relative(run.P, P) < 1e-12
    assert generators.relative(run.x, x) < 1e-12


@pytest.mark.parametrize("spread, noise", [(1e8, 1e-4), (1e6, 1e-10), (1e-8, 1e4)])
def test_the_covariance_is_as_accurate_as_joseph_form(spread, noise, plain):
    """P0 and R far apart, where Omega - K (Omega C')' loses what Joseph's keeps."""
    for seed in range(3):
        rng = np.random.default_rng(seed)
        plant = generators.plant(rng, 3, 2, m=0, cross=False)
        plant = lb.Plant(
            plant.A, None, plant.C, dt=1.0, Q=plant.Q, R=noise * plant.R,
            P0=spread * plant.P0,
        )  # fmt: skip
        y, _, _ = generators.record(rng, plant, 6)
        _, P = generators.exact(plant, y)
        errors = []
        for run in reversed(both(plant, y)):
            errors.append(max(map(generators.relative, run.P, P)))
        assert errors[1] < 20 * errors[0] + 1e-14


@pytest.mark.parametrize("varying", ["A", "C", "R", "E"])
def test_one_matrix_that_changes(varying, plain):
    rng, N = np.random.default_rng(3), 20
    fixed = generators.plant(rng, 3, 2, m=1, cross=False)
    whole = generators.varying(rng, 3, 2, N, m=1, cross=False)
    given = {k: getattr(fixed, k) for k in ("A", "B", "C", "E", "Q", "R", "P0", "x0")}
    plant = lb.Plant(**given | {varying: getattr(whole, varying)}, dt=1.0)
    y, u, u0 = generators.record(rng, plant, N)
    y[3, 0] = y[9] = np.nan
    for m1 in (0, 1):
        found, wanted = both(plant, y, u, u0=u0, m1=m1)
        agree(found, wanted, 1e-11)


def test_a_prior_of_the_first_sample(plain):
    rng = np.random.default_rng(4)
    plant = generators.plant(rng, 3, 2, m=1, at_first=True)
    y, u, u0 = generators.record(rng, plant, 12)
    agree(*both(plant, y, u, u0=u0, m1=1), tol=1e-11)


@pytest.mark.parametrize("weight", ["canonical", np.diag([1.0, 2, 3])], ids=str)
def test_weights(weight, plain):
    rng = np.random.default_rng(4)
    plant = generators.plant(rng, 3, 2, m=1)
    y, u, _ = generators.record(rng, plant, 12)
    agree(*both(plant, holes(rng, y), u, m1=1, weight=weight), tol=1e-11)


def test_any_singular_noise_is_handed_over_or_right(form):
    """As in test_perfect: joint noise and P0 of every rank, against exact numbers."""
    for seed in range(FORMS.index(form), 60, len(FORMS)):
        plant, y, u, u0 = integer_plant(seed)
        x, P = generators.exact(plant, y, u, u0)
        run = in_full(plant, y, u, u0=u0, backend="numba")
        size = np.abs(P).max() + np.abs(plant.P0).max() + np.abs(plant.Q).max() + 1
        assert np.abs(run.x - x).max() < 1e-10 * (1 + np.abs(x).max()), seed
        assert np.abs(run.P - P).max() < 1e-10 * size, seed


def test_a_state_known_at_first_is_handed_over_until_it_is_not(plain, monkeypatch):
    """P0 = 0 and noise on the acceleration only: Sigma is singular for two rows."""
    known = lb.Plant(
        TRACKER.A, None, TRACKER.C, dt=1.0, Q=TRACKER.Q, R=TRACKER.R,
        P0=np.zeros((3, 3)),
    )  # fmt: skip
    y = np.random.default_rng(1).normal(size=(40, 2))
    wanted = in_full(known, y, backend="numpy")
    rows = rows_by_hand(monkeypatch)
    agree(in_full(known, y, backend="numba"), wanted)
    assert 1 < len(rows) < 12


@every_pair(
    kind=generators.KNOWN,
    form=FORMS,
    first=[False, True],
    gaps=[False, True],
    indirect=["form"],
)
def test_states_that_are_known_exactly_stay_in_compiled_code(
    kind, first, gaps, form, monkeypatch
):
    """Their variance is zero to the last bit, and all else as in rationals."""
    plant = generators.known(kind, first=first)
    rng = np.random.default_rng(2)
    u, y = rng.normal(size=(12, 1)), rng.normal(size=(12, 2))
    y = holes(rng, y) if gaps else y
    x, P = generators.exact(plant, y, u, np.zeros(1))
    rows = rows_by_hand(monkeypatch)
    run = in_full(plant, y, u, backend="numba")
    assert len(rows) == 1
    assert generators.relative(run.P, P) < 1e-12 if P.any() else not run.P.any()
    assert generators.relative(run.x, x) < 1e-12
    zero = np.diagonal(P, axis1=1, axis2=2) == 0
    assert zero.any() and (run.std[zero] == 0).all()


@pytest.mark.parametrize("spoiled", [0, 1])
def test_a_row_that_is_not_all_zeros_is_handed_over(spoiled, form, monkeypatch):
    """A variance of zero beside a covariance that is not, at the first row."""
    plant = generators.known("a constant")
    now = start(Settings(plant, 0), plant.x0, np.zeros(1))
    y, u = np.ones((9, 2)), np.ones((9, 1))
    over = Pass(Settings(plant, 0))
    state, _ = over.over(now, y[:1], u[:1], False)
    stacks = stacks_of(over.settings)
    Sigma = state.Sigma.copy()
    Sigma[3, spoiled] = Sigma[spoiled, 3] = 1e-300
    state = state._replace(spread=state.spread._replace(Sigma=Sigma))
    block = stacks.block(state, y, u)
    _, done = block.run(state, 0, History.empty(9, plant), 9)
    assert done == 0


def test_a_plant_without_noise_anywhere_stays_with_numpy(form, monkeypatch):
    """Every Sigma is singular: tried again now and then, never believed."""
    plant = lb.Plant(
        [[0.9, 1], [0, 0.8]], None, [[1, 0]], dt=1.0, Q=np.zeros((2, 2)), R=[[1]],
        P0=np.ones((2, 2)),
    )  # fmt: skip
    y = np.random.default_rng(1).normal(size=(300, 1))
    wanted = in_full(plant, y, backend="numpy")
    rows = rows_by_hand(monkeypatch)
    agree(in_full(plant, y, backend="numba"), wanted)
    assert len(rows) == 300


@pytest.mark.parametrize("size", [300, 7], ids=["whole", "chunks"])
def test_code_that_gives_up_is_tried_ever_more_seldom(size, plain, monkeypatch):
    tried, gives_up, run = [], True, Block.run

    def attempt(block, state, k, *rest):
        tried.append(state.instant)
        return (state, k) if gives_up else run(block, state, k, *rest)

    monkeypatch.setattr(Block, "run", attempt)
    y = np.random.default_rng(1).normal(size=(300, 2))
    over = Pass(Settings(TRACKER, 0))
    now = start(over.settings, TRACKER.x0, np.zeros(0))
    for part in np.split(y, range(size, 300, size)):
        now, _ = over.over(now, part, np.zeros((len(part), 0)), True)
    assert tried == [1, 3, 7, 15, 31, 63, 127, 191, 255]
    gives_up = False
    for _ in range(3):  # once it got on, it is tried for every chunk
        now, _ = over.over(now, y[:60], np.zeros((60, 0)), True)
    assert tried[9:] == [319, 360, 420]


def test_rows_since_the_last_test_are_taken_back(form, monkeypatch):
    """Q and R vanish for good at instant 22, with a Sigma that was definite.

    Loops look at Sigma every few rows only, so they notice late, and what they did
    since the last look is done again by NumPy.
    """
    N = 40
    Q, R = np.ones((N, 2, 2)) * np.eye(2), np.ones((N, 1, 1))
    Q[21:] = 0
    A = np.ones((N, 2, 2)) * [[0.9, 0.1], [0, 0.8]]
    A[22] = [[1, 1], [1, 1]]  # Sigma is singular from here
    plant = lb.Plant(A, None, [[1, 0]], dt=1.0, Q=Q, R=R, P0=np.eye(2))
    y = np.random.default_rng(1).normal(size=(N - 1, 1))
    wanted = in_full(plant, y, backend="numpy")
    rows = rows_by_hand(monkeypatch)
    agree(in_full(plant, y, backend="numba"), wanted)
    assert len(rows) > 10 and min(rows[1:]) >= 16


@pytest.mark.parametrize("unit", [1e-5, 1e-7])
def test_outputs_in_small_units_that_did_not_arrive(unit, plain):
    """The variance of one in their place took the others' digits: 1 part in 1000."""
    C = [[1, 0, 0], [0, 1, 0]]
    small = dataclasses.replace(TRACKER, C=np.multiply(C, unit), R=TRACKER.R * unit**2)
    y = holes(np.random.default_rng(3), np.arange(24.0).reshape(12, 2) % 5)
    for m1 in (0, 1):
        wanted = in_full(TRACKER, y, m1=m1, backend="numpy")
        found = in_full(small, y * unit, m1=m1, backend="numba")
        np.testing.assert_allclose(found.x, wanted.x, rtol=1e-10, atol=1e-12)
        np.testing.assert_allclose(found.std, wanted.std, rtol=1e-10)


def test_noise_free_outputs_are_refused_before_the_run():
    plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[0]], P0=[[1]])
    assert stacks_of(Settings(plant, 0)) is None
    assert stacks_of(Settings(TRACKER, 1)) is not None


@pytest.mark.parametrize("options", [dict(m1=2), dict(weight="canonical")], ids=str)
def test_redundant_outputs_that_never_arrive_together(options, plain):
    """They cannot both be treated as exact, but nothing asks for that."""
    plant = lb.Plant(
        [[0.9, 0.1], [0, 0.8]], None, [[1, 0], [2, 0]], dt=1.0, Q=np.eye(2),
        R=np.eye(2), P0=np.eye(2),
    )  # fmt: skip
    y = np.random.default_rng(1).normal(size=(12, 2))
    y[::2, 0], y[1::2, 1] = np.nan, np.nan
    agree(*both(plant, y, **options))
    y[5] = 1
    for backend in ("numpy", "numba"):
        with pytest.raises(lb.DesignError, match="dependent|independent"):
            in_full(plant, y, backend=backend, **options)


def test_outputs_of_instant_0_are_not_read(plain, monkeypatch):
    """The first measurement is that of instant 1; the rest is compiled."""
    C = np.ones((13, 1, 1)) * [[1, 0.5]]
    C[0] = 0
    plant = lb.Plant(
        [[0.9, 0.1], [0, 0.8]], None, C, dt=1.0, Q=np.eye(2), R=[[1]], P0=np.eye(2)
    )
    y = np.random.default_rng(1).normal(size=(12, 1))
    wanted = in_full(plant, y, m1=1, backend="numpy")
    rows = rows_by_hand(monkeypatch)
    agree(
        in_full(plant, y, m1=1, backend="numba"),
        wanted,
    )
    assert len(rows) == 1


def test_noise_free_for_a_while_and_a_contradiction(plain):
    """R is zero at instants 10 to 12: those rows go to NumPy, which looks at them."""
    R = np.ones((30, 2, 2)) * np.eye(2)
    R[10:13] = 0
    plant = lb.Plant([[0.9]], None, [[1], [1]], dt=1.0, Q=[[1]], R=R, P0=[[1]])
    y = np.ones((29, 2))
    agree(*both(plant, y))
    y[10] = [1, 2]  # instant 11
    for backend in ("numpy", "numba"):
        with pytest.raises(lb.DesignError, match="instant 11 .*contradict"):
            in_full(plant, y, backend=backend)


def test_overflow_is_not_hidden(plain):
    """An unstable state that nothing sees: its variance passes all bounds."""
    plant = lb.Plant(
        np.diag([1e30, 0.5]), None, [[0, 1]], dt=1.0, Q=np.eye(2), R=[[1]], P0=np.eye(2)
    )
    y = np.zeros((20, 1))
    with np.errstate(all="ignore"):
        outcomes = []
        for backend in ("numpy", "numba"):
            try:
                P = in_full(plant, y, backend=backend).P
                outcomes.append(np.isfinite(P).all())
            except (ValueError, np.linalg.LinAlgError) as error:
                outcomes.append(type(error))
    assert outcomes[0] == outcomes[1]


def test_products_are_calls(plain, used, monkeypatch):
    """18 rows are three panels, 7 are two of different heights."""
    rng = np.random.default_rng(2)
    plant = generators.plant(rng, 18, 7, m=1, cross=False)
    y, u, u0 = generators.record(rng, plant, 5)
    wanted = in_full(plant, y, u, u0=u0, backend="numpy")
    rows = rows_by_hand(monkeypatch)
    found = in_full(plant, y, u, u0=u0, backend="numba")
    agree(found, wanted, 1e-11)
    assert len(rows) == 1  # a wrong covariance would leave its rows to NumPy
    assert "product(6, 0, 3, 18, 18, " in used[-1]
    assert "product(4, 1, 1, " in used[-1] and "product(3, 1, 1, " in used[-1]


# -- compiled ------------------------------------------------------------------------


@pytest.mark.parametrize("m1", [0, 1])
def test_numba_scalars_for_a_thousand_steps(m1):
    y, _, _ = generators.record(np.random.default_rng(1), TRACKER, 1_000)
    agree(*both(TRACKER, y, m1=m1))


def test_numba_loops_for_a_thousand_steps(used, monkeypatch):
    monkeypatch.setattr(kernels, "UNROLLED", 0)
    rng = np.random.default_rng(2)
    plant = generators.plant(rng, 4, 2, m=1, cross=False)
    y, u, u0 = generators.record(rng, plant, 1_000)
    agree(*both(plant, y, u, u0=u0), tol=1e-11)
    assert "as loops" in used[-1] and "array(" in used[-1]


def test_numba_for_a_large_plant(used, monkeypatch):
    """Its matrices are not on the stack, and a product takes panels of two heights."""
    monkeypatch.setattr(kernels, "UNROLLED", 0)
    monkeypatch.setattr(printer, "ON_STACK", 0)
    rng = np.random.default_rng(2)
    plant = generators.plant(rng, 7, 1, m=0, cross=False)
    y, _, _ = generators.record(rng, plant, 40)
    agree(*both(plant, y), tol=1e-11)
    assert "product(" in used[-1] and "np.empty(" in used[-1]


@pytest.fixture
def used(monkeypatch):
    """The texts of the kernels that are used."""
    texts, over = [], kernels.over_record

    def remembered(*given):
        found = over(*given)
        texts.append(found.source)
        return found

    remembered.cache_clear = over.cache_clear
    monkeypatch.setattr(kernels, "over_record", remembered)
    return texts


def test_numba_with_missing_outputs_and_any_kind_of_array():
    """Read-only, integer, Fortran and strided arrays, lists; the same bits."""
    plant = lb.Plant(
        [[1, 1], [0, 1]], [[0], [1]], np.eye(2), dt=1.0, Q=np.eye(2), R=np.eye(2),
        P0=np.eye(2),
    )  # fmt: skip
    y = np.arange(40.0).reshape(20, 2)
    y[3, 0] = y[7] = np.nan
    u = np.arange(20)[:, None]
    found, wanted = both(plant, y, u)
    agree(found, wanted)
    frozen = y.copy()
    frozen.setflags(write=False)
    wide = np.full((40, 4), np.inf)
    wide[::2, ::2] = y
    for same in (frozen, np.asfortranarray(y), wide[::2, ::2], y.tolist()):
        again = in_full(plant, same, u, backend="numba")
        np.testing.assert_array_equal(again.x, found.x)
        np.testing.assert_array_equal(again.P, found.P)


@pytest.mark.parametrize("kind", ["constant", "varying"])
@pytest.mark.parametrize("m1", [0, 1])
def test_designs_over_steps(kind, m1, plain, monkeypatch):
    from luenberger.papers.leondes_novak import design

    monkeypatch.setattr(design, "BLOCK", 7)
    rng = np.random.default_rng(2)
    if kind == "varying":
        plant = generators.varying(rng, 3, 2, 30, m=1)
    else:
        plant = generators.plant(rng, 3, 2, m=1)
    a = lb.reduced_order_filter(plant, m1, steps=30, backend="numpy")
    b = lb.reduced_order_filter(plant, m1, steps=30, backend="numba")
    for name in "FGDPVTW":
        if getattr(a, name).any():
            found, wanted = getattr(b, name), getattr(a, name)
            assert generators.relative(found, wanted) < 1e-11, name


# -- which backend ---------------------------------------------------------------------


def test_auto_goes_by_the_length():
    assert not kernels.runs_compiled("auto", kernels.AUTO_ROWS - 1)
    assert kernels.runs_compiled("auto", kernels.AUTO_ROWS)
    assert not kernels.runs_compiled("numpy", 10**9)
    assert kernels.runs_compiled("numba", 1)


def test_without_numba(monkeypatch):
    monkeypatch.setattr(kernels, "find_spec", lambda name: None)
    assert not kernels.runs_compiled("auto", 10**9)
    with pytest.raises(ImportError, match=r"pip install 'luenberger\[fast\]'"):
        lb.kalman_filter(TRACKER, steps=5, backend="numba")


def test_an_unknown_backend_is_refused():
    with pytest.raises(ValueError, match="'auto', 'numpy' or 'numba', got 'c'"):
        lb.kalman_filter(TRACKER, steps=3, backend="c")
