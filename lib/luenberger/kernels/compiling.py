"""A stage list as a function at any sizes, in NumPy, for numba or in C."""

import ctypes
import keyword
from collections import Counter
from collections.abc import Callable, Iterable
from functools import cached_property
from importlib.util import find_spec
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from matrixproof import Derivation

from ..numeric import Matrices
from ..numeric.linalg import solve_right
from .c.any_size import Loops
from .c.file import function
from .c.library import library
from .inside import SOLVED
from .jit import jitted
from .pieces import pieces
from .step import assemble
from .text import names_in, needed, numba_source, numpy_source

TAKEN = frozenset(  # names that loops use, and that C has
    """i j k s d f q run
    auto case char const default do double enum extern float goto inline int long main
    register restrict return short signed sizeof static struct switch typedef union
    unsigned void volatile""".split()
)
OF_NUMPY = frozenset("np eye solve_right symmetrise dict step run".split())
ANOTHER = "write another symbol"
SKEW = 1e-9  # of what stands beside it: more is no rounding
WIDTH = 68  # of a line of arguments


def compile(
    derivation: Derivation | Callable[[], Derivation],
    *outputs: str,
    backend: str = "numpy",
) -> Any:
    r"""Make a function of a stage list that is proved.

    >>> import luenberger as lb
    >>> from luenberger.papers.leondes_novak.derivation import steady_gradient
    >>> gradient = lb.compile(steady_gradient)
    >>> print(gradient.source)
    def step(*, K, M, Omega, C, Lambda):
        Gradient = 2.0 * (Lambda @ (K @ M - (Omega @ C.mT)))
        return dict(Gradient=Gradient)
    <BLANKLINE>
    >>> one = [[1.0]]
    >>> known = dict(K=[[2.0]], M=[[3.0]], Omega=one, C=one, Lambda=one)
    >>> gradient(**known)
    {'Gradient': array([[10.]])}
    >>> text = lb.compile(steady_gradient, "Gradient", backend="c").source
    >>> text.partition(",")[0]
    'int run(int n'

    Only the stages that `outputs` need are kept.  An inverse becomes a solve.

    Parameters
    ----------
    derivation : Derivation, StageList or callable
        A proved derivation with stages, or a function that returns one, such as those
        in ``luenberger.papers.<paper>.derivation``.
    *outputs : str
        Names of the targets that are wanted; all of them, if none are named.
    backend : "numpy", "numba" or "c"
        "numpy" writes matrix products; leading axes of the arrays broadcast.
        "numba" writes the same for matrices, compiled at the first call; needs
        ``luenberger[fast]``.  "c" writes loops in C99, for double; they need nothing
        but math.h, and no more than stack.

    Returns
    -------
    callable
        ``f(**matrices) -> dict`` of 2-D arrays by name; a matrix that the stages do
        not read is not asked for.  ``f.given`` has the names of the matrices and
        ``f.source`` the printed text.
        With numba ``f.run`` takes the matrices in that order and returns a tuple, for
        loops of one's own.  With C the text is the function ``int run(int n, ..., const
        double *A, ..., double *X_out, ...)``, 0 or 1 where a solve has no solution.

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
        If a matrix that a solve needs is not positive definite.  NumPy and numba give
        the solution of least norm where a semi-definite one has any.
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
    require_names(derivation)
    given, source = numpy_source(derivation, outputs)
    step = assemble(source, given, solve_right=solved)
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


def require_names(derivation: Derivation) -> None:
    """Raise ValueError for a matrix whose name means something else in the code."""
    for s in (*derivation.given, *(stage.target for stage in derivation.stages)):
        own(s.name)
        if keyword.iskeyword(s.name) or s.name in OF_NUMPY:
            raise ValueError(f"NumPy's code cannot have the name {s.name!r}; {ANOTHER}")


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


class _Compiled:
    """Code for matrices, whose shapes are compared before it runs."""

    solved: Any

    def __init__(self, derivation: Derivation, outputs: tuple[str, ...]) -> None:
        stages = needed(derivation.stages, outputs)
        read = names_in(stages)
        self.matrices = {s.name: s for s in derivation.given if s.name in read}
        self.given = tuple(self.matrices)
        every = {stage.target.name: stage.target for stage in stages}
        self.results = {name: every[name] for name in outputs or every}
        self.symmetric = symmetric_names(derivation)

    def __call__(self, **matrices: ArrayLike) -> Matrices:
        if set(matrices) != set(self.given):
            raise TypeError(
                f"the matrices are {', '.join(self.given)}, got {', '.join(matrices)}"
            )
        arrays = {k: np.array(matrices[k], float, order="C") for k in self.given}
        sizes = self.measured(arrays)
        require_symmetric(arrays, self.symmetric)
        return self.solved(arrays, sizes)

    def measured(self, arrays: Matrices) -> dict[str, int]:
        """The sizes by letter, from matrices whose shapes agree."""
        sizes: dict[str, int] = {}
        whose: dict[str, str] = {}
        for name, X in arrays.items():
            letters = [str(size) for size in self.matrices[name].shape]
            shape = [sizes.get(k, int(k) if k.isdigit() else None) for k in letters]
            wrong = (w is not None and w != d for w, d in zip(shape, X.shape))
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


class _Numba(_Compiled):
    def __init__(self, derivation: Derivation, outputs: tuple[str, ...]) -> None:
        super().__init__(derivation, outputs)
        require_names(derivation)
        _, self.source = numba_source(derivation, outputs)

    @cached_property
    def run(self) -> Any:
        if find_spec("numba") is None:
            raise ImportError(
                "backend='numba' needs numba, which is not installed: "
                "pip install 'luenberger[fast]', or take another backend"
            )
        return jitted(self.source)

    def solved(self, arrays: Matrices, sizes: dict[str, int]) -> Matrices:
        found = self.run(*arrays.values())
        return {k: np.array(X, order="C") for k, X in zip(self.results, found)}


class _InC(_Compiled):
    def __init__(self, derivation: Derivation, outputs: tuple[str, ...]) -> None:
        super().__init__(derivation, outputs)
        self.pieces = pieces(derivation, outputs)
        symbols = [*self.matrices.values(), *(one.target for one in self.pieces)]
        for symbol in symbols:
            for size in map(sp.sympify, symbol.shape):
                if not (size.is_Integer or size.is_Symbol):
                    raise TypeError(
                        f"no loops for the size {size} of {symbol}; give it a letter"
                    )
        letters = {str(size) for symbol in symbols for size in symbol.shape}
        self.names = {one.name: own(one.name) for one in symbols}
        self.names |= {name: f"{name}_out" for name in self.results}
        taken = set(self.names)
        self.sizes = {
            k: own(k, taken=k in taken) for k in sorted(letters) if not k.isdigit()
        }

        names = Counter([*self.names.values(), *self.sizes.values()])
        if twice := [name for name, k in names.items() if k > 1]:
            raise ValueError(f"two things would be called {twice[0]}; {ANOTHER}")

    @cached_property
    def source(self) -> str:
        loops, arguments = Loops(self.names, self.sizes), list(self.sizes.values())
        written = {self.names[name] for name in self.results}
        body = [
            f"double {name}[{length} + 1];  // a size may be 0"
            for name, length in loops.arrays(self.pieces).items()
            if name not in written
        ]
        body += [*loops.lines(self.pieces), "return 0;"]
        rows, heads = [""], [f"int {size}" for size in arguments]
        for name, X in (self.matrices | self.results).items():
            kind = "const double" if name in self.matrices else "double"
            one, (r, c) = self.names[name], X.shape
            arguments.append(one)
            heads.append(f"{kind} *{one} /* {r} x {c} */")
        for one in heads:
            if rows[-1] and len(f"{rows[-1]}, {one}") > WIDTH:
                rows.append("")
            rows[-1] += f", {one}" if rows[-1] else one
        head = ",\n    ".join(rows)
        lines = [f"    {line}" for line in body]
        return function(f"int run({head})", lines, arguments)

    @cached_property
    def run(self) -> Any:
        otherwise = "the text of the kernel is in `source`"
        return library({"kernel.c": self.source}, otherwise).run

    def solved(self, arrays: Matrices, sizes: dict[str, int]) -> Matrices:
        found = {
            name: np.zeros([int(sizes.get(str(size), size)) for size in X.shape])
            for name, X in self.results.items()
        }
        numbers = [ctypes.c_int(sizes.get(name, 0)) for name in self.sizes]
        pointers = (
            X.ctypes.data_as(ctypes.c_void_p)
            for X in (*arrays.values(), *found.values())
        )
        if self.run(*numbers, *pointers) != 0:
            raise np.linalg.LinAlgError(
                "a matrix that a solve needs is not positive definite"
            )
        return found


def own(name: str, taken: bool = False) -> str:
    """A name as code can use it: one that loops use themselves gets an underscore."""
    if not (name.isidentifier() and name.isascii()):
        raise ValueError(f"{name!r} is no name that code can have; {ANOTHER}")
    return f"{name}_" if taken or name in TAKEN or keyword.iskeyword(name) else name
