"""Whether a reduced model can be believed where a state is (thrum/monitor.h).

SPDX-License-Identifier: Apache-2.0
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypedDict

from . import _native
from ._native import AlignedBlock, call, ffi, lib
from .model import Model

if TYPE_CHECKING:
    from typing_extensions import Unpack

_OPTIONS = ("stretch_least", "reach_most", "load_share_most")
_WARNINGS = {1: "compressed", 2: "inverted", 4: "reach", 8: "load"}


@dataclass(frozen=True)
class Look:
    """What a monitor has seen so far; thrum_monitor_record says what each number is."""

    warnings: tuple[str, ...]
    warnings_now: tuple[str, ...]
    looks: int
    stretch: float
    stretch_least: float
    stretch_tet: int
    reach: float
    reach_most: float
    load_share: float


class MonitorOptions(TypedDict, total=False):
    """Options of a monitor; `Monitor` says what each is."""

    stretch_least: float
    reach_most: float
    load_share_most: float


class Monitor:
    """Looks at coordinates and loads, and remembers the worst. One thread at a time.

    Options: stretch_least (default 1/sqrt 3), reach_most (3 tenths of the diagonal), load_share_most (1).
    """

    def __init__(self, model: Model, **options: Unpack[MonitorOptions]) -> None:
        definition = ffi.new("thrum_monitor_def *")
        lib.thrum_monitor_def_init(definition, ffi.sizeof("thrum_monitor_def"))
        for name, value in options.items():
            if name not in _OPTIONS:
                raise TypeError(f"a monitor has no option {name!r}; it has: {', '.join(_OPTIONS)}")
            setattr(definition, name, float(value))  # type: ignore[arg-type]
        size, place = ffi.new("size_t *"), ffi.new("const thrum_monitor **")
        call(lib.thrum_monitor_size, model._shape, definition, size)
        self._block = AlignedBlock(size[0])
        call(lib.thrum_monitor_init, self._block.place, self._block.size, model._shape, definition, place)
        self._monitor = place[0]
        self._model = model
        self._handle = model._handle()
        self._rank = model.shown
        self._record = ffi.new("thrum_monitor_record *")
        lib.thrum_monitor_clear(self._record)

    def __repr__(self) -> str:
        return f"<thrum.Monitor looks={self.record.looks} warnings={list(self.record.warnings)}>"

    def look(self, q: Any) -> Look:
        """Looks at q (`shown` coordinates)."""
        at = _native.doubles(q, (self._rank,), "q")
        call(lib.thrum_monitor_look, self._monitor, _native.pointer(at), self._record)
        return self.record

    def look_at_load(self, forces: Any) -> Look:
        """Looks at a load, n x 3 forces [N]: what share of it the model cannot feel."""
        field = _native.doubles(forces, (self._model.vertex_count, 3), "forces")
        call(lib.thrum_monitor_look_at_load, self._monitor, self._model._shape, _native.pointer(field), self._record)
        return self.record

    @property
    def record(self) -> Look:
        """All that it has seen."""
        numbers = {name: getattr(self._record, name) for name in Look.__dataclass_fields__}
        for name in ("warnings", "warnings_now"):
            numbers[name] = tuple(text for bit, text in _WARNINGS.items() if numbers[name] & bit)
        return Look(**numbers)

    def clear(self) -> None:
        """Forgets what it has seen."""
        lib.thrum_monitor_clear(self._record)
