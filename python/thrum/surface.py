"""Positions and normals for drawing, in single precision (thrum/surface.h).

SPDX-License-Identifier: Apache-2.0
"""

from __future__ import annotations

from typing import Any

import numpy as np

from . import _native
from ._errors import Missing, Status
from ._native import AlignedBlock, FloatArray, IntArray, call, ffi, lib
from .model import Model

# the faces of a tetrahedron of positive volume, counter-clockwise from outside
_FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))


class Surface:
    """Chosen vertices of a model's body, or all, and the triangles over them.

    vertices: 0-based vertices of the model in the order of the output; None: all. triangles: m x 3 places in the
    output, counter-clockwise from outside; None: no normals. Needs the model only while it is made. Immutable: any
    number of threads may read it.
    """

    def __init__(self, model: Model, vertices: Any = None, triangles: Any = None) -> None:
        chosen = None if vertices is None else _native.vertex_numbers(vertices, model.vertex_count, "vertices")
        count = model.vertex_count if chosen is None else chosen.size
        self.triangles: IntArray | None = (
            None if triangles is None else _native.triangle_numbers(triangles, count, "triangles"))

        definition = ffi.new("thrum_surface_def *")
        definition.vertices = _native.pointer(chosen, "int32_t")
        definition.vertex_count = 0 if chosen is None else chosen.size
        definition.triangles = _native.pointer(self.triangles, "int32_t")
        definition.triangle_count = 0 if self.triangles is None else len(self.triangles)

        size, place = ffi.new("size_t *"), ffi.new("const thrum_surface **")
        call(lib.thrum_surface_size, model._shape, definition, size)
        self._block = AlignedBlock(size[0])
        call(lib.thrum_surface_init, self._block.place, self._block.size, model._shape, definition, place)
        self._surface = place[0]
        self._rank = model.shown
        self.vertex_count = int(lib.thrum_surface_vertex_count(self._surface))

    def __repr__(self) -> str:
        triangles = 0 if self.triangles is None else len(self.triangles)
        return f"<thrum.Surface vertices={self.vertex_count} triangles={triangles}>"

    def positions(self, q: Any, out: FloatArray | None = None) -> FloatArray:
        """X + U q [m], count x 3, into `out` if it is given; q: `shown` coordinates of the model."""
        return self._read(lib.THRUM_SURFACE_POSITIONS, q, out)

    def displacements(self, q: Any, out: FloatArray | None = None) -> FloatArray:
        """U q [m], count x 3, into `out` if it is given; q: `shown` coordinates of the model."""
        return self._read(lib.THRUM_SURFACE_DISPLACEMENTS, q, out)

    def normals(self, positions: FloatArray, out: FloatArray | None = None) -> FloatArray:
        """Unit normals of all vertices, count x 3, from their positions. Missing without triangles."""
        shape = (self.vertex_count, 3)
        placed = _native.output(positions, shape, np.float32, "positions")
        into = _native.output(out, shape, np.float32, "out")
        call(lib.thrum_surface_normals, self._surface, _native.pointer(placed, "float"), 3,
             _native.pointer(into, "float"), 3)
        return into

    def _read(self, quantity: int, q: Any, out: FloatArray | None) -> FloatArray:
        at = _native.doubles(q, (self._rank,), "q")
        into = _native.output(out, (self.vertex_count, 3), np.float32, "out")
        call(lib.thrum_surface_positions, self._surface, quantity, _native.pointer(at), 0, self.vertex_count,
             _native.pointer(into, "float"), 3)
        return into


def outer_triangles(model: Model) -> IntArray:
    """Faces that belong to one tetrahedron alone: m x 3 0-based vertices, in the order of the tetrahedra."""
    tets = model.tets
    if tets is None:
        raise Missing("the model has no mesh", Status.MISSING)
    faces = np.concatenate([tets[:, face] for face in _FACES])
    _, first, uses = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    outer: IntArray = np.ascontiguousarray(faces[np.sort(first[uses == 1])], dtype=np.int32)
    return outer
