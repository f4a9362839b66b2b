"""Exported C beside the exact observer, on a million readings that one chooses."""

import ctypes
import re

import numpy as np

from luenberger.export import to_c
from luenberger.kernels.c.library import library

PATTERNS = ("uniform", "random signs", "constant", "worst signs", "slow square wave")

DRIVER = r"""
#include <stdint.h>
#include <math.h>
#include "unit.h"
enum { r = R_, k = K_, q = Q_, m = unit_inputs };
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
    case 3: return signs[(i % length) * k + j];
    default: return (i / 997) % 2 ? 1.0 : -1.0;
    }
}
/* Largest gaps and exact estimates; returns how many steps did not return 0. */
int compare(int steps, int pattern, const double *X, const double *z0,
            const double *range, const double *one, const double *signs, int length,
            double *gap, double *size)
{
    unit_state state;
    long double z[r + 1], ahead[r + 1];
    int wrong = 0;
    unit_init(&state);
    for (int i = 0; i < r; i++) z[i] = z0[i];
    for (int i = 0; i < steps; i++) {
        double s[k];
        REAL given[k], what[q];
        for (int j = 0; j < k; j++) {
            s[j] = range[j] * reading(pattern, i, j, signs, length);
            given[j] = GIVEN(s[j], one[j]);
        }
        wrong += unit_step(&state, given, given + m, what) != 0;
        for (int a = 0; a < r + q; a++) {
            const double *row = X + a * (r + k);
            long double sum = 0;
            for (int b = 0; b < r; b++) sum += (long double)row[b] * z[b];
            for (int b = 0; b < k; b++) sum += (long double)row[r + b] * s[b];
            if (a < r) ahead[a] = sum;
            else {
                const double shown = SHOWN(what[a - r], one[k + a - r]);
                const double off = fabsl(sum - (long double)shown);
                if (!(off <= gap[a - r])) gap[a - r] = off;
                if (fabsl(sum) > size[a - r]) size[a - r] = fabsl(sum);
            }
        }
        for (int a = 0; a < r; a++) z[a] = ahead[a];
    }
    return wrong;
}
"""
MACROS = {
    "float": "#define REAL float\n#define GIVEN(s, one) (float)(s)\n"
    "#define SHOWN(w, one) (w)\n",
    "fixed": "#define REAL KIND\n#define GIVEN(s, one) unit_counts(s, one)\n"
    "#define SHOWN(w, one) unit_value(w, one)\n",
}
MACROS["double"] = MACROS["float"].replace("float", "double")


def gaps(
    observer, folder, ranges, *, steps, dtype, bits=None, patterns=PATTERNS, **options
):
    """{pattern: (largest gaps, largest estimates)} of exported C, in real units."""
    given = dict(dtype=dtype, bits=bits, **options)
    code, head = to_c(observer, folder, name="unit", ranges=ranges, **given)
    o, m = observer, observer.G.shape[1]
    r, k, q = o.order, m + o.D.shape[1], len(o.P)
    macros = MACROS[dtype].replace("KIND", f"int{bits}_t")
    driver = DRIVER.replace("R_", str(r)).replace("K_", str(k)).replace("Q_", str(q))
    texts = {"unit.c": code.read_text(), "unit.h": head.read_text()}
    compare = library(texts | {"driver.c": macros + driver}, "no").compare
    X = np.block([[o.F, o.G, o.D], [o.P, o.W, o.V]])
    sizes = np.array(list(ranges.values()), float)
    ones, signs = counts_of_units(texts["unit.h"], k, q), worst_signs(o)
    found = {}
    for pattern in PATTERNS:
        gap, size = np.zeros(q), np.zeros(q)
        tables = [np.ascontiguousarray(T, float) for T in (X, o.z0, sizes, ones, signs)]
        pointers = [T.ctypes.data_as(ctypes.c_void_p) for T in (*tables, gap, size)]
        wrong = compare(
            steps, PATTERNS.index(pattern), *pointers[:5], len(signs), *pointers[5:]
        )
        assert wrong == 0
        found[pattern] = gap, size
    return found


def counts_of_units(header, k, q):
    """What the macros of a header say; ones where there are none."""
    lines = [line.split() for line in header.splitlines() if "_ONE " in line]
    return np.array([float(line[2]) for line in lines] or np.ones(k + q))


def worst_signs(observer, length=400):
    """Signs of inputs and measurements that drive the first estimate furthest."""
    B = np.hstack([observer.G, observer.D])
    rows, row = [], observer.P[:1]
    for _ in range(length):
        rows.append(np.where(row @ B < 0, -1.0, 1.0)[0])
        row = row @ observer.F
    return np.array(rows[::-1])


def per_unit(header, name):
    """Of an estimate's bound in a header: its parts, by signal, None for the rest."""
    lines = header.read_text().partition(f'"{name}":\n')[2].splitlines()[:3]
    own = [re.match(r' \*  +(\S+)( max "(.*)")?$', line).groups() for line in lines]
    return {signal: float(size) for size, _, signal in own}
