"""How Sphinx builds the documentation: ``scripts/docs``."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

from dolfingrip.version import __version__

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
MADE = ROOT / "out" / "docs"
sys.path.insert(0, str(HERE / "_ext"))

project = "dolfingrip"
author = "The dolfingrip developers"
project_copyright = f"{author}, GPL-3.0-or-later"
version = release = __version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx.ext.napoleon",
    "sphinx_autodoc_typehints",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinxcontrib.bibtex",
    "first_use",
    "generated",
    "tutorials",
]
exclude_patterns = ["_ext", "pictures"]
bibtex_bibfiles = ["references.bib"]
bibtex_reference_style = "author_year"
bibtex_default_style = "unsrt"

# -- Markdown and tutorials --------------------------------------------------------------------

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 3
suppress_warnings = [
    "sphinx_autodoc_typehints.forward_reference",  # of pydantic's own annotations
]
nb_execution_mode = os.environ.get("DOLFINGRIP_DOCS_EXECUTION", "cache")
nb_execution_cache_path = str(MADE / "executed")
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_merge_streams = True

# Tutorials run in the checkout, as their reader does, and write to out/.
IPYTHON = MADE / "ipython"
STARTUP = IPYTHON / "profile_default" / "startup"
STARTUP.mkdir(parents=True, exist_ok=True)
(STARTUP / "checkout.py").write_text(
    f"CHECKOUT = {str(ROOT)!r}\n" + (HERE / "_ext" / "kernel.py").read_text(encoding="utf-8"),
    encoding="utf-8",
)
os.environ.update(IPYTHONDIR=str(IPYTHON), COLUMNS="84")

# -- Python ------------------------------------------------------------------------------------

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # sphinx_autodoc_typehints puts them into the lists of arguments
always_use_bars_union = True
napoleon_use_ivar = True

# -- pages -------------------------------------------------------------------------------------

smartquotes_action = "qe"  # no dashes: --resolution is an option
html_title = "dolfingrip"
html_theme = "pydata_sphinx_theme"
html_theme_options = {
    "footer_start": ["copyright"],
    "footer_end": [],
    "header_links_before_dropdown": 4,
    "navbar_end": ["theme-switcher"],
    "navigation_with_keys": False,
    "secondary_sidebar_items": ["page-toc"],
    "show_prev_next": True,
    "show_toc_level": 2,
}
html_context = {"default_mode": "auto"}
html_show_sourcelink = False
html_static_path = ["_static", str(MADE / "static")]
html_css_files = ["dolfingrip.css"]
copybutton_exclude = ".linenos, .gp, .go"

# MathJax is shipped: the pages make no request. Its fonts are in this one file.
MATHJAX = ROOT / "web" / "node_modules" / "mathjax"
SHIPPED = MADE / "static" / "mathjax"
SHIPPED.mkdir(parents=True, exist_ok=True)
for file in ("es5/tex-svg-full.js", "LICENSE"):
    shutil.copy(MATHJAX / file, SHIPPED)
mathjax_path = "mathjax/tex-svg-full.js"
mathjax3_config = {
    "options": {"enableMenu": False},
    "svg": {"mtextInheritFont": True},
    "tex": {"inlineMath": [["\\(", "\\)"]], "displayMath": [["\\[", "\\]"]]},
}
