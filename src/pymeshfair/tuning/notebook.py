"""The page to tune on within a notebook: a server in a process of its own, and a frame that shows its page."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import weakref
from html import escape

from ..errors import RunError
from ..operating_system import this_system

#: seconds that a server may take to end in order
_PATIENCE = 20.0


class Tuning:
    """A page to tune on, shown by a notebook where the last line of a cell is one: ``Tuning("scan.ply")``.

    Recipes and results are written to the working folder. The server ends with `close`, at the end of a ``with`` block, when
    this object is deleted, or when the notebook's kernel exits.

    Attributes:
        address: of the page; it gives access, and so is secret.

    Args:
        scan: the mesh file.
        recipe: a shipped name or the path of an .mlx file.
        height: of the frame, in pixels.

    Raises:
        RunError: the server did not start; the message tells why.
    """

    def __init__(self, scan: str | os.PathLike[str], recipe: str = "smooth_implicit", *, height: int = 900) -> None:
        command = [sys.executable, "-m", "pymeshfair", "tune", os.fspath(scan), "--recipe", recipe, "--no-browser", "--json"]
        self._height = height
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, **this_system().own_session())
        self.close = weakref.finalize(self, _end, process)  # which Python also calls before it exits
        assert process.stdout is not None
        printed = ""
        for line in process.stdout:
            printed += line
            if line == "}\n":
                break
        document = json.loads(printed or "{}")
        if "address" not in document:
            process.wait()
            raise RunError(str(document.get("error", {}).get("message", "the server ended without a word")))
        self.address = str(document["address"])

    def _repr_html_(self) -> str:
        """The frame that a notebook shows."""
        return f'<iframe src="{escape(self.address)}" width="100%" height="{self._height}" title="pymeshfair tune"></iframe>'

    def __enter__(self) -> Tuning:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _end(process: subprocess.Popen[str]) -> None:
    with process:  # waits for it, and closes its output
        process.terminate()
        try:
            process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
