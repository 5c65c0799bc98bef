# SPDX-License-Identifier: BSD-3-Clause
"""Settings of Sphinx; build.py puts the pages together and calls it."""

import functools
import os
import sys
from pathlib import Path

from pygments.lexers.c_cpp import CLexer
from sphinx.highlighting import lexers
from sphinx.search.en import SearchEnglish

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE))

project = "Signorom"
copyright = "Signorom developers, BSD 3-Clause"
extensions = ["myst_parser", "breathe", "sphinx.ext.autodoc", "fortran_pages"]
html_theme = "furo"
html_title = "Signorom"
html_show_sphinx = False
html_show_sourcelink = False
html_copy_source = False
html_static_path = [str(HERE / "static")]
html_css_files = ["signorom.css"]
html_js_files = ["signorom.js"]
highlight_language = "none"  # most blocks are commands, formulas and pieces of decks
lexers["geo"] = CLexer()  # scripts of gmsh
# Sphinx remembers the stems of words for one page; most words stand on hundreds of them
SearchEnglish.stem = functools.cache(SearchEnglish.stem)
default_role = "literal"  # `word` in a Python docstring
myst_heading_anchors = 4
exclude_patterns = ["doxygen"]

fortran_root = str(ROOT / "src")

breathe_projects = {"signorom": os.environ["SIGNOROM_DOC_DOXYGEN"]}
breathe_default_project = "signorom"
breathe_domain_by_extension = {"h": "c"}

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
python_use_unqualified_type_names = True
add_module_names = False
