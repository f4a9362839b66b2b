"""The C form of `factors.semidefinite`: no variance below zero, whatever rounding did.

A device carries the covariance itself, not a factor.  Where a row of As annihilates
what is uncertain, rounding leaves a variance of its own size; judged by itself it
would look like any small one.  So Omega is settled when it is made, against what it
was made of, and Sigma is repaired beside Omega: Cholesky with pivots, the rest cut off.
"""

from collections.abc import Mapping

import numpy as np

from ...numeric import Matrix
from ..program import Cost
from .module import Module
from .writer import C, listed, typed


def operations(n: int) -> int:
    """Operations of the repair at the most, its square roots among them."""
    return n**3 // 3 + n * (2 * n * n + 3 * n) + n * n * (n + 4)


def settling(n: int) -> Cost:
    """The cost of `settle`, and on the stack of `by_columns`."""
    return Cost(n * (3 * n + 2), 0, n * (n + 2))


def negligible(n: int, real: str) -> float:
    """The part of what a variance was made of that may be rounding."""
    return 10 * n * float(np.finfo(np.float32 if real == "float" else float).eps)


def by_columns(to: C, n: int) -> str:
    """As and Q of a function in the form that `settle` takes: arrays to pass to it."""
    to.array("columns", n * n)
    to.array("variances", n)
    to.loop("i", 0, n)
    to.set("variances[i]", f"Q[i * {n + 1}]")
    to.loop("k", 0, n)
    to.set(f"columns[k * {n} + i]", f"As[i * {n} + k]")
    to.end()
    to.end()
    return "columns, variances"


def repair(module: Module, n: int) -> str:
    """A static C function that repairs Sigma in place where it is not definite."""
    return _written(DEFINITE + REPAIR, module, n)


def settle(module: Module, As: Matrix, Q: Matrix) -> str:
    """A static C function that clears Omega of rounding, and the matrices it takes."""
    given = {"AS": listed(As.T), "Q": listed(np.diagonal(Q))}
    return _written(SETTLE, module, len(As), given)


def _written(
    text: str, module: Module, n: int, given: Mapping[str, str] | None = None
) -> str:
    """A text with its words put in; rounding is some of the device's, for n terms."""
    single = module.real == "float"
    numbers = dict(given or {}) | {"NEGLIGIBLE": repr(negligible(n, module.real))}
    words = numbers | {
        "NAME": module.name,
        "REAL": module.real,
        "SQRT": "sqrtf" if single else "sqrt",
        "NEXT": str(n + 1),
        "NN": str(n * n),
        "N": str(n),
    }
    for word, value in words.items():
        text = text.replace(f"@{word}@", value)
    return typed(text, module.real)


DEFINITE = """\
static int @NAME@_definite(const @REAL@ Sigma[])
{
    @REAL@ L[@NN@];
    for (int i = 0; i < @NN@; i++) {
        L[i] = Sigma[i];
    }
    for (int k = 0; k < @N@; k++) {
        int known = 1;
        for (int j = k; j < @N@; j++) {
            if (L[k * @N@ + j] != 0.0) {
                known = 0;
            }
        }
        if (known != 0) {
            continue;
        }
        if (!(L[k * @N@ + k] > 0.0)) {
            return 0;
        }
        for (int i = k + 1; i < @N@; i++) {
            const @REAL@ s = L[k * @N@ + i] / L[k * @N@ + k];
            for (int j = i; j < @N@; j++) {
                L[i * @N@ + j] -= s * L[k * @N@ + j];
            }
        }
    }
    return 1;
}

"""

REPAIR = """\
/* Sigma without directions that are negative or rounding, beside Omega and itself. */
static void @NAME@_semidefinite(@REAL@ Sigma[], const @REAL@ Omega[])
{
    @REAL@ X[@NN@], H[@NN@] = {0}, scale[@N@];
    if (@NAME@_definite(Sigma) != 0) {
        return;
    }
    for (int i = 0; i < @N@; i++) {
        const @REAL@ variance = Omega[i * @NEXT@] + Sigma[i * @NEXT@];
        scale[i] = (variance > 0.0) ? @SQRT@(variance) : 1.0;
    }
    for (int i = 0; i < @N@; i++) {
        for (int j = 0; j < @N@; j++) {
            X[i * @N@ + j] = Sigma[i * @N@ + j] / scale[j] / scale[i];
        }
    }
    for (int k = 0; k < @N@; k++) {
        int at = 0;
        @REAL@ root;
        for (int i = 1; i < @N@; i++) {
            if (X[i * @NEXT@] > X[at * @NEXT@]) {
                at = i;
            }
        }
        if (!(X[at * @NEXT@] > @NEGLIGIBLE@)) {
            break;
        }
        root = @SQRT@(X[at * @NEXT@]);
        for (int i = 0; i < @N@; i++) {
            H[i * @N@ + k] = X[i * @N@ + at] / root;
        }
        for (int i = 0; i < @N@; i++) {
            for (int j = 0; j < @N@; j++) {
                X[i * @N@ + j] -= H[i * @N@ + k] * H[j * @N@ + k];
            }
        }
        X[at * @NEXT@] = 0.0;
    }
    for (int i = 0; i < @N@; i++) {
        for (int j = i; j < @N@; j++) {
            @REAL@ s = 0.0;
            for (int k = 0; k < @N@; k++) {
                s += H[i * @N@ + k] * H[j * @N@ + k];
            }
            s *= scale[i] * scale[j];
            Sigma[i * @N@ + j] = s;
            Sigma[j * @N@ + i] = s;
        }
    }
}
"""

SETTLE = """\
static const @REAL@ @NAME@_settle_As_T[@NN@] = @AS@;
static const @REAL@ @NAME@_settle_Q[@N@] = @Q@;

/* Omega without variances that are rounding of what they were made of.
 * Q has the variances only, and As is given by columns.
 */
static void @NAME@_settle(@REAL@ Omega[], const @REAL@ Sigma[],
                          const @REAL@ As_T[], const @REAL@ Q[])
{
    @REAL@ size[@N@];
    for (int i = 0; i < @N@; i++) {
        size[i] = Q[i];
    }
    for (int k = 0; k < @N@; k++) {
        const @REAL@ variance = Sigma[k * @NEXT@];
        for (int i = 0; i < @N@; i++) {
            size[i] += As_T[k * @N@ + i] * As_T[k * @N@ + i] * variance;
        }
    }
    for (int i = 0; i < @N@; i++) {
        if (!(Omega[i * @NEXT@] > @NEGLIGIBLE@ * size[i])) {
            for (int k = 0; k < @N@; k++) {
                Omega[i * @N@ + k] = 0.0;
                Omega[k * @N@ + i] = 0.0;
            }
        }
    }
}

"""
