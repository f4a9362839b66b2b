"""A stage list as a function at any sizes, in NumPy, in loops for numba or in C."""

import ctypes
import keyword
from collections.abc import Callable, Iterator
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..numeric import Matrices
from ..symbolic import Derivation
from . import cache, runs_compiled
from .c import C, function
from .c.library import library
from .lowering import lower, sizes_of
from .numpy import kernel
from .passes import write_pass
from .program import Shape, Size, times
from .python import Python
from .writer import Writer

TAKEN = frozenset("i j k s q ok np back run".split())  # names that loops use


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
        If there is no such backend or output, nothing to compute, or the shapes of
        the matrices do not fit together.
    AssertionError
        If the derivation has no proof, or a false one.
    TypeError
        If what is given is no derivation, a stage has no such form, or a matrix is
        missing or unknown.
    numpy.linalg.LinAlgError
        In loops, if a matrix that a solve needs is not positive definite.

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
    step = kernel(derivation, *outputs)

    def call(**matrices: ArrayLike) -> Matrices:
        return step(**{name: np.asarray(X, float) for name, X in matrices.items()})

    found: Any = call
    found.source, found.given = step.source, step.given
    return found


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
    if not name.isidentifier():
        raise ValueError(
            f"{name!r} is no name that code can have; write another symbol"
        )
    return f"{name}_" if taken or name in TAKEN or keyword.iskeyword(name) else name


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
