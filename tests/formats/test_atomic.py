"""Files are written beside and renamed: real signals, full disks, links, devices."""

import errno
import os
import signal
import stat
import subprocess

import pytest
from interrupts import heeding, sigint  # noqa: F401  a fixture

from luenberger.formats import atomic

WRITER = """
import signal, sys, time
from luenberger.formats.atomic import replacing
signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
with replacing("kept.csv") as file:
    file.write("half of a new o")
    file.flush()
    print("ready", flush=True)
    time.sleep(60)
"""


def names(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize(
    "number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL], ids=lambda n: n.name
)
def test_interrupted_write_leaves_the_old_file(tmp_path, number):
    (tmp_path / "kept.csv").write_text("old")
    run = subprocess.Popen(
        heeding("-c", WRITER),
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert run.stdout.readline() == "ready\n"
    run.send_signal(number)
    run.communicate(timeout=60)
    assert run.returncode != 0 and (tmp_path / "kept.csv").read_text() == "old"
    beside = [name for name in names(tmp_path) if name != "kept.csv"]
    assert len(beside) == (number == signal.SIGKILL)
    assert all(name.startswith(".luenberger-") for name in beside)


def test_an_error_in_the_block_leaves_the_old_file(tmp_path):
    (tmp_path / "a").write_text("old")
    with pytest.raises(ZeroDivisionError), atomic.replacing(tmp_path / "a") as file:
        file.write("new")
        raise ZeroDivisionError
    assert names(tmp_path) == ["a"] and (tmp_path / "a").read_text() == "old"


def test_a_disk_that_is_full_is_said_with_the_file(tmp_path):
    with pytest.raises(OSError) as caught, atomic.replacing(tmp_path / "a"):
        raise OSError(errno.ENOSPC, "No space left on device")
    assert caught.value.filename == str(tmp_path / "a") and names(tmp_path) == []


def test_until_the_block_ends_the_old_file_is_there(tmp_path):
    (tmp_path / "a").write_text("old")
    with atomic.replacing(tmp_path / "a") as file:
        file.write("new")
        file.flush()
        assert (tmp_path / "a").read_text() == "old"
    assert names(tmp_path) == ["a"] and (tmp_path / "a").read_text() == "new"


def test_text_is_written_as_it_is(tmp_path):
    atomic.write(tmp_path / "a", "é\r\nb\n")
    assert (tmp_path / "a").read_bytes() == b"\xc3\xa9\r\nb\n"


def test_permissions(tmp_path):
    """An old file keeps its own; a new one has those that `open` would give."""

    def mode(name):
        return stat.S_IMODE((tmp_path / name).stat().st_mode)

    (tmp_path / "private").write_text("old")
    (tmp_path / "private").chmod(0o600)
    (tmp_path / "plain").write_text("")
    for name in ("private", "new"):
        atomic.write(tmp_path / name, "new")
    assert mode("private") == 0o600 and mode("new") == mode("plain")


def test_a_link_is_followed_and_stays(tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "file").write_text("old")
    (tmp_path / "link").symlink_to("there/file")
    atomic.write(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "there" / "file").read_text() == "new"
    assert names(tmp_path / "there") == ["file"]


def test_a_link_to_nothing_makes_the_file(tmp_path):
    (tmp_path / "link").symlink_to("target")
    atomic.write(tmp_path / "link", "new")
    assert (tmp_path / "target").read_text() == "new"


def test_a_link_that_comes_back_to_itself_stays(tmp_path):
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    with pytest.raises(OSError, match="symbolic links") as caught:
        atomic.write(tmp_path / "a", "new")
    assert caught.value.filename == str(tmp_path / "a")
    assert os.readlink(tmp_path / "a") == "b" and names(tmp_path) == ["a", "b"]


def test_the_nearest_folder(tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "link").symlink_to("there")
    (tmp_path / "file").write_text("")
    (tmp_path / "nowhere").symlink_to("absent")
    assert atomic.existing_folder(tmp_path / "there/a/b") == tmp_path / "there"
    assert atomic.existing_folder(tmp_path / "link") == tmp_path / "link"
    for name in ("file", "file/a", "nowhere", "nowhere/a/b"):
        said = name.partition("/")[0] + " is a "
        with pytest.raises(ValueError, match=f"{said}(file;|link that leads to no)"):
            atomic.existing_folder(tmp_path / name)


@pytest.mark.parametrize("kind", ["folder", "pipe", "device"])
def test_only_files_are_replaced(tmp_path, kind):
    path = tmp_path / "x"
    if kind == "folder":
        path.mkdir()
    elif kind == "pipe":
        os.mkfifo(path)
    else:
        path = os.devnull
    with pytest.raises(ValueError, match=f"x is a {kind}|is a device or a pipe"):
        atomic.write(path, "new")
    assert not os.path.isfile(path)


def test_a_folder_that_is_not_there_is_named(tmp_path):
    with pytest.raises(FileNotFoundError) as caught:
        atomic.write(tmp_path / "absent" / "a", "new")
    assert caught.value.filename == str(tmp_path / "absent" / "a")


def some(tmp_path, count=3):
    """Finished files, the paths they are to have, and a folder for old ones."""
    beside = tmp_path / "beside"
    beside.mkdir()
    moves = {beside / f"{k}": tmp_path / f"{k}" for k in range(count)}
    for k, path in enumerate(moves):
        path.write_text(f"new {k}")
    return moves, beside


def replace_failing_at(monkeypatch, number, error):
    calls, rename = [], os.replace

    def replace(*paths):
        calls.append(paths)
        if len(calls) == number:
            error()
        rename(*paths)

    monkeypatch.setattr(atomic.os, "replace", replace)


@pytest.mark.parametrize("failing", [1, 2, 3])
def test_several_files_are_replaced_or_none(tmp_path, monkeypatch, failing):
    (tmp_path / "1").write_text("old")
    moves, beside = some(tmp_path)

    def full():
        raise OSError("the disk is full")

    replace_failing_at(monkeypatch, failing, full)
    with pytest.raises(OSError, match="the disk is full"):
        atomic.replace_all(moves, beside)
    assert names(tmp_path) == ["1", "beside"]
    assert (tmp_path / "1").read_text() == "old"


@pytest.mark.usefixtures("sigint")
@pytest.mark.parametrize("at", [1, 2, 3])
def test_a_signal_between_renames_waits_for_the_last(tmp_path, monkeypatch, at):
    moves, beside = some(tmp_path)
    before = signal.getsignal(signal.SIGINT)
    replace_failing_at(monkeypatch, at, lambda: signal.raise_signal(signal.SIGINT))
    with pytest.raises(KeyboardInterrupt):
        atomic.replace_all(moves, beside)
    assert [path.read_text() for path in moves.values()] == ["new 0", "new 1", "new 2"]
    assert signal.getsignal(signal.SIGINT) is before


def test_write_all_makes_the_folder_and_leaves_nothing_else(tmp_path):
    paths = atomic.write_all(tmp_path / "a" / "b", {"one": "1", "two": "2"})
    assert paths == [tmp_path / "a/b/one", tmp_path / "a/b/two"]
    assert names(tmp_path / "a/b") == ["one", "two"]
