"""The texts of kernels as instructions: the same bits as by numba's front end."""

import numpy as np
import pytest
from in_full import in_full

import luenberger as lb
from luenberger import kernels
from luenberger.kernels import cache, making, stack

numba = pytest.importorskip("numba", reason="numba is an optional extra")

TYPES = "i8", "f8[:,::1]", "f8[::1]", "i8[::1]", "b1[::1]"
HEAD = "import numpy as np\ndef run(n, X, v, k, b):\n"
# what texts are made of
TEXTS = {
    "sums": "v[0] = X[1, 2] * v[1] - v[2] / 3.0 + 2 * n - -v[4]",
    "sums in place": "v[1] += X[0, 1] * v[2]\n    v[2] -= 0.5\n    v[3] *= v[n]",
    "an index from the end": "v[0] = v[n - 4] + X[n - 5, n - 4]\n    v[1] = v[k[1]]",
    "rests and quotients": (
        "for i in range(-7, 9):\n"
        "        v[i % 5] += i // 3\n"
        "        v[(i + n) % 4] += i // 4 % 3"
    ),
    "extremes": "v[0] = max(v[1], v[2])\n    v[3] = min(abs(v[4]), v[5])",
    "extremes of whole numbers": "v[min(n, 2)] = max(k[0], n - 1) + 1.5",
    "NaN": (
        "v[0] = max(v[6], v[1])\n    v[2] = max(v[1], v[6])\n"
        "    v[3] = 1.0 if v[6] == v[6] else 2.0\n"
        "    v[4] = 1.0 if v[6] != v[6] else 2.0\n"
        "    v[5] = 1.0 if not v[6] > 0.0 else 2.0"
    ),
    "nothing is read that is not wanted": (
        "v[0] = v[1000000000] if n > 1000000 else 1.0\n"
        "    if n < 1000000 or b[1000000000]:\n        v[1] = 7.0\n"
        "    if n > 1000000 and v[1000000000] > 0.0:\n        v[2] = 7.0"
    ),
    "a chain": (
        "b[0] = 1 <= n < 4\n    b[1] = 1 <= n < 3 or not b[3]\n    b[2] = 4 <= n < 9"
    ),
    "loops that end early": (
        "s = 0.0\n    for i in range(1, n + 2, 2):\n"
        "        for j in range(i):\n            s += X[1, j]\n"
        "            if s > v[2]:\n                break\n        v[0] += s\n"
        "    v[1] = s"
    ),
    "a name that the next turn reads": (
        "a = v[0]\n    for i in range(n):\n        v[i] = a\n        a = v[3] + i"
    ),
    "loops of no turn": "for i in range(n, n):\n        v[0] = 5.0",
    "names that are bound again": (
        "a = v[0]\n    a = a + 1.0\n    c = a\n    for i in range(n):\n"
        "        d = a\n        a = c + i\n        c = d\n        if i == 1:\n"
        "            c = a * 2.0\n        else:\n            e = c\n"
        "            v[4] = e\n    v[0] = a\n    v[1] = c\n    v[2] = d"
    ),
    "rows and parts of rows": (
        "row = X[k[0]]\n    part = v[1:4]\n    end = X[1, n - 2:n]\n"
        "    part[0] = row[2]\n    row[0] = end[1] + part[2]\n    part = row\n"
        "    part[1] = 3.5"
    ),
    "rooms": (
        "a = array(3)\n    c = np.empty((2, 3))\n    d = np.zeros(n)\n"
        "    e = np.empty(4, np.int64)\n    for i in range(3):\n"
        "        a[i] = v[i]\n        c[1, i] = a[i] * d[i]\n        e[i] = n - i\n"
        "        v[i] = c[1, i] + e[i] + d[n - 1]\n    v[5] = v.shape[0] + X.shape[1]"
    ),
    "functions": (
        "v[0] = fma(-v[1], v[2], 2)\n    fetch(X, n + 99, 0)\n"
        "    product(1, 1, 1, 2, 1, 0, -1.0, v, 0, 2, v, 2, 2, v, 4, 2, 1, v, 4, 2)"
    ),
    "infinity": "v[0] = -np.inf\n    v[1] = np.inf if b[0] else 0.0",
}


def given():
    v = np.array([0.3, -1.7, 2.9, 0.11, 5.3, -0.7, np.nan, 1e-3])
    X = np.arange(12.0).reshape(3, 4) / 7 - 0.4
    return 3, X, v, np.array([2, -3]), np.array([True, False, True, False])


def by_numba(text, exact):
    way = making.Way(text, stack.ours())
    return cache._settled(making.jit(making.function(way, "whole"), exact), TYPES)


def directly(text, exact):
    function = making.function(making.soon(text), "soon")
    return cache._settled(making.jit(function, exact), TYPES)


# each kind of instruction on numbers; elsewhere what is joined says enough
EXACT = "sums", "sums in place", "extremes", "NaN", "loops that end early", "functions"


@pytest.mark.parametrize("what", TEXTS)
def test_bits_are_those_of_numba(what):
    """And what Python computes, up to the rounding of what is joined."""
    text = f"{HEAD}    {TEXTS[what]}\n    return n + 1\n"
    for exact in (False, True) if what in EXACT else (False,):
        wanted, found = given(), given()
        assert by_numba(text, exact)(*wanted) == directly(text, exact)(*found) == 4
        for one, other in zip(wanted[1:], found[1:]):
            assert one.tobytes() == other.tobytes()
    plain = given()
    making.function(making.Way(text, stack.plain()), "plain")(*plain)
    for one, other in zip(plain[1:], found[1:]):
        np.testing.assert_allclose(one, other, rtol=1e-14)


@pytest.mark.parametrize(
    "lines",
    [
        "v[1] = np.sqrt(v[0])",
        "for i in range(n, 0, -1):\n        v[i] = 0.0",
        "while v[0] > 0.0:\n        v[0] -= 1.0",
        "s = 0\n    for i in range(n):\n        s = s + v[0]\n    v[1] = s",
        "w = v\n    for i in range(n):\n        w = v[1:2]\n    w[0] = 1.0",
        "v[0:2] = 1.0",
        "for i in range(n):\n        w = np.empty(300)\n        v[0] = w.shape[0]",
        "v[0] = n / 2",
    ],
)
def test_what_has_no_instructions_numba_compiles(lines, tmp_path, monkeypatch):
    """It is kept like all others."""
    monkeypatch.setenv("LUENBERGER_CACHE", str(tmp_path))
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    text = f"{HEAD}    {lines}\n    return n\n"
    with pytest.raises(making.Unknown):
        directly(text, True)
    wanted, found = given(), given()
    cache.compiled(text, TYPES, exact=True)(*found)
    making.function(making.Way(text, stack.plain()), "plain")(*wanted)
    for one, other in zip(wanted[1:], found[1:]):
        np.testing.assert_allclose(one, other, rtol=1e-14)
    assert list(tmp_path.rglob("*.nbc"))


def test_a_result_may_be_a_truth():
    text = (
        f"{HEAD}    ok = True\n    if v[0] > 1.0:\n        ok = False\n    return ok\n"
    )
    assert directly(text, True)(*given()) is True


def test_every_way_of_writing_a_record_has_instructions(monkeypatch):
    """Nothing is left to numba's front end: scalars and loops."""

    def left():
        raise AssertionError("a text is left to numba as a whole")

    monkeypatch.setattr(stack, "ours", left)
    for one in (kernels.over_record, cache.compiled):
        one.cache_clear()
    rng = np.random.default_rng(1)
    for n in (2, 7):
        one = np.eye(n)
        plant = lb.Plant(one / 2, None, one[:1], dt=1, Q=one, R=[[1]], P0=one)
        in_full(plant, rng.normal(size=(400, 1)), backend="numba")
