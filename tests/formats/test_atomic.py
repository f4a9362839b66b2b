"""Files are written beside and renamed: real signals, full disks, links, devices."""

import errno
import os
import pathlib
import signal
import stat
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest
from interrupts import heeding, sigint  # noqa: F401  a fixture

from luenberger.formats import atomic, folder_lock

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


# -------------------------------------------------------------- more than one process

NAMES = ("report.html", "plant.json", "design.ipynb", "observer.json", "designs.csv")
ROUNDS = """
import sys
from luenberger.formats.atomic import write_all
who, *names = sys.argv[1:]
for line in sys.stdin:
    write_all(".", {name: who * 2000 for name in names})
    print("done", flush=True)
"""
HOLDER = """
import pathlib, sys, time
from luenberger.formats.folder_lock import alone_in
with alone_in(pathlib.Path(".")):
    print("ready", flush=True)
    time.sleep(60)
"""


def started(folder, *arguments):
    return subprocess.Popen(
        [sys.executable, "-c", *arguments],
        cwd=folder,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


def test_files_of_two_processes_do_not_mix(tmp_path):
    """In either order of the files; the lock does not stay."""
    orders = {"A": NAMES, "B": NAMES, "C": NAMES[::-1]}
    runs = [started(tmp_path, ROUNDS, who, *order) for who, order in orders.items()]
    for _ in range(60):
        for run in runs:
            run.stdin.write("now\n")
            run.stdin.flush()
        assert [run.stdout.readline() for run in runs] == ["done\n"] * 3
        assert len({(tmp_path / name).read_text() for name in NAMES}) == 1
        assert names(tmp_path) == sorted(NAMES)
    for run in runs:
        run.communicate(timeout=60)
        assert run.returncode == 0


def test_files_of_two_threads_do_not_mix(tmp_path):
    def write(who):
        for _ in range(30):
            atomic.write_all(tmp_path, dict.fromkeys(NAMES, who))

    with ThreadPoolExecutor(4) as threads:
        list(threads.map(write, "ABCD"))
    assert len({(tmp_path / name).read_text() for name in NAMES}) == 1
    assert names(tmp_path) == sorted(NAMES)


def test_what_shall_not_stay_goes_before_another_writes(tmp_path, monkeypatch):
    """While files go, the folder is locked."""
    moves, beside = some(tmp_path)
    (tmp_path / "stale").write_text("old")
    monkeypatch.setattr(folder_lock, "PATIENCE", 0)
    unlink = pathlib.Path.unlink

    def seen(path, missing_ok=False):
        if path.name == "stale":
            with pytest.raises(OSError, match="another process"):
                atomic.write_all(tmp_path, {"other": "x"})
        unlink(path, missing_ok)

    monkeypatch.setattr(pathlib.Path, "unlink", seen)
    atomic.replace_all(moves, beside, [tmp_path / "stale", tmp_path / "never"])
    assert names(tmp_path) == ["0", "1", "2", "beside"]


def test_one_that_waits_too_long_says_so_and_one_that_died_does_not_block(
    tmp_path, monkeypatch
):
    run = started(tmp_path, HOLDER)
    assert run.stdout.readline() == "ready\n"
    monkeypatch.setattr(folder_lock, "PATIENCE", 0.05)
    with pytest.raises(OSError, match="another process has been writing") as caught:
        atomic.write_all(tmp_path, {"a": "new"})
    assert caught.value.filename == str(tmp_path)
    assert names(tmp_path) == [folder_lock.NAME]
    run.kill()
    run.communicate(timeout=60)
    assert names(tmp_path) == [folder_lock.NAME]
    atomic.write_all(tmp_path, {"a": "new"})
    assert names(tmp_path) == ["a"]


def test_a_disk_without_locks_is_written_to(tmp_path, monkeypatch):
    fcntl = pytest.importorskip("fcntl", reason="of POSIX only")

    def flock(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(fcntl, "flock", flock)
    atomic.write_all(tmp_path, {"a": "new"})
    assert names(tmp_path) == ["a"]


def test_a_lock_that_its_holder_removed_is_none(tmp_path, monkeypatch):
    """It was opened before it went and locked after: another may hold the new one."""
    fcntl = pytest.importorskip("fcntl", reason="of POSIX only")
    lock, calls = fcntl.flock, []

    def flock(number, how):
        calls.append(number)
        if len(calls) == 1:
            (tmp_path / folder_lock.NAME).unlink()
        elif len(calls) == 2:  # and this one is another's now
            (tmp_path / folder_lock.NAME).rename(tmp_path / "theirs")
            (tmp_path / folder_lock.NAME).touch()
        lock(number, how)

    monkeypatch.setattr(fcntl, "flock", flock)
    with folder_lock.alone_in(tmp_path):
        assert len(calls) == 3
        here = (tmp_path / folder_lock.NAME).stat()
        assert os.path.samestat(os.fstat(calls[-1]), here)
        close, at_end = os.close, []

        def closed(number):
            at_end.append(names(tmp_path))
            close(number)

        monkeypatch.setattr(os, "close", closed)
    assert at_end == [["theirs"]]  # removed while it was locked
