"""Settings of the course; README.md beside this file says how it runs."""

import logging
import sys
from pathlib import Path

import nbformat
from nbgrader import preprocessors

sys.path.insert(0, str(Path.cwd()))

from key import with_formulas  # noqa: E402

c = get_config()  # noqa: F821  nbgrader defines it

c.CourseDirectory.course_id = "luenberger"

# A cell that runs longer is interrupted and scores nothing; the next cell runs.
c.Execute.timeout = 20


class RestoreCells(preprocessors.NbGraderPreprocessor):
    """Puts cells that were deleted back where they were, an answer as a blank one.

    nbgrader's own add_missing_cells knows the checks only, and fails where a check and
    its answer are gone, or where a cell was copied: of a copy, its role is emptied.
    """

    def preprocess(self, nb, resources):
        of = resources["nbgrader"]
        path = f"release/{of['assignment']}/{of['notebook']}.ipynb"
        for copied in [own for own in nb.cells if own.metadata.get("nbgrader") == {}]:
            del copied.metadata["nbgrader"]
        place = 0  # behind the cell before
        for cell in nbformat.read(path, as_version=4).cells:
            if name := self.grade_id(cell):
                names = [self.grade_id(own) for own in nb.cells]
                if name in names:
                    place = names.index(name)
                else:
                    cell["id"] += "-restored"
                    nb.cells.insert(place, cell)
                place += 1
        return nb, resources

    def grade_id(self, cell):
        return cell.metadata.get("nbgrader", {}).get("grade_id")


def unexpected(record):
    """Whether a message says more than that hidden checks have been put back."""
    said = record.getMessage()
    return not said.startswith(("Checksum for grade cell", "Attribute 'checksum'"))


logging.getLogger("AutogradeApp").addFilter(unexpected)

# Of a cell and its copies the last counts, as it does when they run.
c.Autograde.sanitize_preprocessors = [
    preprocessors.ClearOutput,
    preprocessors.DeduplicateIds,
    RestoreCells,
    preprocessors.OverwriteKernelspec,
    preprocessors.OverwriteCells,
    preprocessors.CheckCellMetadata,
]


# Feedback pages need no network: templates/ is here, and formulas are MathML.
c.HTMLExporter.extra_template_basedirs = [str(Path.cwd() / "templates")]
c.HTMLExporter.filters = {"with_formulas": with_formulas}
