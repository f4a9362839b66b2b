"""What does the exported C filter cost beside kernels that a generator wrote?

SLinGen (D. G. Spampinato, D. Fabregat-Traver, P. Bientinesi, M. Pueschel, "Program
generation for small-scale linear algebra applications", CGO 2018) writes one step of a
Kalman filter for one size, with AVX intrinsics: n states, n outputs, n inputs, the
short covariance, no test of anything.  The kernels of the paper are published in the
repository danielesgit/slingen, in the folder output-from-paper/results/
kf-4-52-8.abq.slingen.2017-08-17.1400/genkernels, under the BSD license; they are not
copied here.  Put kf_4.h, kf_12.h, ... into a folder and name it.  For today's g++ the
assembler in _asm256_loadu_pd and _asm256_storeu_pd becomes _mm256_loadu_pd and
_mm256_storeu_pd.

Both are compiled by gcc -O3 -march=native, with the width of vectors that gcc prefers
and, ours, with 256 and with 512 bits as well.  They take turns on one record, and the
estimates are compared before anything is timed.  Ours computes the longer covariance,
which a wrong gain does not make worse, tests data and pivots, and takes outputs that
are missing.  Guarded, it computes the short one and bounds what rounding does to it.

Run:  python benchmarks/slingen.py [--quick] [--kernels FOLDER]
"""

import argparse
import ctypes
import pathlib
import platform
import shutil
import subprocess
import tempfile

import numpy as np
from c_export import compiled, start
from common import in_turns, line, plant, record, same

from luenberger.export import to_c

SIZES = (4, 12, 20, 28, 52)
NATIVE = ["-std=gnu99", "-march=native"]  # gcc's own standard: a * b + c is one step
WIDTHS = {"256": ["-Dmade_LANES=4"], "512": []}  # bits; rows fit the widest there is
WORK, ROUNDS = 2e8, 41  # cubes of n in a record, about; rounds

LOOP = """
#define __int64 long long
#include <immintrin.h>
#include <math.h>
#include "KERNEL"
enum { n = SIZE };
static const double A[n * n] = AAA, Q[n * n] = QQQ, C[n * n] = CCC, R[n * n] = RRR;
static const double B[n * n] = {0}, u[n] = {0};
extern "C" int run(double *state, const double *y, double *what, int steps)
{
    static double prior[n], M0[n * n], Y[n * n], v[n], M1[n * n], M2[n * n], M3[n * n];
    double *x = state, *P = state + n;
    for (int k = 0; k < steps; k++) {
        kernel(A, B, u, Q, y + k * n, C, R, prior, x, M0, P, Y, v, M1, M2, M3);
        for (int i = 0; i < n; i++) what[k * n + i] = x[i];
    }
    return 0;
}
"""


def generated(folder, kernel, one):
    """A published kernel for the matrices of a plant, compiled."""
    text = LOOP.replace("KERNEL", str(kernel)).replace("SIZE", str(one.n))
    for name in "AQCR":
        listed = ", ".join(map(repr, getattr(one, name).ravel().tolist()))
        text = text.replace(3 * name, f"{{{listed}}}")
    source, library = folder / "generated.cpp", folder / "generated.so"
    source.write_text(text)
    flags = ["-O3", "-march=native", "-shared", "-fPIC", "-w"]
    subprocess.run(["g++", *flags, "-o", library, source], check=True)
    return ctypes.CDLL(str(library)).run


def exported(folder, one, flags, update="joseph"):
    code, _ = to_c(one, folder, name="made", update=update)
    return compiled(folder, "made", one.n, one.p, code, flags=flags)


def calls_of(run, state, y, what):
    """One pass over the record, from the same start each time."""
    now = np.empty_like(state)

    def call():
        now[:] = state
        pointers = [ctypes.c_void_p(X.ctypes.data) for X in (now, y, what)]
        if run(*pointers, len(y)):
            raise SystemExit("the compiled step refused its data")

    return call


def contestants(folder, one, kernels, y):
    """Calls by name, ours first, when all of them compute the same."""
    runs = {"exported C": exported(folder, one, NATIVE)}
    for bits, lanes in WIDTHS.items():
        flags = [*NATIVE, f"-mprefer-vector-width={bits}", *lanes]
        runs[f"exported C, {bits} bits"] = exported(folder, one, flags)
    runs["exported C, guarded"] = exported(folder, one, NATIVE, "guarded")
    states = {name: start(one, one.n) for name in runs}
    kernel = kernels / f"kf_{one.n}.h" if kernels else None
    if kernel and kernel.exists():
        runs["SLinGen"] = generated(folder, kernel.resolve(), one)
        states["SLinGen"] = np.concatenate([np.zeros(one.n), one.P0.ravel()])
    calls, found = {}, {}
    for name, run in runs.items():
        found[name] = np.empty_like(y)
        calls[name] = calls_of(run, states[name], y, found[name])
        calls[name]()
        same(name, found[name], found["exported C"])
    return calls


def records(quick=False, kernels=None):
    """One row a size, nanoseconds a step; ratios are to the exported C."""
    intel = platform.machine() in ("x86_64", "AMD64")
    if shutil.which("gcc") is None or shutil.which("g++") is None or not intel:
        return
    for n in SIZES[: 3 if quick else None]:
        one, steps = plant(n, n), int(max(WORK / n**3 / 10, 20))
        y = np.random.default_rng(1).normal(size=(steps, n))
        with tempfile.TemporaryDirectory() as folder:
            calls = contestants(pathlib.Path(folder), one, kernels, y)
            times = in_turns(calls, 11 if quick else ROUNDS)
        yield record(
            "exported C beside SLinGen", f"n = p = {n}", "ns", times, 1e9 / steps
        )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--kernels", type=pathlib.Path, metavar="FOLDER")
    given = parser.parse_args()
    for one in records(given.quick, given.kernels):
        print(line(one), flush=True)
