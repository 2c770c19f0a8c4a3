"""How Sphinx makes a site of these pages: `make docs`."""

import sys
from pathlib import Path

import hillobs

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_extensions"))

project = "hillobs"
author = "the hillobs contributors"
copyright = "the hillobs contributors, MIT licence"
version = release = hillobs.__version__

extensions = [
    "myst_nb",  # pages are Markdown, tutorials are run
    "sphinx.ext.autodoc",  # the reference, from docstrings
    "sphinx_click",  # the command line, from click
    "sphinx_design",  # cards of the front page
    "sphinx_copybutton",
    "docstrings",  # ours are plain text with code in backticks
    "sources",  # links to the code
    "labels",  # links to the equations
]
exclude_patterns = ["_build", "_page", "_site"]
# the page that runs is part of the site as it is
html_extra_path = ["../_page"]

myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]

nb_execution_mode = "cache"
nb_execution_cache_path = str(HERE.parent / "_build" / "executed")
nb_execution_raise_on_error = True
nb_execution_show_tb = True
nb_execution_timeout = 300  # seconds a cell
nb_render_markdown_format = "gfm"  # tables too

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
python_use_unqualified_type_names = True

html_theme = "pydata_sphinx_theme"
html_title = "hillobs"
html_context = {"default_mode": "auto"}
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_theme_options = {
    "navigation_with_keys": False,
    "navbar_align": "left",
    "header_links_before_dropdown": 8,
    "show_toc_level": 2,
    "footer_start": ["copyright"],
    "footer_end": [],
}
