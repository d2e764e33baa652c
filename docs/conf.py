"""Sphinx: how docs/ becomes the site. `scripts/docs` calls it."""
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parent.parent

project = "subsoil"
author = "the authors of subsoil"
copyright = "the authors of subsoil, Apache-2.0"
release = re.search(r"project\(subsoil VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())[1]
version = release

extensions = ["myst_parser", "sphinx.ext.mathjax"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["**/*.in.md"]
root_doc = "index"

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 4
# Pages name files of the repository, which the site does not hold.
suppress_warnings = ["myst.header"]

# MathJax 2 of Debian (libjs-mathjax), copied into the site by scripts/docs, so that equations need no network.
mathjax_path = "mathjax/MathJax.js?config=TeX-AMS_CHTML"
mathjax2_config = {"CommonHTML": {"scale": 95}, "messageStyle": "none",
                   # MyST puts tex2jax_ignore around a page; formulas are of the class `math`.
                   "tex2jax": {"processClass": "tex2jax_process|mathjax_process|math", "processEscapes": True}}
myst_update_mathjax = False  # it writes the settings of MathJax 3

html_theme = "furo"
html_title = f"subsoil {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sphinx = False
html_copy_source = False
html_theme_options = {"navigation_with_keys": True}
pygments_style = "friendly"
highlight_language = "text"
