"""The state of one body, and the steps that advance it (thrum/state.h).

SPDX-License-Identifier: Apache-2.0
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from time import perf_counter
from types import TracebackType
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np

from . import _native
from ._errors import Status
from ._native import Array, call, ffi, lib
from .model import Model

if TYPE_CHECKING:
    from typing_extensions import Unpack

# fields of the def that are chosen by name, and the name of their type
_TYPES = {
    "integrator": "integrator",
    "damping_form": "damping_form",
    "split_form": "split_form",
    "solver": "implicit_solver",
}
_SPLIT_RULES = {"cfl": 0, "sampling": 1, "count": 2}
_KERNELS = {"best": 0, "reference": 1, "avx2": 2, "avx512": 3, "neon": 4, "wasm": 5}
_NUMBERS = ("dt", "damping_alpha", "damping_beta", "split_safety", "newmark_beta", "newmark_gamma", "tolerance")
_WHOLE = ("explicit_count", "iterations_max")
_PLASTIC = ("plastic_yield", "plastic_creep", "plastic_largest")
_SWITCHES = ("adaptive", "fallback", "frequency_matched", "untrained_flow")


class StateOptions(TypedDict, total=False):
    """Options of a state beside integrator and dt; `State` says what each is."""

    damping_alpha: float
    damping_beta: float
    damping_form: str
    split_form: str
    split_rule: str
    split_safety: float
    explicit_count: int
    newmark_beta: float
    newmark_gamma: float
    tolerance: float
    iterations_max: int
    solver: str
    kernel: str
    adaptive: bool
    fallback: bool
    frequency_matched: bool
    untrained_flow: bool
    plastic_yield: float
    plastic_creep: float
    plastic_largest: float


def state_def(options: dict[str, Any]) -> Any:
    """A thrum_state_def with these fields; TypeError for one that it does not have."""
    definition = ffi.new("thrum_state_def *")
    lib.thrum_state_def_init(definition, ffi.sizeof("thrum_state_def"))
    for name, value in options.items():
        if name in _TYPES:
            set_choice(definition, name, value)
        elif name == "split_rule":
            definition.split_rule = _named(_SPLIT_RULES, name, value)
        elif name == "kernel":
            definition.kernel = _named(_KERNELS, name, value)
        elif name in _NUMBERS:
            setattr(definition, name, float(value))
        elif name in _PLASTIC:
            setattr(definition.plastic, name.removeprefix("plastic_"), float(value))
        elif name in _WHOLE:
            setattr(definition, name, value)
        elif name in _SWITCHES:
            setattr(definition, name, 1 if value else 0)
        elif name in ("damping_ratio", "damping_ratios"):
            raise TypeError("a state has no damping ratios: give damping_alpha, twice the ratio and the angular frequency "
                            "of the mode that swings; thrum.simulate takes damping_ratio")
        else:
            known = ", ".join([*_TYPES, "split_rule", "kernel", *_NUMBERS, *_PLASTIC, *_WHOLE, *_SWITCHES])
            raise TypeError(f"a state has no option {name!r}; it has: {known}")
    return definition


def set_choice(definition: Any, name: str, value: str) -> None:
    """Sets a field that is chosen by name; InvalidArgument lists the names."""
    place = ffi.new(f"thrum_{_TYPES[name]} *")
    call(getattr(lib, f"thrum_{_TYPES[name]}_from_name"), str(value).encode(), place)
    setattr(definition, name, place[0])


def _named(names: dict[str, int], field: str, value: str) -> int:
    if value not in names:
        raise ValueError(f"{field}: {value!r} is none of {', '.join(names)}")
    return names[value]


@dataclass(frozen=True)
class Energies:
    """Energies [J]; `high` is that of the modes implicit at rest, contained in `total`."""

    kinetic: float
    potential: float
    total: float
    high: float


@dataclass(frozen=True)
class Report:
    """Counters of a state since it was made; thrum_state_report in thrum/state.h says what each counts."""

    steps: int
    time: float
    iterations: int
    factorisations: int
    newton_steps: int
    energy_steps: int
    substep_steps: int
    switched_steps: int
    first_switch: int
    grown_steps: int
    split_changes: int
    scheme_switches: int
    corrections: int
    corrected: float
    single_steps: int
    tightened: int
    spurious: float
    stability_number_last: float
    stability_number_peak: float
    balance_last: float
    balance_peak: float
    dissipated: float
    plastic_work: float
    scheme: str
    explicit_modes: int
    implicit_modes: int
    iterations_last: int
    residual_last: float


def report_of(found: Any) -> Report:
    """A thrum_state_report as a value of Python."""
    fields = {name: getattr(found, name) for name in Report.__dataclass_fields__}
    fields["scheme"] = ffi.string(lib.thrum_scheme_name(found.scheme)).decode()
    return Report(**fields)


class State:
    """A body at a time: coordinates q [kg^1/2 m], momenta p [kg^1/2 m/s], a load, and how it is stepped.

    Options, with the defaults of the C library: integrator "energy", dt 0.003 [s], damping_alpha 0 [1/s],
    damping_beta 0 [s], damping_form "rest", split_rule "cfl", split_safety 0.5, explicit_count 0, newmark_beta 0.25,
    newmark_gamma 0.5, tolerance 0 (the integrator's own), iterations_max 50, split_form "position", adaptive True,
    fallback True, solver "quasi-newton", frequency_matched True, kernel "best". Plastic flow at the cubature points of a
    model of another law, by "energy": plastic_yield (a strain), plastic_creep [1/s] and plastic_largest (a strain), all
    infinite: no flow. Points that were not trained on flow are refused, but with untrained_flow True: strain and work of
    what flows may then be several times too small.

    A state keeps its model alive. Several threads may use it in turn: each call waits for the one before it. It is
    pickled with its model and continues with the same bits.
    """

    def __init__(self, model: Model, integrator: str = "energy", dt: float = 0.003, **options: Unpack[StateOptions]) -> None:
        self.model = model
        self._options: dict[str, Any] = {"integrator": integrator, "dt": dt, **options}
        self._lock = threading.Lock()
        self._model_handle = model._handle()
        self._c_model = model._c
        place = ffi.new("thrum_state **")
        call(lib.thrum_state_create, self._c_model, state_def(self._options), place)
        self._state: Any = ffi.gc(place[0], lib.thrum_state_destroy, lib.thrum_state_bytes(place[0]))
        self._force = np.zeros(model.rank)
        self._error = _native.new_error()

    # --- closing, copying, pickling --------------------------------------------------------------

    def close(self) -> None:
        """Frees the state: later calls raise ValueError."""
        with self._lock:
            if self._state is not None:
                ffi.release(self._state)
                self._state = None

    def __enter__(self) -> State:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.close()

    def _open(self) -> Any:
        if self._state is None:
            raise ValueError("the state was closed")
        return self._state

    def snapshot(self) -> bytes:
        """Everything that steps change, for `restore`: in this process, another one, or a file."""
        with self._lock:
            state = self._open()
            data = bytearray(lib.thrum_state_snapshot_size(state))
            call(lib.thrum_state_snapshot, state, ffi.from_buffer(data), len(data))
        return bytes(data)

    def restore(self, snapshot: bytes) -> None:
        """Puts the state to where the snapshot was taken; steps from there give the same bits."""
        with self._lock:
            call(lib.thrum_state_restore, self._c_model, self._open(), ffi.from_buffer(snapshot), len(snapshot))

    def copy(self) -> State:
        """A state of its own that continues from here with the same bits."""
        twin = State(self.model, **self._options)
        twin.restore(self.snapshot())
        twin._force[:] = self._force
        return twin

    def __reduce__(self) -> tuple[Any, ...]:
        return _state_from_parts, (self.model, self._options, self.snapshot(), self._force.copy())

    def __repr__(self) -> str:
        if self._state is None:
            return "<thrum.State closed>"
        report = self.report
        return f"<thrum.State {report.scheme} steps={report.steps} time={report.time:.6g} s>"

    # --- setting and stepping --------------------------------------------------------------------

    def set(self, q: Any = None, p: Any = None) -> None:
        """Sets q and p of the same time (r each; None: zero). The counters, the load and the time stay."""
        rank = len(self._force)
        new_q = None if q is None else _native.doubles(q, (rank,), "q")
        new_p = None if p is None else _native.doubles(p, (rank,), "p")
        with self._lock:
            call(lib.thrum_state_set, self._c_model, self._open(), _native.pointer(new_q), _native.pointer(new_p))

    def get(self, q: Array | None = None, p: Array | None = None) -> tuple[Array, Array]:
        """q and p of the same time (r each), into the arrays given, which are then returned."""
        rank = len(self._force)
        into_q = _native.output(q, (rank,), np.float64, "q")
        into_p = _native.output(p, (rank,), np.float64, "p")
        with self._lock:
            call(lib.thrum_state_get, self._c_model, self._open(), _native.pointer(into_q), _native.pointer(into_p))
        return into_q, into_p

    @property
    def q(self) -> Array:
        """Coordinates [kg^1/2 m], r; a copy, and read-only: `set` changes them."""
        return _native.read_only(self.get()[0])

    @property
    def p(self) -> Array:
        """Momenta, also velocities, [kg^1/2 m/s], r; a copy, and read-only: `set` changes them."""
        return _native.read_only(self.get()[1])

    @property
    def force(self) -> Array:
        """The load of the steps to come [kg^1/2 m/s^2], r; a read-only copy. Assign to set it, None for no load."""
        return _native.read_only(self._force.copy())

    @force.setter
    def force(self, value: Any) -> None:
        force = np.zeros(len(self._force)) if value is None else _native.doubles(value, self._force.shape, "force")
        with self._lock:
            call(lib.thrum_state_set_force, self._c_model, self._open(), _native.pointer(force))
            self._force[:] = force

    @property
    def actuation(self) -> dict[str, float]:
        """The levels of the model's actuators by their names; a copy. Assign names and levels, or all levels in order:
        those that are not named stay. None: all zero."""
        return self._actuators(lib.thrum_state_actuation)

    @actuation.setter
    def actuation(self, value: Any) -> None:
        levels = self.model._levels(value, self.actuation)
        with self._lock:
            call(lib.thrum_state_set_actuation, self._c_model, self._open(), _native.pointer(levels))

    @property
    def actuation_work(self) -> dict[str, float]:
        """What each actuator has done to the body since the state was made [J]."""
        return self._actuators(lib.thrum_state_actuation_work)

    @property
    def actuation_measures(self) -> dict[str, float]:
        """Volume of each chamber [m^3] and length of each tendon [m]; of a strain the work of one level since rest [J]."""
        return self._actuators(lib.thrum_state_actuation_measures)

    def _actuators(self, read: Any) -> dict[str, float]:
        names = self.model.actuators
        if not names:
            return {}
        numbers = np.zeros(len(names))
        with self._lock:
            call(read, self._c_model, self._open(), _native.pointer(numbers))
        return dict(zip(names, numbers.tolist()))

    def set_load(self, load: Any) -> None:
        """Sets `force` by the load on all `shown` coordinates, for the step to come.

        Of a condensed model, what acts on the coordinates that follow acts on the others as they follow in the middle of
        the step, which the state extrapolates: set it before each step.
        """
        pushed = _native.doubles(load, (self.model.shown,), "load")
        with self._lock:
            state, force = self._open(), np.empty(len(self._force))
            call(lib.thrum_state_reduce_load, self._c_model, state, _native.pointer(pushed), _native.pointer(force))
            call(lib.thrum_state_set_force, self._c_model, state, _native.pointer(force))
            self._force[:] = force

    def clear_plastic(self) -> None:
        """Puts the material to where nothing has flowed; q and p stay."""
        with self._lock:
            call(lib.thrum_state_clear_plastic, self._c_model, self._open())

    def set_dt(self, dt: float) -> None:
        """Changes the time step [s] between two steps, as often as wanted."""
        with self._lock:
            call(lib.thrum_state_set_dt, self._c_model, self._open(), float(dt))

    def step(self, count: int = 1) -> Status:
        """Makes `count` steps and returns the most notable status among them (thrum_steps in thrum/state.h).

        NotConverged where a step has no solution: the steps before it were made (`report.steps` counts them), and the
        state is that of the last one. The interpreter lock is released while it steps, and Ctrl-C ends it between two
        steps.
        """
        with self._lock:
            if self._state is None:
                raise ValueError("the state was closed")
            error, worst, piece = self._error, 0, 1

            # pieces of some hundredths of a second, between which signals are handled; they have the bits of one call
            while True:
                made = count if count < piece else piece
                began = perf_counter() if count > 1 else 0.0
                status = lib.thrum_steps(self._c_model, self._state, made, ffi.NULL, error)
                if status != 0:
                    _native.check(status, error)
                    worst = status if worst == 0 or status < worst else worst
                count -= made
                if count <= 0:
                    return Status(worst)
                took = perf_counter() - began
                piece = 2 * piece if took < 0.01 else max(piece // 2, 1) if took > 0.04 else piece

    # --- what it says of itself ------------------------------------------------------------------

    @property
    def plastic_strain(self) -> float:
        """The largest plastic strain of all points; 0 where nothing has flowed."""
        with self._lock:
            return float(lib.thrum_state_plastic_strain(self._open()))

    @property
    def point_stiffness(self) -> float:
        """The largest stiffness of the points over that of the body; 0 where nothing can flow."""
        with self._lock:
            return float(lib.thrum_state_point_stiffness(self._open()))

    @property
    def energies(self) -> Energies:
        """Energies of q and p [J]."""
        found = ffi.new("thrum_energies *")
        with self._lock:
            call(lib.thrum_state_energies, self._c_model, self._open(), found)
        return Energies(found.kinetic, found.potential, found.total, found.high)

    @property
    def report(self) -> Report:
        """Counters since the state was made, and how it stands."""
        with self._lock:
            return report_of(lib.thrum_state_report_get(self._open()))

    @property
    def time(self) -> float:
        """Time that the steps took together [s]."""
        return self.report.time

    @property
    def stepped_frequencies(self) -> Array:
        """Frequency of each mode as it is stepped [Hz], r; NaN beyond its limit of stability."""
        modes = ffi.new("thrum_stepped_mode[]", len(self._force))
        with self._lock:
            call(lib.thrum_state_stepped_modes, self._c_model, self._open(), modes)
        return _native.read_only(np.array([mode.stepped_hertz for mode in modes]))


def _state_from_parts(model: Model, options: dict[str, Any], snapshot: bytes, force: Array) -> State:
    state = State(model, **options)
    state.restore(snapshot)
    state._force[:] = force
    return state
