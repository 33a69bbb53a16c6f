"""The configuration with which Sphinx builds the site from these pages: `make docs`."""

import re
import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS / "extensions"))

project = "axode"
copyright = "the axode authors"
version = release = re.search(r"^project\(axode VERSION (\S+)", (DOCS.parent / "CMakeLists.txt").read_text(encoding="utf-8"),
                              re.MULTILINE)[1]

extensions = ["myst_parser", "sphinx.ext.autodoc", "diagrams", "docstrings", "function_links", "functions", "ledger", "source_pages"]
exclude_patterns = ["extensions"]

myst_heading_anchors = 4
myst_fence_as_directive = ["mermaid"]

autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
add_module_names = False
python_maximum_signature_line_length = 100

html_theme = "furo"
html_title = "axode"
html_static_path = ["site.css"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_search_summary = False  # it would load pages, which browsers refuse where the site is opened as files
highlight_language = "text"
pygments_style = "friendly"
pygments_dark_style = "monokai"
