"""Statuses of the C library, and the exceptions that stand for its failures.

SPDX-License-Identifier: Apache-2.0
"""

from __future__ import annotations

import enum
from typing import Any


class Status(enum.IntEnum):
    """What a call of the C library returned (thrum/status.h): 0 is done, above 0 is done but notable."""

    OK = 0
    ENERGY_GREW = 1
    FELL_BACK = 2
    SWITCHED = 3
    INVALID_ARGUMENT = -1
    UNINITIALISED_DEF = -2
    BUFFER_TOO_SMALL = -3
    MISALIGNED = -4
    OUT_OF_MEMORY = -5
    IO = -6
    BAD_FORMAT = -7
    UNSUPPORTED = -8
    BAD_CHECKSUM = -9
    MISSING = -10
    BAD_SHAPE = -11
    BAD_VALUE = -12
    NOT_CONVERGED = -13
    NOT_FINITE = -14
    MODEL_MISMATCH = -15
    SINGULAR = -16
    INTERRUPTED = -17


class Error(Exception):
    """A call failed. `status` says how, for programs; the text says what to do, for people."""

    def __init__(self, message: str, status: Status) -> None:
        super().__init__(message)
        self.status = status

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.status)


class InvalidArgument(Error, ValueError):
    """An argument is out of its range."""


class BadValue(Error, ValueError):
    """A number is not finite or out of its range."""


class OutOfMemory(Error, MemoryError):
    """Memory could not be allocated."""


class BadFile(Error, OSError):
    """A file cannot be read or written, or does not hold what it should."""


class Missing(Error, LookupError):
    """The model lacks a part that the call needs."""


class Unsupported(Error, NotImplementedError):
    """The request is understood but not supported."""


class NotConverged(Error, ArithmeticError):
    """An iteration did not converge, a matrix is singular, or numbers overflowed."""


class ModelMismatch(Error, ValueError):
    """A state, a snapshot or a surface belongs to another model."""


class ProgramFailed(Error, RuntimeError):
    """The program thrum refused or failed. `exit_code` is its exit code."""

    def __init__(self, message: str, exit_code: int) -> None:
        super().__init__(message, Status.INVALID_ARGUMENT if exit_code in (1, 2) else Status.IO)
        self.exit_code = exit_code

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.exit_code)


_EXCEPTIONS: dict[Status, type[Error]] = {
    Status.INVALID_ARGUMENT: InvalidArgument,
    Status.BUFFER_TOO_SMALL: BadFile,  # a snapshot that was cut off: all other memory is the package's own
    Status.OUT_OF_MEMORY: OutOfMemory,
    Status.IO: BadFile,
    Status.BAD_FORMAT: BadFile,
    Status.BAD_CHECKSUM: BadFile,
    Status.UNSUPPORTED: Unsupported,
    Status.MISSING: Missing,
    Status.BAD_SHAPE: BadValue,
    Status.BAD_VALUE: BadValue,
    Status.NOT_CONVERGED: NotConverged,
    Status.NOT_FINITE: NotConverged,
    Status.SINGULAR: NotConverged,
    Status.MODEL_MISMATCH: ModelMismatch,
}


def exception(status: int, message: str) -> Error:
    """The exception that stands for a failure with this message."""
    known = Status(status)
    return _EXCEPTIONS.get(known, Error)(message, known)
