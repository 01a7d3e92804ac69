"""Settings of Sphinx for the site (docs/site/build.py copies this beside the pages). SPDX-License-Identifier: Apache-2.0"""
import json
import os

with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "site.json"), encoding="utf-8") as file:
    site = json.load(file)

project = "Thrum"
author = "the Thrum maintainers"
copyright = "the Thrum maintainers, Apache-2.0"
version = release = site["version"]

extensions = ["myst_parser", "breathe", "sphinx.ext.autodoc"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
# quotes and dashes stay as they are written: "--scale" in a sentence is an option, and may be copied
smartquotes = False
# anchors of headings as the pages link to them
myst_heading_anchors = 4
nitpicky = False
suppress_warnings = ["myst.header"]

breathe_projects = {"thrum": site["doxygen"]}
breathe_default_project = "thrum"
breathe_domain_by_extension = {"h": "c"}
autodoc_member_order = "bysource"
autodoc_typehints = "signature"

html_theme = "sphinx_rtd_theme"
html_theme_options = {"navigation_depth": 2, "collapse_navigation": True}
html_title = f"Thrum {version}"
html_static_path = ["_static"]
html_css_files = ["thrum.css"]
html_extra_path = ["extra"]
html_copy_source = False
html_show_sphinx = False
highlight_language = "none"
