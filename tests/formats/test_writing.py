"""Files are written beside and renamed: the old one stays until all is there."""

import errno
import os
import signal
import stat
import subprocess

import pytest
from interrupts import heeding

from luenberger.formats import writing

WRITER = """
import signal, sys, time
from luenberger.formats.writing import replacing
with replacing("kept.csv") as file:
    file.write("half of a new o")
    file.flush()
    print("ready", flush=True)
    time.sleep(60)
"""


def names(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_interrupted_write_leaves_the_old_file(tmp_path, number):
    (tmp_path / "kept.csv").write_text("old")
    pipe = dict(stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    run = subprocess.Popen(heeding("-c", WRITER), cwd=tmp_path, **pipe)
    assert run.stdout.readline() == "ready\n"
    run.send_signal(number)
    run.communicate(timeout=60)
    assert run.returncode != 0 and (tmp_path / "kept.csv").read_text() == "old"
    beside = [name for name in names(tmp_path) if name != "kept.csv"]
    assert len(beside) == (number == signal.SIGKILL)


def test_an_error_in_the_block_leaves_the_old_file(tmp_path):
    (tmp_path / "a").write_text("old")
    with pytest.raises(ZeroDivisionError), writing.replacing(tmp_path / "a") as file:
        file.write("new")
        raise ZeroDivisionError
    assert names(tmp_path) == ["a"] and (tmp_path / "a").read_text() == "old"


def test_a_disk_that_is_full_is_said_with_the_file(tmp_path):
    with pytest.raises(OSError) as caught, writing.replacing(tmp_path / "a"):
        raise OSError(errno.ENOSPC, "No space left on device")
    assert caught.value.filename == str(tmp_path / "a") and names(tmp_path) == []


def test_until_the_block_ends_the_old_file_is_there(tmp_path):
    (tmp_path / "a").write_text("old")
    with writing.replacing(tmp_path / "a") as file:
        file.write("new")
        file.flush()
        assert (tmp_path / "a").read_text() == "old"
    assert names(tmp_path) == ["a"] and (tmp_path / "a").read_text() == "new"


def test_text_is_written_as_it_is(tmp_path):
    writing.write(tmp_path / "a", "é\r\nb\n")
    assert (tmp_path / "a").read_bytes() == b"\xc3\xa9\r\nb\n"


def test_permissions(tmp_path):
    """An old file keeps its own; a new one has those that `open` would give."""

    def mode(name):
        return stat.S_IMODE((tmp_path / name).stat().st_mode)

    (tmp_path / "private").write_text("old")
    (tmp_path / "private").chmod(0o600)
    (tmp_path / "plain").write_text("")
    for name in ("private", "new"):
        writing.write(tmp_path / name, "new")
    assert mode("private") == 0o600 and mode("new") == mode("plain")


def test_a_link_is_followed_and_stays(tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "link").symlink_to("there/file")
    for text in ("new", "newer"):  # where it leads to nothing, and to a file
        writing.write(tmp_path / "link", text)
        assert (tmp_path / "link").is_symlink()
        assert (tmp_path / "there" / "file").read_text() == text
    assert names(tmp_path / "there") == ["file"]


@pytest.mark.parametrize(
    ("path", "said"),
    [
        (".", "is a folder"),
        (os.devnull, "is a device or a pipe"),
        ("no/a", "there is no folder"),
    ],
)
def test_only_files_are_replaced(tmp_path, path, said):
    with pytest.raises(ValueError, match=f"{said}.*(name a file|make it first)"):
        writing.write(tmp_path / path, "new")
    assert names(tmp_path) == []


def test_several_files_are_written_before_one_is_replaced(tmp_path, monkeypatch):
    paths = writing.write_all(tmp_path / "a" / "b", {"one": "1", "two": "2"})
    assert paths == [tmp_path / "a/b/one", tmp_path / "a/b/two"]
    assert [path.read_text() for path in paths] == ["1", "2"]
    with pytest.raises(TypeError):
        writing.write_all(tmp_path / "a" / "b", {"one": "new", "two": None})
    assert names(tmp_path / "a/b") == ["one", "two"]
    assert [path.read_text() for path in paths] == ["1", "2"]
    with pytest.raises(ValueError, match="one is a file; a folder is needed"):
        writing.write_all(paths[0] / "c", {"x": ""})
