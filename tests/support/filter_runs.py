"""The exported filter beside the exact one, on a million readings that one chooses."""

import ctypes

import numpy as np
from rounding_runs import PATTERNS

from luenberger.export import to_c
from luenberger.kernels.c.library import library
from luenberger.recursion.settings import Settings

DRIVER = r"""
#include <stdint.h>
#include <math.h>
#include "unit.h"
enum { n = N_, p = P_, m = M_ };
typedef long double real;
static uint64_t drawn = 88172645463325252ULL;
static double uniform(void)  /* in -1 to 1 */
{
    drawn ^= drawn << 13; drawn ^= drawn >> 7; drawn ^= drawn << 17;
    return (double)(drawn >> 11) * 0x1p-52 - 1.0;
}
static double reading(int pattern, int i, int j, const double *signs, int length)
{
    switch (pattern) {
    case 0: return uniform();
    case 1: return uniform() < 0 ? -1.0 : 1.0;
    case 2: return 1.0;
    case 3: return signs[(i % length) * (m + p) + j];
    default: return (i / 997) % 2 ? 1.0 : -1.0;
    }
}
/* The gain K of a covariance, by elimination with the largest pivots first. */
static void gain(const real *O, const double *C, const double *R, real *K)
{
    real W[p][p + n];
    for (int a = 0; a < p; a++) {
        for (int i = 0; i < n; i++) {
            W[a][p + i] = 0;
            for (int j = 0; j < n; j++) W[a][p + i] += C[a * n + j] * O[j * n + i];
        }
        for (int b = 0; b < p; b++) {
            W[a][b] = R[a * p + b];
            for (int i = 0; i < n; i++) W[a][b] += W[a][p + i] * C[b * n + i];
        }
    }
    for (int a = 0; a < p; a++) {
        int at = a;
        for (int b = a + 1; b < p; b++) if (fabsl(W[b][a]) > fabsl(W[at][a])) at = b;
        for (int k = 0; k < p + n; k++) {
            real keep = W[a][k]; W[a][k] = W[at][k]; W[at][k] = keep;
        }
        for (int b = 0; b < p; b++) {
            if (b == a) continue;
            real f = W[b][a] / W[a][a];
            for (int k = 0; k < p + n; k++) W[b][k] -= f * W[a][k];
        }
    }
    for (int i = 0; i < n; i++)
        for (int a = 0; a < p; a++) K[i * p + a] = W[a][p + i] / W[a][a];
}
/* The next covariance: As (Y O Y' + K R K') As' + Q. */
static void ahead(real *O, const real *K, const double *A, const double *C,
                  const double *R, const double *Q)
{
    real Y[n][n], T[n][n] = {{0}}, S[n][n] = {{0}}, U[n][n] = {{0}};
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            Y[i][j] = i == j;
            for (int a = 0; a < p; a++) Y[i][j] -= K[i * p + a] * C[a * n + j];
        }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            for (int k = 0; k < n; k++) T[i][j] += Y[i][k] * O[k * n + j];
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            for (int k = 0; k < n; k++) S[i][j] += T[i][k] * Y[j][k];
            for (int a = 0; a < p; a++)
                for (int b = 0; b < p; b++)
                    S[i][j] += K[i * p + a] * R[a * p + b] * K[j * p + b];
        }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            for (int k = 0; k < n; k++) U[i][j] += A[i * n + k] * S[k][j];
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            O[i * n + j] = Q[i * n + j];
            for (int k = 0; k < n; k++) O[i * n + j] += U[i][k] * A[j * n + k];
        }
}
/* Largest gaps; returns how many steps did not return 0. */
int compare(int steps, int pattern, const double *As, const double *B,
            const double *C, const double *E, const double *J, const double *Q,
            const double *R, const double *Omega, const double *x0,
            const double *range, const double *signs, int length, double *gap)
{
    unit_state state;
    real O[n * n], x[n], K[n * p], before[n * n];
    int wrong = 0, settled = 0;
    unit_init(&state);
    for (int i = 0; i < n * n; i++) O[i] = Omega[i];
    for (int i = 0; i < n; i++) x[i] = x0[i];
    for (int i = 0; i < steps; i++) {
        double s[m + p];
        REAL given[m + p], what[n];
        real left[p], known[p], next[n];
        for (int j = 0; j < m + p; j++)
            given[j] = s[j] = range[j] * reading(pattern, i, j, signs, length);
        wrong += unit_step(&state, given, given + m, what) != 0;
        if (!settled) gain(O, C, R, K);
        for (int a = 0; a < p; a++) {
            known[a] = s[m + a];
            for (int j = 0; j < m; j++) known[a] -= (real)E[a * m + j] * s[j];
            left[a] = known[a];
            for (int j = 0; j < n; j++) left[a] -= C[a * n + j] * x[j];
        }
        for (int j = 0; j < n; j++) {
            for (int a = 0; a < p; a++) x[j] += K[j * p + a] * left[a];
            const double off = fabsl(x[j] - (real)what[j]);
            if (!(off <= gap[j])) gap[j] = off;
        }
        for (int j = 0; j < n; j++) {
            next[j] = 0;
            for (int k = 0; k < n; k++) next[j] += As[j * n + k] * x[k];
            for (int k = 0; k < m; k++) next[j] += (real)B[j * m + k] * s[k];
            for (int a = 0; a < p; a++) next[j] += J[j * p + a] * known[a];
        }
        for (int j = 0; j < n; j++) x[j] = next[j];
        if (settled) continue;
        for (int a = 0; a < n * n; a++) before[a] = O[a];
        ahead(O, K, As, C, R, Q);
        settled = 1;
        for (int a = 0; a < n * n; a++)
            if (fabsl(O[a] - before[a]) > 1e-18L * fabsl(O[a])) settled = 0;
    }
    return wrong;
}
"""


def exact_filter(plant):
    """What the exact filter is made of, at the first sample."""
    now, first = Settings(plant, 0).at(0), plant.at_first_sample()
    return [now.As, now.B, now.C, now.E, now.J, now.Qs, now.R, first.P0, first.x0]


def gaps(plant, folder, ranges, *, steps, dtype, **options):
    """{pattern: largest gaps} of an exported filter beside one in long double."""
    code, head = to_c(plant, folder, name="unit", dtype=dtype, **options)
    sizes = {"N_": plant.n, "P_": plant.p, "M_": plant.m}
    driver = f"#define REAL {dtype}\n" + DRIVER
    for word, value in sizes.items():
        driver = driver.replace(word, str(value))
    texts = {"unit.c": code.read_text(), "unit.h": head.read_text()}
    compare = library(texts | {"driver.c": driver}, "no").compare
    given, signs = exact_filter(plant), worst_signs(plant)
    tables = [*given, np.array(list(ranges.values())), signs]
    tables = [np.ascontiguousarray(X, float) for X in tables]
    found = {}
    for k, pattern in enumerate(PATTERNS):
        gap = np.zeros(plant.n)
        pointers = [X.ctypes.data_as(ctypes.c_void_p) for X in (*tables, gap)]
        wrong = compare(steps, k, *pointers[:-1], len(signs), pointers[-1])
        assert wrong == 0
        found[pattern] = gap
    return found


def worst_signs(plant, length=400):
    """Signs of inputs and measurements that drive the first state furthest."""
    As, B, C, E, J, Q, R, Omega, _ = exact_filter(plant)
    before = np.zeros_like(Omega)
    while np.abs(Omega - before).max() > 1e-9 * np.abs(Omega).max():
        before = Omega
        K = np.linalg.solve(C @ Omega @ C.T + R, C @ Omega).T
        Y = np.eye(plant.n) - K @ C
        Omega = As @ (Y @ Omega @ Y.T + K @ R @ K.T) @ As.T + Q
    D = As @ K + J
    D, row, rows = np.hstack([B - D @ E, D]), np.eye(1, plant.n) @ Y, []
    for _ in range(length):
        rows.append(np.where(row @ D < 0, -1.0, 1.0)[0])
        row = row @ (As @ Y)
    return np.array(rows[::-1])


def in_parts(run, parts):
    """What a `Filter` finds in each part of a record, each from the end of the last."""
    end = None
    for part in parts:
        found = run.run(part, start=end)
        end = found.end
        yield found
