"""Kernels that are forked: nothing is left of another, and none dies unnoticed."""

import signal
import sys
import time

import pytest
from interrupts import ended

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="kernels are not forked"
)


@pytest.fixture
def start(monkeypatch, tmp_path):
    """Start a kernel as nbval does."""
    import nbval.kernel
    from jupyter_client.manager import KernelManager
    from notebook_tests import forked

    manager = forked.manager(KernelManager, ("json",))
    monkeypatch.setattr(nbval.kernel, "KernelManager", manager)
    started = []

    def one(folder=tmp_path):
        kernel = nbval.kernel.RunningKernel(
            nbval.kernel.CURRENT_ENV_KERNEL_NAME, folder
        )
        started.append(kernel)
        return kernel

    yield one
    for kernel in started:
        if kernel.is_alive():
            kernel.stop()


def process(kernel):
    return kernel.km.provisioner.process


def says(kernel, code):
    """The value of an expression, or the name of its error."""
    answer = kernel.kc.execute_interactive(
        "", user_expressions={"x": code}, timeout=60, output_hook=lambda _: None
    )
    found = answer["content"]["user_expressions"]["x"]
    return found["data"]["text/plain"] if "data" in found else found["ename"]


def run(kernel, code):
    """An error in it leaves what is asked next to be run."""
    return kernel.kc.execute(code, stop_on_error=False)


def within(seconds, what):
    end = time.monotonic() + seconds
    while not (found := what()) and time.monotonic() < end:
        time.sleep(0.05)
    return found


def test_a_kernel_begins_where_no_cell_was_run(start, tmp_path, monkeypatch):
    first = start()
    run(first, "import json, os, sys; mine, json.mine = 1, 2; os.environ['MINE'] = '3'")
    assert says(first, "mine, json.mine, os.environ['MINE']") == "(1, 2, '3')"
    (tmp_path / "other").mkdir()
    monkeypatch.setenv("GIVEN", "later")
    monkeypatch.chdir(tmp_path)  # not the folder in which the server was started
    other = start("other")
    assert type(process(other)) is type(process(first))
    assert process(other).server is process(first).server
    assert says(other, "mine") == "NameError"
    run(other, "import json, os, sys")
    assert says(other, "hasattr(json, 'mine')") == "False"
    assert says(other, "'MINE' in os.environ") == "False"
    assert says(other, "os.environ['GIVEN']") == "'later'"
    assert says(other, "os.path.basename(os.getcwd())") == "'other'"
    assert says(other, "[one for one in sys.path if 'notebook_tests' in one]") == "[]"


def test_a_kernel_has_what_formats_its_first_error(start):
    kernel = start()
    run(kernel, "import sys")
    assert says(kernel, "'pygments.lexers.python' in sys.modules") == "True"


def test_a_figure_is_shown_where_its_cell_ends(start):
    """The backend asks when it is loaded what it draws for."""
    kernel, shown = start(), []
    code = "import matplotlib.pyplot as plt; line = plt.plot([1, 2])"
    kernel.kc.execute_interactive(code, timeout=60, output_hook=shown.append)
    data = [m["content"]["data"] for m in shown if m["msg_type"] == "display_data"]
    assert [set(one) for one in data] == [{"text/plain", "image/png"}]


def test_a_cell_is_interrupted(start):
    kernel = start()
    asked = run(kernel, "import time; print('begun', flush=True); time.sleep(600)")
    while kernel.get_message("iopub", timeout=60)["msg_type"] != "stream":
        pass
    kernel.interrupt()
    while kernel.get_message("iopub", timeout=60)["msg_type"] != "error":
        pass
    kernel.await_reply(asked, timeout=60)
    assert says(kernel, "1 + 1") == "2"


def test_a_kernel_that_dies_is_noticed(start):
    kernel = start()
    forked = process(kernel)
    run(kernel, "import os; os._exit(3)")
    assert within(60, lambda: not kernel.is_alive())
    assert forked.poll() == 3 and ended(forked.pid)


def test_without_a_server_kernels_are_processes_of_their_own(start):
    from notebook_tests import forked

    orphan = start()
    pid, server = process(orphan).pid, process(orphan).server
    server.process.send_signal(signal.SIGKILL)
    server.process.wait()
    assert not orphan.is_alive() and within(60, lambda: ended(pid))
    own = start()
    assert not isinstance(process(own), forked.Kernel) and says(own, "1 + 1") == "2"
    forked.server.cache_clear()


def test_a_process_with_threads_is_not_forked(tmp_path, monkeypatch):
    from notebook_tests import forked

    code = "import threading as t\nt.Thread(target=t.Event().wait, daemon=True).start()"
    (tmp_path / "with_a_thread.py").write_text(code)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    server = forked.Server(sys.executable, ("with_a_thread",))
    with pytest.raises(ValueError, match="has threads"):
        server.kernel(arguments=[], cwd="", env={})
    server.close()
