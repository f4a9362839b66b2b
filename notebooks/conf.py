"""Builds these notebooks into pages: python -m sphinx -W --keep-going notebooks site

The pages are made from the outputs that the notebooks store; nothing is run again.
They load nothing from elsewhere: MathJax, fonts and search are files among them.
"""

import importlib.util
import re
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "pages" / "extensions"))

project = "luenberger"
author = "the authors of luenberger"
copyright = "the authors of luenberger, MIT licence"
language = "en"

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "numbered_equations",
    "notebook_chains",
    "ledger_pages",
    "derivation_pages",
    "coursework_pages",
    "front_page",
]
exclude_patterns = [
    "plants",
    "coursework/source*",  # holds the solutions
    "coursework/release*",
    "coursework/submitted*",
    "coursework/autograded*",
    "coursework/feedback*",
    "pages/extensions",
    "**.ipynb_checkpoints",
]

nb_execution_mode = "off"
nb_merge_streams = True
nb_render_image_options = {"align": "center"}
nb_code_prompt_show = "Show the code"
nb_code_prompt_hide = "Hide the code"
myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
smartquotes = False  # it would turn the prime of a transpose
suppress_warnings = ["misc.highlighting_failure"]  # of messages that show a lambda

default_role = "py:obj"  # a name in single backquotes leads to its reference
autodoc_member_order = "bysource"
autodoc_typehints = "none"
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True
python_display_short_literal_types = True
viewcode_line_numbers = True

package = importlib.util.find_spec("sphinx-mathjax-offline").submodule_search_locations
mathjax_file = Path(package[0]) / "static" / "mathjax" / "tex-svg-full.js"
mathjax_path = "tex-svg-full.js"  # drawn as curves: no fonts to load
mathjax3_config = {
    "tex": {"tags": "none"},  # numbers are the pages' own, see numbered_equations
    "svg": {"fontCache": "global"},
    "options": {"enableMenu": False},  # it would load more files
}

html_theme = "sphinx_book_theme"
html_title = "luenberger"
html_static_path = ["pages/static", str(mathjax_file)]
html_css_files = ["pages.css"]
html_js_files = ["pages.js"]
html_copy_source = False
html_show_sourcelink = False
html_last_updated_fmt = None
html_theme_options = {
    "show_navbar_depth": 1,
    "navbar_persistent": [],  # the search stands in the sidebar
    "show_toc_level": 2,
    "use_download_button": False,
    "use_fullscreen_button": False,
    "use_source_button": False,
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
    "article_header_start": ["toggle-primary-sidebar.html"],
}


# files that a notebook links to in the repository, and the page that shows each
SHOWN_BY = {"../tests/benchmarks/README.md": "pages/benchmarks.md"}


def link_to_pages(app, docname, content):
    for file, page in SHOWN_BY.items():
        content[0] = content[0].replace(f"]({file})", f"]({page})")


def keep_pictures_inside(app):
    """MyST-NB would leave its folder of pictures beside that of the pages."""
    inside = Path(app.doctreedir) / "jupyter_execute"
    app.env.mystnb_config = app.env.mystnb_config.copy(output_folder=str(inside))


LED_BACK = re.compile(r'(href="[^"#]*)#((?:luenberger|matrixproof)\.[\w.]+)"')


def lead_back(app, pagename, templatename, context, doctree):
    """Viewcode leads back from a module by one prefix; some names have another."""
    if not pagename.startswith("_modules/"):
        return
    known, module = app.env.get_domain("py").objects, pagename.partition("/")[2]

    def right(found):
        name, own = found[2], found[2]
        while name not in known and "." in own:
            own = own.partition(".")[2]
            name = f"{module.replace('/', '.')}.{own}"
            name = name if name in known else f"{module.partition('/')[0]}.{own}"
        return f'{found[1]}#{name}"'

    context["body"] = LED_BACK.sub(right, context["body"])


def setup(app):
    app.connect("html-page-context", lead_back)
    app.connect("source-read", link_to_pages)
    app.connect("builder-inited", keep_pictures_inside, priority=900)


# the index of names is enough; one of modules would be pictures without words
html_domain_indices = False
