"""What is derived is kept for the next process, and trusted only if it is ours."""

import os
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import luenberger as lb
from luenberger import kernels
from luenberger.kernels import kept
from luenberger.kernels.text import MODULE
from luenberger.papers.leondes_novak.derivation import error_recursion, gain_step


def forget():
    """As a new process would begin."""
    kernels.compiled.cache_clear()


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


def files(home, pattern):
    found = sorted(home.rglob(pattern))
    assert found, pattern
    return found


def doubled():
    """A text that takes little time to compile; how often its code was found."""
    pytest.importorskip("numba", reason="numba is an optional extra")
    from luenberger.kernels.jit import jitted

    jitted.cache_clear()
    run = jitted(f"{MODULE}def run(X):\n    return 2.0 * symmetrise(X)\n")
    assert run(np.array([[1.0, 0], [4, 1]])).tolist() == [[2, 4], [4, 2]]
    return sum(run.stats.cache_hits.values())


def test_the_second_time_nothing_is_compiled(home):
    assert [doubled(), doubled()] == [0, 1]
    (module,) = files(home, "run_*.py")
    assert all(kept.private(path) for path in home.rglob("*") if path.is_dir())
    text = module.read_text()
    module.write_text(text + "raise SystemExit('foreign text was run')\n")
    doubled()
    assert module.read_text() == text


@pytest.mark.skipif(os.name == "nt", reason="permissions of this kind are POSIX's")
def test_machine_code_that_others_can_change_is_not_loaded(home):
    assert [doubled(), doubled()] == [0, 1]
    (below,) = files(home, "__pycache__")
    below.chmod(0o777)
    assert doubled() == 0


def test_a_second_process_derives_nothing(home):
    code = (
        "import sys\n"
        "import luenberger as lb\n"
        "p = lb.Plant([[0.5]], None, [[1]], dt=1, Q=[[1]], R=[[1]], P0=[[1]])\n"
        "print(lb.kalman_filter(p).V, 'sympy' in sys.modules)\n"
    )
    said = []
    for _ in range(2):
        run = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True
        )
        said.append(run.stdout.split())
    assert [one[1] for one in said] == ["True", "False"]
    assert said[0][0] == said[1][0]


def test_each_question_has_an_answer_of_its_own(home):
    """Another list, other outputs and stacks: another text, and the same next time."""
    asked = [(gain_step, "M"), (gain_step, "K"), (error_recursion, "Sigma")]
    texts = []
    for _ in range(2):
        for one in asked:
            for stacks in (False, True):
                texts.append(kernels.compiled(*one, stacks=stacks).source)
        forget()
    assert texts[:6] == texts[6:] and len(set(texts)) == 6
    assert len(files(home, "derived_*.txt")) == 6


@pytest.mark.skipif(os.name == "nt", reason="permissions of this kind are POSIX's")
def test_a_folder_that_is_not_trusted_is_no_remark_on_a_design(tmp_path, monkeypatch):
    monkeypatch.setenv("LUENBERGER_CACHE", str(tmp_path))
    tmp_path.chmod(0o777)
    plant = lb.Plant([[0.5]], None, [[1]], dt=1, Q=[[1]], R=[[1]])
    forget()
    with warnings.catch_warnings(record=True):
        warnings.simplefilter("always")
        table = lb.compare(plant)
        with pytest.warns(kept.CacheWarning, match="can be written by others"):
            kept.usable_folder()
    forget()
    assert str(tmp_path) not in f"{table.to_rows()} {table.reasons()}"


@pytest.fixture
def answered(home):
    """A question that was answered once: its file, and who counts the answers."""
    answers = []

    def answer(text="right", question="what"):
        return kept.derived(question, lambda: answers.append(text) or (text, ["x"]))

    assert answer() == ("right", ["x"])
    assert list(answer("not asked for")) == ["right", ["x"]] and answers == ["right"]
    (path,) = files(home, "derived_*.txt")
    return path, answer, answers


def change_a_letter(path):
    path.write_text(path.read_text().replace("right", "wrong"))


def seal_it_again(path):
    """A hash of the text alone, as of a file that says nothing of the question."""
    note = path.read_text().partition("\n")[2].replace("right", "wrong")
    path.write_text(f"{kept._seal('', note)}\n{note}")


def put_a_link(path):
    path.rename(path.with_suffix(".away"))
    path.symlink_to(path.with_suffix(".away"))


SPOILT = {
    "cut short": lambda path: path.write_bytes(path.read_bytes()[:-3]),
    "empty": lambda path: path.write_bytes(b""),
    "no text": lambda path: path.write_bytes(b"\xff\xfe\0"),
    "edited": change_a_letter,
    "edited, and its own hash": seal_it_again,
    "gone": Path.unlink,
    "a folder": lambda path: path.unlink() or path.mkdir(),
    "a link": put_a_link,
    "writable by all": lambda path: path.chmod(0o666),
}


@pytest.mark.parametrize("harm", SPOILT.values(), ids=SPOILT)
def test_a_spoilt_text_is_derived_anew(harm, answered):
    path, answer, answers = answered
    harm(path)
    if path.is_dir():
        with pytest.warns(UserWarning, match="a derivation is not kept"):
            assert answer("anew")[0] == "anew"
        return
    assert answer("anew")[0] == "anew" == answer("not asked for")[0]
    assert answers == ["right", "anew"]


def test_the_answer_to_another_question_is_not_taken(answered, home):
    path, answer, answers = answered
    answer("left", question="where")
    (other,) = set(files(home, "derived_*.txt")) - {path}
    other.replace(path)
    assert answer("anew")[0] == "anew" and answers == ["right", "left", "anew"]


def test_other_sources_or_versions_are_another_question(monkeypatch, tmp_path):
    for part in kept.DERIVING:
        path = tmp_path / part.replace("*", "moore")
        path = path if part.endswith(".py") else path / "a.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("1")
    monkeypatch.setattr(kept, "HOME", tmp_path)
    names = []

    def name():
        kept.sources.cache_clear()
        names.append(kept.asked("what"))

    name()
    package = tmp_path / "luenberger"
    (package / "numeric" / "linalg.py").write_text("2")
    name()
    (package / "papers" / "moore" / "derivation" / "a.py").write_text("2")
    name()
    (tmp_path / "matrixproof" / "a.py").write_text("2")
    name()
    (package / "kernels" / "a.py").rename(package / "kernels" / "b.py")
    name()
    monkeypatch.setattr(np, "__version__", "9.9")
    name()
    monkeypatch.setattr("importlib.metadata.version", lambda name: "9.9")
    name()
    monkeypatch.setattr(sys, "version", "9.9")
    name()
    assert len(set(names)) == len(names) == 8 and None not in names
    (package / "numeric" / "linalg.py").unlink()
    name()
    assert names[-1] is None  # a library without its sources: nothing is kept
    kept.sources.cache_clear()


def test_a_folder_that_others_can_write_to_is_not_used(home):
    home.mkdir()
    home.chmod(0o777)
    forget()
    with pytest.warns(UserWarning, match="can be written by others.*LUENBERGER_CACHE"):
        assert kept.usable_folder() is None
    with pytest.warns(UserWarning):
        doubled()
    assert list(home.iterdir()) == []


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="files have no owner here")
def test_a_folder_of_somebody_else_is_not_used(home, monkeypatch):
    home.mkdir(mode=0o700)
    monkeypatch.setattr(os, "getuid", lambda: home.stat().st_uid + 1)
    with pytest.warns(UserWarning, match="belongs to somebody else"):
        doubled()
    assert list(home.iterdir()) == []


def test_a_folder_that_cannot_be_made_costs_only_time(home, monkeypatch, tmp_path):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("LUENBERGER_CACHE", str(tmp_path / "file" / "below"))
    doubled()
    assert (tmp_path / "file").read_text() == "in the way"


def test_half_a_file_is_never_left(home, monkeypatch):
    home.mkdir(mode=0o700)
    monkeypatch.setattr(os, "replace", lambda *_: (_ for _ in ()).throw(OSError(5, "")))
    with pytest.raises(OSError):
        kept.replace(home / "a", "text")
    assert list(home.iterdir()) == []


PLACES = [
    ("linux", {"XDG_CACHE_HOME": "/x"}, "/x/luenberger"),
    ("linux", {}, "/home/me/.cache/luenberger"),
    ("darwin", {}, "/home/me/Library/Caches/luenberger"),
    ("win32", {"LOCALAPPDATA": "/local"}, "/local/luenberger"),
    ("linux", {"LUENBERGER_CACHE": "/here", "XDG_CACHE_HOME": "/x"}, "/here"),
]


@pytest.mark.parametrize("platform, environment, wanted", PLACES)
def test_where_the_folder_is(platform, environment, wanted, monkeypatch):
    for name in ("LUENBERGER_CACHE", "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(kept.sys, "platform", platform)
    monkeypatch.setattr(Path, "home", lambda: Path("/home/me"))
    assert kept.folder() == Path(wanted)


def test_without_a_home_nothing_is_kept(monkeypatch):
    def homeless():
        raise RuntimeError("Could not determine home directory.")

    for name in ("LUENBERGER_CACHE", "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(Path, "home", homeless)
    assert kept.usable_folder() is None
