"""Exported C, compiled without a warning and called over records."""

import ctypes
import re
import shutil
import subprocess

import numpy as np
import pytest

from luenberger.export import to_c

GCC = shutil.which("gcc") or shutil.which("cc")
needs_compiler = pytest.mark.skipif(GCC is None, reason="there is no C compiler")
STRICT = "-std=c99 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror".split()
SANITIZED = ["-fsanitize=undefined,address", "-fno-sanitize-recover=all"]
DRIVER = """
#include <stddef.h>
#include "unit.h"
unit_state state;
void start(const REAL *x0, const REAL *sigma0);
int run(int N, const REAL *u, const REAL *y, REAL *what, REAL *variances, int *code);
void start(const REAL *x0, const REAL *sigma0)
{
    (void)sigma0;
    unit_init(&state, INIT);
}
int run(int N, const REAL *u, const REAL *y, REAL *what, REAL *variances, int *code)
{
    (void)u; (void)y; (void)variances;
    for (int k = 0; k < N; k++) {
        code[2 * k] = unit_estimate(&state, SEEN);
        SPREAD
        code[2 * k + 1] = unit_advance(&state, MOVED);
    }
    return (int)sizeof state;
}
"""


def gcc(*arguments, check=True):
    command = [GCC, *STRICT, *map(str, arguments), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert not check or done.returncode == 0, done.stderr
    return done


def taken(header, function):
    """The arrays that a function takes."""
    declared = re.search(rf"unit_{function}\(([^;]*)\);", header)
    return re.findall(r"(\w+)\[\]", declared[1]) if declared else None


def driver(header, real):
    sizes = dict(u="inputs", y="outputs", what="estimates")
    text = DRIVER.replace("REAL", real)
    for function, word in dict(estimate="SEEN", advance="MOVED").items():
        rows = [f"{k} + k * unit_{sizes[k]}" for k in taken(header, function)]
        text = text.replace(f", {word}", "".join(f", {row}" for row in rows))
    text = text.replace("INIT", ", ".join(taken(header, "init")))
    told = "unit_variances(&state, variances + k * unit_estimates);"
    return text.replace("SPREAD", told if taken(header, "variances") else "")


class Compiled:
    """An export on its own: `run` returns estimates, and the codes of both calls."""

    def __init__(self, folder, source, dtype="double", level="-O1", flags=(), **more):
        self.type = np.float64 if dtype == "double" else np.float32
        code, self.header = to_c(source, folder, name="unit", dtype=dtype, **more)
        self.text = code.read_text()
        (folder / "driver.c").write_text(driver(self.header.read_text(), dtype))
        made = folder / "unit.so"
        gcc(level, *flags, "-shared", "-fPIC", "-o", made, code, folder / "driver.c")
        self.library = ctypes.CDLL(str(made))
        self.width = int(re.search(r"_estimates = (\d+)", self.header.read_text())[1])
        head = self.header.read_text()
        self.taken = {k: taken(head, k) for k in ("estimate", "advance")}
        sizes = re.findall(rf"^    {dtype} (\w+)\[(\d+)\];", head, re.M)
        self.members = [(k, int(size)) for k, size in sizes]
        self.start()

    def numbers(self):
        """The members of `state`, in one array, and each by its name."""
        sizes = [size for _, size in self.members]
        whole = np.frombuffer(self.state, self.type, sum(sizes)).copy()
        parts = np.split(whole, np.cumsum(sizes)[:-1])
        return whole, dict(zip((k for k, _ in self.members), parts))

    def call(self, function, state, **given):
        """A function on a state of its own: the code, and the bytes behind it."""
        room, self.kept = ctypes.create_string_buffer(state, len(state)), []
        arrays = [self.pointer(given[k]) for k in self.taken[function]]
        return getattr(self.library, f"unit_{function}")(room, *arrays), room.raw

    def start(self, x0=None, sigma0=None):
        self.library.start(*map(self.pointer, (x0, sigma0)))

    def pointer(self, X):
        if X is None:
            return None
        self.kept = [*getattr(self, "kept", []), np.ascontiguousarray(X, self.type)]
        return self.kept[-1].ctypes.data_as(ctypes.c_void_p)

    def run(self, y, u=None):
        """Estimates (N, q) and codes (N, 2); `variances` and `state` are set."""
        N, self.kept = len(y), []
        what = np.full((N, self.width), 7, self.type)
        self.variances, code = np.zeros_like(what), np.zeros((N, 2), np.int32)
        u = np.zeros((N, 1)) if u is None else u
        out = (X.ctypes.data_as(ctypes.c_void_p) for X in (what, self.variances, code))
        size = self.library.run(N, self.pointer(u), self.pointer(y), *out)
        self.state = bytes((ctypes.c_char * size).in_dll(self.library, "state"))
        return what, code
