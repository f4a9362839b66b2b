"""Builds the pages once for all tests that look at them."""

import importlib.util
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).parents[2]
NEEDED = {
    "sphinx": "sphinx",
    "myst_nb": "myst-nb",
    "sphinx_book_theme": "sphinx-book-theme",
    "sphinx-mathjax-offline": "sphinx-mathjax-offline",
    "sphinx_revealjs": "sphinx-revealjs",
}
COMMAND = ["-m", "sphinx", "-W", "--keep-going", "-q", "-j", "auto"]


def missing():
    """Why the pages cannot be built here; empty if they can."""
    names = [NEEDED[m] for m in NEEDED if importlib.util.find_spec(m) is None]
    how = 'install -r environment-pip.txt -e "./lib[site]"'
    return f"no pages without {', '.join(names)}: {how}" if names else ""


def build(folder):
    """The pages in `folder`, built as the README says, every warning an error."""
    command = [sys.executable, *COMMAND]
    library = os.pathsep.join([str(ROOT / "lib"), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [*command, str(ROOT / "notebooks"), str(folder)],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": library, "OMP_NUM_THREADS": "1"},
    )
    assert done.returncode == 0, done.stderr
    return folder


def build_once(folder):
    """The same for all processes that ask for it: the first builds, the others wait."""
    import fcntl  # of POSIX only

    done = folder / "done"
    folder.mkdir(exist_ok=True)
    with open(folder / "lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not done.exists():
            build(folder / "pages")
            done.touch()
    return folder / "pages"
