"""What is generated is kept for the next process, and trusted only if it is ours."""

import os
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
from in_full import in_full

import luenberger as lb
from luenberger import kernels
from luenberger.kernels import cache
from luenberger.kernels import kept as kept_texts

numba = pytest.importorskip("numba", reason="numba is an optional extra")

PLANT = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[2]], R=[[1]], P0=[[1]])


def forget():
    """As a new process would begin."""
    kernels.compiled.cache_clear()
    kernels.over_record.cache_clear()
    cache.compiled.cache_clear()


@pytest.fixture
def home(tmp_path, monkeypatch):
    folder = tmp_path / "kept"
    monkeypatch.setenv("LUENBERGER_CACHE", str(folder))
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    forget()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield folder
    forget()


@pytest.fixture
def compilations(monkeypatch):
    """The number of times that numba compiled, and did not read."""
    done, settled = [], cache._settled

    def watched(run, types):
        run = settled(run, types)
        done.append(sum(run.stats.cache_hits.values()) == 0)
        return run

    monkeypatch.setattr(cache, "_settled", watched)
    return done


def estimated():
    forget()
    found = in_full(PLANT, [[2]] * 3, backend="numba").x
    np.testing.assert_allclose(found, in_full(PLANT, [[2]] * 3).x, rtol=1e-12)


def doubled():
    """The same of a text that takes the least time to compile."""
    forget()
    text = "def run(n_):\n    return 2 * n_\n"
    assert cache.compiled(text, ("i8",))(21) == 42


def kept(home, pattern):
    found = sorted(home.rglob(pattern))
    assert found, pattern
    return found


def test_arguments_of_other_types_are_refused_and_compile_nothing():
    run = cache._settled(numba.njit(lambda x: x[0]), ["f8[::1]"])
    assert run(np.ones(2)) == 1
    with pytest.raises(TypeError, match="No matching definition"):
        run(np.ones(2, dtype=np.float32))


def test_the_second_time_nothing_is_compiled(home, compilations):
    estimated()
    estimated()
    assert compilations == [True, False]
    assert len(kept(home, "luenberger_*.py")) == 1
    assert len(kept(home, "*.nbc")) == len(kept(home, "*.sha256")) == 1
    if hasattr(os, "getuid"):
        assert home.stat().st_mode & 0o777 == 0o700


def test_a_second_process_neither_compiles_nor_derives(home, compilations):
    """Neither the loop over a record nor the NumPy kernels of its first row."""
    plant = lb.Plant([[0.5]], None, [[1]], dt=1, Q=[[1]], R=[[1]], P0=[[1]])
    D = lb.kalman_filter(plant, steps=1, backend="numpy").D
    estimated()
    code = (
        "import sys\n"
        "import luenberger as lb\n"
        "from luenberger.kernels import cache\n"
        "settled = cache._settled\n"
        "def watched(run, types):\n"
        "    run = settled(run, types)\n"
        "    print(sum(run.stats.cache_hits.values()))\n"
        "    return run\n"
        "cache._settled = watched\n"
        "q = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[2]], R=[[1]], P0=[[1]])\n"
        "print(lb.kalman_filter(q, steps=3, backend='numba').D.shape)\n"
        "p = lb.Plant([[0.5]], None, [[1]], dt=1, Q=[[1]], R=[[1]], P0=[[1]])\n"
        "D = lb.kalman_filter(p, steps=1, backend='numpy').D\n"
        "print(D.tolist(), 'sympy' in sys.modules)\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    said = run.stdout.splitlines()
    assert said == ["1", "(3, 1, 1)", f"{D.tolist()} False"], run.stderr


def truncate(path):
    path.write_bytes(path.read_bytes()[:100])


def change_a_byte(path):
    data = bytearray(path.read_bytes())
    data[-20] ^= 1
    path.write_bytes(data)


BROKEN = {
    "code cut short": ("*.nbc", truncate),
    "code with one byte changed": ("*.nbc", change_a_byte),
    "index cut short": ("*.nbi", truncate),
    "index empty": ("*.nbi", lambda path: path.write_bytes(b"")),
    "no hashes": ("*.sha256", Path.unlink),
    "hashes of something else": ("*.sha256", lambda path: path.write_text("00  x\n")),
    "hashes that are no text": (
        "*.sha256",
        lambda path: path.write_bytes(b"\xff\xfe\0"),
    ),
    "no code": ("*.nbc", Path.unlink),
    "writable by all": ("*.nbc", lambda path: path.chmod(0o666)),
}


@pytest.mark.parametrize("pattern, harm", BROKEN.values(), ids=BROKEN.keys())
def test_a_broken_entry_is_made_anew(pattern, harm, home, compilations):
    if pattern == "*.nbc" and harm is BROKEN["writable by all"][1] and os.name == "nt":
        pytest.skip("permissions of this kind are POSIX")
    doubled()
    (path,) = kept(home, pattern)
    harm(path)
    doubled()
    doubled()
    assert compilations == [True, True, False]


@pytest.mark.skipif(os.name == "nt", reason="umask is POSIX's")
@pytest.mark.parametrize("umask", [0o002, 0o000])
def test_a_loose_umask_costs_nothing(home, compilations, umask):
    """002 is many a system's own: numba's files are then open to the user's group."""
    before = os.umask(umask)
    try:
        doubled()
        doubled()
    finally:
        os.umask(before)
    assert compilations == [True, False]
    assert all(kept_texts.private(path) for path in home.rglob("*"))


def test_foreign_text_is_never_run(home, compilations):
    doubled()
    (path,) = kept(home, "luenberger_*.py")
    ours = path.read_text()
    path.write_text(ours + "raise SystemExit('foreign text was run')\n")
    doubled()
    assert path.read_text() == ours


def test_a_text_that_others_can_change_is_written_anew(home, compilations):
    """It says what it should, and might say something else a moment later."""
    doubled()
    (path,) = kept(home, "luenberger_*.py")
    if os.name != "nt":
        path.chmod(0o666)
        doubled()
        assert kept_texts.ours(path)
    path.rename(path.with_suffix(".away"))
    path.symlink_to(path.with_suffix(".away"))
    doubled()
    assert not path.is_symlink()


def test_foreign_machine_code_is_never_loaded(home, compilations, tmp_path):
    """Somebody else's files under our names: a pickle that would call what it likes."""
    doubled()
    for path in kept(home, "*.nb?"):
        path.write_bytes(
            b"cos\nsystem\n(S'touch %s'\ntR." % str(tmp_path / "x").encode()
        )
    doubled()
    assert not (tmp_path / "x").exists()
    assert compilations == [True, True]


def test_a_disk_that_fails_costs_only_time(home, monkeypatch):
    def full(path, text):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(cache, "replace", full)
    with pytest.warns(UserWarning, match="not kept: .*No space left"):
        estimated()


def test_numba_may_keep_its_files_elsewhere(home, tmp_path, monkeypatch, compilations):
    """NUMBA_CACHE_DIR is honoured, and its folder is looked at as ours is."""
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir(mode=0o700)
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(elsewhere))
    doubled()
    (path,) = kept(elsewhere, "*.nbc")
    truncate(path)
    doubled()
    doubled()
    assert compilations == [True, True, False]


def test_another_version_is_another_entry(monkeypatch):
    before = cache.key("text", ("f8",))
    assert cache.key("text", ("f8",)) == before
    assert cache.key("text ", ("f8",)) != before != cache.key("text", ("i8",))
    monkeypatch.setattr(numba, "__version__", "9.9")
    assert cache.key("text", ("f8",)) != before
