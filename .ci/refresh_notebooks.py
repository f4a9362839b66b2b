"""Run notebooks top to bottom in place: python .ci/refresh_notebooks.py [NOTEBOOK ...]

Without arguments every notebook of the repository.  Lessons are marked as slides, too.
"""

import sys
from pathlib import Path

from notebook_tests import refresh, slides

ROOT = Path(__file__).resolve().parents[1]


def every():
    found = sorted((ROOT / "notebooks").rglob("*.ipynb"))
    return [path for path in found if ".ipynb_checkpoints" not in path.parts]


if __name__ == "__main__":
    chosen = [Path(path).resolve() for path in sys.argv[1:]] or every()
    refresh.main(chosen)
    slides.main(path for path in chosen if path.parent == ROOT / "notebooks")
