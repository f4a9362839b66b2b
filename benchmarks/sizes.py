"""How many bytes of flash does exported C take, in double, float and whole numbers?

Compiled with gcc -std=c99 -Os for this machine: bytes of code and constants (.text and
.rodata and what else `size` calls text, without debugging), of the module alone.  A
device has its own instructions, and one without floating point adds a library for it;
beside each other the rows say what a choice costs.  "unrolled" is every product in a
line of its own, "loops" goes over tables: the export takes what is in bold.

Run:  python benchmarks/sizes.py [--quick]
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile

from common import plant

import luenberger as lb
from luenberger.export import to_c
from luenberger.export.c import fixed
from luenberger.kernels import cost

SIZES = [(3, 2), (6, 3), (10, 4), (30, 6)]
NUMBERS = {
    "double": dict(dtype="double"),
    "float": dict(dtype="float"),
    "32 bits": dict(dtype="fixed", bits=32),
    "16 bits": dict(dtype="fixed", bits=16),
}
FORMS = {"unrolled": 10**9, "loops": 0}  # what is written as scalars, at most


def flash(source, options, most=None):
    """Bytes of an export; `most` operations or products are unrolled."""
    kept = cost.SHORT, cost.LONG, fixed.UNROLLED
    if most is not None:
        cost.SHORT, cost.LONG, fixed.UNROLLED = most, most, most
    try:
        with tempfile.TemporaryDirectory() as folder:
            code, _ = to_c(source, folder, name="unit", **options)
            made = pathlib.Path(folder) / "unit.o"
            command = "gcc -std=c99 -Os -fno-asynchronous-unwind-tables -c -o"
            subprocess.run([*command.split(), made, code], check=True)
            done = subprocess.run(["size", made], capture_output=True, text=True)
            return int(done.stdout.splitlines()[1].split()[0])
    finally:
        cost.SHORT, cost.LONG, fixed.UNROLLED = kept


def rows(sizes=SIZES):
    """(what, numbers, {form: bytes}); "exported" is the form that the export takes."""
    for n, p in sizes:
        here = plant(n, p)
        observer = lb.kalman_filter(here)
        for numbers, options in NUMBERS.items():
            given = options | (dict(plant=here) if "bits" in options else {})
            found = {form: flash(observer, given, most) for form, most in FORMS.items()}
            found["exported"] = flash(observer, given)
            yield f"observer, n = {n}, p = {p}", numbers, found
        for numbers in ("double", "float"):
            options = NUMBERS[numbers]
            forms = FORMS if n <= 6 else {"loops": 0}
            found = {form: flash(here, options, most) for form, most in forms.items()}
            found["exported"] = flash(here, options)
            yield f"filter, n = {n}, p = {p}", numbers, found


def table(found):
    """Markdown: in bold what the export takes."""
    lines = ["|  | numbers | unrolled | loops |", "| --- | --- | --- | --- |"]
    for what, numbers, forms in found:
        cells = [
            f"**{forms[form]}**" if forms.get(form) == forms["exported"] else
            str(forms.get(form, ""))
            for form in FORMS
        ]  # fmt: skip
        lines.append(f"| {what} | {numbers} | {' | '.join(cells)} |")
    return "\n".join(lines)


if __name__ == "__main__":
    if shutil.which("gcc") is None or shutil.which("size") is None:
        raise SystemExit("this takes gcc and size, and one of them is not there")
    print(table(rows(SIZES[:2] if "--quick" in sys.argv else SIZES)))
