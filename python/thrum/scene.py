"""Placed bodies, what acts on them, and their steps side by side (thrum/scene.h).

SPDX-License-Identifier: Apache-2.0
"""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass
from types import TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _native
from ._errors import Status
from ._fields import Def
from ._native import Array, FloatArray, call, ffi, lib
from .model import Model
from .state import Report, report_of, set_choice, state_def
from .surface import Surface

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._keywords import BodyOptions, LinkOptions, LoadOptions, ObstacleOptions, PairsOptions, SolidOptions, WindOptions

_LINK_REPORT = ("drift", "largest_drift", "stored", "lost", "driven")


class Load:
    """A load over time on one body, in world axes.

    One of: force, x, y, z [N], which `vertices` (0-based) or the `group` share, or the whole body; field, n x 3 [N];
    acceleration [m/s^2]. It acts in [start, until) [s], as it is, or times sin(2 pi frequency (t - start)) [Hz],
    or with `ramp` times (t - start) / (until - start). More `options` of its course by the rows of thrum/fields.h.
    """

    def __init__(self, force: Any = None, vertices: Any = None, group: str | None = None, field: Any = None,
                 acceleration: Any = None, *, ramp: bool = False, **options: Unpack[LoadOptions]) -> None:
        self.force, self.vertices, self.group, self.field, self.acceleration = force, vertices, group, field, acceleration
        self.ramp, self.options = ramp, options

    def __repr__(self) -> str:
        given = {name: value for name, value in vars(self).items() if value is not None and name not in ("ramp", "options")}
        words = [*given, *(["ramp"] if self.ramp else []), *(f"{name}={value}" for name, value in self.options.items())]
        return f"Load({', '.join(words)})"


@dataclass(frozen=True)
class Touch:
    """A point where two bodies touched in the last step: thrum_pair_touch in thrum/contact_pairs.h.

    bodies: in place of a body the number of a solid, where one was touched. force [N] acts on the first body and its negative on the second; normal leads from the second to the first. Where
    they struck each other as a whole, impulse [N s] did so in place of a force.
    """

    bodies: tuple[Body | int, Body | int]
    position: Array
    force: Array
    normal: Array
    distance: float
    impulse: Array


@dataclass(frozen=True)
class Overlap:
    """A body that lies inside another one, or inside the obstacle of this number: depth of its deepest vertex [m]."""

    body: Body
    other: Body | None
    obstacle: int | None
    depth: float


class Obstacle:
    """A rigid obstacle: `shape` "plane", "sphere" or "box"; the options are fields of thrum_obstacle (thrum/fields.h).

    Each is an attribute, too: Obstacle(radius=2).radius is 2.
    """

    def __init__(self, **options: Unpack[ObstacleOptions]) -> None:
        self._def = Def("obstacle", dict(options))

    def __repr__(self) -> str:
        return f"Obstacle({', '.join(f'{name}={self._def.get(name)!r}' for name in self._def.names())})"

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self._def.get(name)
        except TypeError as error:
            raise AttributeError(str(error)) from None


class Pull:
    """A spring that pulls a vertex of a body to a target, until `end`."""

    def __init__(self, scene: Scene, number: int) -> None:
        self._scene = scene
        self._number = number

    def __repr__(self) -> str:
        return f"<thrum.Pull {self._number}>"

    def move(self, target: Any) -> None:
        """Moves the target [m]."""
        self._scene._call(lib.thrum_scene_pull_move, self._number, _vector(target, "target"))

    def end(self) -> None:
        """Ends the pull."""
        self._scene._call(lib.thrum_scene_pull_end, self._number)

    @property
    def point(self) -> Array:
        """Position of the pulled vertex [m]."""
        return _native.read_only(self._read()[0])

    @property
    def force(self) -> Array:
        """Mean force of the last step on it [N]."""
        return _native.read_only(self._read()[1])

    def _read(self) -> tuple[Array, Array]:
        point, force = np.empty(3), np.empty(3)
        self._scene._call(lib.thrum_scene_pull_get, self._number, _native.pointer(point), _native.pointer(force))
        return point, force


class Link:
    """A spring or joint between places of two bodies, or of a body and the world: `Scene.add_link` makes it.

    Links are solved for with the bodies (docs/links.md): a joint does no work, a spring gives back what it took.
    """

    def __init__(self, scene: Scene, number: int) -> None:
        self.scene = scene
        self.number = number

    def __repr__(self) -> str:
        return f"<thrum.Link {self.number} {self.kind}>"

    def _get(self) -> Any:
        found = ffi.new("thrum_scene_link *")
        self.scene._call(lib.thrum_scene_link_get, self.number, found)
        return found

    @property
    def kind(self) -> str:
        """"spring", "ball", "hinge" or "weld"."""
        made = Def("link")
        made.c.kind = self._get().kind
        return str(made.get("kind"))

    @property
    def bodies(self) -> tuple[Body, Body | None]:
        """What it ties; None: the world."""
        found = self._get()
        first, second = found.bodies
        return self.scene.bodies[first], self.scene.bodies[second] if second >= 0 else None

    @property
    def holds(self) -> bool:
        """False: it has let go, as it does after a body of it has failed."""
        return bool(self._get().holds)

    @property
    def length(self) -> float:
        """Of a spring without force [m]."""
        return float(self._get().length)

    @property
    def places(self) -> Array:
        """Where its two ends are, 2 x 3 [m]."""
        found = self._get()
        return _native.read_only(np.array([list(place) for place in found.places]))

    @property
    def force(self) -> Array:
        """Mean force of the last step on the place of the first body [N]."""
        found = self._get()
        return _native.read_only(np.array(list(found.report.force)))

    @property
    def torque(self) -> Array:
        """Mean torque of the last step about it, of hinges and welds [N m]."""
        found = self._get()
        return _native.read_only(np.array(list(found.report.torque)))

    @property
    def report(self) -> dict[str, float]:
        """drift of a joint after the last step, largest_drift of all but its first two [m]; stored, lost, driven [J].

        The work of its forces on the bodies is driven - stored - lost: energy in the spring now, what the damper or the
        closing of the joint took, and what an end that follows a path has done.
        """
        found = self._get()
        return {name: getattr(found.report, name) for name in _LINK_REPORT}

    def release(self) -> None:
        """Lets it go from now on."""
        self.scene._call(lib.thrum_scene_link_release, self.number)


class Body:
    """One body of a scene."""

    def __init__(self, scene: Scene, number: int, model: Model) -> None:
        self.scene = scene
        self.model = model
        self.number = number

    def __repr__(self) -> str:
        return f"<thrum.Body {self.number} {self.name!r}>"

    def _info(self) -> Any:
        # its parts lie in it: keep it in a variable while they are read
        info = ffi.new("thrum_scene_body_info *")
        self.scene._call(lib.thrum_scene_body, self.number, info)
        return info

    @property
    def name(self) -> str:
        """Its name."""
        return str(ffi.string(self._info().name).decode("utf-8", "replace"))

    @property
    def status(self) -> Status:
        """Below 0: the body has stopped for this reason; `Scene.reset` starts it again."""
        return Status(self._info().status)

    @property
    def report(self) -> Report:
        """Counters since the last change of one of its parameters."""
        info = self._info()
        return report_of(info.report)

    @property
    def touching(self) -> int:
        """Number of its touches in the last step."""
        info = self._info()
        return int(info.contact.touching)

    def contact_force(self, other: Body | None = None, *, obstacle: int | None = None, solid: int | None = None) -> Array:
        """Force of contact on it, mean over the last step [N]: of everything, of another body, or of an obstacle or solid by number."""
        if sum(of is not None for of in (other, obstacle, solid)) > 1:
            raise TypeError("contact_force takes a body, an obstacle or a solid, and one of them")
        kind, number = (lib.THRUM_SCENE_ANYTHING, 0) if other is None else (lib.THRUM_SCENE_BODY, other.number)
        if obstacle is not None:
            kind, number = lib.THRUM_SCENE_OBSTACLE, obstacle
        if solid is not None:
            kind, number = lib.THRUM_SCENE_SOLID, solid
        force = ffi.new("double[3]")
        self.scene._call(lib.thrum_scene_contact_force, self.number,
                         ffi.new("thrum_scene_thing *", {"kind": kind, "number": number})[0], force)
        return _native.read_only(np.array(list(force)))

    @property
    def energies(self) -> dict[str, float]:
        """kinetic, potential, gravity, contact, their sum total, and high [J]."""
        found = ffi.new("thrum_scene_energies *")
        self.scene._call(lib.thrum_scene_body_energies, self.number, found)
        return {name: getattr(found, name) for name in ("kinetic", "potential", "gravity", "contact", "total", "high")}

    @property
    def q(self) -> Array:
        """Coordinates that show the scaled body [kg^1/2 m]; a read-only copy."""
        return _native.read_only(self._coordinates()[0])

    @property
    def p(self) -> Array:
        """Their momenta [kg^1/2 m/s]; a read-only copy."""
        return _native.read_only(self._coordinates()[1])

    def _coordinates(self) -> tuple[Array, Array]:
        shown = self._info().shown
        q, p = np.empty(shown), np.empty(shown)
        self.scene._call(lib.thrum_scene_body_get, self.number, _native.pointer(q), _native.pointer(p))
        return q, p

    @property
    def matrix(self) -> Array:
        """From the model's coordinates to the world, 4 x 4, for column vectors."""
        flat = np.empty(16)
        with self.scene._lock:
            lib.thrum_scene_body_matrix(self.scene._open(), self.number, _native.pointer(flat))
        return _native.read_only(flat.reshape(4, 4).T.copy())

    def positions(self, surface: Surface, out: FloatArray | None = None) -> FloatArray:
        """X + U q of a surface of its model, in the model's coordinates, count x 3; `matrix` places them."""
        into = _native.output(out, (surface.vertex_count, 3), np.float32, "out")
        self.scene._call(lib.thrum_scene_body_positions, self.number, surface._surface,
                         _native.pointer(into, "float"), 3)
        return into

    def vertex(self, vertex: int) -> tuple[Array, Array]:
        """Position [m] and velocity [m/s] of one vertex (0-based) in the world."""
        position, velocity = np.empty(3), np.empty(3)
        self.scene._call(lib.thrum_scene_body_vertex, self.number, vertex, _native.pointer(position),
                         _native.pointer(velocity))
        return _native.read_only(position), _native.read_only(velocity)

    def pull(self, vertex: int, target: Any, stiffness: float, damping: float = -1.0) -> Pull:
        """Starts a spring from a vertex (0-based) to a target [m]; stiffness [N/m], damping [N s/m], < 0: critical."""
        number = ffi.new("int32_t *")
        self.scene._call(lib.thrum_scene_pull_start, self.number, vertex, _vector(target, "target"),
                         float(stiffness), float(damping), number)
        return Pull(self.scene, number[0])

    def add_load(self, load: Load) -> None:
        """Adds a load over time."""
        made = _load_def(load, self.model)
        self.scene._call(lib.thrum_scene_add_load, self.number, made.c)

    def add_actuation(self, name: str, level: float, course: Load | None = None) -> None:
        """Adds to the level of an actuator of the model: `level` times the course of a load, or all the time."""
        actuators = self.model.actuators
        if name not in actuators:
            raise KeyError(f"no actuator {name!r}; the model has {', '.join(actuators) or 'none'}")
        made = _load_def(course or Load(force=(0.0, 0.0, 0.0)), self.model)
        self.scene._call(lib.thrum_scene_add_actuation, self.number, actuators.index(name), float(level),
                         ffi.addressof(made.c, "course"))

    def set_damping(self, alpha: float, beta: float = 0.0) -> None:
        """Rayleigh damping [1/s, s] from now on."""
        self.scene._call(lib.thrum_scene_set_damping, self.number, float(alpha), float(beta))

    def set_stiffness(self, stiffness: float) -> None:
        """Factor of Young's modulus from now on."""
        self.scene._call(lib.thrum_scene_set_stiffness, self.number, float(stiffness))

    def set_rank(self, rank: int) -> None:
        """Number of coordinates that are stepped from now on; those beyond follow, as after `set_condensed`."""
        self.scene._call(lib.thrum_scene_set_rank, self.number, rank)

    def set_condensed(self, masters: int) -> None:
        """Number of coordinates that are stepped from now on while all others follow at rest; 0: all are stepped."""
        self.scene._call(lib.thrum_scene_set_condensed, self.number, masters)

    def set_detail(self, masters: int, jump: float, *, beyond: float = 0.0, still: float = 0.0) -> None:
        """Coordinates that Scene.update_detail has the body step while it is far or still, the others following.

        It is far where its middle is further than `beyond` [m] from Scene.eye, and still where no vertex has moved or deformed
        faster than `still` [m/s] for a period and nothing is about to act on it; 0: never. No vertex jumps further than `jump` [m] at a change; one that would waits.
        """
        detail = ffi.new("thrum_scene_detail *", {"masters": masters, "beyond": beyond, "still": still, "jump": jump})
        self.scene._call(lib.thrum_scene_set_detail, self.number, detail)

    def clear_detail(self) -> None:
        """Leaves the number of coordinates as it is from now on."""
        self.scene._call(lib.thrum_scene_set_detail, self.number, ffi.NULL)

    @property
    def detail(self) -> dict[str, float]:
        """What the level of detail has done so far, by the names of thrum_scene_detail_report; all zero without one."""
        report = ffi.new("thrum_scene_detail_report *")
        self.scene._call(lib.thrum_scene_body_detail, self.number, report)
        return {name: getattr(report, name) for name in ("set", "reduced", "changes", "put_off", "reduced_steps",
                                                         "largest_jump", "energy", "distance", "speed")}

    def set_integrator(self, name: str) -> None:
        """Integrator from now on."""
        definition = ffi.new("thrum_state_def *")
        set_choice(definition, "integrator", name)
        self.scene._call(lib.thrum_scene_set_integrator, self.number, definition.integrator)


class Scene:
    """Bodies in one world with one time step dt [s]. Threads may use it in turn: each call waits for the one before.

    It keeps the models of its bodies alive.
    """

    def __init__(self, dt: float = 0.003, gravity: Any = None) -> None:
        self._lock = threading.Lock()
        self._kept: list[object] = []
        place = ffi.new("thrum_scene **")
        call(lib.thrum_scene_create, float(dt), place)
        self._scene: Any = ffi.gc(place[0], lib.thrum_scene_destroy)
        self.bodies: list[Body] = []
        self.links: list[Link] = []
        if gravity is not None:
            self.gravity = gravity

    def __repr__(self) -> str:
        if self._scene is None:
            return "<thrum.Scene closed>"
        return f"<thrum.Scene bodies={len(self.bodies)} links={len(self.links)} steps={self.steps} time={self.time:.6g} s>"

    def close(self) -> None:
        """Frees the scene with all its bodies: later calls raise ValueError."""
        with self._lock:
            if self._scene is not None:
                ffi.release(self._scene)
                self._scene = None
                self._kept.clear()

    def __enter__(self) -> Scene:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.close()

    def _open(self) -> Any:
        if self._scene is None:
            raise ValueError("the scene was closed")
        return self._scene

    def _call(self, function: Any, *arguments: Any) -> int:
        with self._lock:
            return call(function, self._open(), *arguments)

    # --- building --------------------------------------------------------------------------------

    def add_body(self, model: Model, name: str | None = None, *, touch: Any = None, q: Any = None, p: Any = None,
                 integrator: str = "energy", state: dict[str, Any] | None = None,
                 **options: Unpack[BodyOptions]) -> Body:
        """Adds a body.

        triangles: its outer triangles (m x 3), for wind and contact; touch: 0-based vertices that may touch obstacles,
        or "all" of the triangles. state: the other options of `State`. All options are fields of thrum_scene_body_def
        (thrum/fields.h), such as position, rotation (quaternion w, x, y, z), free, velocity and spin.
        """
        handle = model._handle()
        made = Def("body", dict(options), model.vertex_count)
        made.c.model = model._c
        made.c.state = state_def({"integrator": integrator, **(state or {})})[0]
        if name is not None:
            text = ffi.new("char[]", name.encode())
            made.kept.append(text)
            made.c.name = text
        if isinstance(touch, str):
            if "triangles" not in options:
                raise ValueError("touch: without triangles it is a list of vertices")
            touch = np.unique(np.asarray(options["triangles"]))
        made.set("touch", touch, model.vertex_count)
        for key, value in (("q", q), ("p", p)):
            if value is not None:
                numbers = _native.doubles(value, (model.shown,), key)
                made.kept.append(numbers)
                setattr(made.c, key, _native.pointer(numbers))

        number = ffi.new("int32_t *")
        self._call(lib.thrum_scene_add_body, made.c, number)
        self._kept.append(handle)
        body = Body(self, number[0], model)
        self.bodies.append(body)
        return body

    def find(self, name: str) -> Body:
        """The first body of this name; KeyError where there is none."""
        with self._lock:
            number = int(lib.thrum_scene_find_body(self._open(), name.encode()))
        if number < 0:
            raise KeyError(f"the scene has no body {name!r}")
        return self.bodies[number]

    @property
    def gravity(self) -> Array:
        """Gravity [m/s^2] for all bodies; a read-only copy. Assign to set it."""
        found = np.empty(3)
        with self._lock:
            lib.thrum_scene_gravity(self._open(), _native.pointer(found))
        return _native.read_only(found)

    @gravity.setter
    def gravity(self, value: Any) -> None:
        self._call(lib.thrum_scene_set_gravity, _vector(value, "gravity"))

    def set_eye(self, place: Any) -> None:
        """Place that distances of bodies with a level of detail are from, such as the camera [m]."""
        self._call(lib.thrum_scene_set_eye, _vector(place, "eye"))

    def update_detail(self) -> None:
        """Looks at all bodies with a level of detail; call it every few steps."""
        self._call(lib.thrum_scene_update_detail)

    def set_wind(self, velocity: Any, **options: Unpack[WindOptions]) -> None:
        """Wind on the triangles of all bodies: its velocity [m/s], and fields of thrum_scene_wind_def (thrum/fields.h)."""
        self._call(lib.thrum_scene_set_wind, Def("wind", {"velocity": velocity, **options}).c)

    def add_obstacle(self, obstacle: Obstacle) -> int:
        """Adds an obstacle, which moves with its velocity, and returns its number."""
        number = ffi.new("int32_t *")
        self._call(lib.thrum_scene_add_obstacle, obstacle._def.c, number)
        return int(number[0])

    def add_solid(self, **options: Unpack[SolidOptions]) -> int:
        """Adds an obstacle that bodies with triangles touch by its faces, and returns its number, apart from `add_obstacle`'s.

        shape: "mesh" (vertices, triangles), "box" (half), "cylinder" or "capsule" (radius, height) or "height_field"
        (heights, spacing); the options are fields of thrum_scene_solid_def (thrum/fields.h).
        """
        number = ffi.new("int32_t *")
        made = Def("solid", dict(options))
        self._call(lib.thrum_scene_add_solid, made.c, number)
        return int(number[0])

    def obstacle(self, number: int) -> Obstacle:
        """An obstacle where it is now."""
        found = Obstacle()
        self._call(lib.thrum_scene_obstacle_get, number, found._def.c)
        return found

    def set_obstacle(self, number: int, obstacle: Obstacle) -> None:
        """Changes an obstacle from now on."""
        self._call(lib.thrum_scene_set_obstacle, number, obstacle._def.c)

    def add_link(self, kind: str, body: Body, *, group: str | None = None, other: Body | None = None,
                 other_group: str | None = None, **options: Unpack[LinkOptions]) -> Link:
        """Links two bodies, or a body and the world, as they are now; see thrum_scene_link_def and docs/links.md.

        kind: "spring", "ball", "hinge" or "weld". place [m], in the world now: of the body, weighed over its vertices
        near it, or over `vertices` (0-based) or a `group` where they are given; without a place it is their mean, or that
        of the whole body. other: the second body, or None for the world. A spring's other end is at other_place, else at the
        mean of other_vertices or other_group, else at the place; a joint has one place. The options are fields of
        thrum_scene_link_def (thrum/fields.h).
        """
        made = Def("link", {"kind": kind})
        made.c.body, made.c.other = self._own(body), -1 if other is None else self._own(other)
        given: dict[str, Any] = dict(options)
        for key, of, named in (("vertices", body, group), ("other_vertices", other, other_group)):
            chosen = _chosen(key, of, given.pop(key, None), named)
            if of is not None:
                made.set(key, chosen, of.model.vertex_count)
        if (given.get("path_times") is None) != (given.get("path_places") is None):
            raise ValueError("path_times and path_places come together")
        for key, value in given.items():
            made.set(key, value)

        number = ffi.new("int32_t *")
        self._call(lib.thrum_scene_add_link, made.c, number)
        self.links.append(Link(self, number[0]))
        return self.links[-1]

    def _own(self, body: Body) -> int:
        if body.scene is not self:
            raise ValueError("a link is of bodies of its own scene")
        return body.number

    def set_collisions(self, on: bool = True, **options: Unpack[PairsOptions]) -> None:
        """Makes all bodies with triangles touch each other from now on, or with on=False pass through each other.

        The options are fields of thrum_contact_pairs_def (thrum/fields.h), such as thickness [m], friction and
        restitution. Condensed bodies do not touch others.
        """
        made = Def("contact between bodies", dict(options))
        self._call(lib.thrum_scene_set_collisions, made.c if on else ffi.NULL)

    @property
    def collisions(self) -> dict[str, float]:
        """Counters and energies of contact between the bodies, by the names of thrum_contact_pairs_report."""
        with self._lock:
            report = lib.thrum_scene_collisions(self._open())
        return {name: getattr(report, name) for name, _ in ffi.typeof("thrum_contact_pairs_report").fields}

    @property
    def touches(self) -> list[Touch]:
        """Where bodies touched each other in the last step, and behind those where they struck each other."""
        found, touch = [], ffi.new("thrum_pair_touch *")
        collisions = self.collisions
        for index in range(int(collisions["touching"] + collisions["struck"])):
            self._call(lib.thrum_scene_collision_get, index, touch)
            things = [lib.thrum_scene_thing_of(number) for number in touch.bodies]
            first, second = (self.bodies[thing.number] if thing.kind == lib.THRUM_SCENE_BODY else thing.number for thing in things)
            position, force, normal, impulse = (_native.read_only(np.array(list(getattr(touch, name))))
                                                for name in ("position", "force", "normal", "impulse"))
            found.append(Touch((first, second), position, force, normal, touch.distance, impulse))
        return found

    def find_overlap(self) -> Overlap | None:
        """The body that lies deepest, for its size, inside an obstacle or another body; look before the first step."""
        found = ffi.new("thrum_scene_overlap *")
        self._call(lib.thrum_scene_find_overlap, found)
        if found.body < 0:
            return None
        return Overlap(self.bodies[found.body], self.bodies[found.other] if found.other >= 0 else None,
                       int(found.obstacle) if found.obstacle >= 0 else None, found.depth)

    @property
    def account(self) -> dict[str, Any]:
        """Energies [J] and momenta of all bodies together, by the names of thrum_scene_account."""
        found = ffi.new("thrum_scene_account *")
        self._call(lib.thrum_scene_account_get, found)
        return {name: _native.read_only(np.array(list(getattr(found, name)))) if "momentum" in name else getattr(found, name)
                for name, _ in ffi.typeof("thrum_scene_account").fields}

    def add_base_motion(self, times: Any, accelerations: Any) -> None:
        """Moves the ground under all bodies: accelerations (k x 3) [m/s^2] at `times` (k) [s], linear between them."""
        when = _native.doubles(times, (None,), "times")
        pushed = _native.doubles(accelerations, (len(when), 3), "accelerations")
        velocities, positions = np.empty_like(pushed), np.empty_like(pushed)
        motion = ffi.new("thrum_base_motion *", {
            "count": len(when), "times": _native.pointer(when), "accelerations": _native.pointer(pushed)})
        call(lib.thrum_base_motion_check, motion)
        lib.thrum_base_motion_integrate(len(when), motion.times, motion.accelerations, _native.pointer(velocities),
                                        _native.pointer(positions))
        motion.velocities, motion.positions = _native.pointer(velocities), _native.pointer(positions)
        self._call(lib.thrum_scene_add_base_motion_record, motion)
        # the scene reads them in every step
        self._kept.append((motion, when, pushed, velocities, positions))

    # --- stepping --------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """Time of the scene [s]."""
        with self._lock:
            return float(lib.thrum_scene_time(self._open()))

    @property
    def steps(self) -> int:
        """Steps that were completed."""
        with self._lock:
            return int(lib.thrum_scene_steps(self._open()))

    @property
    def dt(self) -> float:
        """Time step [s]; assign to change it between two steps."""
        with self._lock:
            return float(lib.thrum_scene_dt(self._open()))

    @dt.setter
    def dt(self, value: float) -> None:
        self._call(lib.thrum_scene_set_dt, float(value))

    def step(self, count: int = 1) -> Status:
        """Makes `count` steps of every body that has not stopped; the most notable status.

        A body whose step fails stops, keeps its last state, and the call raises after that step; the others have
        made it too. Its `status` says why it stopped, and further steps go on without it.
        """
        if count < 0:
            raise ValueError(f"count: {count} steps")
        worst = 0
        with self._lock:
            scene, error = self._open(), _native.new_error()
            for _ in range(count):
                status = _native.check(lib.thrum_scene_step(scene, error), error)
                worst = status if status > 0 and (worst == 0 or status < worst) else worst
        return Status(worst)

    def reset(self) -> None:
        """Everything back to its start; bodies that stopped start again."""
        self._call(lib.thrum_scene_reset)

    def snapshot(self) -> bytes:
        """Everything that steps change, for `restore`."""
        with self._lock:
            data = bytearray(lib.thrum_scene_snapshot_size(self._open()))
            call(lib.thrum_scene_snapshot, self._scene, ffi.from_buffer(data), len(data))
        return bytes(data)

    def restore(self, snapshot: bytes) -> None:
        """Back to a snapshot of this scene, or of one that was built in the same way."""
        self._call(lib.thrum_scene_restore, ffi.from_buffer(snapshot), len(snapshot))


def _vector(value: Any, name: str) -> Any:
    return ffi.new("double[3]", _native.doubles(value, (3,), name).tolist())


def _chosen(name: str, body: Body | None, vertices: Any, group: str | None) -> Any:
    """The vertices of a side of a link; None where there is no list."""
    if vertices is not None and group is not None:
        raise ValueError(f"{name}: a list or a group, not both")
    if body is None and (vertices is not None or group is not None):
        raise ValueError(f"{name}: the world has none")
    return body.model.group(group) if body is not None and group is not None else vertices


def _load_def(load: Load, model: Model) -> Def:
    """The def of a load on a body of a model."""
    given = [name for name in ("force", "field", "acceleration") if getattr(load, name) is not None]
    if len(given) != 1:
        raise ValueError("a load is one of force, field and acceleration")
    options: dict[str, Any] = dict(load.options)
    if load.ramp and options.get("frequency") is not None:
        raise ValueError("a load is a ramp or a sine, not both")
    if load.field is not None:
        options["field"] = _native.doubles(load.field, (model.vertex_count, 3), "field")
    else:
        options["vector"] = _native.doubles(getattr(load, given[0]), (3,), given[0])
    if load.ramp or options.get("frequency") is not None:
        options.setdefault("shape", "ramp" if load.ramp else "sine")

    # the row is called as in C, where "from" is no word of the language
    options["from"] = options.pop("start", None)
    options["vertices"] = model.group(load.group) if load.group is not None else load.vertices
    return Def("load", {"kind": given[0], **options}, model.vertex_count)
