"""The C library behind the package, and how arrays go into it and come out of it.

SPDX-License-Identifier: Apache-2.0
"""

from __future__ import annotations

import os
import sys
import threading
import warnings
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from . import _declarations, _errors

# made by declarations.py out of the headers
ffi: Any = _declarations.ffi

Array = npt.NDArray[np.float64]
FloatArray = npt.NDArray[np.float32]
IntArray = npt.NDArray[np.int32]


def library_path() -> str:
    """The C library that this package steps with: THRUM_LIBRARY, else the one inside the package, else the system's.

    The last is a name that the loader looks up, "libthrum_scene.so.0.2"; that library brings the runtime with it.
    """
    given = os.environ.get("THRUM_LIBRARY")
    if given:
        return given
    inside = os.path.join(os.path.dirname(os.path.abspath(__file__)), "libthrum.so")
    if os.path.exists(inside):
        return inside
    major, minor = (ffi.integer_const(f"THRUM_VERSION_{part}") for part in ("MAJOR", "MINOR"))
    # before 1.0 a minor version may change the interface, and is part of the name (docs/versioning.md)
    return f"libthrum_scene.so.{major}" if major else f"libthrum_scene.so.0.{minor}"


def _open() -> Any:
    try:
        return ffi.dlopen(library_path())
    except OSError as error:
        raise ImportError(f"thrum: its C library cannot be loaded: {error}. Install the package again, or set "
                          "THRUM_LIBRARY to a libthrum.so that has the scenes too") from error


lib: Any = _open()


def version() -> str:
    """Version of the C library, "major.minor.patch"."""
    return str(ffi.string(lib.thrum_version()).decode())


def integrators() -> list[str]:
    """Names of the integrators, for `Model.state` and scenes."""
    names: list[str] = []
    while True:
        name = lib.thrum_integrator_name(len(names))
        if name == ffi.NULL:
            return names
        names.append(ffi.string(name).decode())


def check(status: int, error: Any) -> int:
    """Returns a status that is no failure; raises the exception of one that is."""
    if status >= 0:
        return status
    message = ffi.string(error.message).decode("utf-8", "replace")
    raise _errors.exception(status, message or ffi.string(lib.thrum_status_text(status)).decode())


def new_error() -> Any:
    """A place for the detail of a failure."""
    return ffi.new("thrum_error *")


def call(function: Any, *arguments: Any) -> int:
    """Calls a function whose last parameter is a thrum_error, and raises what it says."""
    error = new_error()
    return check(function(*arguments, error), error)


def warn(text: str) -> None:
    """A RuntimeWarning at the line outside of the package that called it."""
    level, frame = 1, sys._getframe(0)
    while frame.f_back is not None and str(frame.f_globals.get("__name__", "")).split(".")[0] == "thrum":
        level, frame = level + 1, frame.f_back
    warnings.warn(text, RuntimeWarning, stacklevel=level)


def call_interruptible(keeps: tuple[Any, ...], function: Any, *arguments: Any) -> int:
    """`call` of a function that may take long and changes nothing but its arguments, which Ctrl-C does not wait for.

    Signals are handled by the main thread, between two of its instructions: so it waits while another one calls. keeps: what
    the arguments point into, which lives as long as the call, also where the caller has gone on.
    """
    if threading.current_thread() is not threading.main_thread():
        return call(function, *arguments)
    error = new_error()
    found: list[int] = []

    def work(_kept: tuple[Any, ...]) -> None:
        found.append(function(*arguments, error))

    worker = threading.Thread(target=work, args=(keeps,), daemon=True)
    worker.start()
    while worker.is_alive():
        worker.join(0.05)
    return check(found[0], error)


# --- arrays -----------------------------------------------------------------------------------


def real_numbers(value: Any, name: str) -> Array:
    """`value` as doubles of any shape. ValueError names the argument: complex numbers and texts are no such numbers."""
    given = np.asarray(value)
    if given.dtype.kind not in "biufO":
        raise ValueError(f"{name}: real numbers are needed, not {given.dtype}")
    return np.ascontiguousarray(given, dtype=np.float64)


def doubles(value: Any, shape: tuple[int | None, ...], name: str) -> Array:
    """`value` as doubles in C order; None in a shape is any length. ValueError names the argument."""
    array = real_numbers(value, name)
    _check_shape(array, shape, name)
    return array


def vertex_numbers(value: Any, count: int, name: str) -> IntArray:
    """`value` as 0-based vertices below `count`."""
    array = np.asarray(value)
    if array.size == 0:
        raise ValueError(f"{name}: it is empty")
    if not np.issubdtype(array.dtype, np.integer):
        raise TypeError(f"{name}: whole numbers are needed, not {array.dtype}")
    if array.min() < 0 or array.max() >= count:
        raise ValueError(f"{name}: {int(array.min())} to {int(array.max())} are not within 0 to {count - 1}")
    return np.ascontiguousarray(array, dtype=np.int32)


def triangle_numbers(value: Any, count: int, name: str) -> IntArray:
    """`value` as m x 3 0-based vertices below `count`."""
    array = vertex_numbers(value, count, name)
    _check_shape(array, (None, 3), name)
    return array


def output(value: npt.NDArray[Any] | None, shape: tuple[int, ...], dtype: type, name: str) -> npt.NDArray[Any]:
    """`value` if it can be written in place, a new array if it is None."""
    if value is None:
        return np.empty(shape, dtype)
    if not isinstance(value, np.ndarray) or value.dtype != dtype or not value.flags.c_contiguous:
        raise TypeError(f"{name}: an array of {np.dtype(dtype)} in C order is needed")
    if not value.flags.writeable:
        raise ValueError(f"{name}: it is read-only")
    _check_shape(value, shape, name)
    return value


def _check_shape(array: npt.NDArray[Any], shape: tuple[int | None, ...], name: str) -> None:
    fits = array.ndim == len(shape) and all(want in (None, have) for want, have in zip(shape, array.shape))
    if not fits:
        wanted = " x ".join("any" if size is None else str(size) for size in shape)
        have = " x ".join(str(size) for size in array.shape) or "a single number"
        raise ValueError(f"{name}: its shape is {have}, not {wanted}")


def pointer(array: npt.NDArray[Any] | None, kind: str = "double") -> Any:
    """The address of an array for a call, during which the caller keeps the array; NULL for None."""
    return ffi.NULL if array is None else ffi.cast(f"{kind} *", array.ctypes.data)


class _Memory:
    """Memory of the library as numpy sees it; it keeps `owner`, and with it the memory, alive."""

    def __init__(self, address: int, shape: tuple[int, ...], kind: str, owner: object) -> None:
        self.owner = owner
        self.__array_interface__ = {"shape": shape, "typestr": kind, "data": (address, True), "version": 3}


Kind = TypeVar("Kind", bound=np.generic)


def read_only(array: npt.NDArray[Kind]) -> npt.NDArray[Kind]:
    """The same array, which refuses to be written to: it is a copy, and what is written there would be lost."""
    array.flags.writeable = False
    return array


def view(place: Any, shape: tuple[int, ...], kind: str, owner: object) -> npt.NDArray[Any] | None:
    """A read-only array over memory of the library, without a copy; None for NULL."""
    if place == ffi.NULL:
        return None
    return np.asarray(_Memory(int(ffi.cast("uintptr_t", place)), shape, kind, owner))


class AlignedBlock:
    """`size` bytes aligned to 64, which live as long as this object."""

    def __init__(self, size: int) -> None:
        self.size = size
        self._bytes = np.empty(size + 64, np.uint8)
        offset = -self._bytes.ctypes.data % 64
        self.array = self._bytes[offset:offset + size]

    @property
    def place(self) -> Any:
        """Its address, for a call."""
        return ffi.cast("void *", self.array.ctypes.data)
