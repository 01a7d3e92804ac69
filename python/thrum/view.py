"""The page of `thrum view`: bodies that move as they are pulled at, in a browser or a cell of a notebook.

SPDX-License-Identifier: Apache-2.0
"""

from __future__ import annotations

import html
import os
import shutil
import tempfile
from typing import Any, Union

from . import _program
from .model import Model

Shown = Union[Model, _program.Run, str, "os.PathLike[str]"]


class View:
    """A page that shows models or a scene; it needs nothing but a browser. A notebook shows it as it is."""

    def __init__(self, page: str, height: int) -> None:
        self.page = page
        self.height = height

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the page as a file for a browser."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.page)

    def __repr__(self) -> str:
        return f"<thrum.View {len(self.page)} characters; save(path) writes it as a page>"

    def _repr_html_(self) -> str:
        """The page within a page: what notebooks call."""
        return (f'<iframe srcdoc="{html.escape(self.page, quote=True)}" width="100%" height="{self.height}" '
                'style="border: 0" title="Thrum: pull at the body" allow="fullscreen"></iframe>')


def view(*what: Shown, height: int = 480, **options: Any) -> View:
    """Makes the page that `thrum view` shows, with the program, which must have been built with its viewer.

    what: models, model files, names of models that come with Thrum, one scene file, or one `Run`. height: of the cell, in pixels.
    options: those of the program with underscores, such as surface="skin.obj". ProgramFailed with the program's message.
    """
    folder = tempfile.mkdtemp(prefix="thrum-")
    try:
        names = []
        for number, item in enumerate(what):
            if isinstance(item, Model):
                names.append(os.path.join(folder, f"model{number or ''}.npz"))
                item.save(names[-1])
            elif isinstance(item, _program.Run):
                names.append(item.folder)
            else:
                names.append(os.fspath(item))
        page = os.path.join(folder, "view.html")
        _program.run_program("view", *names, output=page, **options)
        with open(page, encoding="utf-8") as file:
            return View(file.read(), height)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
