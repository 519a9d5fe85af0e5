"""The notebook of the examples, run cell by cell: ``python docs/run_notebook.py`` writes its outputs anew.

Jupyter gives the same outputs; this needs nothing that the package does not need.
"""

from __future__ import annotations

import ast
import base64
import json
import sys
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any, Final

NOTEBOOK: Final = Path(__file__).resolve().parent.parent / "examples" / "first_filter.ipynb"


def outputs(source: str, number: int, space: dict[str, Any]) -> list[dict[str, Any]]:
    """Run a cell in a name space, and return what it printed and what its last line shows."""
    *statements, last = ast.parse(source).body
    value, printed = None, StringIO()
    if not isinstance(last, ast.Expr):
        statements.append(last)
    with redirect_stdout(printed):
        exec(compile(ast.Module(statements, []), "cell", "exec"), space)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), "cell", "eval"), space)
    found: list[dict[str, Any]] = []
    if printed.getvalue():
        found.append({"name": "stdout", "output_type": "stream", "text": lines(printed.getvalue())})
    if value is not None:
        result = {"data": data(value), "execution_count": number, "metadata": {}, "output_type": "execute_result"}
        found.append(result)
    return found


def data(value: Any) -> dict[str, Any]:
    """What a notebook shows of a value, by its kind."""
    kinds: dict[str, Any] = {"text/plain": lines(repr(value))}
    if text := getattr(value, "_repr_html_", lambda: None)():
        kinds["text/html"] = lines(text)
    if picture := getattr(value, "_repr_png_", lambda: None)():
        kinds["image/png"] = base64.b64encode(picture).decode()
    return kinds


def lines(text: str) -> list[str]:
    """Lines of a text, each with its end, as notebooks keep them."""
    return text.splitlines(keepends=True)


def write(path: Path) -> None:
    """Run all cells in one name space, and write the notebook with their outputs."""
    content = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    space = vars(sys.modules["__main__"])  # as in Jupyter, where workers find the functions of cells
    code = (cell for cell in content["cells"] if cell["cell_type"] == "code")
    for number, cell in enumerate(code, 1):
        cell.update(execution_count=number, outputs=outputs("".join(cell["source"]), number, space))
    path.write_text(json.dumps(content, indent=1, ensure_ascii=False, sort_keys=True) + "\n", encoding="utf-8")


if __name__ == "__main__":
    from run_notebook import write  # the same, out of reach of the names of cells

    write(Path(sys.argv[1]) if len(sys.argv) > 1 else NOTEBOOK)
