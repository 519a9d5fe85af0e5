"""Sphinx builds the site from this folder: ``make docs``, or rosdoc2, which executes this file within its own."""

from __future__ import annotations

import re
from importlib.util import find_spec
from pathlib import Path
from typing import Any

project = "lie_rigid_body"
author = "Seed 2b615e39 maintainers"
project_copyright = author

# rosdoc2 has neither of the two: it keeps its own theme, and its pages fetch MathJax from the network.
OFFLINE_MATHJAX = "sphinx-mathjax-offline"
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx.ext.napoleon",
    *([OFFLINE_MATHJAX] if find_spec(OFFLINE_MATHJAX) else []),
]
rosdoc2_settings = {"allow_other_extensions": True, "override_theme": False}
html_theme = "furo"
html_title = "lie_rigid_body"

myst_enable_extensions = ["amsmath", "dollarmath"]
myst_heading_anchors = 3
suppress_warnings = ["myst.header"]  # a page may skip a level of headings

default_role = "autolink"  # `name` in a docstring: a link where there is something to link to
nitpicky = True
# The words of a type, as in "array_like, shape (3,)", and `names` that are not of this package.
nitpick_ignore_regex = [("py:class", ".*"), ("py:obj", ".*")]
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the docstrings say types, with shapes and units
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False

README_LINKS = {"](docs/": "](", "](config/": "](../config/", "](LICENSE": "](../LICENSE"}


def with_readme(app: Any, page: str, source: list[str]) -> None:
    """Make the README of the folder above a page of the site, and let other pages link to it there."""
    readme = Path(app.srcdir).parent / "README.md"
    if page != "readme":
        source[0] = source[0].replace("](../README.md", "](readme.md")
    elif readme.is_file():
        source[0] = readme.read_text(encoding="utf-8")
        for above, here in README_LINKS.items():
            source[0] = source[0].replace(above, here)


def with_bars(_app: object, _what: str, _name: str, _object: object, _options: object, lines: list[str]) -> None:
    """Let |x| in a docstring be the absolute value of x, and no substitution of reStructuredText."""
    lines[:] = [re.sub(r"(``.*?``)|\|", lambda found: found[1] or r"\|", line) for line in lines]


def setup(app: Any) -> None:
    """Tell Sphinx what to do when it has read a page or a docstring."""
    app.connect("source-read", with_readme)
    app.connect("autodoc-process-docstring", with_bars)
