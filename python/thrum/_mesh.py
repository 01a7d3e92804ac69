"""Meshes and surfaces in arrays, and the files that hand them to the program.

SPDX-License-Identifier: Apache-2.0
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ._native import real_numbers

# nodes 9 and 10 of a tetrahedron lie on edges 2-4 and 3-4, in Gmsh's files the other way round
_TO_GMSH = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]
_GMSH_TYPE = {4: 4, 10: 11}  # of tetrahedra, by their nodes
_GMSH_POINT = 15


@dataclass(repr=False)
class Mesh:
    """A tetrahedral mesh in arrays, for `Model.precompute`, `check` and all that take a mesh.

    vertices: n x 3 [m]. tets: m x 4, or m x 10 with nodes in the middle of the edges 0-1, 1-2, 0-2, 0-3, 1-3, 2-3, as of
    VTK, Abaqus and meshio; 0-based. groups: named vertices, 0-based numbers or a mask of n, which `fix="NAME"`, loads and
    `Model.group` take. regions: m whole numbers or names, which `material="NAME:E,NU,RHO"` takes.
    """

    vertices: Any
    tets: Any
    groups: Mapping[str, Any] | None = None
    regions: Any = None

    def __post_init__(self) -> None:
        self.vertices = real_numbers(self.vertices, "mesh")
        self.tets = np.asarray(self.tets)
        if self.vertices.ndim != 2 or self.vertices.shape[1] != 3:
            raise ValueError("mesh: its vertices are not n x 3")
        if self.tets.ndim != 2 or self.tets.shape[1] not in _GMSH_TYPE or not np.issubdtype(self.tets.dtype, np.integer):
            raise ValueError("mesh: its tets are not m x 4 or m x 10 whole numbers")
        count = len(self.vertices)
        if self.tets.size and (self.tets.min() < 0 or self.tets.max() >= count):
            raise ValueError(f"mesh: its tets name vertices beyond 0 to {count - 1}")
        self.groups = {_name(name, "groups"): chosen_vertices(chosen, count, f"groups[{name!r}]")
                       for name, chosen in (self.groups or {}).items()}
        if self.regions is not None:
            self.regions = np.asarray(self.regions)
            if self.regions.shape != (len(self.tets),) or self.regions.dtype.kind not in "iuU":
                raise ValueError(f"regions: a whole number or a name for each of {len(self.tets)} tets is needed")

    def __repr__(self) -> str:
        regions = "" if self.regions is None else f" regions={len(np.unique(self.regions))}"
        groups = f" groups={sorted(self.groups)}" if self.groups else ""
        return f"<thrum.Mesh vertices={len(self.vertices)} tets={len(self.tets)} nodes={self.tets.shape[1]}{regions}{groups}>"


def _name(name: Any, what: str) -> str:
    if not isinstance(name, str) or not name or set(name) & set('"\n\r'):
        raise ValueError(f"{what}: {name!r} is no name of one line without quotes")
    return name


def chosen_vertices(value: Any, count: int, name: str) -> npt.NDArray[np.int64]:
    """0-based vertices of a mask of `count`, or of numbers below it."""
    chosen = np.asarray(value)
    if chosen.dtype == bool:
        if chosen.shape != (count,):
            raise ValueError(f"{name}: a mask has {count} entries, one a vertex, not {chosen.shape}")
        return np.flatnonzero(chosen)
    if chosen.ndim != 1 or not np.issubdtype(chosen.dtype, np.integer):
        raise ValueError(f"{name}: a mask, or a list of whole numbers, is needed")
    if chosen.size and (chosen.min() < 0 or chosen.max() >= count):
        raise ValueError(f"{name}: {int(chosen.min())} to {int(chosen.max())} are not within 0 to {count - 1}")
    return chosen.astype(np.int64)


def as_mesh(given: Any) -> Mesh:
    """A mesh, a pair (vertices, tets), or the tetrahedra of a meshio mesh with its named sets."""
    if isinstance(given, Mesh):
        return given
    if hasattr(given, "points") and hasattr(given, "cells"):
        return _of_meshio(given)
    try:
        vertices, tets = given
    except (TypeError, ValueError):
        raise TypeError("mesh: a file, a name, a Model, a Mesh, a meshio mesh or a pair (vertices, tets) is needed") from None
    return Mesh(vertices, tets)


def _of_meshio(mesh: Any) -> Mesh:
    """Sets of points are groups, and so are the corners of named cells of points, lines and triangles; the names of
    tetrahedra, "gmsh:physical" in `cell_data` and `field_data`, are regions."""
    kinds = {cells.type for cells in mesh.cells} & {"tetra", "tetra10"}
    if len(kinds) != 1:
        found = ", ".join(sorted({cells.type for cells in mesh.cells})) or "no cells"
        raise ValueError(f"mesh: cells of one type, tetra or tetra10, are needed; it has: {found}")
    blocks = [number for number, cells in enumerate(mesh.cells) if cells.type in kinds]
    tets = np.concatenate([mesh.cells[number].data for number in blocks])
    groups = dict(getattr(mesh, "point_sets", None) or {})

    # tags of cells, and the names of those that have one
    tags = (getattr(mesh, "cell_data", None) or {}).get("gmsh:physical")
    if tags is None:
        return Mesh(mesh.points, tets, groups)
    regions = np.concatenate([np.asarray(tags[number]) for number in blocks]).astype(np.int64)
    named = regions.astype(str).astype(object)
    for name, (tag, dimension) in (getattr(mesh, "field_data", None) or {}).items():
        if dimension == 3:
            named[regions == tag] = name
            continue
        parts = [cells.data[np.asarray(tags[number]) == tag] for number, cells in enumerate(mesh.cells)
                 if cells.data.ndim == 2 and _dimension(cells.type) == dimension]
        if parts:
            groups.setdefault(name, np.unique(np.concatenate([part.ravel() for part in parts])))
    return Mesh(mesh.points, tets, groups, named.astype(str))


def _dimension(kind: str) -> int:
    return {"vertex": 0, "line": 1, "line3": 1}.get(kind, 2 if kind.startswith(("triangle", "quad")) else 3)


def write_mesh(mesh: Mesh, path: str) -> None:
    """Writes a mesh as a Gmsh file: groups are physical points, regions physical volumes."""
    nodes = mesh.tets.shape[1]
    names, tags = np.unique(np.zeros(len(mesh.tets), int) if mesh.regions is None else mesh.regions, return_inverse=True)
    groups = list((mesh.groups or {}).items())
    with open(path, "w", encoding="utf-8") as file:
        file.write("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n")
        if groups or mesh.regions is not None:
            lines = [f'0 {tag} "{name}"' for tag, (name, _) in enumerate(groups, 1)]
            if mesh.regions is not None:
                lines += [f'3 {tag} "{_name(str(name), "regions")}"' for tag, name in enumerate(names, 1)]
            file.write(f"$PhysicalNames\n{len(lines)}\n" + "\n".join(lines) + "\n$EndPhysicalNames\n")
        file.write(f"$Nodes\n{len(mesh.vertices)}\n")
        file.writelines(f"{number} {x!r} {y!r} {z!r}\n" for number, (x, y, z) in enumerate(mesh.vertices.tolist(), 1))

        # tetrahedra first, so that the numbers of messages are those of the array
        file.write(f"$EndNodes\n$Elements\n{len(mesh.tets) + sum(len(chosen) for _, chosen in groups)}\n")
        corners = (mesh.tets + 1)[:, _TO_GMSH[:nodes]].tolist()
        number = 0
        for tag, row in zip((tags.ravel() + 1).tolist(), corners):
            number += 1
            file.write(f"{number} {_GMSH_TYPE[nodes]} 2 {tag} {tag} {' '.join(map(str, row))}\n")
        for tag, (_, chosen) in enumerate(groups, 1):
            for vertex in (chosen + 1).tolist():
                number += 1
                file.write(f"{number} {_GMSH_POINT} 2 {tag} {tag} {vertex}\n")
        file.write("$EndElements\n")


def write_surface(surface: Any, path: str) -> None:
    """Writes a pair (vertices, triangles) as an .obj file."""
    try:
        vertices, triangles = surface
    except (TypeError, ValueError):
        raise TypeError("surface: a file or a pair (vertices, triangles) is needed") from None
    points, corners = real_numbers(vertices, "surface"), np.asarray(triangles)
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError("surface: its vertices are not n x 3")
    if corners.ndim != 2 or corners.shape[1] != 3 or not np.issubdtype(corners.dtype, np.integer):
        raise ValueError("surface: its triangles are not m x 3 whole numbers")
    with open(path, "w", encoding="ascii") as file:
        file.writelines(f"v {x!r} {y!r} {z!r}\n" for x, y, z in points.tolist())
        file.writelines(f"f {a} {b} {c}\n" for a, b, c in (corners + 1).tolist())


def fix_texts(fix: Any, count: int | None, folder: str) -> Any:
    """What `--fix` takes: texts as they are, masks and 0-based numbers of vertices as files that list them.

    A mask of n x 3 holds x, y and z by themselves. count: of vertices that arrays may name; None: arrays cannot.
    """
    if fix is None or isinstance(fix, (str, os.PathLike)):
        return fix
    given = [fix] if isinstance(fix, np.ndarray) or all(isinstance(part, (int, np.integer, bool)) for part in fix) else list(fix)
    texts: list[Any] = []
    for part in given:
        if isinstance(part, (str, os.PathLike)):
            texts.append(part)
            continue
        if count is None:
            raise ValueError("fix: vertices of a mesh file are named by a text; masks and numbers go with a mesh in arrays "
                             "or a Model")
        texts += _fix_files(part, count, os.path.join(folder, f"fix-{len(texts)}"))
    return texts


def _fix_files(part: Any, count: int, path: str) -> list[str]:
    mask = np.asarray(part)
    if mask.dtype == bool and mask.shape == (count, 3):
        columns = [(mask[:, axis], ":" + "xyz"[axis]) for axis in range(3) if mask[:, axis].any()]
    else:
        columns = [(mask, "")]
    texts = []
    for column, suffix in columns:
        chosen = chosen_vertices(column, count, "fix")
        if not chosen.size:
            raise ValueError("fix: it names no vertex")
        name = path + suffix.replace(":", "-")
        with open(name, "w", encoding="ascii") as file:
            file.writelines(f"{vertex + 1}\n" for vertex in chosen.tolist())
        texts.append(name + suffix)
    return texts
