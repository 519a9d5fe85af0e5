"""Sphinx builds the site from this folder: ``make docs``, or rosdoc2, which executes this file within its own."""

from __future__ import annotations

import re
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from sphinx.util import logging

project = "lie_rigid_body"
author = "Seed 2b615e39 maintainers"
project_copyright = author

# rosdoc2 has its own theme, and its pages fetch MathJax from the network.
OFFLINE_MATHJAX = "sphinx-mathjax-offline"
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx.ext.napoleon",
    *([OFFLINE_MATHJAX] if find_spec(OFFLINE_MATHJAX) else []),
]
html_theme = "furo"
html_title = "lie_rigid_body"

myst_enable_extensions = ["amsmath", "dollarmath"]
myst_heading_anchors = 3
suppress_warnings = ["myst.header"]  # a page may skip a level of headings

default_role = "autolink"  # `name` in a docstring: a link where there is something to link to
nitpicky = True
# The words of a type, as in "array_like, shape (3,)", and `names` that are not of this package.
nitpick_ignore_regex = [("py:class", ".*"), ("py:obj", ".*")]
autodoc_mock_imports = ["flint", "hypothesis", "pytest"]  # extras, which few build environments have
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the docstrings say types, with shapes and units
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False

LONGEST_PAGE = 2500
PAGES_ABOVE = {"README.md": "readme", "CONTRIBUTING.md": "contributing"}


def with_pages_above(app: Any, page: str, source: list[str]) -> None:
    """Make pages of the folder above pages of the site, and let links to and from them fit."""
    for file, name in PAGES_ABOVE.items():
        # where rosdoc2 builds, the folder above is not ours, and copies of such pages are below
        for above in (Path(app.srcdir).parent / file, Path(app.srcdir) / "standard_docs" / "original" / file):
            if page == name and above.is_file():
                text = above.read_text(encoding="utf-8")
                source[0] = re.sub(r"\]\((?!https?:|#)(docs/)?([^)#]+)", link_from_above, text)
        up = "../" * page.count("/")
        source[0] = source[0].replace(f"]({up}../{file}", f"]({up}{name}.md")


def link_from_above(found: re.Match[str]) -> str:
    """A link of such a page, as this folder sees it; what is no page of the site is a file to load."""
    within, target = found.groups()
    return f"]({target}" if within else f"](../{target}" if target in PAGES_ABOVE else f"](path:../{target}"


def with_bars(_app: object, _what: str, _name: str, _object: object, _options: object, lines: list[str]) -> None:
    """Let |x| in a docstring be the absolute value of x, and no substitution of reStructuredText."""
    lines[:] = [re.sub(r"(``.*?``)|\|", lambda found: found[1] or r"\|", line) for line in lines]


def with_few_words(app: Any, tree: Any, page: str) -> None:
    """Warn of a page from docstrings that is longer than one reads; test_sentences.py counts the words of others."""
    count = len(tree.astext().split())
    if str(app.env.doc2path(page)).endswith(".rst") and count > LONGEST_PAGE:
        logging.getLogger(__name__).warning("%s has %d words (limit %d): split it", page, count, LONGEST_PAGE)


def setup(app: Any) -> None:
    """Tell Sphinx what to do when it has read a page or a docstring."""
    app.connect("source-read", with_pages_above)
    app.connect("autodoc-process-docstring", with_bars)
    app.connect("doctree-resolved", with_few_words)
