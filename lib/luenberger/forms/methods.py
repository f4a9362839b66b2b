"""The forms as methods of an observer."""

from __future__ import annotations

import dataclasses
from typing import Any, Self

import numpy as np

from ..errors import CertificateError, DesignError
from ..numeric import Matrix
from ..numeric.linalg import eigenvalues, modes
from .balanced import balanced_form
from .companion import companion_form, require_some
from .hidden import as_moved, shown_changes
from .modal import modal
from .system import Change, System, carried_out


class Forms:
    """The same observer in other coordinates S z, for whoever has F, G, D, P, T, z0.

    F, G, D, P, T and z0 become S F S^-1, S G, S D, P S^-1, S T and S z0; V, W and L
    stay.  The estimate is the same for every y, u and start, and so is the certificate.
    That F S = S F, and likewise for the others, is measured before a form is returned.
    """

    def modal(self, pairs: str = "rotation") -> Self:
        """The same observer, each pole on its own: F is block diagonal.

        A real pole is an entry of the diagonal; a pair s +- j w is a block.  Each mode
        is scaled so that one of its gains is 1, and of a pair the one beside it is 0:
        in P if the observer estimates one number, else in G or D.

        Parameters
        ----------
        pairs : "rotation" or "companion"
            [[s, -w], [w, s]], which keeps its poles well in short words; or
            [[0, 1], [-(s^2 + w^2), 2 s]], which is a multiplication and an addition
            less.

        Returns
        -------
        Observer

        Raises
        ------
        DesignError
            If poles are defective or nearly so, with the poles; if the observer is
            complex or varies over time.

        See Also
        --------
        companion, balanced : other coordinates.

        Examples
        --------
        >>> import luenberger as lb
        >>> plant = lb.Plant([[0.9, 1], [-0.2, 0.7]], None, [[1, 0]], dt=1.0,
        ...                  Q=[[1, 0], [0, 1]], R=[[1]])
        >>> modal = lb.kalman_filter(plant).modal()
        >>> bool(modal.F[0, 0] == modal.F[1, 1] and modal.F[0, 1] == -modal.F[1, 0])
        True
        >>> modal.D[:, 0]
        array([1., 0.])
        >>> lb.certify(modal, plant).worst < 1e-14
        True
        """
        return self._in(lambda system: modal(system, pairs))

    def balanced(self) -> Self:
        """The same observer, its inputs reaching each state as far as w^ shows it.

        Both Gramians are the same diagonal matrix, X = F X F' + G G' + D D' and
        Y = F' Y F + P' P (in continuous time F X + X F' + G G' + D D' = 0, likewise
        Y).  So numbers are of like size, as a device with a fixed point needs.  The
        form depends on the units of u, y and w^, and not on those of z.

        Returns
        -------
        Observer

        Raises
        ------
        DesignError
            If F is not stable, or some state is not reached by y and u or not shown
            by the estimate; if the observer is complex or varies over time.

        References
        ----------
        B. C. Moore, IEEE Trans. Automat. Contr. 26 (1981) 17-32;
        `forms/derivation/gramians.py`.

        Examples
        --------
        >>> import luenberger as lb
        >>> observer = lb.Observer([[0.5]], None or [[]], [[3]], [[12]], [[0]], [[1]],
        ...                        [[1]], dt=1.0)
        >>> form = observer.balanced()
        >>> float(form.D[0, 0]), float(form.P[0, 0])
        (6.0, 6.0)
        """
        dt: float = vars(self)["dt"]
        return self._in(lambda system: balanced_form(system, dt))

    def companion(
        self, estimate: int | str | None = None, output: int | str | None = None
    ) -> Self:
        """The same observer as a chain: F has ones beside its diagonal and one row.

        From an estimate w the states are w less V y and W u, and what becomes of it,
        P F^k z; that row of P is 1, 0, ..., 0, and the last row of F has the
        coefficients of its characteristic polynomial.  From an output it is the
        transpose: that column of D is 1, 0, ..., 0.  The chain must reach all states.

        Parameters
        ----------
        estimate, output : int or str, optional
            Where the chain starts, by number or name.  Default the one of all that
            leaves the fewest entries, estimates first.

        Returns
        -------
        Observer

        Raises
        ------
        DesignError
            If the chain does not reach all states in working precision; if the
            observer is complex or varies over time.
        ValueError
            An estimate or output that there is not, or both.

        Examples
        --------
        >>> import luenberger as lb
        >>> observer = lb.Observer([[0.5, 1], [0, 0.25]], [[], []], [[0], [1]],
        ...                        [[1, 1]], [[0]], T=[[1], [1]], L=[[2]], dt=1.0)
        >>> form = observer.companion()
        >>> form.F, form.P
        (array([[ 0.   ,  1.   ],
               [-0.125,  0.75 ]]), array([[1., 0.]]))
        """
        if estimate is not None and output is not None:
            raise ValueError("a chain starts from an estimate or from an output")
        o: Any = self
        rows = _places("estimate", estimate, o.estimate_names, output is None)
        columns = _places("output", output, _outputs(o), estimate is None)
        inputs = o.G.shape[-1]
        found = [
            form
            for given in (
                *({"row": row} for row in rows),
                *({"column": inputs + column} for column in columns),
            )
            for form in self._tried(given)
        ]
        asked = output if estimate is None else estimate
        chosen = "of this observer" if asked is None else f"from {asked!r}"
        if o.order:
            require_some(found, chosen, modes(eigenvalues(o.F)))
        return min(found, key=_entries) if found else self

    def without_hidden(self) -> Self:
        """The same observer without states that its estimate never shows.

        A state is left out where no entry of F and P leads from it to w^; then
        directions in which all states together show nothing, to twelve digits.
        An observer that shows all of its states is returned as it is.

        Returns
        -------
        Observer

        Raises
        ------
        DesignError
            If the observer is complex or varies over time.

        Examples
        --------
        >>> import luenberger as lb
        >>> plant = lb.Plant([[0.9, 0], [0, 0.5]], None, [[1, 0], [0, 1]], dt=1.0,
        ...                  Q=[[1, 0], [0, 1]], R=[[1, 0], [0, 1]])
        >>> first = lb.kalman_filter(plant, L=[1, 0])
        >>> first.order, first.without_hidden().order
        (2, 1)
        """
        system = self._system()
        if not len(system.F):
            return self
        system, found = as_moved(system), [self]
        for change in shown_changes(system):
            try:
                found.append(self._moved(change, system))
            except CertificateError:
                continue
        return min(found, key=lambda one: len(vars(one)["F"]))

    def _tried(self, given: dict[str, int]) -> list[Self]:
        """The companion form from one place, if there is one."""
        system = self._system()
        if not len(system.F):
            return []
        try:
            return [
                self._moved(change, system)
                for change in companion_form(system, **given)
            ]
        except (CertificateError, np.linalg.LinAlgError):
            return []

    def _in(self, form: Any) -> Self:
        system = self._system()
        return self._moved(form(system), system) if len(system.F) else self

    def _system(self) -> System:
        o: Any = self
        if o.steps is not None or o.is_complex:
            kind = "varies over time" if o.steps is not None else "is complex"
            raise DesignError(
                f"forms are of a constant, real observer, and this one {kind}. Design "
                "one with a steady gain, or separate real and imaginary parts."
            )
        return System.of(o.F, np.hstack([o.G, o.D]), o.P)

    def _moved(self, change: Change, system: System) -> Self:
        o: Any = self
        given: dict[str, Matrix] = {name: getattr(o, name) for name in "FGDPT"}
        found = carried_out(change, system, given | {"z0": o.z0})
        return dataclasses.replace(o, **found)


def _outputs(o: Any) -> tuple[str, ...]:
    count = o.D.shape[-1]
    return o.output_names or tuple(f"y{k + 1}" for k in range(count))


def _places(
    what: str, chosen: int | str | None, known: tuple[str, ...], every: bool
) -> list[int]:
    """The numbers of the places that a chain may start from."""
    if chosen is None:
        return list(range(len(known))) if every else []
    if isinstance(chosen, str) and chosen in known:
        return [known.index(chosen)]
    if isinstance(chosen, (int, np.integer)) and 0 <= chosen < len(known):
        return [int(chosen)]
    raise ValueError(f"there is no {what} {chosen!r}; there are {list(known)}")


def _entries(o: Any) -> int:
    """Entries of an observer that are work."""
    return sum(int(np.count_nonzero(X)) for X in (o.F, o.G, o.D, o.P))
