"""A copy of the tree, and children of this process that run tests in it."""

import math
import os
import pickle
import resource
import shutil
import signal
import subprocess
import sys
import time
import traceback
from contextlib import suppress
from pathlib import Path

CLOCK = 10  # seconds of the clock for a second of the processor
HERE = Path(__file__).parent
IGNORED = ("*", ".git", ".venv", "__pycache__", "*.egg-info", ".pytest_cache")


class Tree:
    """A copy of a repository in a folder of its own, with caches of its own."""

    def __init__(self, repository, folder, package):
        self.root, self.folder = folder / "tree", folder
        self.package = next(self.root / p for p in _packages(repository, package))
        _copy(repository, self.root)
        for name in ("cache", "notes", "start"):
            (folder / name).mkdir()
        start = "import os\nif 'REACH_FOLDER' in os.environ:\n"
        start += "    import reach\n    reach.install_from_environment()\n"
        (folder / "start" / "sitecustomize.py").write_text(start)
        subprocess.run(
            [sys.executable, "-m", "compileall", "-q", str(self.package)], check=True
        )

    def environment(self):
        paths = [self.package.parent, self.folder / "start", HERE]
        return dict(
            PYTHONPATH=os.pathsep.join(map(str, paths)),
            PYTHONDONTWRITEBYTECODE="1",
            LUENBERGER_CACHE=str(self.folder / "cache"),
            OPENBLAS_NUM_THREADS="1",
        )

    def enter(self, **environment):
        """In a child: the copy is the library and the current folder from here on."""
        os.environ.update(self.environment() | environment)
        sys.path[:0] = [str(self.package.parent), str(HERE)]
        sys.dont_write_bytecode = True
        os.chdir(self.root)


def _packages(repository, package):
    for place in ("lib", "src", "."):
        if (repository / place / package / "__init__.py").exists():
            yield Path(place) / package
    raise SystemExit(f"there is no package {package} in {repository}")


def _copy(repository, to):
    """What git knows of, and new files that it does not ignore; else everything."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "-co", "--exclude-standard"],
        cwd=repository,
        capture_output=True,
        text=True,
    )
    if listed.returncode or not listed.stdout:
        shutil.copytree(repository, to, ignore=shutil.ignore_patterns(*IGNORED[1:]))
        return
    for name in filter(None, listed.stdout.split("\0")):
        if (repository / name).is_file():  # not one that was just deleted
            (to / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(repository / name, to / name)


class Child:
    """A forked process that carries out `task`, for `limit` seconds at most.

    They are seconds of its processor, so that a busy machine does not count; of the
    clock it has ten times as many.  What the task returns is `result`; without it,
    `ended` says why.
    """

    def __init__(self, task, folder, limit):
        self.answer, self.limit = folder / "answer", math.ceil(limit)
        self.deadline = time.monotonic() + CLOCK * self.limit
        self.answer.unlink(missing_ok=True)
        sys.stdout.flush()
        self.pid = os.fork()
        if self.pid == 0:
            self._work(task, folder / "log")
        with suppress(OSError):  # it may have done so itself, or be gone
            os.setpgid(self.pid, self.pid)
        self.result = self.ended = None

    def _work(self, task, log):
        try:
            os.setpgid(0, 0)
            resource.setrlimit(resource.RLIMIT_CPU, (self.limit, self.limit + 1))
            signal.signal(signal.SIGINT, signal.default_int_handler)
            out = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
            for stream in (1, 2):
                os.dup2(out, stream)
            answer = pickle.dumps(task())
            self.answer.with_suffix(".part").write_bytes(answer)
            self.answer.with_suffix(".part").rename(self.answer)
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            os._exit(0)

    def finished(self):
        done, status = os.waitpid(self.pid, os.WNOHANG)
        if not done and time.monotonic() < self.deadline:
            return False
        used_up = os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGXCPU
        self.ended = "died" if done and not used_up else "hung"
        self.stop(reap=not done)
        if done and self.answer.exists():
            self.result, self.ended = pickle.loads(self.answer.read_bytes()), None
        return True

    def stop(self, reap=True):
        """End the child and whatever it started."""
        with suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGKILL)
        if reap:
            os.waitpid(self.pid, 0)

    def wait(self):
        try:
            while not self.finished():
                time.sleep(0.02)
        except BaseException:
            self.stop()
            raise
        return self
