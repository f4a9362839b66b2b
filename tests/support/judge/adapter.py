"""The names of the library that the judge calls; all of them stand here.

Who renames one adds the new name here and keeps the old one, by which the judge times
an older checkout.  Arrays in, arrays out; a refusal is a `lb.DesignError`.
"""

import re

import luenberger as lb
from luenberger.export import to_c

Refused = lb.DesignError


def plant(A, B, C, E, *, Q, R, S=None, P0=None, x0=None, prior=False):
    """A discrete plant; P0=None says that nothing is known of its start."""
    more = {} if P0 is None else dict(P0=P0, x0=x0)
    now = hasattr(lb.Plant, "at_first_sample")  # else an older checkout
    first = dict(at_first=True) if now else dict(P0_is="prior")
    more |= first if prior else {}
    return lb.Plant(A, B, C, E, dt=1.0, Q=Q, R=R, S=S, **more)


def filtered(plant, y, u=None, u0=None, m1=(), arrival=None):
    """Estimates and covariances (N, n), (N, n, n)."""
    if hasattr(lb, "Record"):
        record = lb.Record(y, u, u0=u0, arrival=arrival)
        run = lb.Filter(plant, list(m1)).run(record)
        return run.x, run.P
    more = {} if arrival is None else dict(arrival=arrival)
    run = lb.filter_data(plant, y, u, u0=u0, m1=list(m1), history=True, **more)
    return run.x, run.P


def smoothed(plant, y, u=None, u0=None, m1=()):
    """The same of the whole record."""
    if hasattr(lb, "smooth"):  # an older checkout
        run = lb.smooth(plant, y, u, u0=u0, m1=list(m1))
    else:
        run = lb.Filter(plant, list(m1)).smooth(lb.Record(y, u, u0=u0))
    return run.x, run.P


def log_likelihood(plant, y, u=None, u0=None):
    if hasattr(lb, "log_likelihood"):
        return lb.log_likelihood(plant, y, u, u0=u0)
    return lb.Filter(plant).log_likelihood(lb.Record(y, u, u0=u0))


def reason(error):
    """Why a record was refused: "contradiction", "digits" or "undetermined"."""
    words = {
        "contradict": "contradiction", "does not determine": "undetermined",
        "digits": "digits", "no output shows": "digits",
    }  # fmt: skip
    return next((why for part, why in words.items() if part in str(error)), str(error))


def where(error):
    """The instant and the numbers of the outputs that a contradiction names."""
    instant = re.search(r"at instant (\d+) ", str(error))
    return int(instant[1]), {int(j) - 1 for j in re.findall(r"'y(\d+)'", str(error))}


# -- what is timed: compiled code, over whole records ---------------------------------


def over_rows(plant, y, settled=False):
    """The estimates of a record, or of a fleet (M, N, p); by default in full."""
    if not hasattr(lb, "Record"):  # an older checkout
        settle = 1e-9 if settled else None
        return lb.filter_data(plant, y, backend="numba", settle=settle).x
    from luenberger.filtering import tail

    look = tail.LOOK
    if not settled:  # no record has so many rows, so it is never looked for
        tail.LOOK = 1 << 60
    try:
        return lb.Filter(plant).run(y).x
    finally:
        tail.LOOK = look


def smoothed_rows(plant, y):
    if hasattr(lb, "smooth"):
        return lb.smooth(plant, y, backend="numba").x
    return lb.Filter(plant).smooth(y).x


def likelihood_of_rows(plant, y):
    if hasattr(lb, "log_likelihood"):
        return lb.log_likelihood(plant, y, backend="numba")
    return lb.Filter(plant).log_likelihood(y)


def as_called(plant, y):
    """A short record, as users call it."""
    if hasattr(lb, "Record"):
        return lb.Filter(plant).run(y).x
    return lb.filter_data(plant, y).x


def fitted(plant, y):
    """The log likelihood that a fit of a diagonal Q and of R reaches, start unknown."""
    return lb.fit_noise(plant, y, Q="diagonal").log_likelihood


FIRST = (  # a program: the first record of a plant in a new process
    "import numpy as np, luenberger as lb\n"
    "A, C = [[1, 1, 0.5], [0, 1, 1], [0, 0, 1]], [[1, 0, 0], [0, 1, 0]]\n"
    "plant = lb.Plant(A, None, C, dt=1.0, Q=np.diag([0.0, 0, 1]),\n"
    "                 R=np.diag([0.25, 4]), P0=np.eye(3))\n"
    "if hasattr(lb, 'Record'):\n"
    "    lb.Filter(plant).run(np.zeros((1000, 2)))\n"
    "else:\n"
    "    lb.filter_data(plant, np.zeros((1000, 2)), backend='numba')\n"
)
DEVICE = """
#include "made.h"
int run(const double *y, double *what, int rows)
{
    made_state state;
    made_init(&state%s);
    for (int k = 0; k < rows; k++)
        if (%s)
            return 1;
    return 0;
}
"""
NOW = ", 0, 0", "made_estimate(&state, y + k * P, what + k * N) || made_advance(&state)"
THEN = "", "made_step(&state, 0, y + k * P, what + k * N)"  # of an older checkout


def exported(plant, folder):
    """The sources of `int run(y, what, rows)`, the exported filter over a record."""
    code, header = to_c(plant, folder, name="made")
    calls = THEN if "made_step" in header.read_text() else NOW
    driver = folder / "driver.c"
    driver.write_text(f"enum {{ N = {plant.n}, P = {plant.p} }};\n{DEVICE % calls}")
    return code, driver
