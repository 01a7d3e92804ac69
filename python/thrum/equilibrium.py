"""Static equilibrium of a body under a load (thrum/equilibrium.h).

SPDX-License-Identifier: Apache-2.0
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np

from . import _native
from ._native import AlignedBlock, Array, call, ffi, lib

if TYPE_CHECKING:
    from .model import Model

_INSTABILITIES = ("none", "bifurcation", "limit")
_OPTIONS = ("factor", "first_step", "tolerance", "steps_max", "iterations_max", "stay")


class EquilibriumOptions(TypedDict, total=False):
    """Options of `Model.equilibrium`; thrum_equilibrium_def says what each is."""

    factor: float
    first_step: float
    tolerance: float
    steps_max: int
    iterations_max: int
    stay: bool
    actuation: Any  # levels of actuators by name, which grow with the load


@dataclass(frozen=True, repr=False)
class Equilibrium:
    """An equilibrium and how the body came there; thrum_equilibrium_report says what each number is."""

    q: Array  # r
    mode: Array  # r: the direction of least stiffness where the path lost its stability, else at q
    factor: float
    residual: float
    energy: float
    load_energy: float
    least: float
    softest: float
    softest_factor: float
    critical: float
    critical_linear: float
    instability: str
    jumps: int
    load_steps: int
    cut_steps: int
    iterations: int
    factorisations: int

    def __repr__(self) -> str:
        fate = "stable" if self.stable else "unstable"
        return f"<thrum.Equilibrium factor={self.factor:.6g} energy={self.energy:.6g} J {fate} residual={self.residual:.1e}>"

    @property
    def stable(self) -> bool:
        """Whether the body stays there when it is nudged."""
        return self.least >= 0.0


def _warn_of(model: Model, shown: Array) -> None:
    """A RuntimeWarning where the model cannot be believed in this shape, as the program's static has it."""
    if model.basis is None or model.tets is None:
        return
    look = model.monitor().look(shown)
    if {"compressed", "inverted"} & set(look.warnings):
        _native.warn(f"a tetrahedron is compressed to {look.stretch_least:.3f} of its length; below 0.577, StVK gives "
                     "way: do not trust this shape")


def _acting(model: Model, actuation: Any) -> tuple[Any, Any]:
    """The model under these levels, and what keeps them alive."""
    if actuation is None:
        return model._c, None
    memory = np.zeros(lib.thrum_model_actuation_count(model._c))
    made = ffi.new("thrum_model *")
    call(lib.thrum_model_actuate, model._c, _native.pointer(model._levels(actuation)), _native.pointer(memory), made)
    return made, (memory, made)


def find(model: Model, load: Any, q: Any, options: dict[str, Any]) -> Equilibrium:
    """`Model.equilibrium`: NotConverged says how far the load was followed, a RuntimeWarning what not to believe."""
    rank = model.rank
    force = _native.doubles(load, (rank,), "load")
    at = np.zeros(rank) if q is None else _native.doubles(q, (rank,), "q").copy()
    mode = np.zeros(rank)
    options = dict(options)
    acting, levels = _acting(model, options.pop("actuation", None))
    definition = ffi.new("thrum_equilibrium_def *")
    lib.thrum_equilibrium_def_init(definition, ffi.sizeof("thrum_equilibrium_def"))
    for name, value in options.items():
        if name not in _OPTIONS:
            raise TypeError(f"an equilibrium has no option {name!r}; it has: {', '.join(_OPTIONS)}")
        setattr(definition, name, value)
    definition.mode = _native.pointer(mode)

    size, report = ffi.new("size_t *"), ffi.new("thrum_equilibrium_report *")
    call(lib.thrum_equilibrium_size, acting, size)
    workspace = AlignedBlock(size[0])
    _native.call_interruptible(
        (model._handle(), levels, force, at, mode, workspace), lib.thrum_equilibrium, acting, definition, _native.pointer(force),
        _native.pointer(at), workspace.place, workspace.size, report)

    _warn_of(model, model.shape(at, force * report.factor) if model.shown == rank else model.shape(at))
    numbers = {name: getattr(report, name) for name in Equilibrium.__dataclass_fields__ if name not in ("q", "mode")}
    numbers["instability"] = _INSTABILITIES[report.instability]
    return Equilibrium(q=at, mode=mode, **numbers)
