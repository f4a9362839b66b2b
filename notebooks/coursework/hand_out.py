"""Makes the folder that students get: python hand_out.py, in the folder of the course.

It holds the released notebooks, the library as a wheel, the exact packages and a page
on how to install them.  A folder that would hold a solution is refused.
"""

import shutil
import sys
import zipfile
from pathlib import Path

HERE = Path(__file__).parent
MARK = b"### BEGIN "  # of solutions and hidden checks
PACKAGES = ("numpy", "scipy", "sympy", "matplotlib", "jupyter", "ipykernel")
INSTALL = """\
# Install

1. Install Python 3.11, 3.12 or 3.13, and open a terminal in this folder.
2. `python3 -m venv .venv` (on Windows: `py -m venv .venv`)
3. `.venv/bin/python -m pip install -r requirements.txt` (`.venv\\Scripts\\python ...`)
4. `.venv/bin/jupyter lab` (`.venv\\Scripts\\jupyter lab`), and open an assignment.
5. Write your identifier into its first cell of code. Hand in the notebook, by its name.
"""


def refuse(why):
    sys.exit(f"hand_out.py: {why}")


def pinned(wheel):
    """The packages of the course, as the library's environment pins them."""
    lines = (HERE / "environment-pip.txt").read_text(encoding="utf-8").splitlines()
    names = {line.partition("==")[0]: line for line in lines if "==" in line}
    missing = [name for name in PACKAGES if name not in names]
    if missing:
        refuse(f"environment-pip.txt does not pin {', '.join(missing)}")
    return "\n".join([*(names[name] for name in PACKAGES), f"./{wheel.name}", ""])


def one_wheel():
    """The wheel of the library, if it holds nothing that students must not see."""
    wheels = sorted((HERE / "wheel").glob("luenberger-*.whl"))
    if len(wheels) != 1:
        refuse(f"wheel/ has {len(wheels)} wheels of luenberger, and should have one")
    with zipfile.ZipFile(wheels[0]) as archive:
        for name in archive.namelist():
            if MARK in archive.read(name):
                refuse(f"{wheels[0].name} holds a solution, in {name}")
    return wheels[0]


def main():
    notebooks = sorted((HERE / "release").glob("*/*.ipynb"))
    if not notebooks:
        refuse("release/ is empty: nbgrader generate_assignment makes it")
    for path in notebooks:
        if MARK in path.read_bytes():
            refuse(f"{path} holds a solution")
    wheel, folder = one_wheel(), HERE / "hand-out"
    required = pinned(wheel)
    shutil.rmtree(folder, ignore_errors=True)
    for path in notebooks:
        (folder / path.parent.name).mkdir(parents=True)
        shutil.copy(path, folder / path.parent.name)
    shutil.copy(wheel, folder)
    (folder / "requirements.txt").write_text(required, encoding="utf-8")
    (folder / "INSTALL.md").write_text(INSTALL, encoding="utf-8")


if __name__ == "__main__":
    main()
