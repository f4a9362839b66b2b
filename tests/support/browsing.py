"""Chromium for the tests that look at pages as a reader does, and what to look at."""

import contextlib
import functools
import http.client
import http.server
import importlib.util
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.parse
import urllib.request

ROOT = pathlib.Path(__file__).parents[2]
NAMES = ("chromium", "chromium-browser", "google-chrome")
HOME = {"127.0.0.1", "localhost", ""}
PATIENCE = 120_000  # ms: only a fault waits that long, or a machine that is very busy


# -- what there is ---------------------------------------------------------------------


def chromium():
    """The browser's path; None where there is no browser."""
    return next(filter(None, map(shutil.which, NAMES)), None)


def missing():
    """Why no page can be looked at here; empty if one can."""
    for package in ("playwright", "axe_playwright_python"):
        if importlib.util.find_spec(package) is None:
            how = 'install -r environment-pip.txt -e "./lib[browser,course,site]"'
            return f"no browser without {package}: {how}"
    if chromium() is None:
        return f"none of {', '.join(NAMES)} found: apt-get install chromium"
    return ""


# -- who serves pages ------------------------------------------------------------------


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


@contextlib.contextmanager
def served(folder):
    """The files of a folder at an address of this machine."""
    handler = functools.partial(Quiet, directory=folder)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}"
        finally:
            server.shutdown()
            thread.join()


# every cell drawn, not only those in view; no question about news on a first visit
SETTINGS = {
    "notebook-extension/tracker": {"windowingMode": "none"},
    "apputils-extension/notification": {"fetchNews": "false", "checkForUpdates": False},
}


@contextlib.contextmanager
def lab(notebooks, home):
    """JupyterLab on a folder, with a configuration of its own below `home`.

    Gives a function from a notebook's name to its address.
    """
    for name, values in SETTINGS.items():
        file = home / "lab" / "@jupyterlab" / f"{name}.jupyterlab-settings"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(values))
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    token = os.urandom(16).hex()
    options = dict(ip="127.0.0.1", port=port, port_retries=0, open_browser=False)
    options |= dict(root_dir=notebooks, allow_root=True)
    command = [sys.executable, "-m", "jupyterlab"]
    command += [f"--ServerApp.{key}={value}" for key, value in options.items()]
    command += [f"--IdentityProvider.token={token}"]
    with open(home / "log", "w") as log:
        process = subprocess.Popen(
            command, env=own_environment(home), stdout=log, stderr=log
        )
    try:
        wait_for(f"http://127.0.0.1:{port}/api?token={token}", process, home / "log")
        yield (
            lambda name: f"http://127.0.0.1:{port}/lab/tree/{name}?reset&token={token}"
        )
    finally:
        end(process)


def own_environment(home):
    """Nothing of the user's is read or written, and figures are drawn in cells."""
    library = os.pathsep.join([str(ROOT / "lib"), os.environ.get("PYTHONPATH", "")])
    own = {
        "HOME": home,
        "IPYTHONDIR": home / "ipython",
        "JUPYTER_CONFIG_DIR": home / "config",
        "JUPYTER_DATA_DIR": home / "data",
        "JUPYTER_RUNTIME_DIR": home / "runtime",
        "JUPYTERLAB_SETTINGS_DIR": home / "lab",
        "JUPYTERLAB_WORKSPACES_DIR": home / "workspaces",
        "PYTHONPATH": library,
        "OMP_NUM_THREADS": "1",
    }
    kept = {key: value for key, value in os.environ.items() if key != "MPLBACKEND"}
    return kept | {key: str(value) for key, value in own.items()}


def wait_for(address, process, log):
    """Until the server answers."""
    last = time.monotonic() + PATIENCE / 1000
    while True:
        try:
            return urllib.request.urlopen(address, timeout=10).close()
        except (OSError, http.client.HTTPException):  # refused, reset, not yet there
            if process.poll() is not None or time.monotonic() > last:
                raise RuntimeError(f"no answer:\n{log.read_text()}") from None
        time.sleep(0.1)


def end(process):
    """A server asked to end ends its kernels too; one that does not is killed."""
    process.send_signal(signal.SIGTERM)
    try:
        process.wait(30)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


# -- who looks at them -----------------------------------------------------------------


@contextlib.contextmanager
def chromium_running():
    """A browser that finds no host but this machine."""
    from playwright.sync_api import sync_playwright

    nowhere = "MAP * ~NOTFOUND, EXCLUDE 127.0.0.1, EXCLUDE localhost"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=chromium(), args=[f"--host-resolver-rules={nowhere}"]
        )
        try:
            yield browser
        finally:
            browser.close()


@contextlib.contextmanager
def window(browser, width=1280, height=800, pardoned=None):
    """A page that may ask nothing of another machine.

    Nor may its scripts fail, but with the words `pardoned`.
    """
    context = browser.new_context(viewport={"width": width, "height": height})
    context.set_default_timeout(PATIENCE)
    asked, faults = [], []
    context.on("request", lambda request: asked.append(request.url))
    context.on("weberror", lambda fault: faults.append(str(fault.error)))
    page = context.new_page()
    page.on("websocket", lambda socket: asked.append(socket.url))
    try:
        yield page
    finally:
        context.close()
    away = sorted({url for url in asked if urllib.parse.urlsplit(url).hostname})
    away = [url for url in away if urllib.parse.urlsplit(url).hostname not in HOME]
    assert not away, f"asked of another machine: {away}"
    faults = [fault for fault in faults if fault != pardoned]
    assert not faults, f"faults of scripts: {faults}"


def visit(page, address):
    """Open a page and wait until its mathematics is set."""
    page.goto(address)
    settled(page)


def settled(page):
    """Until all is loaded, mathematics is set and nothing moves any more."""
    page.wait_for_function(
        """async () => {
            if (document.readyState !== "complete") return false;
            await window.MathJax?.startup?.promise;
            const frame = () => new Promise((done) => requestAnimationFrame(done));
            await frame();
            await frame();
            await Promise.allSettled(document.getAnimations().map((a) => a.finished));
            return true;
        }"""
    )


# -- what they see ---------------------------------------------------------------------

# What sticks out of the window, or out of a parent that hides the rest of it.  Not what
# a reader can scroll to, what is kept aside until asked for, or is for screen readers.
CUT = """() => {
    const width = document.documentElement.clientWidth, found = new Set();
    if (document.documentElement.scrollWidth > width) found.add("the page itself");
    const look = (element, { left, right, fixed }) => {
        const style = getComputedStyle(element), box = element.getBoundingClientRect();
        if (style.display === "none") return;
        if (style.clip !== "auto" || style.clipPath !== "none") return;
        fixed ||= style.position === "fixed";
        const aside = fixed && (box.right <= 0 || box.left >= width);
        if ((box.right > right + 1.5 || box.left < left - 1.5) && !aside
            && box.width >= 2 && box.height >= 2 && element.checkVisibility(
                { visibilityProperty: true, opacityProperty: true }))
            found.add(`cut: ${element.localName} ${element.getAttribute("class")} `
                + element.textContent.trim().slice(0, 40));
        if (element.localName === "svg" || /auto|scroll/.test(style.overflowX)) return;
        if (/hidden|clip/.test(style.overflowX)) {
            left = Math.max(left, box.left);
            right = Math.min(right, box.right);
        }
        for (const child of element.children) look(child, { left, right, fixed });
    };
    for (const child of document.body.children)
        look(child, { left: 0, right: width, fixed: false });
    return [...found].slice(0, 8);
}"""

UNREADABLE = """() => {
    const found = [];
    const small = (e) => {
        const box = e.getBoundingClientRect();
        return e.checkVisibility() && (box.width < 1 || box.height < 1);
    };
    for (const image of document.images)
        if (!image.naturalWidth || !(image.alt || image.ariaHidden) || small(image))
            found.push(`image ${image.src.slice(0, 60)}`);
    for (const math of document.querySelectorAll("div.math, span.math"))
        if (!math.querySelector("mjx-container svg"))
            found.push(`not set: ${math.textContent.slice(0, 60)}`);
    for (const math of document.querySelectorAll("mjx-container, math"))
        if (small(math)) found.push(`not seen: ${math.textContent.slice(0, 60)}`);
    for (const fault of document.querySelectorAll("[data-mml-node=merror], merror"))
        found.push(`not understood: ${fault.textContent.slice(0, 60)}`);
    return found.slice(0, 8);
}"""


def faults(page):
    """All that is cut off, empty, without words or not set on a page as it stands."""
    return page.evaluate(CUT) + page.evaluate(UNREADABLE)


# axe-core has no rule for what MathJax draws or spells in a formula: four elements of
# five, which would take most of its time.  They are put back.
LOOKED_AT = """async () => {
    const formulas = [...document.querySelectorAll("mjx-container > *")];
    const kept = formulas.map((formula) => [...formula.childNodes]);
    for (const formula of formulas) formula.replaceChildren();
    const found = await axe.run(document, { resultTypes: ["violations"] });
    formulas.forEach((formula, k) => formula.replaceChildren(...kept[k]));
    return found.violations;
}"""


def barriers(page):
    """What axe-core finds in the way of some readers, whatever its impact."""
    file = importlib.util.find_spec("axe_playwright_python").submodule_search_locations
    page.evaluate(pathlib.Path(file[0], "axe.min.js").read_text(encoding="utf-8"))
    return [
        f"{one['id']} ({one['impact']}): {node['html'][:120]}"
        for one in page.evaluate(LOOKED_AT)
        for node in one["nodes"]
    ]
