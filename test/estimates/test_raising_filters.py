"""What is said of a filter that raises: the line of the user's own code on the way of the exception."""

from __future__ import annotations

import importlib
import shlex

import pytest

from lie_rigid_body.estimates.estimators import told
from lie_rigid_body.foundation.errors import FilterError, InputError
from lie_rigid_body.runs import Estimate


def test_place_of_an_error_is_a_line_of_the_user_or_none():
    def failed(function, *arguments):
        try:
            function(*arguments)
        except Exception as error:
            return told(error)

    assert " test_raising_filters.py line " in failed(_raise, "of the package")
    assert " test_raising_filters.py line " in failed(Estimate, "nothing")
    assert told(FilterError("of the package")) == "of the package"
    with pytest.raises(ValueError) as caught:
        shlex.split('"')
    assert ".py" not in told(caught.value.with_traceback(caught.tb.tb_next))


def test_place_of_an_error_in_an_installed_filter_is_its_first_line(tmp_path, monkeypatch):
    folder = tmp_path / "site-packages"
    folder.mkdir()
    (folder / "installed_filter.py").write_text("import json\n\ndef estimate(run):\n    return json.loads(run)\n")
    monkeypatch.syspath_prepend(folder)
    estimate = importlib.import_module("installed_filter").estimate
    with pytest.raises(ValueError) as caught:
        estimate("no JSON")
    assert " installed_filter.py line 4" in told(caught.value.with_traceback(caught.tb.tb_next))


def _raise(words):
    raise InputError(words)
