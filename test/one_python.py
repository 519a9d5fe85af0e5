"""What another Python would be asked, done in this process: each takes half a second of a processor to start."""

from __future__ import annotations

import pickle
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from lie_rigid_body.foundation.errors import FilterError, LieRigidBodyError, describe
from lie_rigid_body.system.interpreters import Interpreter


@contextmanager
def asked_here(folder: Path) -> Iterator[None]:
    """Context for what is about neither that process nor its end. Questions and replies are pickled as ever.

    Modules below a folder, such as estimators, are forgotten at its end: another test has others of their names.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Interpreter, "ask", _ask)
        patch.setattr(sys, "path", [*sys.path])
        yield
    files = {name: str(getattr(module, "__file__", "")) for name, module in sys.modules.items()}
    for name in [name for name, file in files.items() if file.startswith(str(folder))]:
        del sys.modules[name]


def _ask(_: Interpreter, question: Callable[[], object], limit_s: float) -> object:
    try:
        return pickle.loads(pickle.dumps(pickle.loads(pickle.dumps(question))()))
    except LieRigidBodyError:
        raise
    except Exception as error:
        raise FilterError(describe(error)) from None
