"""A stage list as a function at any sizes, in NumPy, in loops for numba or in C."""

import ctypes
import keyword
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..numeric import Matrices
from ..numeric.linalg import solve_right
from ..symbolic import Derivation
from . import cache, runs_compiled
from .c import C, function
from .c.library import library
from .lowering import lower, sizes_of
from .numpy import kernel
from .passes import write_pass
from .program import Shape, Size, times
from .python import Python
from .step import assemble
from .writer import Writer

TAKEN = frozenset(  # names that loops use, that C has, and that Python's loops call
    """i j k s q ok np back run
    auto case char const default do double enum extern float goto inline int long main
    register restrict return short signed sizeof static struct switch typedef union
    unsigned void volatile fabs fmax fmin sqrt
    abs array bool len max min range""".split()
)
OF_LOOPS = re.compile(r"[afgt]\d+(_\d+)?")  # what they call numbers and products
ANOTHER = "write another symbol"
SKEW = 1e-9  # of what stands beside it: more is no rounding
SOLVED = 1e-6  # of the terms of a residual: more is no solution
OF_NUMPY = frozenset("np eye solve_right symmetrise dict step".split())


def compile(
    derivation: Derivation | Callable[[], Derivation],
    *outputs: str,
    backend: str = "numpy",
) -> Any:
    r"""Make a function of a stage list that is proved.

    Stages :math:`X = f(A, B, \dots)`, in order, become code that computes each
    target once; an inverse :math:`N M^{-1}` becomes a solve with a factor of M.  Only
    the stages that `outputs` need are kept.

    Parameters
    ----------
    derivation : Derivation, StageList or callable
        A proved derivation with stages, or a function that returns one, such as those
        in ``luenberger.papers.<paper>.derivation``.
    *outputs : str
        Names of the targets that are wanted; all of them, if none are named.
    backend : "numpy", "numba" or "c"
        "numpy" writes matrix products; leading axes of the arrays broadcast.
        "numba" writes loops over flat arrays, compiled at the first call; needs
        ``luenberger[fast]``.  "c" writes the same loops in C99, for double; they need
        nothing but math.h, and no more than stack.

    Returns
    -------
    callable
        ``f(**matrices) -> dict`` of 2-D arrays by name; a matrix that the stages do
        not read is not asked for.  ``f.given`` has the names of the matrices and
        ``f.source`` the printed text.

        With numba the text is a module whose ``run(n, p, ..., A, ..., X_out, ...)``
        takes sizes, flat arrays and arrays for the results, and ``f.run`` is that
        function, to be called in loops of one's own; it returns whether every matrix
        that a solve needs was definite.  With C the text is the function
        ``int run(int n, ..., const double *A, ..., double *X_out, ...)``, which
        returns 0, or 1 where one was not; a call compiles it with the C compiler of
        the machine.

    Raises
    ------
    ValueError
        If there is no such backend or output, nothing to compute, a name that code
        cannot have, or the shapes of the matrices do not fit together.  At a call, if
        a matrix that the derivation takes to be symmetric is not.
    AssertionError
        If the derivation has no proof, or a false one.
    TypeError
        If what is given is no derivation, a stage has no such form, or a matrix is
        missing or unknown.
    numpy.linalg.LinAlgError
        If a matrix that a solve needs is not positive definite.  NumPy gives the
        solution of least norm where a semi-definite one has any.

    Examples
    --------
    >>> from luenberger.papers.leondes_novak.derivation import steady_gradient
    >>> from luenberger.symbolic import compile
    >>> gradient = compile(steady_gradient)
    >>> print(gradient.source)
    def step(*, K, M, Omega, C, Lambda):
        Gradient = 2.0 * (Lambda @ (K @ M - (Omega @ C.mT)))
        return dict(Gradient=Gradient)
    <BLANKLINE>
    >>> one = [[1.0]]
    >>> known = dict(K=[[2.0]], M=[[3.0]], Omega=one, C=one, Lambda=one)
    >>> gradient(**known)
    {'Gradient': array([[10.]])}
    >>> text = compile(steady_gradient, "Gradient", backend="c").source
    >>> print(text[: text.index("{")])
    int run(int n, int p, const double *K /* n x p */,
        const double *M /* p x p */, const double *Omega /* n x n */,
        const double *C /* p x n */, const double *Lambda /* n x n */,
        double *Gradient_out /* n x p */)
    <BLANKLINE>
    """
    backends = {"numpy": _numpy, "numba": _Numba, "c": _InC}
    if backend not in backends:
        raise ValueError(f"backend must be 'numpy', 'numba' or 'c', got {backend!r}")
    found = derivation() if callable(derivation) else derivation
    if not isinstance(found, Derivation):
        raise TypeError(
            "what is compiled is a Derivation, or a function that returns one, got "
            f"{type(derivation).__name__}"
        )
    targets = [stage.target.name for stage in found.stages]
    if not targets:
        raise ValueError(f"{found.source or 'the derivation'} has no stages to compile")
    if unknown := [name for name in outputs if name not in targets]:
        raise ValueError(
            f"no stage computes {', '.join(unknown)}; there are {', '.join(targets)}"
        )
    return backends[backend](found, outputs)


def _numpy(derivation: Derivation, outputs: tuple[str, ...]) -> Any:
    for s in (*derivation.given, *(stage.target for stage in derivation.stages)):
        own(s.name)
        if keyword.iskeyword(s.name) or s.name in OF_NUMPY:
            raise ValueError(f"NumPy's code cannot have the name {s.name!r}; {ANOTHER}")
    text = kernel(derivation, *outputs)
    step = assemble(text.source, text.given, solve_right=solved)
    symmetric = symmetric_names(derivation)

    def call(**matrices: ArrayLike) -> Matrices:
        arrays = {name: np.asarray(X, float) for name, X in matrices.items()}
        require_symmetric(arrays, symmetric)
        return step(**arrays)

    found: Any = call
    found.source, found.given = step.source, step.given
    return found


def solved(N: np.ndarray, M: np.ndarray) -> np.ndarray:
    """X with X M = N, or LinAlgError where there is none."""
    X = solve_right(N, M)
    if (abs(X @ M - N) > SOLVED * (abs(X) @ abs(M) + abs(N))).any():
        raise np.linalg.LinAlgError(
            "a matrix that a solve needs is not positive definite"
        )
    return X


def symmetric_names(derivation: Derivation) -> list[str]:
    """The given matrices that the derivation takes to be symmetric."""
    known = getattr(derivation.letters, "symmetric", ())
    return [s.name for s in derivation.given if s in known]


def require_symmetric(arrays: Matrices, names: Iterable[str]) -> None:
    """Raise unless these arrays, as far as they are given, equal their transposes.

    Each entry is judged beside its own mirror image and the diagonal, so that units
    play no part.
    """
    for name in names:
        X = arrays.get(name)
        if X is None or X.ndim < 2 or X.shape[-1] != X.shape[-2]:
            continue  # its shape is judged elsewhere
        size = abs(X)
        root = np.sqrt(np.diagonal(size, axis1=-2, axis2=-1))
        beside = root[..., :, None] * root[..., None, :]
        if (abs(X - X.mT) > SKEW * (size + size.mT + beside)).any():
            raise ValueError(
                f"{name} must be symmetric, as the derivation supposes: the largest "
                f"|{name} - {name}'| is {abs(X - X.mT).max():.3g}; "
                f"give ({name} + {name}') / 2 if that is rounding"
            )


class _Loops:
    """Loops at any sizes, written and run in one of the languages below."""

    solved: Any

    def __init__(self, derivation: Derivation, outputs: tuple[str, ...]) -> None:
        self.program = lower(derivation, outputs)
        shapes, self.given = self.program.shapes, self.program.given
        self.results = {
            stage.target.name: sizes_of(stage.target)
            for stage in derivation.stages
            if stage.target.name in self.program.results
        }
        every = {
            size
            for shape in (*shapes.values(), *self.results.values())
            for size in shape
        }
        letters = sorted(size for size in every if isinstance(size, str))
        self.places = {name: own(name) for name in shapes}
        self.sizes = {k: own(k, taken=k in shapes) for k in letters}
        self.symmetric = symmetric_names(derivation)
        self.require_names()

    def require_names(self) -> None:
        """Raise where two things would have one name in the text."""
        names = [*self.places.values(), *self.sizes.values()]
        names += [f"{name}_out" for name in self.results]
        if twice := [name for name, k in Counter(names).items() if k > 1]:
            raise ValueError(f"two things would be called {twice[0]}; {ANOTHER}")
        for name in self.places.values():
            inner = re.compile(rf"{name}_(l|least|T|[adil]\d+(_\d+)?)")
            if clash := [other for other in names if inner.fullmatch(other)]:
                raise ValueError(
                    f"loops keep what they make of {name} under the name {clash[0]}; "
                    f"{ANOTHER}"
                )

    def named(self) -> Iterator[tuple[str, Shape]]:
        """(name, shape) of the arguments that are matrices: given, then results."""
        for name in self.given:
            yield self.places[name], self.program.shapes[name]
        for name, shape in self.results.items():
            yield f"{name}_out", shape

    def write(self, to: Writer) -> list[str]:
        """Write the body; return its lines."""
        results = {}
        for name, shape in self.results.items():
            length = times(*(self.sizes.get(d, d) for d in shape))
            results[name] = f"{name}_out", length
        write_pass(self.program, self.sizes, to, self.places, results)
        return to.lines

    def __call__(self, **matrices: ArrayLike) -> Matrices:
        if set(matrices) != set(self.given):
            raise TypeError(
                f"the matrices are {', '.join(self.given)}, got {', '.join(matrices)}"
            )
        arrays = {k: np.array(matrices[k], float, order="C") for k in self.given}
        require_symmetric(arrays, self.symmetric)
        sizes = self.measured(arrays)
        found = {
            name: np.zeros([sizes.get(d, d) for d in shape])
            for name, shape in self.results.items()
        }
        numbers = [sizes.get(name, 0) for name in self.sizes]
        if not self.solved(numbers, [*arrays.values(), *found.values()]):
            raise np.linalg.LinAlgError(
                "a matrix that a solve needs is not positive definite"
            )
        return found

    def measured(self, arrays: Matrices) -> dict[str, int]:
        """The sizes by letter, from matrices whose shapes agree."""
        sizes: dict[str, int] = {}
        whose: dict[str, str] = {}
        for name, X in arrays.items():
            letters = self.program.shapes[name]
            shape = tuple(sizes.get(size, size) for size in letters)
            wrong = (w != d for w, d in zip(shape, X.shape) if isinstance(w, int))
            if X.ndim != 2 or any(wrong):
                known = [
                    f"{k} = {sizes[k]}, as in {whose[k]}" for k in letters if k in sizes
                ]
                raise ValueError(
                    f"{name} must be {letters[0]} x {letters[1]}, got shape {X.shape}; "
                    + ", ".join(dict.fromkeys(known))
                )
            for letter, size in zip(letters, X.shape):
                if letter not in sizes:
                    sizes[letter], whose[letter] = size, name
        return sizes


def own(name: str, taken: bool = False) -> str:
    """A name as code can use it: one that loops use themselves gets an underscore."""
    if not (name.isidentifier() and name.isascii()):
        raise ValueError(f"{name!r} is no name that code can have; {ANOTHER}")
    used = name in TAKEN or keyword.iskeyword(name) or OF_LOOPS.fullmatch(name)
    return f"{name}_" if taken or used else name


class _Python(Python):
    turns = False

    def array(self, name: str, length: Size) -> None:
        self.let(name, f"np.empty({length})")


class _Numba(_Loops):
    @cached_property
    def source(self) -> str:
        to = _Python(1)
        to.let("ok", "True")
        names = ", ".join((*self.sizes.values(), *(name for name, _ in self.named())))
        body = [*self.write(to), "    return ok"]
        return "\n".join(
            ["import numpy as np", "", "", f"def run({names}):", *body, ""]
        )

    @cached_property
    def run(self) -> Any:
        runs_compiled("numba", 0)  # or say that numba is not installed
        types = ["i8"] * len(self.sizes) + ["f8[::1]"] * sum(1 for _ in self.named())
        return cache.compiled(self.source, tuple(types))

    def solved(self, sizes: list[int], arrays: list[np.ndarray]) -> bool:
        return self.run(*sizes, *(X.reshape(-1) for X in arrays))


class _InC(_Loops):
    @cached_property
    def source(self) -> str:
        kinds = ["const double"] * len(self.given) + ["double"] * len(self.results)
        arguments = [f"int {size}" for size in self.sizes.values()]
        arguments += [
            f"{kind} *{name} /* {shape[0]} x {shape[1]} */"
            for kind, (name, shape) in zip(kinds, self.named())
        ]
        rows: list[list[str]] = [[]]
        for one in arguments:
            if len(", ".join([*rows[-1], one])) > 68:
                rows.append([])
            rows[-1].append(one)
        head = ",\n    ".join(", ".join(row) for row in rows)
        names = [*self.sizes.values(), *(name for name, _ in self.named())]
        lines = [*self.write(C("double")), "    return 0;"]
        return function(f"int run({head})", lines, names)

    @cached_property
    def run(self) -> Any:
        otherwise = "the text of the kernel is in `source`"
        return library({"kernel.c": self.source}, otherwise).run

    def solved(self, sizes: list[int], arrays: list[np.ndarray]) -> bool:
        pointers = (X.ctypes.data_as(ctypes.c_void_p) for X in arrays)
        return self.run(*map(ctypes.c_int, sizes), *pointers) == 0
