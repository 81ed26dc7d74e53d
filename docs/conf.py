"""The site: `sphinx-build -W --keep-going -b html docs out/docs`, without the network."""

from __future__ import annotations

import sys
from pathlib import Path

import gemrender

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_ext"))

project = "gemrender"
author = "The gemrender authors"
copyright = author  # noqa: A001 (Sphinx's name)
version = release = gemrender.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
    "mitsuba_manuals",
    "generated",
    "offline",
]
exclude_patterns = ["_ext", "_static"]
nitpicky = False
default_role = "py:obj"
smartquotes = False  # a command in the text stays one: two hyphens, straight quotes

myst_enable_extensions = ["colon_fence", "attrs_block"]
myst_heading_anchors = 4

# Notebooks are text, and are run when the site is built; a cell that fails fails the build.
nb_execution_mode = "force"
nb_execution_timeout = 600
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_show_tb = True
nb_merge_streams = True
nb_ipywidgets_js = {}

autodoc_typehints = "none"  # docstrings have types, units and ranges
autodoc_use_type_comments = False
autodoc_member_order = "bysource"
autoclass_content = "class"
add_module_names = False
python_use_unqualified_type_names = True
maximum_signature_line_length = 80
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False

html_theme = "furo"
html_title = f"gemrender {version}"
html_static_path = ["_static"]
html_css_files = ["gemrender.css"]
html_math_renderer = "mathml"
html_copy_source = False
html_show_sphinx = False
html_theme_options = {"sidebar_hide_name": False, "top_of_page_buttons": []}
copybutton_prompt_text = r"\$ |>>> "
copybutton_prompt_is_regexp = True
