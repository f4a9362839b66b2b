"""Notebooks in JupyterLab, in Chromium: they run, draw, and follow a slider."""

import json
import re
import shutil
import sys

import browsing
import pytest
from browsing import ROOT, window

pytestmark = pytest.mark.browser

NOTEBOOKS = sorted((ROOT / "notebooks").glob("[0-9]*.ipynb"))
LAST = "every cell has run"
DONE = """([last, raising]) => {
    const cells = [...document.querySelectorAll(".jp-CodeCell")];
    const failed = (cell, k) => !raising.includes(k)
        && cell.querySelector("[data-mime-type$=stderr], [data-mime-type$=error]");
    const output = cells.at(-1).querySelector(".jp-OutputArea-output");
    const prompt = cells.at(-1).querySelector(".jp-InputPrompt");
    const finished = output?.textContent.includes(last)
        && /\\d/.test(prompt.textContent);
    return finished || cells.some(failed);
}"""
READOUT = ".widget-readout"
BYTES = """async (image) => {
    const response = await fetch(image.src);
    const bytes = [...new Uint8Array(await response.arrayBuffer())];
    return bytes.map((byte) => byte.toString(16).padStart(2, "0")).join("");
}"""


RESTS = 3000  # milliseconds, far more than a change takes to reach the kernel
RESTED = """(enough) => new Promise((resolve, reject) => {
    const seen = () => document.querySelector("img.widget-image").src
        + document.querySelector(".jp-Notebook-ExecutionIndicator").dataset.status;
    const begun = performance.now();
    let [last, since] = [seen(), begun];
    const look = () => {
        const now = seen();
        const busy = !now.endsWith("idle");
        if (busy || now !== last) [last, since] = [now, performance.now()];
        if (performance.now() - since > enough) resolve();
        else if (performance.now() - begun > 40 * enough) reject("never at rest");
        else setTimeout(look, 50);
    };
    look();
})"""


@pytest.fixture(scope="module")
def lab(browser, tmp_path_factory):
    """Addresses of notebooks in a JupyterLab, on copies without any output."""
    if not shutil.which("jupyter-lab", path=f"{sys.prefix}/bin"):
        pytest.skip("no notebook is opened without jupyterlab: install jupyter")
    folder = tmp_path_factory.mktemp("notebooks")
    shutil.copytree(ROOT / "notebooks" / "plants", folder / "plants")
    for path in NOTEBOOKS:
        notebook = json.loads(path.read_text(encoding="utf-8"))
        (folder / path.name).write_text(json.dumps(unexecuted(notebook)))
    with browsing.lab(folder, tmp_path_factory.mktemp("home")) as address:
        yield folder, address


def unexecuted(notebook):
    """The notebook before it was run, with a cell at its end that says it has been."""
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            cell |= {"outputs": [], "execution_count": None}
    last = {"cell_type": "code", "id": "last", "metadata": {}, "execution_count": None}
    notebook["cells"].append(last | {"outputs": [], "source": f"print({LAST!r})"})
    return notebook


def code(notebook):
    return [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]


def may_raise(cell):
    return "raises-exception" in cell["metadata"].get("tags", ())


def run_all(page, folder, address, name):
    """Choose Run, Run All Cells, wait for the end, save; the notebook as saved."""
    given = code(json.loads((folder / name).read_text()))
    page.goto(address(name))
    page.locator(".jp-CodeCell").nth(len(given) - 1).wait_for(state="attached")
    page.locator(".jp-KernelName", has_text="Python 3").wait_for()
    page.locator(".jp-Notebook-ExecutionIndicator[data-status=idle]").wait_for()
    page.locator(".jp-CodeCell .cm-content").first.click()
    page.locator(".lm-MenuBar-itemLabel", has_text=re.compile("^Run$")).click()
    item = '.lm-Menu-item[data-command="runmenu:run-all"]:not(.lm-mod-disabled)'
    page.locator(item).click()
    raising = [k for k, cell in enumerate(given) if may_raise(cell)]
    page.wait_for_function(DONE, arg=[LAST, raising])
    with page.expect_response(is_save) as saved:
        page.keyboard.press("Control+s")
    assert saved.value.ok
    return json.loads((folder / name).read_text())


def is_save(response):
    return response.request.method == "PUT" and "/api/contents/" in response.url


def errors(notebook):
    """What went wrong in cells that were not meant to, and what was not run."""
    for cell in code(notebook):
        source = "".join(cell["source"])
        kinds = {output["output_type"] for output in cell["outputs"]}
        if may_raise(cell) != ("error" in kinds):
            yield source
        elif cell["execution_count"] is None and source:
            yield f"not run: {source}"


def pictures(notebook):
    return [
        k
        for k, cell in enumerate(code(notebook))
        if any("image/png" in output.get("data", {}) for output in cell["outputs"])
    ]


def test_the_first_notebook_runs_and_draws_its_figure(browser, lab):
    (path,) = (path for path in NOTEBOOKS if path.name.startswith("00"))
    stored = pictures(json.loads(path.read_text(encoding="utf-8")))
    with window(browser) as page:
        notebook = run_all(page, *lab, path.name)
        assert list(errors(notebook)) == []
        assert pictures(notebook) == stored and stored
        cells = page.locator(".jp-CodeCell")
        for k in stored:
            image = cells.nth(k).locator(".jp-OutputArea img")
            assert image.evaluate("(image) => image.naturalWidth") > 300
            assert image.bounding_box()["width"] > 300
        assert page.locator(".jp-MarkdownOutput mjx-container").count() > 20


def test_the_slider_changes_the_figure_and_back(browser, lab):
    (path,) = (path for path in NOTEBOOKS if path.name.startswith("04"))
    with window(browser) as page:
        assert list(errors(run_all(page, *lab, path.name))) == []
        image, readout = page.locator("img.widget-image"), page.locator(READOUT)
        slide(page, "Home")
        least, at_least = image.evaluate(BYTES), float(readout.inner_text())
        slide(page, "End")
        assert image.evaluate(BYTES) != least
        assert float(readout.inner_text()) > at_least
        slide(page, "Home")
        assert image.evaluate(BYTES) == least
        assert float(readout.inner_text()) == at_least


def slide(page, key):
    """Press a key on the slider; wait until kernel and picture have rested a while."""
    page.locator(".noUi-handle").press(key)
    page.evaluate(RESTED, RESTS)


def test_an_error_in_a_cell_is_noticed(browser, lab):
    folder, address = lab
    cell = {"cell_type": "code", "id": "wrong", "metadata": {}, "source": "1 / 0"}
    notebook = {"nbformat": 4, "nbformat_minor": 5, "cells": [cell]}
    kernel = {"name": "python3", "display_name": "Python 3 (ipykernel)"}
    notebook = unexecuted(notebook | {"metadata": {"kernelspec": kernel}})
    (folder / "wrong.ipynb").write_text(json.dumps(notebook))
    with window(browser) as page:
        found = list(errors(run_all(page, folder, address, "wrong.ipynb")))
    assert found[0] == "1 / 0" and found[1].startswith("not run")
