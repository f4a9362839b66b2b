"""Many records of one plant: what each is by itself, whatever is beside it."""

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import luenberger as lb
from luenberger.filtering import many

N, M, NAMES = 30, 21, ("x", "std", "P", "K")
SAME = "noisy", "exact output", "varying", "mixed", "varying, mixed"  # to the last bit
KINDS = *SAME, "correlated", "accurate", "many states"


@pytest.fixture(params=["in lanes", "in turn"])
def fast(request, monkeypatch):
    """Few states in lanes, or one record after the other."""
    if request.param == "in lanes":
        pytest.importorskip("numba", reason="lanes are compiled")
        monkeypatch.setattr(many, "MANY", 0)


def drawn(kind, seed=3):
    rng = np.random.default_rng(seed)
    n, p = (8, 2) if kind == "many states" else (2, 2)
    steps = (N + 1,) if "varying" in kind else ()
    A, B = rng.normal(size=(*steps, n, n)) / n, rng.normal(size=(*steps, n, 1))
    C, E = rng.normal(size=(*steps, p, n)), rng.normal(size=(*steps, p, 1))
    H = rng.normal(size=(n + p, n + p))
    J = H @ H.T
    R = np.diag([0.0 if kind == "exact output" else 1.0, 2.0])
    more = dict(at_first=True) if "varying" in kind else {}
    if "mixed" in kind:
        R = J[n:, n:]
    if kind in ("correlated", "accurate"):
        R, more["S"] = J[n:, n:], J[:n, n:]
    return lb.Plant(
        A, B, C, E=E, dt=1.0, Q=J[:n, :n], R=R, P0=np.eye(n), x0=np.ones(n), **more
    )


def filtered(kind):
    return lb.Filter(drawn(kind), 1 if kind == "accurate" else 0)


def records(seed=0):
    """Some with gaps of their own, some without any, one without a reading."""
    rng = np.random.default_rng(seed)
    y, u = rng.normal(size=(M, N, 2)), rng.normal(size=(M, N, 1))
    y[3:18][rng.random((15, N, 2)) < 0.2] = np.nan
    y[18] = np.nan
    return y, u


@pytest.mark.parametrize("kind", KINDS)
def test_a_record_is_what_it_is_by_itself(kind, fast):
    y, u = records()
    run = filtered(kind)
    found = run.run(lb.Record(y, u, u0=[0.3]))
    for k in (0, 2, 3, 17, 18, 20):
        one = run.run(lb.Record(y[k], u[k], u0=[0.3]))
        for name in NAMES:
            mine, own = getattr(found, name)[k], getattr(one, name)
            if kind in SAME or k == 3:  # the same operations
                np.testing.assert_array_equal(mine, own, name)
            np.testing.assert_allclose(mine, own, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("p", [3, 4])
def test_every_set_of_outputs_has_noises_of_its_own(p, exact, fast):
    rng = np.random.default_rng(p)
    H, C = rng.normal(size=(p, p)), rng.normal(size=(p, 2))
    H[0, exact:] = 0.0
    H[0] *= not exact
    one = lb.Plant(
        [[0.9, 0.2], [0, 0.8]], None, C, dt=1.0, Q=np.eye(2), R=H @ H.T, P0=np.eye(2)
    )
    y = rng.normal(size=(6, 40, p))
    y[rng.random(y.shape) < 0.5] = np.nan
    found = lb.Filter(one).run(y)
    for k, own in enumerate(y):
        alone = lb.Filter(one).run(own)
        np.testing.assert_array_equal(found.x[k], alone.x)
        np.testing.assert_array_equal(found.std[k], alone.std)
        seen = ~np.isnan(own[0])  # the first row, by the textbook
        PC = (one.A @ one.A.T + np.eye(2)) @ C[seen].T
        x = PC @ np.linalg.solve(C[seen] @ PC + one.R[np.ix_(seen, seen)], own[0, seen])
        np.testing.assert_allclose(found.x[k, 0], x, rtol=1e-9, atol=1e-9)


def test_what_an_input_adds_to_a_reading_is_told_to_rounding(fast):
    known = lb.Plant([[1]], [[0]], [[1]], E=[[1 / 3]], dt=1.0, Q=[[1]], R=[[1]],
                     P0=[[1]])  # fmt: skip
    u = np.linspace(0.1, 1, 8).reshape(2, 4, 1)
    y = np.nextafter(u / 3, 9)
    y[0, 0] = np.nan
    found = lb.Filter(known).run(lb.Record(y, u))
    np.testing.assert_array_equal(found.x, np.zeros((2, 4, 1)))


@pytest.mark.parametrize("kind", KINDS)
def test_bits_hang_on_no_other_record(kind, fast):
    y, u = records()
    run, record = filtered(kind), lb.Record(y, u)
    whole = run.run(record)
    with ThreadPoolExecutor(3) as executor:
        parts = [*executor.map(run.run, record.split(4))]
    for name in ("x", "std"):
        joined = np.concatenate([getattr(part, name) for part in parts])
        np.testing.assert_array_equal(joined, getattr(whole, name))
    order = np.random.default_rng(1).permutation(M)
    mixed = run.run(lb.Record(y[order], u[order]))
    np.testing.assert_array_equal(mixed.x, whole.x[order])


def test_what_goes_to_other_processes_and_comes_back(fast):
    y, u = records()
    run = filtered("noisy")
    whole = run.run(lb.Record(y, u))
    there, record = pickle.loads(pickle.dumps((run, lb.Record(y, u))))
    back = pickle.loads(pickle.dumps(there.run(record)))
    for name in NAMES:
        np.testing.assert_array_equal(getattr(back, name), getattr(whole, name))


def test_parts_go_to_a_cluster():
    distributed = pytest.importorskip("distributed", reason="the extra `cluster`")
    run, record = filtered("noisy"), lb.Record(*records())
    with distributed.Client(processes=False, dashboard_address=None) as client:
        parts = [*client.get_executor().map(run.run, record.split(8))]
    joined = np.concatenate([part.x for part in parts])
    np.testing.assert_array_equal(joined, run.run(record).x)


@pytest.mark.parametrize("kind", KINDS)
def test_rows_go_on_where_they_ended(kind, fast):
    y, u = records()
    run = filtered(kind)
    whole, first = (run.run(lb.Record(y[:, :k], u[:, :k])) for k in (N, 11))
    rest = run.run(lb.Record(y[:, 11:], u[:, 11:]), start=first.end)
    for name in NAMES:
        joined = np.concatenate([getattr(X, name) for X in (first, rest)], axis=1)
        wanted = getattr(whole, name)
        if kind in SAME:
            np.testing.assert_array_equal(joined, wanted)
        np.testing.assert_allclose(joined, wanted, rtol=1e-10, atol=1e-10)
    one = run.run(lb.Record(y[5, 11:], u[5, 11:]), start=first.end[5])
    np.testing.assert_allclose(one.x, rest.x[5], rtol=1e-10, atol=1e-10)
    assert len(first.end[:2]) == 2 and first.end[4].instant == 11


def test_lists_of_several_lengths(fast):
    y, u = records()
    run = filtered("noisy")
    rows = [N, 7, 0, N, 12]
    given = [X[:k] for X, k in zip(y, rows)], [X[:k] for X, k in zip(u, rows)]
    found = run.run(lb.Record(*given))
    for k, (own, acts) in enumerate(zip(*given)):
        one = run.run(lb.Record(own, acts))
        for name in NAMES:
            np.testing.assert_array_equal(getattr(found, name)[k], getattr(one, name))
    parts = [run.run(part) for part in lb.Record(*given).split(2)]
    joined = [X for part in parts for X in part.x]
    assert all((a == b).all() for a, b in zip(joined, found.x, strict=True))
    alike = run.run(lb.Record([*y[:3]], [*u[:3]]))
    np.testing.assert_array_equal(alike.x, run.run(lb.Record(y[:3], u[:3])).x)


def test_tables_keep_their_index_and_names():
    pandas = pytest.importorskip("pandas", reason="the extra `tables`")
    plant = lb.Plant(
        [[0.5]], [[1]], [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[1]], state_names=["a"],
        output_names=["b"], input_names=["c"],
    )  # fmt: skip
    run = lb.Filter(plant)
    tables = [
        pandas.DataFrame({"c": [1.0, 2, 3], "b": [1.0, 0, 1]}, index=[5, 6, 7])[:k]
        for k in (3, 2)
    ]
    found = run.run(tables)
    for table, x in zip(tables, found.x):
        assert x.equals(run.run(table).x) and list(x.columns) == ["a"]


def test_what_all_have_is_given_once(fast):
    y, u = records()
    run = filtered("noisy")
    found = run.run(lb.Record(y, u[0]))
    np.testing.assert_array_equal(found.x, run.run(lb.Record(y, u[[0] * M])).x)
    parts = [part.x for part in map(run.run, lb.Record(y, u[0]).split(8))]
    np.testing.assert_array_equal(np.concatenate(parts), found.x)
    walk = lb.Plant([[0]], None, [[1]], Q=[[1]], R=[[1]], P0=[[1]])
    time = [0, 1, 5, 6]
    found = lb.Filter(walk).run(lb.Record(y[:, :4, :1], time=time))
    for k in (2, 5):
        one = lb.Filter(walk).run(lb.Record(y[k, :4, :1], time=time))
        np.testing.assert_array_equal(found.x[k], one.x)
        np.testing.assert_array_equal(found.std[k], one.std)
    first, rest = (
        lb.Record(y[:, k, :1], time=time[k]) for k in (slice(2), slice(2, 4))
    )
    end = lb.Filter(walk).run(first).end
    np.testing.assert_array_equal(
        lb.Filter(walk).run(rest, start=end).std, found.std[:, 2:]
    )


@pytest.mark.parametrize("kind", ["noisy", "many states"])
def test_without_gaps_deviations_are_held_once(kind, fast):
    y, u = records()
    found = filtered(kind).run(lb.Record(y[:3], u[:3]))
    assert found.std.strides[0] == 0 and not found.std.flags.writeable


def test_what_is_refused_names_its_record(fast):
    exact = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[0]], P0=[[1]])
    y = np.ones((5, 4, 1))
    y[3, 1] = np.nan
    y[3, 2] = 2.0
    with pytest.raises(lb.DesignError, match="record 3: at instant 3 .* contradicts"):
        lb.Filter(exact).run(y)
    y[3, 1] = 1.0
    with pytest.raises(lb.DesignError, match="record 3: at instant 3 .* contradicts"):
        lb.Filter(exact).run(y)
    grows = lb.Plant(
        [[2, 0], [1, 2]], None, np.eye(2), dt=1.0, Q=np.eye(2), R=np.eye(2),
        P0=np.eye(2),
    )  # fmt: skip
    y = np.ones((5, 60, 2))
    y[1, 3:50] = np.nan
    with pytest.raises(lb.DesignError, match="record 1: too few digits are left"):
        lb.Filter(grows).run(y)
    y[:, 3:50], y[2, 9, 1] = 1.0, np.inf
    with pytest.raises(ValueError, match="y is infinite in record 2, row 9"):
        lb.Filter(grows).run(y)


def test_sizes_that_disagree_are_refused():
    y, u = records()
    run = filtered("noisy")
    with pytest.raises(ValueError, match=r"y must be .* or \(M, N, 2\) for many"):
        run.run(y[..., :1])
    with pytest.raises(ValueError, match=r"u must be \(21, 30, 1\), or \(30, 1\)"):
        run.run(lb.Record(y, u[:, :4]))
    with pytest.raises(ValueError, match="u is missing or not finite in record 0, row"):
        run.run(lb.Record(y, np.where(u == u[0, 4], np.nan, u)))
    with pytest.raises(ValueError, match="record 1: y has 30 rows but u has 4"):
        run.run(lb.Record([*y], [u[0], u[1, :4], *u[2:]]))
    with pytest.raises(ValueError, match="y holds no record"):
        run.run(y[:0])
    with pytest.raises(ValueError, match="start must be as many"):
        run.run(lb.Record(y, u), start=run.run(lb.Record(y[0], u[0])).end)
    with pytest.raises(ValueError, match="arrival is for one record"):
        run.run(lb.Record(y, u, arrival=np.zeros((N, 2))))


def test_each_record_tells_of_its_own_start():
    """Where nothing is known of it: as the records one by one."""
    rng = np.random.default_rng(4)
    A, C = rng.normal(size=(3, 3)), rng.normal(size=(2, 3))
    one = lb.Filter(lb.Plant(A, None, C, dt=1.0, Q=np.eye(3), R=np.eye(2)))
    y = rng.normal(size=(3, 9, 2))
    y[1, 0] = np.nan
    found = one.run(y)
    more = one.run(y, start=found.end)
    for k in range(3):
        alone = one.run(y[k])
        assert np.array_equal(found.x[k], alone.x)
        assert np.array_equal(found.std[k], alone.std)
        assert np.array_equal(found.P[k], alone.P)
        assert np.array_equal(more.x[k], one.run(y[k], start=alone.end).x)
