"""Run a notebook, and turn it into one HTML page that needs no network."""

import asyncio
import atexit
import os
import re
import secrets
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

TEMPLATES = Path(__file__).parent / "templates"
DISPLAYED = re.compile(r"\$\$(.+?)\$\$", re.S)
SIGNALS = signal.SIGINT, signal.SIGTERM
SCROLLS = re.compile(
    r'<(?=table|pre|math[^>]*display="block"|div class="output_png)(\w+)'
)
INLINE = re.compile(r"(?<![\\$\w])\$([^$\n]+?)\$(?![\w$])")


class NotebookError(RuntimeError):
    """A cell of the notebook raised; the message is that of the exception."""


def run(
    notebook: Any,
    folder: Path,
    progress: Callable[[int, int, str], object] = lambda step, steps, title: None,
) -> Any:
    """Execute a notebook (a node) in `folder`, in this Python and in place.

    ``progress(step, steps, title)`` is called before each code cell with the
    heading the cell stands under.
    """
    nbclient = _notebook_tools().nbclient
    titles = _headings(notebook)
    steps = len(titles)

    def started(cell, cell_index):
        client.heed_signal()
        if cell_index in titles:
            number, title = titles[cell_index]
            progress(number, steps, title)

    client = _client(notebook, folder, started)
    with tempfile.TemporaryDirectory() as settings:
        # no personal start-up files, and the kernel's threads do not fight
        env = os.environ | {"IPYTHONDIR": settings, "OMP_NUM_THREADS": "1"}
        try:
            client.execute(env=env, stderr=subprocess.DEVNULL)
            client.heed_signal()
        except nbclient.exceptions.CellExecutionError as error:
            raise NotebookError(f"{error.ename}: {error.evalue}") from None
        except (nbclient.exceptions.DeadKernelError, asyncio.CancelledError):
            client.end()
            if client.came is not None:
                signal.raise_signal(client.came)
            raise NotebookError("the notebook's Python process died") from None
        finally:
            client.end()
    for not_of_this_run in ("language_info", "as_run"):  # interpreter, template's cells
        notebook.metadata.pop(not_of_this_run, None)
    return notebook


def _client(notebook, folder, started):
    class Client(_Heeding, _notebook_tools().nbclient.NotebookClient):
        pass

    return Client(
        notebook,
        timeout=None,
        kernel_name="python3",
        record_timing=False,
        store_widget_state=False,
        extra_arguments=["--log-level=ERROR"],
        resources={"metadata": {"path": str(folder)}},
        on_cell_start=started,
    )


class _Heeding:
    """A client that ends cleanly on a signal and then hands the signal on.

    A signal that is ignored, as by a job in the background, stays ignored.

    nbclient's own answer to a signal is to end the kernel under itself.  Here its task
    is cancelled.  asyncio may lose that, where what is awaited is done in the same
    turn of its loop, so the signal is remembered as well.
    """

    came, ending, loop = None, False, None

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        self.before = {number: signal.getsignal(number) for number in SIGNALS}

    async def async_start_new_kernel(self, **options):
        here = threading.current_thread()
        if here is threading.main_thread() and os.name != "nt":
            self.loop, task = asyncio.get_running_loop(), asyncio.current_task()
            for number, handler in self.before.items():
                if handler == signal.SIG_IGN:  # nbclient has put its own there
                    self.loop.remove_signal_handler(number)
                    signal.signal(number, signal.SIG_IGN)
                else:
                    self.loop.add_signal_handler(number, self.stop, task, number)
        await super().async_start_new_kernel(**options)

    async def _async_cleanup_kernel(self):
        self.ending = True  # let it: what writes into the folder has to be gone
        await super()._async_cleanup_kernel()

    def stop(self, task, number):
        again, self.came = self.came is not None, number
        if not (again or self.ending):
            task.cancel()

    def heed_signal(self):
        if self.came is not None:
            raise asyncio.CancelledError

    def end(self):
        """Leave no kernel, which nbclient does to one that starts; handlers back."""
        self.ending = True
        if self.km is not None and self.km.has_kernel:
            self._cleanup_kernel()
        atexit.unregister(self._cleanup_kernel)
        for number, handler in self.before.items() if self.loop else ():
            self.loop.remove_signal_handler(number)
            signal.signal(number, handler)


def read(path: str | Path) -> Any:
    return _notebook_tools().nbformat.read(path, as_version=4)


def write(notebook: Any, path: str | Path) -> None:
    _notebook_tools().nbformat.write(notebook, path)


def to_html(notebook: Any, title: str) -> str:
    """The notebook's text and results, without its code, as one HTML page."""
    tools = _notebook_tools()
    formulas: dict[str, str] = {}
    page = tools.nbformat.from_dict(notebook)  # a copy: formulas are taken out of it
    for cell in page.cells:
        if cell.cell_type == "markdown":
            cell.source = _take_formulas(cell.source, formulas)
        for output in cell.get("outputs", []):
            data = output.get("data", {})
            if "text/latex" in data and "text/html" not in data:
                data["text/html"] = _take_formulas(data.pop("text/latex"), formulas)
    exporter = tools.nbconvert.HTMLExporter(
        template_name="offline",
        extra_template_basedirs=[str(TEMPLATES)],
        exclude_input=True,
        exclude_output_prompt=True,
        exclude_anchor_links=True,
        embed_images=True,
    )
    body, _ = exporter.from_notebook_node(page, {"metadata": {"name": title}})
    for token, formula in formulas.items():
        body = body.replace(token, formula)
    # what may scroll on a phone is reached with the keyboard; there are no scripts
    return SCROLLS.sub(r'<\1 tabindex="0"', body)


def _take_formulas(text, formulas):
    """Replace TeX by tokens that Markdown leaves alone, and keep MathML for each."""

    def token(match, display):
        tex = match[1].removeprefix(r"\displaystyle ")
        name = f"formula{secrets.token_hex(16)}end"  # not in anybody's text
        formulas[name] = _mathml(tex, display)
        return name

    text = DISPLAYED.sub(lambda match: token(match, "block"), text)
    return INLINE.sub(lambda match: token(match, "inline"), text)


def _mathml(tex, display):
    from latex2mathml.converter import convert

    return convert(tex, display=display)


def _headings(notebook):
    """Of each code cell by index: its number and the heading above it."""
    found, title = {}, ""
    for k, cell in enumerate(notebook.cells):
        if cell.cell_type == "markdown":
            lines = [line for line in cell.source.splitlines() if line.startswith("#")]
            title = lines[-1].strip("# ") if lines else title
        elif cell.source.strip():
            found[k] = (len(found) + 1, title)
    return found


def _notebook_tools():
    """Jupyter's packages, imported when needed: the library does without them."""
    # 3 s of building a grammar for international URLs, which notebooks have none of;
    # jsonschema treats the absent module as an absent optional check
    sys.modules.setdefault("rfc3987_syntax", None)
    try:
        import nbclient
        import nbconvert
        import nbformat
    except ImportError as error:
        raise NotebookError(
            f"the report needs the Python package {error.name!r}: install "
            "environment-pip.txt, or luenberger[report]"
        ) from None
    return _Tools(nbclient, nbconvert, nbformat)


class _Tools:
    def __init__(self, nbclient, nbconvert, nbformat):
        self.nbclient, self.nbconvert, self.nbformat = nbclient, nbconvert, nbformat
