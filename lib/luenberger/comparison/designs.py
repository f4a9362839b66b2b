"""What a comparison tries: every method, and within it every choice."""

from __future__ import annotations

import dataclasses
import functools
import itertools
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..analysis.mean_square import equivalent_noise
from ..arguments import expect
from ..errors import CertificateError, DesignError, short
from ..numeric import Matrix, Vector
from ..numeric.linalg import eigenvalues
from ..numeric.staircase_form import find_in_even_units
from ..observer import Observer
from ..papers.haddad_bernstein.design import fixed_order_filter
from ..papers.kawazoe.deadbeat import deadbeat_observer
from ..papers.leondes_novak.design import kalman_filter, reduced_order_filter
from ..papers.moore.design import functional_observer
from ..papers.poles import numbers
from ..papers.van_dooren.design import reduced_order_observer
from ..plant import Plant
from ..plant.estimates import Combinations

KALMAN = "Kalman filter"
NOVAK = "Leondes-Novak filter"
FIXED = "fixed-order filter"
REDUCED = "reduced-order observer"
DEADBEAT = "deadbeat observer"
FUNCTIONAL = "functional observer"
METHODS = (KALMAN, NOVAK, FIXED, REDUCED, DEADBEAT, FUNCTIONAL)
SINGLE = {KALMAN, DEADBEAT, FUNCTIONAL}  # of which there is one design

EVERY_SUBSET_UP_TO = 4  # outputs; above it only the first 0, 1, ..., p are tried
EVERY_SIZE_UP_TO = 50  # states; above it only the first 0, 1, 2, 4, ..., p outputs
FEW_ORDERS = 3  # fixed orders up to it are tried, others where they could win
NO_ORDER_ABOVE = 100  # states; above it no fixed-order filter
PREDICTORS_UP_TO = 5  # states; above it no fixed-order filter with V = 0
STARTS = 3  # of the search for each fixed-order filter
SPEED = 3.0  # of an observer, beside the plant, where no noise says how fast
SPEEDS = (1.0, SPEED, 10.0)  # where nothing is known of the noise


@dataclass(frozen=True, eq=False)
class Question:
    """The plant that designs are for, and what of it is wanted."""

    plant: Plant
    rows: np.ndarray | None = None  # L, or None for the state
    called: tuple[str, ...] | None = None  # the rows of L
    scale: np.ndarray | None = None

    @property
    def L(self) -> Combinations | None:
        """The rows with their names, where they have them."""
        if self.rows is None or self.called is None:
            return self.rows
        return dict(zip(self.called, self.rows))

    @property
    def weight(self) -> Matrix | None:
        """Of the error that filters make least, I or 1 / scale^2."""
        return None if self.scale is None else np.diag(self.scale**-2.0)

    @functools.cached_property
    def additive(self) -> Plant:
        """The plant with additive noises that trouble an estimate as much as its own.

        It is for filters that know no multiplicative noise: (4.4) of Haddad and
        Bernstein; see `mean_square.equivalent_noise`.
        """
        return additive(self.plant)


def additive(plant: Plant) -> Plant:
    if not plant.multiplicative or not noisy(plant):
        return plant
    _, Q, S, R = equivalent_noise(plant)
    return dataclasses.replace(plant, Q=Q, R=R, S=S, multiplicative=())


def noisy(plant: Plant) -> bool:
    """Whether the plant says how noisy it is."""
    return plant.dt > 0 and plant.Q is not None and plant.R is not None


@dataclass(frozen=True)
class Candidate:
    """A design to be tried: what it is called, and a function of the question."""

    method: str
    label: str
    make: Callable[[Question], Observer]
    order: int | None = None
    accurate: tuple[int, ...] = ()
    horizon: str | None = None
    feedthrough: bool | None = None  # of a fixed-order filter


def candidates(
    plant: Plant,
    *,
    orders: Iterable[int] | int | None = None,
    methods: Iterable[str] | str | None = None,
    poles: ArrayLike | None = None,
) -> dict[str, Candidate]:
    """Every method and every choice within it, by name: the designs of `compare`.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0,
    ...                  Q=[[0.25, 0.5], [0.5, 1]], R=[[0.01]])
    >>> [*lb.candidates(plant, methods="fixed-order filter")]
    ['fixed-order filter, order 1', 'fixed-order filter, order 1, V = 0']
    >>> lb.compare(plant, lb.candidates(plant, orders=2)).recommended().name
    'Kalman filter'

    They are made for what `compare` is asked: its L and scale.

    Parameters
    ----------
    plant : Plant
        Its size, its outputs, and what is known of its noise say what there is.
    orders : int or iterable of int, optional
        Only designs of these orders, and every fixed order among them.  Default every
        order of exact designs, and fixed orders up to 3.
    methods : str or iterable of str, optional
        Only these, by their names in the table.
    poles : (n - rank C,) array_like, optional
        Of the reduced-order observer.

    Returns
    -------
    dict of str to Candidate
    """
    expect(plant=plant)
    wanted = _orders(orders, plant.n)
    given = None if poles is None else tuple(numbers(np.ravel(poles)))
    found = [
        *_kalman(plant),
        *_leondes_novak(plant),
        *_fixed_orders(plant, wanted),
        *_reduced_order(plant, given),
        Candidate(DEADBEAT, "all poles zero", _deadbeat, _free(plant)),
        Candidate(FUNCTIONAL, "L x from the fewest states", _functional),
    ]
    names = _methods(methods)
    return {
        title(one.method, one.label): one
        for one in found
        if one.method in names
        and (wanted is None or one.order is None or one.order in wanted)
    }


def title(method: str, label: str) -> str:
    """The method, and which design of it where there are several."""
    return method if method in SINGLE or not label else f"{method}, {label}"


def _methods(given: Iterable[str] | str | None) -> tuple[str, ...]:
    if given is None:
        return METHODS
    names = (given,) if isinstance(given, str) else tuple(given)
    unknown = [name for name in names if name not in METHODS]
    if unknown or not names:
        said = f"there is no method {short(unknown[0])}" if unknown else "none is named"
        raise ValueError(f"methods: {said}; there are {', '.join(METHODS)}")
    return names


def _orders(given: Iterable[int] | int | None, n: int) -> tuple[int, ...] | None:
    if given is None:
        return None
    several = np.iterable(given) and not isinstance(given, str)
    found: tuple[Any, ...] = tuple(given) if several else (given,)  # type: ignore[arg-type]
    for order in found:
        whole = isinstance(order, int | np.integer) and not isinstance(order, bool)
        if not whole or not 0 <= order <= n:
            raise ValueError(
                f"orders must be whole numbers from 0 to {n}, got {order!r}"
            )
    if not found:
        raise ValueError(f"orders is empty; leave it out, or give some of 0 to {n}")
    return found


# -- each method -------------------------------------------------------------------


def _kalman(plant: Plant) -> Iterator[Candidate]:
    yield Candidate(
        KALMAN,
        "every output filtered",
        lambda asked: kalman_filter(asked.additive, L=asked.L),
        plant.n,
        horizon="step",
    )


def choices(n: int, p: int) -> list[tuple[int, ...]]:
    """The sets of accurate outputs to try, smallest first."""
    sizes = range(p + 1)
    if n > EVERY_SIZE_UP_TO:
        sizes = sorted({0, *(2**k for k in range(p.bit_length())), p})
    elif p <= EVERY_SUBSET_UP_TO:
        return [one for m1 in sizes for one in itertools.combinations(range(p), m1)]
    return [tuple(range(m1)) for m1 in sizes]


def _leondes_novak(plant: Plant) -> Iterator[Candidate]:
    gains = {"step": "step-wise gain", "steady": "best constant gain"}
    for accurate, horizon in itertools.product(choices(plant.n, plant.p)[1:], gains):
        outputs = ", ".join(plant.output_names[k] for k in accurate)
        yield Candidate(
            NOVAK,
            f"{outputs} taken as accurate, {gains[horizon]}",
            functools.partial(_novak, accurate=accurate, horizon=horizon),
            plant.n - len(accurate),
            accurate,
            horizon,
        )


def _novak(asked: Question, accurate: tuple[int, ...], horizon: str) -> Observer:
    """Of L x, if that is asked for, with the gain that is best for it.

    The step-wise gain weighs the whole state then, and so does the best constant one
    where there is none for L x.
    """
    rows, weight = asked.rows, asked.weight
    if rows is not None and weight is not None:
        weight = rows.T @ weight @ rows if horizon == "steady" else None
    design = functools.partial(
        reduced_order_filter, asked.additive, accurate, L=asked.L, horizon=horizon
    )
    try:
        return design(weight=weight)
    except CertificateError:
        if rows is None or horizon == "step":
            raise
        found = design(weight=np.eye(asked.plant.n))
        warnings.warn("Its gain is the best one for the whole state.", stacklevel=2)
        return found


def _fixed_orders(plant: Plant, wanted: tuple[int, ...] | None) -> Iterator[Candidate]:
    most = FEW_ORDERS if plant.n <= NO_ORDER_ABOVE else 0
    for order in range(1, plant.n):
        if order <= most if wanted is None else order in wanted:
            yield fixed_order(order)
            if plant.n <= PREDICTORS_UP_TO:
                yield fixed_order(order, feedthrough=False)


def fixed_order(order: int, feedthrough: bool = True) -> Candidate:
    """The search for the best filter of an order, with V or without."""

    def make(asked: Question) -> Observer:
        return fixed_order_filter(
            asked.plant,
            order,
            L=asked.L,
            weight=asked.weight,
            feedthrough=feedthrough,
            starts=STARTS,
        )

    label = f"order {order}{'' if feedthrough else ', V = 0'}"
    return Candidate(FIXED, label, make, order, feedthrough=feedthrough)


def _free(plant: Plant) -> int | None:
    """The states that outputs leave unknown; None where no observer has its poles."""
    try:
        _, form = find_in_even_units(plant.A, plant.C, plant.dt)
    except ValueError:
        return None
    return plant.n - form.rank


def _reduced_order(
    plant: Plant, poles: tuple[complex, ...] | None
) -> Iterator[Candidate]:
    count = _free(plant)

    def given(poles: Any, label: str) -> Candidate:
        def make(asked: Question) -> Observer:
            return reduced_order_observer(asked.plant, poles, L=asked.L)

        return Candidate(REDUCED, label, make, count)

    if poles is not None or count is None:
        label = "chosen poles" if poles is None else "poles as given"
        yield given(poles or (0.5,) * plant.n, label)  # or its refusal
        return
    minimal: tuple[complex, ...] = ()
    try:
        one = reduced_order_filter(additive(plant), plant.p, horizon="steady")
        minimal = tuple(one.poles)
    except ValueError:
        pass
    if len(minimal) == count:
        yield given(minimal, "poles of the minimal-order filter")
        return
    for times in (SPEED,) if noisy(plant) else SPEEDS:
        rates = f"{times:g} times the" if times != 1 else "at the"
        label = f"Butterworth poles, {rates} rates of the plant"
        yield given(butterworth(plant, count, times), label.replace(", at", " at"))


def butterworth(plant: Plant, count: int, times: float = SPEED) -> tuple[complex, ...]:
    """Poles on a circle in the left half plane, `times` as far out as the plant's.

    The plant's distance is the geometric mean of its modes' rates, |s|.  In discrete
    time the poles are exp(s dt).
    """
    known = rates(plant)
    unit = 1 / plant.dt if plant.dt > 0 else 1.0
    distance = times * (np.exp(np.log(known).mean()) if len(known) else unit / SPEED)
    angle = np.pi * (2 * np.arange(count // 2) + count + 1) / (2 * max(count, 1))
    upper = distance * np.exp(1j * angle)
    s = np.concatenate([upper, upper.conj(), [-distance] * (count % 2)])
    return tuple(np.exp(s * plant.dt) if plant.dt > 0 else s)


def rates(plant: Plant) -> Vector:
    """How fast the plant's modes are, in rad/s; those that never change left out."""
    poles = eigenvalues(plant.A)
    if plant.dt > 0:
        poles = np.log(poles[poles != 0].astype(complex)) / plant.dt
    return np.abs(poles[poles != 0])


def _deadbeat(asked: Question) -> Observer:
    return deadbeat_observer(asked.plant, L=asked.L)


def _functional(asked: Question) -> Observer:
    if asked.rows is None:
        raise DesignError(
            "it needs L, the combinations L x of the states that it is to estimate"
        )
    return functional_observer(asked.plant, asked.L)


# -- designs of one's own ----------------------------------------------------------


def own(given: Any) -> list[Candidate]:
    """The designs of a dict or a list: observers, functions of a plant, candidates."""
    if isinstance(given, Observer):
        raise ValueError(
            "designs is one observer alone; give a list, [observer], or a dict by name"
        )
    if isinstance(given, Mapping):
        named = dict(given)
    elif np.iterable(given) and not isinstance(given, str):
        named = {f"design {k + 1}": one for k, one in enumerate(given)}
    else:
        raise ValueError(
            "designs must be a dict, by name, of observers or of functions of a plant, "
            f"or a list of them; got {short(given)}"
        )
    if not named:
        raise ValueError("designs is empty; give at least one")
    return [_one_of(str(name), one) for name, one in named.items()]


def _one_of(name: str, given: Any) -> Candidate:
    if isinstance(given, Candidate):
        return given
    if isinstance(given, Observer):
        if given.steps is not None:
            raise DesignError(
                f"design {name!r} varies over time, and steady errors are of constant "
                "designs; design without steps="
            )
        return Candidate(name, "", lambda asked: given, given.order)
    if not callable(given):
        raise ValueError(
            f"design {name!r} must be an Observer or a function of a plant that "
            f"returns one, got {short(given)}"
        )

    def make(asked: Question) -> Observer:
        found = given(asked.plant)
        if not isinstance(found, Observer):
            raise TypeError(
                f"design {name!r} must return an Observer, got {short(found)}"
            )
        return found

    return Candidate(name, "", make)


def left_out(plant: Plant) -> Iterator[str]:
    """What `candidates` leaves out of its own accord, as it would take long."""
    if len(choices(plant.n, plant.p)) < 2**plant.p:
        yield f"{NOVAK}s that take other outputs as accurate"
    if plant.n > PREDICTORS_UP_TO:
        yield f"{FIXED}s with V = 0"
