"""Running a notebook: a signal ends it whenever it comes, and its kernel with it."""

import asyncio
import os
import signal

import pytest
from interrupts import ended, sigint  # noqa: F401  a fixture

from luenberger.report.notebook import run, to_html

nbclient = pytest.importorskip("nbclient", reason="the report is an optional extra")
nbformat = pytest.importorskip("nbformat", reason="the report is an optional extra")
pytestmark = [
    pytest.mark.skipif(os.name == "nt", reason="signals are POSIX's"),
    pytest.mark.usefixtures("sigint"),
]


def interrupt():
    os.kill(os.getpid(), signal.SIGINT)


def watched(patch, name, before=None, after=None):
    """Wrap a coroutine of nbclient's client; the kernel's number at each call."""
    ran, seen = getattr(nbclient.NotebookClient, name), []

    async def wrapper(self, *arguments, **options):
        seen.append(self.km.provisioner.pid)
        if before:
            before()
        found = await ran(self, *arguments, **options)
        if after:
            await after(len(seen))
        return found

    patch.setattr(nbclient.NotebookClient, name, wrapper)
    return seen


def run_three_cells(folder):
    cells = [nbformat.v4.new_code_cell(f"open('{k}', 'w').close()") for k in range(3)]
    run(nbformat.v4.new_notebook(cells=cells), folder)


def test_signal_in_the_same_turn_as_the_end_of_a_cell(tmp_path, monkeypatch):
    """asyncio forgets to cancel then; the next cell must not run all the same."""

    async def late(cell):
        if cell == 2:
            await asyncio.sleep(0.3)  # the reply has come, and waits for this
            interrupt()
            await asyncio.sleep(0)

    watched(monkeypatch, "_async_poll_output_msg", after=late)
    with pytest.raises(KeyboardInterrupt):
        run_three_cells(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["0", "1"]


def test_a_signal_that_is_ignored_stays_so(tmp_path, monkeypatch):
    """As in a job in the background, which the terminal's SIGINT does not concern."""
    ignored = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        watched(monkeypatch, "async_start_new_kernel_client", before=interrupt)
        run_three_cells(tmp_path)
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, ignored)
    assert len(list(tmp_path.iterdir())) == 3


def test_text_that_looks_like_what_stands_for_a_formula_stays(tmp_path):
    """Names of signals are in the outputs; formulas are put back into the page last."""
    notebook = nbformat.v4.new_notebook(
        cells=[
            nbformat.v4.new_markdown_cell("$x$ and $$y$$"),
            nbformat.v4.new_markdown_cell("formula0end, formula1end"),
        ]
    )
    page = to_html(notebook, "formula0end")
    assert page.count("<math") == 2 and "formula0end, formula1end" in page
    assert "<title>formula0end</title>" in page


def test_signal_while_the_kernel_starts(tmp_path, monkeypatch):
    name = "async_start_new_kernel_client"
    seen = watched(monkeypatch, name, before=interrupt)
    with pytest.raises(KeyboardInterrupt):
        run_three_cells(tmp_path)
    assert ended(seen[0]) and list(tmp_path.iterdir()) == []


def test_signal_while_the_kernel_ends(tmp_path, monkeypatch):
    """It is waited for, as it may still write into the folder."""
    seen = watched(monkeypatch, "_async_cleanup_kernel", before=interrupt)
    with pytest.raises(KeyboardInterrupt):
        run_three_cells(tmp_path)
    assert ended(seen[0]) and len(list(tmp_path.iterdir())) == 3
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
