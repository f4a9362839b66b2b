"""The working tree beside an older commit: what notebooks show, how long it takes."""

import json
import os
import subprocess
import sys
import tempfile
from contextlib import contextmanager
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[3]


def git(*words):
    return subprocess.run(["git", "-C", ROOT, *words], check=True, capture_output=True)


# -- notebooks ------------------------------------------------------------------------


def shown(text):
    """{cell: what it shows} of a notebook, without counters and metadata."""
    found = {}
    for k, cell in enumerate(json.loads(text)["cells"]):
        outputs = [
            {part: of for part, of in one.items() if part in ("text", "data", "ename")}
            for one in cell.get("outputs", [])
        ]
        if cell["cell_type"] == "code":
            found[cell.get("id", k)] = outputs
    return found


def differing(old, new):
    """One line on two texts of a notebook, "" where all cells show the same."""
    old, new = shown(old), shown(new)
    other = sum(old[k] != new[k] for k in old.keys() & new.keys())
    counts = {"show something else": other, "are new": len(new.keys() - old.keys()),
              "are gone": len(old.keys() - new.keys())}  # fmt: skip
    return ", ".join(f"{count} {what}" for what, count in counts.items() if count)


def notebooks(against):
    """One line a notebook; 1 if any shows something else than in the older commit."""
    found = {}
    names = git("ls-tree", "-r", "--name-only", against).stdout.decode().split("\n")
    old = {name for name in names if name.endswith(".ipynb")}
    names = git("ls-files").stdout.decode().split("\n")
    new = {name for name in names if name.endswith(".ipynb") and (ROOT / name).exists()}
    for name in sorted(old | new):
        if name in old & new:
            text = git("show", f"{against}:{name}").stdout.decode()
            found[name] = differing(text, (ROOT / name).read_text())
        else:
            found[name] = "is new" if name in new else "is gone"
    for name, words in found.items():
        print(f"{name}: {words or 'the same'}")
    return int(any(found.values()))


# -- timings --------------------------------------------------------------------------


@contextmanager
def older(commit):
    """The library of a commit, in a temporary folder."""
    with tempfile.TemporaryDirectory() as folder:
        packed = git("archive", commit, "lib").stdout
        subprocess.run(["tar", "-x", "-C", folder], input=packed, check=True)
        yield Path(folder) / "lib"


def environment(lib, cache):
    path = os.pathsep.join(map(str, (lib, Path(__file__).parents[1])))
    kept = {"LUENBERGER_CACHE": str(cache), "NUMBA_CACHE_DIR": str(cache)}
    # modules are compiled to bytecode once, as where a package is installed
    kept |= {"PYTHONPYCACHEPREFIX": str(cache.parent / "bytecode")}
    kept |= {"PYTHONDONTWRITEBYTECODE": ""}
    return os.environ | kept | {"PYTHONPATH": path, "NUMBA_NUM_THREADS": "1"}


def alone(program, lib, cache):
    """Processor seconds of a new process."""
    before = os.times()
    command = [sys.executable, "-c", program]
    subprocess.run(command, check=True, env=environment(lib, cache))
    after = os.times()
    return sum(after[2:4]) - sum(before[2:4])


class Side:
    """A process with the library of one checkout, that times what it is told."""

    def __init__(self, lib, cache):
        self.process = subprocess.Popen(
            [sys.executable, "-m", "judge.timed"], env=environment(lib, cache),
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip

    def time(self, name):
        print(name, file=self.process.stdin, flush=True)
        answer = self.process.stdout.readline()
        if not answer:
            raise SystemExit(f"{name}: a side has ended, see above")
        return tuple(map(float, answer.split()))

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def line(name, old, new, differs=0.0):
    """A row: seconds of both and the median of ratios in turns, with its quartiles."""
    low, ratio, high = np.quantile(np.array(new) / old, [0.25, 0.5, 0.75])
    words = f"  differ by {differs:.0e}" if not differs < 1e-7 else ""
    print(f"{name:36}{np.median(old):10.4f}{np.median(new):10.4f}"
          f"{ratio:8.2f}  ({low:.2f} to {high:.2f}){words}", flush=True)  # fmt: skip


def timings(against, rounds, only):
    """Print the table of ratios; each side takes its turn in every round."""
    from . import adapter, timed

    print(f"{'processor seconds':36}{'then':>10}{'now':>10}{'ratio':>8}")
    with older(against) as lib, tempfile.TemporaryDirectory() as folder:
        libs = lib, ROOT / "lib"
        caches = [Path(folder) / side for side in ("then", "now")]
        sides = [Side(*both) for both in zip(libs, caches)]
        for name in timed.rows():
            if only in name:
                turns = np.array([[side.time(name) for side in sides]
                                  for _ in range(rounds)])  # fmt: skip
                then, now = turns[0, :, 1]
                differs = abs(now - then) / abs(then)
                line(name, turns[:, 0, 0], turns[:, 1, 0], differs)
        for side in sides:
            side.close()
        fresh = iter(range(10**6))
        for name, program, cache in (
            ("import", "import luenberger", lambda k: caches[k]),
            ("first record, cache kept", adapter.FIRST, lambda k: caches[k]),
            ("first record, no cache", adapter.FIRST,
             lambda k: Path(folder) / str(next(fresh))),
        ):  # fmt: skip
            if only in name:
                for k in (0, 1):
                    alone(program, libs[k], cache(k))
                turns = [[alone(program, libs[k], cache(k)) for k in (0, 1)]
                         for _ in range(rounds)]  # fmt: skip
                line(name, *np.array(turns).T)
    return 0
