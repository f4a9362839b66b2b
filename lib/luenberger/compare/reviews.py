"""A comparison for a review: in Markdown, in LaTeX, as a data frame."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..show import Table


class Reviews:
    """What `Comparison` is in other programs; it has `table` and `rows`."""

    if TYPE_CHECKING:

        @property
        def table(self) -> Table: ...

        def rows(self) -> list[dict[str, Any]]: ...

    def to_markdown(self) -> str:
        """The table of the designs in Markdown, the recommended one in bold.

        Examples
        --------
        >>> import luenberger as lb
        >>> plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]])
        >>> table = lb.compare(plant, methods=["Kalman filter"])
        >>> print(table.to_markdown()[:40])
        | method | which | order | worst state |
        """
        return self.table.to_markdown()

    def to_latex(self) -> str:
        """The table of the designs as a tabular of LaTeX, which needs no package.

        Examples
        --------
        >>> import luenberger as lb
        >>> plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]])
        >>> table = lb.compare(plant, methods=["Kalman filter"])
        >>> print(table.to_latex().splitlines()[-1])
        \\end{tabular}
        """
        return self.table.to_latex()

    def to_frame(self) -> Any:
        """`rows` as a data frame: every attempt with all its figures, and refusals.

        Returns
        -------
        pandas.DataFrame

        Raises
        ------
        ImportError
            If pandas is not installed.

        Examples
        --------
        >>> import luenberger as lb
        >>> plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]])
        >>> frame = lb.compare(plant, methods=["Kalman filter"]).to_frame()
        >>> frame[["method", "order", "recommended"]].values.tolist()
        [['Kalman filter', 1, True]]
        """
        try:
            import pandas
        except ImportError:
            raise ImportError(
                "to_frame needs pandas, which is not installed: pip install pandas, "
                "or take rows(), a list of plain dicts"
            ) from None
        return pandas.DataFrame(self.rows())
