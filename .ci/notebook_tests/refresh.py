"""Run a notebook from top to bottom and store it: refresh(path).

Timings, widget state and the interpreter's version are left out, so a second run leaves
no difference in git.
"""

import os
import sys
import tempfile
import textwrap
import time
from pathlib import Path

from . import as_run, in_pytest, prose  # noqa: F401  sets what kernels inherit

sys.modules.setdefault("rfc3987_syntax", None)  # spares nbformat 3 s of unused grammar
import nbformat  # noqa: E402
from nbclient import NotebookClient  # noqa: E402


def refresh(path):
    notebook = nbformat.read(path, as_version=4)
    kernel = {"name": "python3", "display_name": "Python 3 (ipykernel)"}
    kernel["language"] = "python"  # without it ruff passes over the notebook
    notebook.metadata = nbformat.from_dict({"kernelspec": kernel})
    client = NotebookClient(
        notebook,
        timeout=600,
        kernel_name="python3",
        record_timing=False,
        store_widget_state=False,
        coalesce_streams=True,  # however they were cut while the machine was busy
        extra_arguments=["--log-level=ERROR"],
        resources={"metadata": {"path": str(path.parent)}},
    )
    client.execute()
    notebook.metadata.pop("widgets", None)
    notebook.metadata.pop("language_info", None)
    for output in (o for cell in notebook.cells for o in cell.get("outputs", ())):
        # a view names its model by a random id, and without state shows nothing
        output.get("data", {}).pop("application/vnd.jupyter.widget-view+json", None)
        if output.output_type == "error":  # the message; the rest is paths and lines
            message = f"{output.ename}: {output.evalue}"
            output.traceback = textwrap.wrap(message, 88)
    describe_pictures(notebook)
    prose.tie(notebook)
    notebook.metadata[as_run.KEY] = as_run.fingerprint(notebook)
    nbformat.write(notebook, path)


def describe_pictures(notebook):
    """Give each cell the words of its picture, where MyST-NB looks for them.

    The cell has read them off the picture when it ran; nbconvert finds them in the
    output.
    """
    for cell in notebook.cells:
        cell.metadata.pop("mystnb", None)
        for output in cell.get("outputs", ()):
            look = output.get("metadata", {}).get("image/png", {})
            if "alt" in look:
                cell.metadata["mystnb"] = {"image": {"alt": look["alt"]}}


def main(paths):
    with tempfile.TemporaryDirectory() as settings:
        os.environ["IPYTHONDIR"] = settings  # nobody's personal start-up files
        for path in map(Path, paths):
            start = time.perf_counter()
            refresh(path.resolve())
            print(f"{path} {time.perf_counter() - start:.1f} s")


if __name__ == "__main__":
    main(sys.argv[1:])
