"""Sphinx reads this. Build with ./impedraw docs (setup/docs.sh)."""

import os
import re
from pathlib import Path

here = Path(__file__).parent
build = Path(os.environ.get("IMPEDRAW_DOCS_BUILD", here.parent / "build" / "docs"))

project = "impedraw"
release = version = re.search(r"project\(impedraw VERSION ([\d.]+)", (here.parent / "CMakeLists.txt").read_text())[1]
author = "the impedraw authors"
copyright = "the impedraw authors"  # noqa: A001, Sphinx's own name

extensions = ["myst_parser", "breathe", "sphinxcontrib.katex"]
exclude_patterns = ["_build", "doxygen_filter.py"]
root_doc = "index"

# Markdown, with formulas between dollar signs.
myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
myst_dmath_double_inline = True

# The library reference, from what Doxygen found in the public headers.
breathe_projects = {"impedraw": str(build / "doxygen" / "xml")}
breathe_default_project = "impedraw"
release = version = re.search(r"project\(impedraw VERSION ([\d.]+)", (here.parent / "CMakeLists.txt").read_text())[1]
breathe_domain_by_extension = {"h": "cpp"}
breathe_default_members = ("members",)
primary_domain = "cpp"
highlight_language = "text"

# References that nothing here can resolve: other libraries' types, and what is private.
nitpick_ignore_regex = [
    ("cpp:identifier", r"(Eigen|std)(::.*)?"),
    ("cpp:identifier", r"(Vector6|Matrix6)::.*"),
    ("cpp:identifier", r"Canvas|FlatChart|JointDrive|Mujoco|PathSpline|PosedBody"),
    ("cpp:identifier", r"kMostNeighbours|kTorqueTerms"),
]

html_theme = "furo"
html_title = f"impedraw {release}"
html_static_path = ["static", str(build / "static")]
html_css_files = ["site.css"]
html_js_files = ["versions.js"]
html_copy_source = False
html_show_copyright = False
html_theme_options = {"navigation_with_keys": True}

# Formulas are rendered in the browser, by files that the site brings along.
katex_css_path = "katex/katex.min.css"
katex_options = "throwOnError: true, strict: false"
