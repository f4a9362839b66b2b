"""Lessons as slides, for nbconvert; the deck needs no network.

    python -m nbconvert --config notebooks/slides.py --output-dir deck LESSON.ipynb ...

Open `deck/LESSON.slides.html`.  The folder `deck` can be carried to another machine.
reveal.js and MathJax come with the extra `site`.
"""

import importlib.util
import shutil
import sys
from pathlib import Path

from nbconvert.postprocessors import PostProcessorBase

HERE = Path(__file__).resolve().parent


def in_package(name, *parts):
    """A file or folder of an installed package, which need not be imported."""
    return Path(*importlib.util.find_spec(name).submodule_search_locations, *parts)


class Carry(PostProcessorBase):
    """Copies what the slides load beside them."""

    def postprocess(self, input):  # the name that nbconvert gives
        beside = Path(input).parent
        revealing = in_package("sphinx_revealjs", "_static", "revealjs")
        shutil.copytree(revealing, beside / "reveal.js", dirs_exist_ok=True)
        maths = in_package("sphinx-mathjax-offline", "static", "mathjax")
        shutil.copy(maths / "tex-svg-full.js", beside)


if "get_config" in globals():  # as nbconvert reads its settings, not as a module
    sys.path.insert(0, str(HERE))
    c = get_config()  # noqa: F821  given by nbconvert
    c.NbConvertApp.export_format = "slides"
    c.NbConvertApp.postprocessor_class = "slides.Carry"
    c.SlidesExporter.template_name = "slides"
    c.SlidesExporter.extra_template_basedirs = [str(HERE / "pages")]
    c.SlidesExporter.reveal_url_prefix = "reveal.js"
    c.SlidesExporter.reveal_theme = "white"  # its fonts come with it
    c.SlidesExporter.mathjax_url = "tex-svg-full.js"
    c.SlidesExporter.exclude_input_prompt = True
    c.SlidesExporter.exclude_output_prompt = True
    c.TagRemovePreprocessor.enabled = True
    c.TagRemovePreprocessor.remove_input_tags = {"hide-input"}
