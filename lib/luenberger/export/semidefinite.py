"""The C form of `linalg.semidefinite`: no variance below zero, whatever rounding did.

Where an unstable mode has no variance and no noise drives it, rounding may leave a
negative one, from which the covariance runs away.  LAPACK is not on the device, so
eigenvalues are found by Jacobi's rotations, a fixed number of sweeps at the most.
"""

SWEEPS = 30


def operations(n):
    """Operations of the repair at the most, its square roots among them."""
    rotation = 14 + 18 * n
    return SWEEPS * n * (n - 1) // 2 * rotation + n * n * (2 * n + 4) + n**3 // 3


def repair(module, n):
    """A static C function that repairs Sigma in place where it is not definite."""
    suffix = "f" if module.real == "float" else ""
    negligible = module.number(1e-9 if suffix else 1e-18)
    words = {
        "NAME": module.name,
        "REAL": module.real,
        "SWEEPS": str(SWEEPS),
        "NEGLIGIBLE": negligible,
        "ZERO": module.number(0.0),
        "ONE": module.number(1.0),
        "TWO": module.number(2.0),
        "FABS": f"fabs{suffix}",
        "SQRT": f"sqrt{suffix}",
        "NN": str(n * n),
        "N": str(n),
    }
    text = DEFINITE + REPAIR
    for word, value in words.items():
        text = text.replace(f"@{word}@", value)
    return text


DEFINITE = """\
static int @NAME@_definite(const @REAL@ Sigma[])
{
    @REAL@ L[@NN@];
    for (int i = 0; i < @NN@; i++) L[i] = Sigma[i];
    for (int k = 0; k < @N@; k++) {
        if (!(L[k * @N@ + k] > 0)) return 0;
        for (int i = k + 1; i < @N@; i++) {
            const @REAL@ s = L[k * @N@ + i] / L[k * @N@ + k];
            for (int j = i; j < @N@; j++) L[i * @N@ + j] -= s * L[k * @N@ + j];
        }
    }
    return 1;
}

"""

REPAIR = """\
/* Eigenvalues of Sigma that are negative, at unit diagonal of Omega, become zero. */
static void @NAME@_semidefinite(@REAL@ Sigma[], const @REAL@ Omega[])
{
    @REAL@ X[@NN@], V[@NN@], scale[@N@];
    int turned = 1;
    if (@NAME@_definite(Sigma)) return;
    for (int i = 0; i < @N@; i++) {
        const @REAL@ variance = Omega[i * @N@ + i];
        scale[i] = variance > 0 ? @SQRT@(variance) : @ONE@;
    }
    for (int i = 0; i < @N@; i++) {
        for (int j = 0; j < @N@; j++) {
            X[i * @N@ + j] = Sigma[i * @N@ + j] / scale[j] / scale[i];
            V[i * @N@ + j] = i == j ? @ONE@ : @ZERO@;
        }
    }
    for (int sweep = 0; turned && sweep < @SWEEPS@; sweep++) {
        turned = 0;
        for (int i = 0; i < @N@; i++) {
            for (int j = i + 1; j < @N@; j++) {
                const @REAL@ a = X[i * @N@ + j];
                @REAL@ q, t, c, s;
                if (!(@FABS@(a) > @NEGLIGIBLE@)) continue;
                turned = 1;
                q = (X[j * @N@ + j] - X[i * @N@ + i]) / (@TWO@ * a);
                t = @ONE@ / (@FABS@(q) + @SQRT@(q * q + @ONE@));
                if (q < 0) t = -t;
                c = @ONE@ / @SQRT@(t * t + @ONE@);
                s = t * c;
                for (int k = 0; k < @N@; k++) {
                    const @REAL@ left = X[k * @N@ + i], right = X[k * @N@ + j];
                    X[k * @N@ + i] = c * left - s * right;
                    X[k * @N@ + j] = s * left + c * right;
                }
                for (int k = 0; k < @N@; k++) {
                    const @REAL@ left = X[i * @N@ + k], right = X[j * @N@ + k];
                    X[i * @N@ + k] = c * left - s * right;
                    X[j * @N@ + k] = s * left + c * right;
                }
                for (int k = 0; k < @N@; k++) {
                    const @REAL@ left = V[k * @N@ + i], right = V[k * @N@ + j];
                    V[k * @N@ + i] = c * left - s * right;
                    V[k * @N@ + j] = s * left + c * right;
                }
            }
        }
    }
    for (int i = 0; i < @N@; i++) {
        for (int j = i; j < @N@; j++) {
            @REAL@ s = 0;
            for (int k = 0; k < @N@; k++) {
                const @REAL@ value = X[k * @N@ + k];
                if (value > 0) s += V[i * @N@ + k] * value * V[j * @N@ + k];
            }
            s *= scale[i] * scale[j];
            Sigma[i * @N@ + j] = s;
            Sigma[j * @N@ + i] = s;
        }
    }
}
"""
