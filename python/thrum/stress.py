"""Stress and strain at the centres of tetrahedra, and stress at nodes (thrum/stress.h).

SPDX-License-Identifier: Apache-2.0
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _native
from ._native import AlignedBlock, Array, IntArray, call, ffi, lib, read_only
from .model import Model


def _largest(values: Array) -> float:
    """NaN where there is none."""
    finite = values[np.isfinite(values)]
    return float(finite.max()) if finite.size else float("nan")


@dataclass(frozen=True, repr=False)
class Stress:
    """Values at count points. A symmetric tensor is six numbers xx, yy, zz, xy, yz, xz."""

    strain: Array  # count x 6, Green strain [1]
    second_piola: Array  # count x 6 [Pa]
    cauchy: Array  # count x 6 [Pa]; NaN where the tetrahedron is inverted
    von_mises: Array  # count [Pa]; NaN where it is inverted
    stretch: Array  # count: least principal stretch [1]; below 0: inverted

    def __repr__(self) -> str:
        return f"<thrum.Stress points={len(self.von_mises)} von_mises up to {_largest(self.von_mises):.4g} Pa>"


class StressPoints:
    """The centre of each chosen tetrahedron (0-based), or of all. Any number of threads may read it."""

    def __init__(self, model: Model, tets: Any = None) -> None:
        chosen = None if tets is None else _native.vertex_numbers(tets, model.tet_count, "tets")
        definition = ffi.new("thrum_stress_points_def *")
        definition.tets = _native.pointer(chosen, "int32_t")
        definition.tet_count = 0 if chosen is None else chosen.size
        size, place = ffi.new("size_t *"), ffi.new("const thrum_stress_points **")
        call(lib.thrum_stress_points_size, model._shape, definition, size)
        self._block = AlignedBlock(size[0])
        call(lib.thrum_stress_points_init, self._block.place, self._block.size, model._shape, definition, place)
        self._points = place[0]
        self._model = model._handle()
        self._rank = model.shown

    def __len__(self) -> int:
        return int(lib.thrum_stress_points_count(self._points))

    def __repr__(self) -> str:
        return f"<thrum.StressPoints points={len(self)}>"

    @property
    def tets(self) -> IntArray:
        """0-based tetrahedron of each point."""
        return read_only(np.array([lib.thrum_stress_points_tet(self._points, n) for n in range(len(self))], np.int32))

    def read(self, q: Any) -> Stress:
        """Stress and strain at q (`shown` coordinates of the model)."""
        at = _native.doubles(q, (self._rank,), "q")
        count = len(self)
        found = Stress(np.empty((count, 6)), np.empty((count, 6)), np.empty((count, 6)), np.empty(count),
                       np.empty(count))
        output = ffi.new("thrum_stress_points_output *")
        for name in Stress.__dataclass_fields__:
            setattr(output, name, _native.pointer(getattr(found, name)))
        work = np.empty(lib.thrum_stress_points_work_count(self._points))
        call(lib.thrum_stress_points_read, self._points, _native.pointer(at), _native.pointer(work), output)
        return found


@dataclass(frozen=True, repr=False)
class NodeStress:
    """Values at count nodes. A symmetric tensor is six numbers xx, yy, zz, xy, yz, xz."""

    cauchy: Array  # count x 6 [Pa]; NaN next to a tetrahedron that is inverted
    von_mises: Array  # count [Pa]; NaN there too

    def __repr__(self) -> str:
        return f"<thrum.NodeStress nodes={len(self.von_mises)} von_mises up to {_largest(self.von_mises):.4g} Pa>"


class StressNodes:
    """Each vertex of the mesh, once for each region that meets there. Any number of threads may read it.

    In ten-node tetrahedra stress is extrapolated to the nodes and averaged within a region; in linear ones it is the
    average of a patch, which lags behind the stress at a surface.
    """

    def __init__(self, model: Model) -> None:
        size, place = ffi.new("size_t *"), ffi.new("const thrum_stress_nodes **")
        call(lib.thrum_stress_nodes_size, model._shape, size)
        self._block = AlignedBlock(size[0])
        call(lib.thrum_stress_nodes_init, self._block.place, self._block.size, model._shape, place)
        self._nodes = place[0]
        self._model = model._handle()  # the nodes refer to its mesh
        self._shape = model._shape
        self._rank = model.shown
        self._vertex_count = model.vertex_count

    def __len__(self) -> int:
        return int(lib.thrum_stress_nodes_count(self._nodes))

    def __repr__(self) -> str:
        return f"<thrum.StressNodes nodes={len(self)}>"

    @property
    def vertices(self) -> IntArray:
        """0-based vertex of each node."""
        return read_only(np.array([lib.thrum_stress_nodes_vertex(self._nodes, n) for n in range(len(self))], np.int32))

    @property
    def regions(self) -> IntArray:
        """0-based region of each node."""
        return read_only(np.array([lib.thrum_stress_nodes_region(self._nodes, n) for n in range(len(self))], np.int32))

    @property
    def extrapolated(self) -> bool:
        """False: averages of patches of linear tetrahedra."""
        return bool(lib.thrum_stress_nodes_extrapolated(self._nodes))

    def read(self, q: Any) -> NodeStress:
        """Stress at q (`shown` coordinates of the model)."""
        at = _native.doubles(q, (self._rank,), "q")
        u = np.empty((self._vertex_count, 3))
        call(lib.thrum_displacement, self._shape, _native.pointer(at), 0, len(u), _native.pointer(u))
        found = NodeStress(np.empty((len(self), 6)), np.empty(len(self)))
        call(lib.thrum_stress_nodes_read, self._nodes, _native.pointer(u), _native.pointer(found.cauchy),
             _native.pointer(found.von_mises))
        return found
