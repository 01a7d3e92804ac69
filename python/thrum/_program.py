"""The program thrum, for what the run time does not do: precompute, runs with records, statics, the trade-off.

SPDX-License-Identifier: Apache-2.0
"""

from __future__ import annotations

import csv
import json
import os
import re
import shutil
import subprocess
import tempfile
import warnings
from typing import Any

import numpy as np
import numpy.typing as npt

from ._errors import ProgramFailed
from ._native import real_numbers

# done, and done but flagged
_DONE = (0, 3)

# how the program begins a line that warns, and what stands around one that says why it refuses
_WARNING = "thrum: warning: "
_REFUSAL = re.compile(r"^thrum(?: [a-z]+)?: |\s*\(try: [^()]*\)$", re.MULTILINE)

# an option in a message, which is a keyword here; --help has none
_OPTION = re.compile(r"(?<![\w-])--(?!help\b)([a-z][a-z0-9]*(?:-[a-z0-9]+)*)")


def program() -> str:
    """Path of the program: THRUM_PROGRAM, else `thrum` in PATH. ProgramFailed says what to do without one."""
    found = os.environ.get("THRUM_PROGRAM") or shutil.which("thrum")
    if not found:
        raise ProgramFailed(
            "the program thrum is not installed, and this call needs it: install the Debian package thrum, unpack the "
            "tarball for other distributions, or build it from the sources (cmake --preset release, cmake --build "
            "build/release, cmake --install build/release); set THRUM_PROGRAM where it is not in PATH", 127)

    # what THRUM_PROGRAM names may lie elsewhere, as a relative path does after os.chdir
    if not shutil.which(found):
        raise ProgramFailed(f"THRUM_PROGRAM: {found} is no program that can be run; name one that is built", 127)
    return found


def arguments(options: dict[str, Any]) -> list[str]:
    """Options as the command line has them: fix="x<0.1" is --fix x<0.1, a list repeats, True stands alone."""
    words = []
    for name, value in options.items():
        option = "--" + name.replace("_", "-")
        for item in value if isinstance(value, (list, tuple)) else [value]:
            if item is True:
                words.append(option)
            elif item is not None and item is not False:
                # joined by =, so that a value may begin with -
                words.append(f"{option}={os.fspath(item) if isinstance(item, os.PathLike) else item}")
    return words


def _message(text: str, mesh: str | None) -> str:
    """What the program says, in Python's names: dt in place of --dt, `mesh` in place of the file made of it."""
    if mesh is not None:
        text = text.replace(mesh, "mesh").replace(os.path.basename(mesh), "mesh")
    return _OPTION.sub(lambda option: option[1].replace("-", "_"), text)


def run_program(command: str, *words: str, _mesh: str | None = None, **options: Any) -> dict[str, Any]:
    """Runs `thrum COMMAND WORDS OPTIONS --json` and returns the object that it prints.

    A run that is flagged (exit code 3) returns too: look at its "status". What the program warns of is a
    RuntimeWarning. ProgramFailed with the program's own line for every other exit code. Messages name options as the
    keywords that they are here, and the temporary file _mesh as "mesh".
    """
    # a file whose name begins with - is no option
    files = [os.path.join(os.curdir, word) if word.startswith("-") else word for word in words]
    line = [program(), command, *files, *arguments(options), "--json", "-q"]
    done = subprocess.run(line, capture_output=True, encoding="utf-8", errors="replace", check=False)
    if done.returncode not in _DONE:
        text = _REFUSAL.sub("", done.stderr.strip()) or f"thrum {command} ended with the exit code {done.returncode}"
        raise ProgramFailed(_message(text, _mesh), done.returncode)

    # nobody sees the program's standard error, and its warnings say where the result is wrong
    for text in done.stderr.splitlines():
        if text.startswith(_WARNING):
            warnings.warn(_message(text[len(_WARNING):], _mesh), RuntimeWarning, stacklevel=3)
    return dict(json.loads(done.stdout))


def precompute(mesh: Any, output: str | os.PathLike[str], **options: Any) -> dict[str, Any]:
    """Makes the model file `output` of a mesh (see `Model.precompute`) and returns the program's report."""
    if isinstance(mesh, (str, os.PathLike)):
        return run_program("precompute", os.fspath(mesh), output=output, **options)
    with tempfile.TemporaryDirectory(prefix="thrum-") as folder:
        # a name that no message has by chance
        path = os.path.join(folder, "given-mesh.msh")
        write_mesh(mesh, path)
        return run_program("precompute", path, _mesh=path, output=output, **options)


def write_mesh(mesh: Any, path: str) -> None:
    """Writes a pair (vertices, tets), or the tetrahedra of a meshio mesh, as a Gmsh file."""
    if hasattr(mesh, "points") and hasattr(mesh, "cells"):
        vertices = mesh.points
        blocks = [cells.data for cells in mesh.cells if cells.type == "tetra"]
        if not blocks:
            kinds = ", ".join(sorted({cells.type for cells in mesh.cells})) or "no cells"
            raise ValueError(f"mesh: it has no cells of the type tetra, but {kinds}")
        tets = np.concatenate(blocks)
    else:
        try:
            vertices, tets = (np.asarray(part) for part in mesh)
        except (TypeError, ValueError):
            raise TypeError("mesh: a file, a name, a meshio mesh or a pair (vertices, tets) is needed") from None
    vertices = real_numbers(vertices, "mesh")
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise ValueError("mesh: its vertices are not n x 3")
    if tets.ndim != 2 or tets.shape[1] != 4 or not np.issubdtype(tets.dtype, np.integer):
        raise ValueError("mesh: its tets are not m x 4 whole numbers")
    if tets.size and (tets.min() < 0 or tets.max() >= len(vertices)):
        raise ValueError(f"mesh: its tets name vertices beyond 0 to {len(vertices) - 1}")

    with open(path, "w", encoding="ascii") as file:
        file.write(f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{len(vertices)}\n")
        file.writelines(f"{number} {x!r} {y!r} {z!r}\n" for number, (x, y, z) in enumerate(vertices.tolist(), 1))
        file.write(f"$EndNodes\n$Elements\n{len(tets)}\n")
        file.writelines(f"{number} 4 2 1 1 {a} {b} {c} {d}\n"
                        for number, (a, b, c, d) in enumerate((tets + 1).tolist(), 1))
        file.write("$EndElements\n")


class Run:
    """What `thrum simulate` recorded: a folder and its files.

    report: the program's report (run.json). q: rows x r coordinates. energy: its columns by name.
    """

    def __init__(self, folder: str | os.PathLike[str], report: dict[str, Any] | None = None) -> None:
        self.folder = os.fspath(folder)
        if report is None:
            with open(os.path.join(self.folder, "run.json"), encoding="utf-8") as file:
                report = json.load(file)
        self.report: dict[str, Any] = dict(report or {})

    def array(self, name: str) -> npt.NDArray[Any]:
        """An array that the run recorded, such as "q" or "end"; FileNotFoundError where it recorded none."""
        found: npt.NDArray[Any] = np.load(os.path.join(self.folder, f"{name}.npy"), allow_pickle=False)
        return found

    @property
    def q(self) -> npt.NDArray[Any]:
        """Coordinates, one row a record."""
        return self.array("q")

    @property
    def energy(self) -> dict[str, npt.NDArray[np.float64]]:
        """energy.csv by columns: time_s, kinetic_j and so on."""
        with open(os.path.join(self.folder, "energy.csv"), encoding="utf-8", newline="") as file:
            rows = list(csv.reader(file))
        values = np.array(rows[1:], dtype=np.float64).reshape(len(rows) - 1, len(rows[0]))
        return {name: values[:, column] for column, name in enumerate(rows[0])}


def simulate(model: str | os.PathLike[str], output: str | os.PathLike[str], **options: Any) -> Run:
    """Runs `thrum simulate` on a model file, a name or a scene file, and returns what it recorded.

    options: those of the program with underscores, such as time=3, load="impulse:0,0,-40@tip", full=True.
    """
    return Run(output, run_program("simulate", os.fspath(model), output=output, **options))


def static(model: str | os.PathLike[str], **options: Any) -> dict[str, Any]:
    """Runs `thrum static` and returns its report; full=True solves the whole mesh."""
    return run_program("static", os.fspath(model), **options)


def tradeoff(model: str | os.PathLike[str], output: str | os.PathLike[str], **options: Any) -> dict[str, Any]:
    """Runs `thrum tradeoff`: what speed and accuracy cost each other, such as error="5%"; returns its report."""
    return run_program("tradeoff", os.fspath(model), output=output, **options)
