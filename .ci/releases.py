"""environment-pip.txt with other releases: .ci/releases.py newest | oldest | differing

`newest` drops the pins.  `oldest` drops them too, and pins what the library needs, its
extras for users among it, to the lower bounds that lib/pyproject.toml declares.
`differing` says which installed releases are not those that are pinned.
"""

import re
import sys
import tomllib
from importlib.metadata import version
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# tables is of what a notebook stores; the others are tools, and exact
EXTRAS = ("cluster", "fast", "ledger")


def newest(line):
    return line.partition("==")[0]


def oldest(line):
    name = line.partition("==")[0]
    return f"{name}=={bounds()[name]}" if name in bounds() else name


def bounds():
    """{name: the oldest release that the library declares to work with}."""
    project = tomllib.loads((ROOT / "lib" / "pyproject.toml").read_text())["project"]
    extras = (project["optional-dependencies"][extra] for extra in EXTRAS)
    wanted = [*project["dependencies"], *(one for extra in extras for one in extra)]
    return dict(re.fullmatch(r"([\w-]+)>=([\d.]+)", one).groups() for one in wanted)


def differing(line):
    name, _, pinned = line.partition("==")
    found = version(name) if pinned else ""
    return f"{name} {found}, pinned {pinned}" if found != pinned else None


def main(which):
    choose = {"newest": newest, "oldest": oldest, "differing": differing}[which]
    for line in (ROOT / "environment-pip.txt").read_text().splitlines():
        said = choose(line)
        if said is not None:
            print(said)


if __name__ == "__main__":
    main(*sys.argv[1:])
