"""What does exported C cost beside C written by hand for the same work?

Both are compiled with gcc -std=c99 -O3, sizes and matrices known at compile time, and
take turns on one record.  By hand: the textbook loops, without the tests that the
export makes (finite data, positive pivots, a definite covariance).  Two forms of the
covariance: the one that the library uses, which no rounding of the gain amplifies,
and Omega - K C Omega, which is shorter.  Results are compared before anything is timed.

Run:  OMP_NUM_THREADS=1 python benchmarks/c_export.py [--quick]
"""

import ctypes
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy as np
from common import in_turns, line, plant, record, same

import luenberger as lb
from luenberger.export import to_c

SIZES = [(3, 2), (6, 3), (10, 4)]
STEPS, ROUNDS = 4000, 51

FILTER = """
int hand_step(double *restrict state, const double *u, const double *restrict y,
              double *restrict what)
{
    double *x = state, (*O)[n] = (void *)(state + n), (*S)[n] = (void *)&O[n][0];
    double N[n][p], M[p][p], L[p][p], d[p], K[n][p], W[n][n];
    (void)u;
    for (int i = 0; i < n; i++) for (int j = 0; j < p; j++) {
        double s = 0; for (int k = 0; k < n; k++) s += O[i][k] * C[j][k]; N[i][j] = s; }
    for (int i = 0; i < p; i++) for (int j = i; j < p; j++) {
        double s = R[i][j]; for (int k = 0; k < n; k++) s += C[i][k] * N[k][j];
        M[i][j] = M[j][i] = s; }
    for (int j = 0; j < p; j++) {
        double s = M[j][j]; for (int k = 0; k < j; k++) s -= L[j][k] * L[j][k] * d[k];
        d[j] = s;
        for (int i = j + 1; i < p; i++) {
            double q = M[i][j];
            for (int k = 0; k < j; k++) q -= L[i][k] * L[j][k] * d[k];
            L[i][j] = q / s; } }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < p; j++) {
            double s = N[i][j]; for (int k = 0; k < j; k++) s -= L[j][k] * K[i][k];
            K[i][j] = s; }
        for (int j = 0; j < p; j++) K[i][j] /= d[j];
        for (int j = p - 1; j >= 0; j--) {
            double s = K[i][j]; for (int k = j + 1; k < p; k++) s -= L[k][j] * K[i][k];
            K[i][j] = s; } }
    for (int j = 0; j < p; j++) {
        double s = y[j]; for (int k = 0; k < n; k++) s -= C[j][k] * x[k]; d[j] = s; }
    for (int i = 0; i < n; i++) {
        double s = x[i]; for (int j = 0; j < p; j++) s += K[i][j] * d[j]; what[i] = s; }
    for (int i = 0; i < n; i++) for (int j = 0; j < n; j++) {
        double s = O[i][j]; for (int k = 0; k < p; k++) s -= K[i][k] * N[j][k];
        W[i][j] = s; }
#if SHORT
    for (int i = 0; i < n; i++) for (int j = i; j < n; j++) S[i][j] = S[j][i] = W[i][j];
#else
    for (int i = 0; i < n; i++) for (int j = 0; j < p; j++) {
        double s = 0; for (int k = 0; k < n; k++) s += W[i][k] * C[j][k];
        for (int k = 0; k < p; k++) s -= K[i][k] * R[k][j]; N[i][j] = s; }
    for (int i = 0; i < n; i++) for (int j = i; j < n; j++) {
        double s = W[i][j]; for (int k = 0; k < p; k++) s -= N[i][k] * K[j][k];
        S[i][j] = S[j][i] = s; }
#endif
    for (int i = 0; i < n; i++) {
        double s = 0; for (int k = 0; k < n; k++) s += A[i][k] * what[k]; x[i] = s; }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) W[i][j] = 0;
        for (int k = 0; k < n; k++)
            for (int j = 0; j < n; j++) W[i][j] += A[i][k] * S[k][j]; }
    for (int i = 0; i < n; i++) for (int j = i; j < n; j++) {
        double s = Q[i][j]; for (int k = 0; k < n; k++) s += W[i][k] * A[j][k];
        O[i][j] = O[j][i] = s; }
    return 0;
}
"""
OBSERVER = """
int hand_step(double *restrict z, const double *u, const double *restrict y,
              double *restrict what)
{
    double next[n];
    (void)u;
    for (int i = 0; i < n; i++) {
        double s = 0; for (int k = 0; k < n; k++) s += P[i][k] * z[k];
        for (int k = 0; k < p; k++) s += V[i][k] * y[k]; what[i] = s; }
    for (int i = 0; i < n; i++) {
        double s = 0; for (int k = 0; k < n; k++) s += F[i][k] * z[k];
        for (int k = 0; k < p; k++) s += D[i][k] * y[k]; next[i] = s; }
    for (int i = 0; i < n; i++) z[i] = next[i];
    return 0;
}
"""
LOOP = """
int NAME_step(void *, const double *, const double *, double *);
int run(double *state, const double *y, double *what, int steps)
{
    for (int k = 0; k < steps; k++)
        if (NAME_step(state, 0, y + k * p, what + k * n)) return 1;
    return 0;
}
"""


def hand(source, short):
    """C with the matrices of a plant or an observer as constants."""
    filter_ = isinstance(source, lb.Plant)
    text = f"#define SHORT {int(short)}\n"
    for name in "ACQR" if filter_ else "FDPV":
        rows = (", ".join(map(repr, row)) for row in getattr(source, name).tolist())
        X = getattr(source, name)
        text += f"static const double {name}[{X.shape[0]}][{X.shape[1]}] = "
        text += "{" + ", ".join(f"{{{row}}}" for row in rows) + "};\n"
    return text + (FILTER if filter_ else OBSERVER)


def compiled(folder, name, n, p, *sources, flags=()):
    loop = folder / f"{name}_loop.c"
    size = f"enum {{ n = {n}, p = {p} }};\n"
    loop.write_text(size + LOOP.replace("NAME", name))
    library = folder / f"{len(list(folder.iterdir()))}.so"
    flags = [*"-std=c99 -O3 -shared -fPIC".split(), *flags]
    subprocess.run(["gcc", *flags, "-o", library, loop, *sources, "-lm"], check=True)
    return ctypes.CDLL(str(library)).run


def contestants(folder, source, n, p):
    """Compiled `run`s by name."""
    out = {}
    code, _ = to_c(source, folder, name="made")
    out["exported"] = compiled(folder, "made", n, p, code)
    for label, short in (("by hand", False), ("by hand, short form", True)):
        if short and isinstance(source, lb.Observer):
            continue
        path = folder / f"hand{int(short)}.c"
        path.write_text(f"enum {{ n = {n}, p = {p} }};\n" + hand(source, short))
        out[label] = compiled(folder, "hand", n, p, path)
    return out


def start(source, n):
    if isinstance(source, lb.Observer):
        return source.z0.copy()
    Omega = source.A @ source.P0 @ source.A.T + source.Q
    return np.concatenate([np.zeros(n), Omega.ravel(), Omega.ravel()])


def called(run, source, y):
    """The estimates of a record."""
    n = len(source.L) if isinstance(source, lb.Observer) else source.n
    state, what = start(source, n), np.empty((len(y), n))
    if run(*(ctypes.c_void_p(X.ctypes.data) for X in (state, y, what)), len(y)):
        raise SystemExit("the compiled step refused its data")
    return what


def over_records(one, folder, name):
    """The exported filter of a plant over any record, for this processor."""
    code, _ = to_c(one, folder, name=name)
    flags = ["-std=gnu99", "-march=native"]
    run = compiled(folder, name, one.n, one.p, code, flags=flags)
    Omega = (one.A @ one.P0 @ one.A.T + one.Q).ravel()
    start = np.concatenate([one.A @ one.x0, Omega, Omega])

    def over(y):
        state, what = start.copy(), np.empty((len(y), one.n))
        if run(*(ctypes.c_void_p(X.ctypes.data) for X in (state, y, what)), len(y)):
            raise SystemExit("the compiled step refused its data")
        return what

    return over


def records(quick=False):
    """Two rows a size, filter and observer; ratios are to the exported C."""
    if shutil.which("gcc") is None:
        return
    for n, p in SIZES:
        y = np.random.default_rng(1).normal(size=(STEPS, p))
        one = plant(n, p)
        for kind, source in (("filter", one), ("observer", lb.kalman_filter(one))):
            with tempfile.TemporaryDirectory() as folder:
                runs = contestants(pathlib.Path(folder), source, n, p)
                wanted = called(runs["exported"], source, y)
                for name, run in runs.items():
                    same(name, called(run, source, y), wanted)
                calls = {
                    name: lambda run=run: called(run, source, y)  # noqa: B023
                    for name, run in runs.items()
                }
                times = in_turns(calls, 21 if quick else ROUNDS)
            names = {"exported": "exported C", "by hand, short form": "C, short form"}
            names["by hand"] = "C by hand"
            times = {names[name]: all_ for name, all_ in times.items()}
            case = f"{kind}, n = {n}, p = {p}"
            yield record("exported C", case, "ns", times, 1e9 / STEPS)


if __name__ == "__main__":
    for one in records("--quick" in sys.argv):
        print(line(one), flush=True)
