"""Many states of one model that are stepped together (thrum/batch.h).

SPDX-License-Identifier: Apache-2.0
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _native
from ._errors import BadValue, ModelMismatch, Status
from ._native import AlignedBlock, Array, call, ffi, lib
from .model import Model
from .state import State

# no status: it stands where a call ended before it looked at a state
_UNTOUCHED = 1000
_ENERGIES = np.dtype([(name, np.float64) for name in ("kinetic", "potential", "total", "high")])


class _Range:
    """States that one thread steps, with a workspace of their own."""

    def __init__(self, batch: Batch, first: int, end: int) -> None:
        self.first, self.end = first, end
        self.model = batch._c_model
        self.places = batch._places + first
        self.statuses = batch._statuses[first:end]
        self.status_place = _native.pointer(self.statuses, "thrum_status")
        size = ffi.new("size_t *")
        call(lib.thrum_batch_size, self.model, size)
        self.workspace = AlignedBlock(size[0])

    def step(self, count: int) -> None:
        error = _native.new_error()
        for _ in range(count):
            self.statuses[:] = _UNTOUCHED
            status = lib.thrum_batch_step(self.model, self.places, self.end - self.first, self.status_place,
                                          self.workspace.place, self.workspace.size, error)
            if status < 0 and (self.statuses == _UNTOUCHED).any():
                _native.check(status, error)

    def rollout(self, forces: Array, levels: Array | None, q: Array, statuses: npt.NDArray[np.int32]) -> None:
        steps, rank = q.shape[1:]
        for n in range(steps):
            if levels is not None:
                call(lib.thrum_batch_set_actuation, self.model, self.places, self.end - self.first,
                     _native.pointer(levels[self.first:self.end, n]), steps * levels.shape[2])
            call(lib.thrum_batch_set_forces, self.model, self.places, self.end - self.first,
                 _native.pointer(forces[self.first:self.end, n]), steps * rank)
            self.step(1)
            statuses[self.first:self.end, n] = self.statuses
            call(lib.thrum_batch_get, self.model, self.places, self.end - self.first,
                 _native.pointer(q[self.first:self.end, n]), ffi.NULL, steps * rank)


class Batch:
    """States of one model that are stepped side by side, so that the model's numbers are read once for several.

    Each state ends with the same bits as by `State.step`. A state may be listed once. Threads: one batch belongs to
    one thread at a time; give each thread a batch of its own, they share the model.
    """

    def __init__(self, model: Model, states: Sequence[State], threads: int = 1) -> None:
        if threads < 1:
            raise ValueError(f"threads: {threads}; it is 1 or more")
        if len({id(state) for state in states}) != len(states):
            raise ValueError("a state is listed twice in the batch")
        for number, state in enumerate(states):
            if not isinstance(state, State):
                raise TypeError(f"state {number} of the batch is a {type(state).__name__}")
            if state._c_model.identity != model._c.identity or state._c_model.rank != model.rank:
                raise ModelMismatch(f"state {number} of the batch belongs to another model", Status.MODEL_MISMATCH)
        self.model = model
        self.states = list(states)
        self._model_handle = model._handle()
        self._c_model = model._c
        self._statuses = np.zeros(len(states), np.int32)
        self._places = ffi.new("thrum_state *[]", [state._open() for state in states])
        # in one order for all threads, so that two batches with common states cannot wait for each other
        self._in_order = sorted(states, key=id)
        self.threads = min(threads, len(states)) or 1
        ends = [len(states) * k // self.threads for k in range(self.threads + 1)]
        self._ranges = [_Range(self, first, end) for first, end in zip(ends, ends[1:])]

    def __len__(self) -> int:
        return len(self.states)

    def __repr__(self) -> str:
        return f"<thrum.Batch states={len(self.states)} rank={self.model.rank}>"

    def step(self, count: int = 1) -> npt.NDArray[np.int32]:
        """Makes `count` steps of every state; the statuses of the last one (`Status`), one for each state.

        A state whose step fails stays as it was while the others go on; its status is below 0. A failure of the call
        itself, such as a state of another model, raises before any step.
        """
        if count < 0:
            raise ValueError(f"count: {count} steps")
        with self._locked():
            self._each(lambda one: one.step(count))
            return self._statuses.copy()

    def rollout(self, q0: Any, forces: Any, p0: Any = None, actuation: Any = None) -> tuple[Array, npt.NDArray[np.int32]]:
        """Motions under forces that are known before: q (count x steps x r) and the statuses (count x steps).

        q0, p0: the starts, count x r, or r for all; None: zero. forces: count x steps x r, the loads of each step.
        actuation: count x steps x model.actuators, the levels of each step; None: those that the states have. A state whose
        step fails stays where it was in that step.
        """
        loads = _native.doubles(forces, (len(self), None, self.model.rank), "forces")
        self._check_loads(loads, "forces")
        levels = None if actuation is None else _native.doubles(
            actuation, (len(self), loads.shape[1], len(self.model.actuators)), "actuation")
        if levels is not None:
            self._check_loads(levels, "actuation")
        q, statuses = np.empty(loads.shape), np.zeros(loads.shape[:2], np.int32)
        self.set(q0, p0)
        with self._locked():
            self._each(lambda one: one.rollout(loads, levels, q, statuses))
            if loads.shape[1] > 0:
                self._keep_forces(loads[:, -1].copy())
        return q, statuses

    # --- arrays of all states ----------------------------------------------------------------------

    def set(self, q: Any = None, p: Any = None, where: Any = None) -> None:
        """Sets q and p of the same time (count x r, or r for all; None: zero), where the mask `where` (count) is true."""
        chosen = None if where is None else np.ascontiguousarray(where, dtype=np.uint8)
        if chosen is not None and (chosen.shape != (len(self),) or np.asarray(where).dtype != np.bool_):
            raise ValueError(f"where: {len(self)} truth values are needed")
        rows = [None if given is None else np.ascontiguousarray(self._rows(given, name)) for given, name in ((q, "q"), (p, "p"))]
        with self._locked():
            call(lib.thrum_batch_set, self._c_model, self._places, len(self), _native.pointer(chosen, "uint8_t"),
                 _native.pointer(rows[0]), _native.pointer(rows[1]), self.model.rank)

    def get(self, q: Array | None = None, p: Array | None = None) -> tuple[Array, Array]:
        """q and p of the same time (count x r), into the arrays given, which are then returned."""
        shape = (len(self), self.model.rank)
        into_q, into_p = _native.output(q, shape, np.float64, "q"), _native.output(p, shape, np.float64, "p")
        self._get(into_q, into_p)
        return into_q, into_p

    @property
    def q(self) -> Array:
        """q of every state, count x r; a copy, and read-only: `set` changes them."""
        return _native.read_only(self.coordinates())

    @property
    def p(self) -> Array:
        """p of every state, count x r; a copy, and read-only: `set` changes them."""
        p = np.empty((len(self), self.model.rank))
        self._get(None, p)
        return _native.read_only(p)

    @property
    def force(self) -> Array:
        """The loads of the steps to come, count x r; a read-only copy. Assign to set them, r for all, None for no load."""
        return _native.read_only(np.array([state._force for state in self.states]).reshape(len(self), self.model.rank))

    @force.setter
    def force(self, value: Any) -> None:
        rows = np.array(self._rows(0.0 if value is None else value, "force"), order="C")
        self._check_loads(rows, "force")
        with self._locked():
            call(lib.thrum_batch_set_forces, self._c_model, self._places, len(self), _native.pointer(rows), self.model.rank)
            self._keep_forces(rows)

    @property
    def actuation(self) -> Array:
        """The levels of the steps to come, count x model.actuators; a read-only copy. Assign to set them, a row for all."""
        levels = np.empty((len(self), len(self.model.actuators)))
        with self._locked():
            for number in range(len(self) if levels.size else 0):
                call(lib.thrum_state_actuation, self._c_model, self._places[number], _native.pointer(levels[number]))
        return _native.read_only(levels)

    @actuation.setter
    def actuation(self, value: Any) -> None:
        width = len(self.model.actuators)
        rows = np.array(self._rows(0.0 if value is None else value, "actuation", width), order="C")
        self._check_loads(rows, "actuation")
        with self._locked():
            call(lib.thrum_batch_set_actuation, self._c_model, self._places, len(self), _native.pointer(rows), width)

    @property
    def energies(self) -> npt.NDArray[Any]:
        """Energies [J] of every state: an array with the fields kinetic, potential, total and high."""
        found = np.empty(len(self), _ENERGIES)
        with self._locked():
            call(lib.thrum_batch_energies, self._c_model, self._places, len(self), _native.pointer(found, "thrum_energies"))
        found.flags.writeable = False
        return found

    def coordinates(self, out: Array | None = None) -> Array:
        """q of every state, count x r."""
        values = _native.output(out, (len(self), self.model.rank), np.float64, "out")
        self._get(values, None)
        return values

    # --- within ------------------------------------------------------------------------------------

    @contextlib.contextmanager
    def _locked(self) -> Iterator[None]:
        """No other thread uses the states meanwhile, and none is closed."""
        for state in self._in_order:
            state._lock.acquire()
        try:
            if any(state._state is None for state in self.states):
                raise ValueError("a state of the batch was closed")
            yield
        finally:
            for state in self._in_order:
                state._lock.release()

    def _each(self, work: Callable[[_Range], None]) -> None:
        """Does the work of each range, in a thread of its own where there are several."""
        if len(self._ranges) == 1:
            work(self._ranges[0])
            return
        with ThreadPoolExecutor(len(self._ranges)) as pool:
            for _ in pool.map(work, self._ranges):
                pass

    def _get(self, q: Array | None, p: Array | None) -> None:
        with self._locked():
            call(lib.thrum_batch_get, self._c_model, self._places, len(self), _native.pointer(q), _native.pointer(p),
                 self.model.rank)

    def _rows(self, value: Any, name: str, width: int | None = None) -> Array:
        """`value` as count x r, or count x width: rows, or one row for all."""
        given = _native.real_numbers(value, name)
        width = self.model.rank if width is None else width
        try:
            return np.broadcast_to(given, (len(self), width))
        except ValueError:
            have = " x ".join(map(str, given.shape))
            raise ValueError(f"{name}: its shape is {have}, not {len(self)} x {width} or {width}") from None

    def _check_loads(self, loads: Array, name: str) -> None:
        """Refuses loads before any state has taken its own."""
        if not np.isfinite(loads).all():
            state = int(np.argmin(np.isfinite(loads).reshape(len(self), -1).all(axis=1)))
            raise BadValue(f"{name}: that of state {state} is not finite", Status.BAD_VALUE)

    def _keep_forces(self, rows: Array) -> None:
        """The states know their loads too."""
        for state, row in zip(self.states, rows):
            state._force = row

    def __reduce__(self) -> tuple[Any, ...]:
        return Batch, (self.model, self.states, self.threads)
