"""The reduced model: what `thrum precompute` writes and states step.

SPDX-License-Identifier: Apache-2.0
"""

from __future__ import annotations

import io
import json
import os
import pathlib
import tempfile
from collections.abc import Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from . import _native, _program
from ._errors import BadFile, Error, Missing, Status
from ._native import AlignedBlock, Array, IntArray, call, ffi, lib

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import PrecomputeOptions
    from .batch import Batch
    from .equilibrium import Equilibrium, EquilibriumOptions
    from .monitor import Monitor, MonitorOptions
    from .state import State, StateOptions
    from .stress import StressNodes, StressPoints
    from .surface import Surface

Path = Union[str, "os.PathLike[str]"]

_LAWS = ("stvk", "corotational", "neo-hookean")  # in the order of their numbers in a model file


class _Handle:
    """A model in the library's memory with all that it points into: freed when nobody refers to it any more."""

    def __init__(self, model: Any, keeps: tuple[object, ...]) -> None:
        self.model = model
        self.keeps = keeps


class Model:
    """A reduced model. Immutable: any number of states, bodies and threads may share it.

    Made by `Model.load`, `Model.from_bytes` and `Model.precompute`, never directly. States, views and models made
    from it keep its memory alive, whatever happens to this object. It is pickled with its whole file.
    """

    def __init__(self, handle: _Handle, recipe: tuple[Any, ...] = ()) -> None:
        if not isinstance(handle, _Handle):
            raise TypeError("a Model is made by Model.load(path), Model.from_bytes(data) or Model.precompute(mesh)")
        self._shared: _Handle | None = handle
        # how the model is made again elsewhere: a function of this module and its arguments
        self._recipe = recipe
        # the file that it was loaded from: its path, time and size
        self._loaded_from: tuple[str, int, int] | None = None

    # --- making and closing --------------------------------------------------------------------

    @classmethod
    def load(cls, path: Path) -> Model:
        """Reads a model file (.npz). BadFile where it cannot be read or is no model, with the array and the reason."""
        seen = _seen(path)
        try:
            data = np.fromfile(os.fspath(path), np.uint8)
        except OSError as error:
            raise BadFile(f"{os.fspath(path)}: {error.strerror}", Status.IO) from error
        try:
            model = cls._from_array(data)
        except Error as error:
            raise type(error)(f"{os.fspath(path)}: {error}", error.status) from None
        model._loaded_from = seen
        return model

    @classmethod
    def from_bytes(cls, data: Any) -> Model:
        """The model whose file has these bytes (any bytes-like object); they are copied."""
        return cls._from_array(np.frombuffer(data, np.uint8))

    @classmethod
    def _from_array(cls, data: Any) -> Model:
        if data.size == 0:
            raise BadFile("the model file is empty", Status.BAD_FORMAT)
        file = AlignedBlock(data.size)
        file.array[:] = data
        handle = _in_place(file) or _copied(file)
        return cls(handle, ("bytes", file))

    @classmethod
    def precompute(cls, mesh: Any, output: Path | None = None, **options: Unpack[PrecomputeOptions]) -> Model:
        """Makes a model of a tetrahedral mesh with the program `thrum precompute`, which must be installed.

        mesh: a file, the name of a model that comes with Thrum, `beam:20x3x3@1x0.15x0.15`, a Model, a `Mesh` with groups and
        regions, a meshio mesh, or a pair (vertices n x 3 [m], tets m x 4 or m x 10, 0-based). output: a file for the model;
        None: none is left behind. options: those of the program with underscores, such as fix="x<0.001", modes=10, rank=20,
        young=2e6, order=2; a list for an option that may be repeated, True for one without a value. fix also takes a mask of
        the vertices, n or n x 3 for x, y and z by themselves, or their 0-based numbers, where the mesh is arrays or a Model.
        ProgramFailed with the program's message.
        """
        with tempfile.TemporaryDirectory(prefix="thrum-") as folder:
            path = os.fspath(output) if output is not None else os.path.join(folder, "model.npz")
            _program.precompute(mesh, path, **options)
            return cls.load(path)

    def close(self) -> None:
        """Gives the model up: later calls raise ValueError. States and views made before keep what they need."""
        self._shared = None

    def __enter__(self) -> Model:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.close()

    def __reduce__(self) -> tuple[Any, ...]:
        self._handle()
        kind, *arguments = self._recipe
        if kind == "bytes":
            return _model_from_bytes, (arguments[0].array.tobytes(),)
        return _model_from_parent, (kind, *arguments)

    def __repr__(self) -> str:
        if self._shared is None:
            return "<thrum.Model closed>"
        return f"<thrum.Model rank={self.rank} vertices={self.vertex_count} tets={self.tet_count}>"

    def _file(self, otherwise: str) -> str:
        """The file that it was loaded from, as long as that is as it was, else `otherwise`, which is written."""
        self._handle()
        if self._loaded_from is not None and self._loaded_from == _seen(self._loaded_from[0]):
            return self._loaded_from[0]
        self.save(otherwise)
        return otherwise

    def save(self, path: Path) -> None:
        """Writes the file that the model was read from, byte for byte, or that of its other parameters.

        A model that was scaled or condensed has no file.
        """
        content = self._bytes()
        target = pathlib.Path(path)
        with tempfile.NamedTemporaryFile(dir=target.parent, delete=False) as beside:
            beside.write(content)
        os.replace(beside.name, target)

    def _bytes(self) -> bytes:
        """The file of this model."""
        self._handle()
        if self._recipe[0] == "bytes":
            return bytes(self._recipe[1].array.tobytes())
        if self._recipe[0] != "parameters":
            raise ValueError("a model that was scaled or condensed has no file; save the one it was made of")

        # the arrays of the model that it was made of, with their numbers here; what is no array of the model stays
        arrays = {}
        with np.load(io.BytesIO(self._recipe[1]._bytes())) as file:
            for name in file.files:
                before, here = file[name], getattr(self._c, name, None)
                if here is None:
                    arrays[name] = before
                elif here != ffi.NULL:
                    arrays[name] = np.frombuffer(ffi.buffer(here, before.nbytes), before.dtype).reshape(before.shape)
        written = io.BytesIO()
        np.savez(written, **arrays)
        Model.from_bytes(written.getvalue())  # what cannot be read again is not written
        return written.getvalue()

    def _handle(self) -> _Handle:
        if self._shared is None:
            raise ValueError("the model was closed")
        return self._shared

    @property
    def _c(self) -> Any:
        return self._handle().model

    # --- what is in it ---------------------------------------------------------------------------

    @property
    def rank(self) -> int:
        """Number of coordinates r."""
        return int(self._c.rank)

    @property
    def shown(self) -> int:
        """Number of coordinates that show the body: r, but for a condensed model, whose others follow."""
        return int(lib.thrum_condensed_shape_model(self._c).rank)

    @property
    def masters(self) -> int:
        """Coordinates of a model that was precomputed condensed, which `condense` makes steppable; else 0."""
        return int(lib.thrum_model_masters(self._c))

    @property
    def vertex_count(self) -> int:
        """Number of mesh vertices n, held ones included; 0 without a mesh."""
        return int(self._shape.vertex_count)

    @property
    def tet_count(self) -> int:
        """Number of tetrahedra; 0 without a mesh."""
        return int(self._shape.tet_count)

    @property
    def actuators(self) -> list[str]:
        """Names of what acts on the body, `actuation` of a state; made by precompute(actuator=["air=chamber:inside"])."""
        count = lib.thrum_model_actuators(self._c)
        return [ffi.string(lib.thrum_model_actuator_text(self._c, k)).decode().split("=")[0] for k in range(count)]

    def _levels(self, value: Any, before: dict[str, float] | None = None) -> Array:
        """Levels of all actuators, from names and levels, where others stay as before, or from all in order."""
        names = self.actuators
        if isinstance(value, dict):
            for name in value:
                if name not in names:
                    raise KeyError(f"no actuator {name!r}; the model has {', '.join(names) or 'none'}")
            return np.array([float(value.get(name, (before or {}).get(name, 0.0))) for name in names])
        return np.zeros(len(names)) if value is None else _native.doubles(value, (len(names),), "actuation")

    @property
    def _shape(self) -> Any:
        return lib.thrum_condensed_shape_model(self._c)

    def _view(self, model: Any, name: str, shape: tuple[int, ...], kind: str = "<f8") -> Any:
        return _native.view(getattr(model, name), shape, kind, self._handle())

    @property
    def omega2(self) -> Array:
        """Squared angular frequencies [1/s^2], r, ascending; a view."""
        values: Array = self._view(self._c, "omega2", (self.rank,))
        return values

    @property
    def frequencies(self) -> Array:
        """Frequencies of the coordinates at rest [Hz], r."""
        return _native.read_only(np.sqrt(self.omega2) / (2.0 * np.pi))

    @property
    def vertices(self) -> Array | None:
        """Rest positions [m], n x 3; a view. None without a mesh."""
        values: Array | None = self._view(self._shape, "vertices", (self.vertex_count, 3))
        return values

    @property
    def tets(self) -> IntArray | None:
        """0-based corners of the tetrahedra, m x 4; a view. None without a mesh."""
        values: IntArray | None = self._view(self._shape, "tets", (self.tet_count, 4), "<i4")
        return values

    @property
    def fixed(self) -> Any:
        """n: bit 0, 1, 2 is set where x, y, z of the vertex is held; a view. None without a mesh."""
        return self._view(self._shape, "fixed", (self.vertex_count,), "|u1")

    @property
    def material(self) -> Array | None:
        """Young's modulus [Pa], Poisson's ratio, density [kg/m^3], one row a region; a view."""
        values: Array | None = self._view(self._shape, "material", (int(self._shape.region_count), 3))
        return values

    @property
    def laws(self) -> list[str]:
        """The law of each region: stvk, corotational or neo-hookean; one where they are not told apart."""
        count = int(self._shape.law_count)
        if count > 0:
            return [_LAWS[self._shape.region_law[region]] for region in range(count)]
        named = self._shape.point_law
        law = ffi.string(ffi.cast("const char *", named)).decode() if named != ffi.NULL else _LAWS[0]
        return [law] * max(int(self._shape.region_count), 1)

    @property
    def point_training(self) -> Array | None:
        """What cubature points were trained on: the largest strain, the yield beyond which it flowed (0: it was elastic),
        the largest plastic strain, and 1 where the gradients were learned; None: not known, or without points."""
        values: Array | None = self._view(self._shape, "point_training", (4,))
        return values

    @property
    def basis(self) -> Array | None:
        """U [kg^-1/2], 3 n x shown; a view. None for a model without a mesh."""
        values: Array | None = self._view(self._shape, "basis", (3 * self.vertex_count, self.shown))
        return values

    @property
    def groups(self) -> dict[str, IntArray]:
        """Named vertex groups: 0-based vertices of each; views."""
        groups = {}
        for number in range(int(self._shape.group_count)):
            name = lib.thrum_model_group_name(self._shape, number)
            vertices, count = ffi.new("const int32_t **"), ffi.new("int64_t *")
            call(lib.thrum_model_group, self._shape, name, vertices, count)
            found = _native.view(vertices[0], (count[0],), "<i4", self._handle())
            assert found is not None
            groups[ffi.string(name).decode("utf-8", "replace")] = found
        return groups

    @property
    def meta(self) -> dict[str, Any]:
        """What precompute noted about the model; empty where it noted nothing."""
        text = self._view(self._shape, "meta", (int(self._shape.meta_bytes),), "|u1")
        return {} if text is None else dict(json.loads(text.tobytes()))

    # --- models made from it ---------------------------------------------------------------------

    def truncate(self, rank: int) -> Model:
        """The model that steps the lowest `rank` coordinates while all others follow at rest; of r itself, this one.

        No coordinate is cut off, for without those that follow a body that bends would be too stiff: see `condense`.
        """
        return self if rank == self.rank else self.condense(rank)

    def scale(self, length: float = 1.0, stiffness: float = 1.0, density: float = 1.0) -> Model:
        """The same body with lengths, Young's modulus and density times these factors (each > 0), exactly.

        Springs to the ground are stiffer with the body, by stiffness times length.
        """
        return self._derived("scale", length, stiffness, density)

    def condense(self, masters: int) -> Model:
        """The model that steps the lowest `masters` coordinates while all others follow at rest."""
        return self._derived("condense", masters)

    @property
    def parameters(self) -> Array:
        """Lame's lambda and mu [Pa] and the density [kg/m^3] of each region, regions x 3; no rows for a model that was made
        without `--parameters`."""
        values = np.empty((lib.thrum_model_parameter_count(self._c) // 3, 3))
        if values.size > 0:
            call(lib.thrum_model_parameters_get, self._c, _native.pointer(values))
        return _native.read_only(values)

    def with_parameters(self, values: Any) -> Model:
        """The body of other `parameters` (regions x 3), with modes of its own and at the same cost.

        Its basis spans what that of this model spans. Failures: thrum_model_set_parameters.
        """
        shape = (max(1, len(self.parameters)), 3)  # where there are none the library says so
        return self._derived("parameters", *_native.doubles(values, shape, "values").ravel().tolist())

    def _with_parameters(self, *values: float) -> Model:
        size, work, made = ffi.new("size_t *"), ffi.new("size_t *"), ffi.new("const thrum_model **")
        call(lib.thrum_model_parameters_size, self._c, size, work)
        block, scratch = AlignedBlock(size[0]), np.empty(work[0])
        call(lib.thrum_model_set_parameters, block.place, block.size, self._c, ffi.new("double[]", list(values)), ffi.NULL,
             _native.pointer(scratch), made)
        return Model(_Handle(made[0], (block, self._handle())), ("parameters", self, *values))

    def _derived(self, kind: str, *arguments: float) -> Model:
        if kind == "parameters":
            return self._with_parameters(*arguments)
        size, made = ffi.new("size_t *"), ffi.new("const thrum_model **")
        extra = (ffi.new("thrum_model_scaling *", list(arguments)),) if kind == "scale" else arguments
        size_extra = () if kind == "scale" else arguments
        call(getattr(lib, f"thrum_model_{kind}_size"), self._c, *size_extra, size)
        block = AlignedBlock(size[0])
        call(getattr(lib, f"thrum_model_{kind}"), block.place, block.size, self._c, *extra, made)
        return Model(_Handle(made[0], (block, self._handle())), (kind, self, *arguments))

    # --- forces and energy -----------------------------------------------------------------------

    def _work(self) -> Any:
        if self.masters > 0:
            raise Missing("the model was precomputed condensed and has no energy of all its coordinates: take "
                          f"model.condense({self.masters})", Status.MISSING)
        return ffi.new("double[]", lib.thrum_work_count(self._c))

    def strain_energy(self, q: Any) -> float:
        """V(q) [J]; q: r."""
        at = _native.doubles(q, (self.rank,), "q")
        return float(lib.thrum_strain_energy(self._c, _native.pointer(at), self._work()))

    def internal_force(self, q: Any) -> Array:
        """R(q), the gradient of V [kg^1/2 m/s^2], r; q: r."""
        at = _native.doubles(q, (self.rank,), "q")
        force = np.empty(self.rank)
        lib.thrum_internal_force(self._c, _native.pointer(at), _native.pointer(force), self._work())
        return force

    def tangent_stiffness(self, q: Any) -> Array:
        """T(q), the second derivatives of V [1/s^2], r x r; q: r."""
        at = _native.doubles(q, (self.rank,), "q")
        tangent = np.empty((self.rank, self.rank))
        lib.thrum_tangent_stiffness(self._c, _native.pointer(at), _native.pointer(tangent), self._work())
        return tangent

    def external_load(self, force: Any = None, *, vertices: Any = None, group: str | None = None, vertex: int | None = None,
                      field: Any = None, gravity: Any = None) -> Array:
        """The load on the coordinates [kg^1/2 m/s^2], `shown` of them, for `State.force` and `equilibrium`.

        force: one force x, y, z [N] that the whole body shares, or the `vertices` (0-based), the `group` or the one
        `vertex` named with it. field: a force for each vertex, n x 3 [N]. gravity: an acceleration [m/s^2]. What is
        given adds up. Missing for a model without what the load needs, KeyError for a group that is not there.
        """
        reduced = np.zeros(self.shown)
        into = _native.pointer(reduced)
        places = [place for place in (vertices, group, vertex) if place is not None]
        if len(places) > 1 or (places and force is None):
            raise ValueError("external_load: one of vertices, group and vertex, and a force with it")
        if force is not None:
            vector = _native.doubles(force, (3,), "force")
            self._add_force(vector, vertices, group, vertex, into)
        if field is not None:
            forces = _native.doubles(field, (self.vertex_count, 3), "field")
            call(lib.thrum_load_add_field, self._shape, _native.pointer(forces), into)
        if gravity is not None:
            acceleration = _native.doubles(gravity, (3,), "gravity")
            call(lib.thrum_load_add_gravity, self._shape, _native.pointer(acceleration), into)
        return reduced

    def _add_force(self, force: Array, vertices: Any, group: str | None, vertex: int | None, into: Any) -> None:
        chosen: IntArray | None = None
        if vertex is not None:
            chosen = _native.vertex_numbers([vertex], self.vertex_count, "vertex")
        elif vertices is not None:
            chosen = _native.vertex_numbers(vertices, self.vertex_count, "vertices")
        elif group is not None:
            chosen = self.group(group)
        count = 0 if chosen is None else chosen.size
        call(lib.thrum_load_add_shared, self._shape, _native.pointer(chosen, "int32_t"), count,
             _native.pointer(force), into)

    def group(self, name: str) -> IntArray:
        """0-based vertices of a group; KeyError with the groups that there are."""
        groups = self.groups
        if name not in groups:
            known = ", ".join(sorted(groups)) or "none"
            raise KeyError(f"the model has no group {name!r}; it has: {known}")
        return groups[name]

    # --- showing it ------------------------------------------------------------------------------

    def displacement(self, q: Any, vertices: slice | None = None) -> Array:
        """u = U q [m], one row a vertex: of all, or of those of a slice without a step. q: `shown` coordinates."""
        at = _native.doubles(q, (self.shown,), "q")
        first, last, step = (vertices or slice(None)).indices(self.vertex_count)
        if step != 1:
            raise ValueError("vertices: a slice without a step is needed")
        moved = np.empty((max(last - first, 0), 3))
        if len(moved):
            call(lib.thrum_displacement, self._shape, _native.pointer(at), first, len(moved),
                 _native.pointer(moved))
        return moved

    def positions(self, q: Any) -> Array:
        """X + U q [m], n x 3; q: `shown` coordinates."""
        rest = self.vertices
        if rest is None:
            raise Missing("the model has no mesh", Status.MISSING)
        placed: Array = rest + self.displacement(q)
        return placed

    def shape(self, q: Any, load: Any = None) -> Array:
        """All `shown` coordinates at q (r): those that follow included, with their static answer to `load`."""
        at = _native.doubles(q, (self.rank,), "q")
        pushed = None if load is None else _native.doubles(load, (self.shown,), "load")
        shown = np.empty(self.shown)
        lib.thrum_condensed_shape(self._c, _native.pointer(at), _native.pointer(pushed), _native.pointer(shown))
        return shown

    def condensed_load(self, q: Any, load: Any) -> Array:
        """The force on the stepped coordinates (r) of a load on all `shown` ones, at q (r): it depends on q.

        Of a model that is not condensed it is the load itself.
        """
        at = _native.doubles(q, (self.rank,), "q")
        pushed = _native.doubles(load, (self.shown,), "load")
        reduced = np.empty(self.rank)
        lib.thrum_condensed_load(self._c, _native.pointer(at), _native.pointer(pushed), _native.pointer(reduced))
        return reduced

    def start(self, mode: int, amplitude: float) -> Array:
        """q (`shown`) with coordinate `mode` (0-based) such that no vertex moves further than `abs(amplitude)` [m]."""
        if not 0 <= mode < self.shown:
            raise ValueError(f"mode: {mode} is not within 0 to {self.shown - 1}")
        q = np.zeros(self.shown)
        call(lib.thrum_mode_add, self._shape, mode, amplitude, _native.pointer(q))
        return q

    # --- what is made for it ---------------------------------------------------------------------

    def state(self, integrator: str = "energy", dt: float = 0.003, **options: Unpack[StateOptions]) -> State:
        """A state at rest. options: the other fields of thrum_state_def (`State` lists them)."""
        from .state import State
        return State(self, integrator=integrator, dt=dt, **options)

    def batch(self, states: Sequence[State], threads: int = 1) -> Batch:
        """States of this model that are stepped together, by so many threads."""
        from .batch import Batch
        return Batch(self, states, threads)

    def equilibrium(self, load: Any, q: Any = None, **options: Unpack[EquilibriumOptions]) -> Equilibrium:
        """The static equilibrium under a load (r), followed from rest or from the equilibrium q (r).

        A RuntimeWarning says where the shape is compressed, or bent further than the basis is made for.
        """
        from .equilibrium import find
        return find(self, load, q, dict(options))

    def surface(self, vertices: Any = None, triangles: Any = None) -> Surface:
        """Positions and normals of chosen vertices, for drawing."""
        from .surface import Surface
        return Surface(self, vertices, triangles)

    def outer_triangles(self) -> IntArray:
        """The outer triangles of the mesh, counter-clockwise from outside: m x 3 0-based vertices."""
        from .surface import outer_triangles
        return outer_triangles(self)

    def stress_points(self, tets: Any = None) -> StressPoints:
        """Stress and strain at the centres of chosen tetrahedra, or of all."""
        from .stress import StressPoints
        return StressPoints(self, tets)

    def stress_nodes(self) -> StressNodes:
        """Stress at the nodes, where it is largest on a surface that is bent or twisted."""
        from .stress import StressNodes
        return StressNodes(self)

    def monitor(self, **options: Unpack[MonitorOptions]) -> Monitor:
        """Tells whether the model can be believed where a state is."""
        from .monitor import Monitor
        return Monitor(self, **options)


def _seen(path: Path) -> tuple[str, int, int] | None:
    """The absolute path of a file, its time and its size; None where it cannot be looked at."""
    try:
        found = os.stat(path)
    except OSError:
        return None
    return os.path.abspath(path), found.st_mtime_ns, found.st_size


def _in_place(file: AlignedBlock) -> _Handle | None:
    """The model in the bytes of its file, packed for speed; None where its arrays lie too crooked for that."""
    model, error = ffi.new("thrum_model *"), _native.new_error()
    status = lib.thrum_model_view(file.place, file.size, model, error)
    if status == lib.THRUM_MISALIGNED:
        return None
    _native.check(status, error)
    if model.c3 == ffi.NULL:
        return _Handle(model, (file,))
    packed = AlignedBlock(lib.thrum_model_pack_size(model))
    call(lib.thrum_model_pack, model, packed.place, packed.size)
    return _Handle(model, (file, packed))


def _copied(file: AlignedBlock) -> _Handle:
    """The model in memory of its own."""
    size, made = ffi.new("size_t *"), ffi.new("const thrum_model **")
    call(lib.thrum_model_size, file.place, file.size, size)
    block = AlignedBlock(size[0])
    call(lib.thrum_model_init, block.place, block.size, file.place, file.size, made)
    return _Handle(made[0], (block,))


def _model_from_bytes(data: bytes) -> Model:
    return Model.from_bytes(data)


def _model_from_parent(kind: str, parent: Model, *arguments: float) -> Model:
    return parent._derived(kind, *arguments)
