"""Many states of one model that are stepped together (thrum/batch.h).

SPDX-License-Identifier: Apache-2.0
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _native
from ._errors import ModelMismatch, Status
from ._native import AlignedBlock, Array, call, ffi, lib
from .model import Model
from .state import State

# no status: it stands where a call ended before it looked at a state
_UNTOUCHED = 1000


class Batch:
    """States of one model that are stepped side by side, so that the model's numbers are read once for several.

    Each state ends with the same bits as by `State.step`. A state may be listed once. Threads: one batch belongs to
    one thread at a time; give each thread a batch of its own, they share the model.
    """

    def __init__(self, model: Model, states: Sequence[State]) -> None:
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
        size = ffi.new("size_t *")
        call(lib.thrum_batch_size, self._c_model, size)
        self._workspace = AlignedBlock(size[0])
        self._statuses = np.zeros(len(states), np.int32)
        self._status_place = _native.pointer(self._statuses, "thrum_status")
        self._places = ffi.new("thrum_state *[]", [state._open() for state in states])
        # in one order for all threads, so that two batches with common states cannot wait for each other
        self._in_order = sorted(states, key=id)

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
        error = _native.new_error()
        for state in self._in_order:
            state._lock.acquire()
        try:
            if any(state._state is None for state in self.states):
                raise ValueError("a state of the batch was closed")
            for _ in range(count):
                self._statuses[:] = _UNTOUCHED
                status = lib.thrum_batch_step(self._c_model, self._places, len(self.states), self._status_place,
                                              self._workspace.place, self._workspace.size, error)
                if status < 0 and (self._statuses == _UNTOUCHED).any():
                    _native.check(status, error)
        finally:
            for state in self._in_order:
                state._lock.release()
        return self._statuses.copy()

    def coordinates(self, out: Array | None = None) -> Array:
        """q of every state, count x r."""
        values = _native.output(out, (len(self.states), self.model.rank), np.float64, "out")
        for row, state in zip(values, self.states):
            state.get(q=row)
        return values

    def __reduce__(self) -> tuple[Any, ...]:
        return Batch, (self.model, self.states)
