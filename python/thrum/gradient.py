"""Gradients of runs (thrum/gradient.h): how a loss changes with start, forces, damping and material.

SPDX-License-Identifier: Apache-2.0
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _native
from ._native import Array, call, ffi, lib
from .model import Model

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .scene import Obstacle
    from .state import StateOptions

# what a loss returns: its value, and its derivatives by q and p after each step; None: it does not depend on them
Loss = Callable[[Array, Array], "tuple[float, Any, Any]"]


@dataclass(frozen=True)
class Gradient:
    """Derivatives of a loss by what a run depends on; thrum_tape_gradient says what each is."""

    q: Array  # by the start, r
    p: Array  # r
    force: Array  # by the force of each step, steps x model.shown
    damping: Array  # by the damping of each coordinate [1/s], r: 2 omega times that is the one by the ratio of a linear mode
    alpha: float  # by damping_alpha
    beta: float  # by damping_beta
    stiffness: float  # by a factor of Young's modulus
    density: float  # by a factor of the density
    # by `Model.parameters`, regions x 3, with displacements, velocities and forces held; None: not asked for
    parameters: Array | None = None
    actuation: Array | None = None  # by the level of each actuator in each step, steps x model.actuators; None: there are none
    springs: Array | None = None  # by the stiffness of each spring that was asked for [N/m], at what it was stepped with


@dataclass(frozen=True)
class Touching:
    """What a body that is held touches in a run that is differentiated: planes and boxes, by its vertices or some of them.

    Springs that push and what slides are smooth. Impacts, rest and stick are not: `pull_back` refuses a step with one and names
    its time, vertex and obstacle, or with subgradient="fixed" takes each touch to keep its law.
    """

    obstacles: Sequence[Obstacle]  # the stiffness of each, or `stiffness`, is a pressure per depth [N/m^3]
    vertices: Any = None  # that may touch: a group or numbers; None: all
    areas: Any = None  # of the surface that each stands for [m^2]; None: shares of the box of all of them
    stiffness: float = 0.0  # of obstacles without their own; 0: of the body as in its file
    subgradient: str | None = None
    room: int | None = None  # for touches in each step, where one that sticks takes 3; None: for all that may touch


class Rollout:
    """A run that was recorded: q and p after each step, and derivatives. `thrum.rollout` makes it."""

    def __init__(self, model: Model, steps: int, q: Any, p: Any, force: Any, stiffness: float, density: float,
                 options: dict[str, Any], actuation: Any = None, touching: Touching | None = None,
                 before: Rollout | None = None, checkpoints: int = 0, every: int = 1) -> None:
        if every < 1 or checkpoints < 0 or (checkpoints > 0 and touching is not None):
            raise ValueError(f"checkpoints {checkpoints}, every {every}: 0 or more without what touches, and 1 or more")
        if steps < 1:
            raise ValueError(f"steps: {steps} steps; a run has one or more")
        rank = model.rank
        start = [None if value is None else _native.doubles(value, (rank,), name) for value, name in ((q, "q"), (p, "p"))]
        forces = None if force is None else _native.doubles(force, (steps, model.shown), "force")
        # coordinates stay: a factor of the density divides stiffness and forces
        self.model, self.steps, self.every = model, steps, every
        self._factors = (float(stiffness), float(density))
        self._stepped = model.scale(stiffness=self._ratio()) if self._ratio() != 1.0 else model
        self._forces = forces if forces is None or density == 1.0 else forces / self._factors[1]
        self._held = self._factors_of_levels()
        levels = None if actuation is None else np.ascontiguousarray(self._levels(actuation, steps) * self._held)
        self._handle = self._stepped._handle()
        self._c_model = self._stepped._c
        self._parts: Any = None
        self._springs: list[Array] = []

        # the tape, and a state that is only needed to record it
        definition, place = ffi.new("thrum_tape_def *"), ffi.new("thrum_tape **")
        lib.thrum_tape_def_init(definition, ffi.sizeof("thrum_tape_def"))
        definition.steps, definition.checkpoints, definition.every = steps, checkpoints, every
        self._seen: tuple[Array, Array] | None = None
        self._rows = steps // every + 1
        if touching is not None:
            if touching.subgradient not in (None, "fixed"):
                raise ValueError(f'subgradient: {touching.subgradient!r} is neither None nor "fixed"')
            # pages that no touch comes to are never made
            count = self.model.vertex_count if touching.vertices is None else len(self._chosen(touching.vertices))
            definition.touches = steps * (3 * count if touching.room is None else touching.room)
            definition.subgradient = int(touching.subgradient is not None)
        # a run that Ctrl-C has left goes on in the state, so it is not closed here: it ends with what refers to it
        state = self._stepped.state(**options)
        definition.state = state._state
        if before is None:
            call(lib.thrum_tape_create, self._c_model, definition, place)
            self._tape = ffi.gc(place[0], lib.thrum_tape_destroy, 24 * rank * steps)
        else:
            # of a run that nobody reads any more, with pages that are there
            self._tape = before._tape
        call(lib.thrum_tape_start, self._c_model, self._tape, state._state, *map(_native.pointer, start))
        if touching is not None:
            if levels is not None:
                raise ValueError("actuation: a run that touches has no levels")
            self._touch(touching, state._state, steps, float(options.get("dt", 0.003)))
        elif checkpoints > 0:
            self._see(state, levels, every)
        else:
            _native.call_interruptible((state, self._tape, self._forces, levels), lib.thrum_tape_run_levels, self._c_model,
                                       self._tape, state._state, _native.pointer(self._forces), _native.pointer(levels),
                                       steps, ffi.NULL)
        self.dt = float(options.get("dt", 0.003))

    def _ratio(self) -> float:
        stiffness, density = self._factors
        if not (stiffness > 0.0 and density > 0.0):
            raise ValueError(f"stiffness {stiffness} and density {density} are factors above 0")
        return stiffness / density

    def _chosen(self, vertices: Any) -> Any:
        """Numbers of vertices, or of those of a group."""
        return np.ascontiguousarray(self.model.group(vertices) if isinstance(vertices, str) else vertices, dtype=np.int32).ravel()

    def _touch(self, touching: Touching, state: Any, steps: int, dt: float) -> None:
        """Makes the steps with contact, solved as far as numbers go."""
        definition, size = ffi.new("thrum_contact_def *"), ffi.new("size_t *")
        lib.thrum_contact_def_init(definition, ffi.sizeof("thrum_contact_def"))
        definition.tolerance, definition.sweeps_max, definition.stiffness = 1e-13, 1000, touching.stiffness
        chosen = touching.vertices
        if chosen is not None:
            at = self._chosen(chosen)
            definition.vertices, definition.vertex_count = _native.pointer(at, "int32_t"), at.size
        areas = None if touching.areas is None else _native.doubles(touching.areas, (self.model.vertex_count if chosen is None else at.size,),
                                                                        "areas")
        definition.areas = _native.pointer(areas)
        call(lib.thrum_contact_size, self._c_model, state, definition, size)
        memory, place = _native.AlignedBlock(size[0]), ffi.new("thrum_contact **")
        call(lib.thrum_contact_init, memory.place, size[0], self._c_model, state, definition, place)

        # obstacles that move are the caller's, as they are in C; in coordinates that stay what they push is divided by the
        # density, and that of the body is as in its file
        around = ffi.new("thrum_contact_environment *")
        obstacles = ffi.new("thrum_obstacle[]", len(touching.obstacles))
        own = touching.stiffness or lib.thrum_contact_stiffness(place[0]) / self._ratio()
        for n, obstacle in enumerate(touching.obstacles):
            obstacles[n] = obstacle._def.c[0]
            obstacles[n].stiffness = (obstacles[n].stiffness or own) / self._factors[1]
            obstacles[n].damping /= self._factors[1]
        around.obstacles, around.obstacle_count = obstacles, len(touching.obstacles)
        for k in range(steps):
            around.load = ffi.NULL if self._forces is None else _native.pointer(self._forces[k])
            call(lib.thrum_tape_contact_step, self._c_model, self._tape, state, place[0], around)
            for obstacle in obstacles:
                for axis in range(3):
                    obstacle.centre[axis] += dt * obstacle.velocity[axis]

    def _factors_of_levels(self) -> Array:
        """What the levels are multiplied by in coordinates that stay: what acts is divided by the density, as forces are."""
        kinds = _native.view(self.model._c.actuator_kind, (len(self.model.actuators),), "<i4", self.model)
        if kinds is None:
            return np.ones(0)
        if self._factors[1] != 1.0 and lib.THRUM_ACTUATOR_GAS in kinds:
            raise ValueError("density: a body with a gas has no factor of its density, as the pressure outside stays")
        return np.where(kinds == lib.THRUM_ACTUATOR_STRAIN, 1.0, 1.0 / self._factors[1])

    def _levels(self, value: Any, steps: int) -> Array:
        """Levels of each step, steps x actuators, from names and levels, each a number or steps of them, or all in order."""
        names = self.model.actuators
        if not isinstance(value, dict):
            return _native.doubles(value, (steps, len(names)), "actuation")
        rows = np.zeros((steps, len(names)))
        for name, levels in value.items():
            if name not in names:
                raise KeyError(f"no actuator {name!r}; the model has {', '.join(names) or 'none'}")
            rows[:, names.index(name)] = levels
        return rows

    def __repr__(self) -> str:
        return f"<thrum.Rollout steps={self.steps} dt={self.dt:g} s rank={self.model.rank}>"

    def _see(self, state: Any, levels: Array | None, every: int) -> None:
        """Makes the steps of a tape that keeps no rows, and keeps those that are asked for."""
        q, p = np.empty((self._rows, self.model.rank)), np.empty((self._rows, self.model.rank))
        for first in range(0, self.steps + 1, every):
            q[first // every], p[first // every] = state.get()
            count = min(every, self.steps - first)
            rows = [None if given is None else given[first:first + count] for given in (self._forces, levels)]
            _native.call_interruptible((state, self._tape, *rows), lib.thrum_tape_run_levels, self._c_model, self._tape,
                                       state._state, *map(_native.pointer, rows), count, ffi.NULL)
        self._seen = _native.read_only(q), _native.read_only(p)

    def _points(self, place: Any) -> Array:
        found = _native.view(place, (self.steps + 1, self.model.rank), "<f8", self)
        assert found is not None
        return found[::self.every]

    @property
    def q(self) -> Array:
        """q after each step, or each `every` of them, the start first, (steps / every + 1) x r; read-only."""
        return self._seen[0] if self._seen else self._points(lib.thrum_tape_q(self._tape))

    @property
    def p(self) -> Array:
        """p after each step, likewise."""
        return self._seen[1] if self._seen else self._points(lib.thrum_tape_p(self._tape))

    @property
    def times(self) -> Array:
        """Times of these rows [s]."""
        return self.dt * self.every * np.arange(self._rows)

    def pull_back(self, q_bar: Any = None, p_bar: Any = None, *, parameters: bool = False,
                  springs: Sequence[Any] = ()) -> Gradient:
        """The gradient of a loss from its derivatives by q and p, (steps + 1) x r each; None: it does not depend on them.

        parameters: by `Model.parameters` as well, of a run without factors of stiffness and density. springs: by the
            stiffness of springs to the ground as well, of which each is (vertices, direction): the mean of these vertices, or of
            the group of that name, is held along a unit vector, or for None in all directions. Unsupported where a step was
            divided by a fallback level. Costs about two more runs. One thread at a time.
        """
        shape, rank = (self._rows, self.model.rank), self.model.rank
        bars = [None if value is None else _native.doubles(value, shape, name)
                for value, name in ((q_bar, "q_bar"), (p_bar, "p_bar"))]
        q, p, damping, force = np.empty(rank), np.empty(rank), np.empty(rank), np.empty((self.steps, self.model.shown))
        levels = np.empty((self.steps, self._held.size)) if self._held.size else None
        found = ffi.new("thrum_tape_gradient *", {"q": _native.pointer(q), "p": _native.pointer(p),
                                                  "force": _native.pointer(force), "damping": _native.pointer(damping),
                                                  "levels": _native.pointer(levels)})
        held = self._parts_of(parameters, springs)
        values = np.empty(len(held))
        found.parts, found.part, found.part_count = held, _native.pointer(values), len(held)
        call(lib.thrum_tape_pull_back, self._c_model, self._tape, *map(_native.pointer, bars), found)
        stiffness, density = self._factors
        # the library's are by factors of what was stepped
        return Gradient(q, p, force / density, damping, found.alpha, found.beta, found.stiffness / stiffness,
                        found.density / density, values[:len(values) - len(springs)].reshape(-1, 3) if parameters else None,
                        None if levels is None else levels * self._held, values[len(values) - len(springs):] / density if springs else None)

    def _parts_of(self, parameters: bool, springs: Sequence[Any]) -> Any:
        """The parts of the energy that are asked for, those of the parameters first."""
        count = 0
        if parameters and self._parts is None:
            place = ffi.new("thrum_parameter_parts **")
            call(lib.thrum_parameter_parts_create, self._c_model, place)
            self._parts = ffi.gc(place[0], lib.thrum_parameter_parts_destroy)
        if parameters:
            count = lib.thrum_parameter_parts_count(self._parts)
        held = ffi.new("thrum_energy_part[]", count + len(springs))
        for n in range(count):
            held[n] = lib.thrum_parameter_parts_list(self._parts)[n]
        self._springs = [self._spring(*spring) for spring in springs]
        for n, linear in enumerate(self._springs):
            held[count + n].linear = _native.pointer(linear)
        return held

    def _spring(self, vertices: Any, direction: Any) -> Array:
        """L of a spring of 1 N/m."""
        chosen = self.model.group(vertices) if isinstance(vertices, str) else vertices
        at = np.ascontiguousarray(chosen, dtype=np.int32).ravel()
        along = None if direction is None else _native.doubles(direction, (3,), "direction")
        linear = np.empty((self.model.rank, self.model.rank))
        call(lib.thrum_spring_linear, self._c_model, _native.pointer(at, "int32_t"), at.size, _native.pointer(along),
             _native.pointer(linear))
        return linear

    def push_forward(self, q: Any = None, p: Any = None, force: Any = None, damping: Any = None, alpha: float = 0.0,
                     beta: float = 0.0, stiffness: float = 0.0, density: float = 0.0,
                     actuation: Any = None) -> tuple[Array, Array]:
        """The change of q and p, (steps + 1) x r each, with a change of what the run depends on, to first order."""
        rank = self.model.rank
        held = [None if value is None else _native.doubles(value, shape, name)
                for value, shape, name in ((q, (rank,), "q"), (p, (rank,), "p"), (force, (self.steps, self.model.shown), "force"),
                                           (damping, (rank,), "damping"))]
        by_stiffness, by_density = self._factors
        if held[2] is not None:
            held[2] = held[2] / by_density
        levels = None if actuation is None else np.ascontiguousarray(self._levels(actuation, self.steps) * self._held)
        direction = ffi.new("thrum_tape_gradient *", {
            **{name: _native.pointer(value) for name, value in zip(("q", "p", "force", "damping"), held)},
            "levels": _native.pointer(levels),
            "alpha": float(alpha), "beta": float(beta), "stiffness": float(stiffness) / by_stiffness,
            "density": float(density) / by_density})
        into = np.empty((self._rows, rank)), np.empty((self._rows, rank))
        call(lib.thrum_tape_push_forward, self._c_model, self._tape, direction, *map(_native.pointer, into))
        return into


def rollout(model: Model, steps: int, q: Any = None, p: Any = None, force: Any = None, *, actuation: Any = None,
            touching: Touching | None = None, stiffness: float = 1.0, density: float = 1.0, checkpoints: int = 0, every: int = 1,
            **options: Unpack[StateOptions]) -> Rollout:
    """Makes a run of `steps` steps that can be differentiated.

    q, p: the start (r; None: zero); force: the force of each step (steps x model.shown; None: none); actuation: levels of
    what acts on the body in each step, {"air": 2e4, "wire": a number for each step} or steps x model.actuators (None: zero);
    touching: what the body touches; every: q and p are seen after each so many steps; checkpoints: where above 0, the state is kept
    so often and the steps between are made again by a pass, at the cost of a run and with the same bits: with `every` a long run then
    takes little memory. stiffness, density: factors of Young's modulus and of the density of the whole body, in coordinates that stay, where muscles
    follow the modulus and pressures, tendons and gases do not. options: those of `Model.state`, with the integrators energy,
    newmark, midpoint and verlet. A tolerance of 1e-13 makes gradients agree with differences of runs; with the default they err
    by about 1e-5 of a step.
    """
    return Rollout(model, steps, q, p, force, stiffness, density, dict(options), actuation, touching, None, checkpoints, every)


def value_and_gradient(loss: Loss, model: Model, steps: int, q: Any = None, p: Any = None, force: Any = None, *,
                       actuation: Any = None, touching: Touching | None = None, stiffness: float = 1.0, density: float = 1.0,
                       parameters: bool = False, checkpoints: int = 0, every: int = 1,
                       **options: Unpack[StateOptions]) -> tuple[float, Gradient]:
    """The loss of a run and its gradient. loss(q, p) gets q and p after each step, or each
    `every`, (steps / every + 1) x r each, and returns its value and
    its derivatives by both (None: it does not depend on that one). parameters: as for `Rollout.pull_back`. All else is as for `rollout`."""
    run = rollout(model, steps, q, p, force, actuation=actuation, touching=touching, stiffness=stiffness, density=density,
                  checkpoints=checkpoints, every=every, **options)
    value, q_bar, p_bar = loss(run.q, run.p)
    return float(value), run.pull_back(q_bar, p_bar, parameters=parameters)


def hessian_product(loss: Loss, model: Model, steps: int, q: Any = None, p: Any = None, force: Any = None, *,
                    actuation: Any = None, touching: Touching | None = None,
                    along: dict[str, Any], step: float = 1e-4, **options: Unpack[StateOptions]) -> Gradient:
    """The change of the gradient of a loss along a direction: a product with the matrix of its second derivatives.

    along: the direction of some of q, p, force, actuation (steps x model.actuators), damping_alpha, damping_beta, stiffness and
    density, which are then given too or have their defaults. By the difference of two exact gradients, `step` of the direction to either side: about six runs, and
    1e-6 where a step is small beside what it changes and the tolerance of the run is 1e-13.
    """
    held: dict[str, Any] = {"q": q, "p": p, "force": force, "actuation": actuation, "touching": touching, **options}
    defaults: dict[str, Any] = {"q": np.zeros(model.rank), "p": np.zeros(model.rank), "force": np.zeros((steps, model.shown)),
                                "actuation": np.zeros((steps, len(model.actuators))), "damping_alpha": 0.0, "damping_beta": 0.0,
                                "stiffness": 1.0, "density": 1.0}
    found: list[Gradient] = []
    run: Rollout | None = None
    for side in (step, -step):
        moved = dict(held)
        for name, change in along.items():
            at = held.get(name)
            moved[name] = (defaults[name] if at is None else np.asarray(at)) + side * np.asarray(change)
        given = [moved.pop(name, default) for name, default in (("q", None), ("p", None), ("force", None), ("stiffness", 1.0),
                                                                ("density", 1.0), ("actuation", None), ("touching", None))]
        q, p, force, stiffness, density, actuation, touching = given
        run = Rollout(model, steps, q, p, force, stiffness, density, moved, actuation, touching, run)
        found.append(run.pull_back(*loss(run.q, run.p)[1:]))
    return Gradient(**{field.name: (getattr(found[0], field.name) - getattr(found[1], field.name)) / (2 * step)
                       for field in fields(Gradient) if getattr(found[0], field.name) is not None})
