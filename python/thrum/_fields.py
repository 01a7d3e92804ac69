"""Defs of bodies, obstacles, solids, links, loads and contact, filled by name from the rows of thrum/fields.h.

SPDX-License-Identifier: Apache-2.0
"""

from __future__ import annotations

import operator
from typing import Any

import numpy as np

from . import _native
from ._native import ffi, lib

# C types of the records, in the order of thrum_scene_record
_RECORDS = {"body": "thrum_scene_body_def", "obstacle": "thrum_obstacle", "solid": "thrum_scene_solid_def",
            "link": "thrum_scene_link_def", "contact between bodies": "thrum_contact_pairs_def",
            "wind": "thrum_scene_wind_def", "load": "thrum_scene_load_def"}
_MEMBERS = {lib.THRUM_FIELD_DOUBLE: "double", lib.THRUM_FIELD_FLOAT: "float", lib.THRUM_FIELD_INT64: "int64_t",
            lib.THRUM_FIELD_INT32: "int32_t", lib.THRUM_FIELD_FLAG: "int32_t", lib.THRUM_FIELD_CHOICE: "int32_t"}


def _text(value: Any) -> str:
    return "" if value == ffi.NULL else str(ffi.string(value).decode())


def _fields_of(record: int) -> dict[str, Any]:
    count = ffi.new("int64_t *")
    fields = lib.thrum_scene_fields(record, count)
    return {_text(fields[n].name): fields[n] for n in range(count[0])}


_FIELDS = {name: _fields_of(number) for number, name in enumerate(_RECORDS)}


class Def:
    """A def with its defaults, and the arrays that live as long as it does."""

    def __init__(self, record: str, options: dict[str, Any] | None = None, vertex_count: int | None = None) -> None:
        self.record = record
        self.c = ffi.new(f"{_RECORDS[record]} *")
        lib.thrum_scene_record_default(list(_RECORDS).index(record), self.c)
        self.kept: list[object] = []
        for name, value in (options or {}).items():
            self.set(name, value, vertex_count)

    def _field(self, name: str) -> Any:
        found = _FIELDS[self.record].get(name)
        if found is None:
            raise TypeError(f"{self.record}: there is no option {name!r}; there are {', '.join(_FIELDS[self.record])}")
        return found

    def _place(self, offset: int, kind: str) -> Any:
        return ffi.cast(f"{kind} *", ffi.cast("char *", self.c) + offset)

    def set(self, name: str, value: Any, vertex_count: int | None = None) -> None:
        """Sets one field; `vertex_count` bounds lists of vertices. None leaves it as it is."""
        field = self._field(name)
        if value is None:
            return
        if field.kind not in _MEMBERS:
            self._set_array(name, field, value, vertex_count)
            return
        place = self._place(field.offset, _MEMBERS[field.kind])
        if field.kind in (lib.THRUM_FIELD_DOUBLE, lib.THRUM_FIELD_FLOAT):
            numbers = _native.real_numbers(value, name).ravel()
            if numbers.size != field.width:
                raise ValueError(f"{name}: {field.width} numbers are needed, not {numbers.size}")
            for n, number in enumerate(numbers.tolist()):
                place[n] = number
        elif field.kind == lib.THRUM_FIELD_CHOICE:
            names = _text(field.names).split()
            if value not in names:
                raise ValueError(f"{name}: {value!r} is none of {', '.join(names)}")
            place[0] = names.index(value)
        else:
            place[0] = operator.index(value)

    def _set_array(self, name: str, field: Any, value: Any, vertex_count: int | None) -> None:
        counts = self._place(field.count_offset, "int64_t")
        array: Any
        if field.kind == lib.THRUM_FIELD_GRID:
            array = _native.doubles(value, (None, None), name)
            counts[0], counts[1] = array.shape
        else:
            whole = field.kind == lib.THRUM_FIELD_INTS
            flat: Any = _native.vertex_numbers(value, vertex_count or 2**31, name) if whole else _native.real_numbers(value, name)
            if flat.size % field.width != 0:
                raise ValueError(f"{name}: rows of {field.width} numbers are needed, not {flat.size} numbers")
            array = np.ascontiguousarray(flat.reshape(-1, field.width))
            if counts[0] not in (0, len(array)):
                raise ValueError(f"{name}: {len(array)} of them do not fit the {counts[0]} of another array")
            counts[0] = len(array)
        self.kept.append(array)
        self._place(field.offset, "void *")[0] = ffi.cast("void *", array.ctypes.data)

    def names(self) -> list[str]:
        """Names of the fields that are no arrays."""
        return [name for name, field in _FIELDS[self.record].items() if field.kind in _MEMBERS]

    def get(self, name: str) -> Any:
        """A field that is no array, as it was set."""
        field = self._field(name)
        place = self._place(field.offset, _MEMBERS[field.kind])
        if field.kind == lib.THRUM_FIELD_CHOICE:
            return _text(field.names).split()[place[0]]
        if field.kind == lib.THRUM_FIELD_FLAG:
            return bool(place[0])
        return place[0] if field.width == 1 else tuple(place[0:field.width])
