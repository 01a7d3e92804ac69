"""Thrum: real-time deformable bodies that keep their energy.

>>> import thrum
>>> model = thrum.Model.precompute("beam", modes=5)        # needs the program thrum
>>> state = model.state(integrator="energy", dt=0.003)
>>> state.force = model.external_load(force=(0, 0, -40), group="tip")
>>> state.step(100)
<Status.OK: 0>
>>> model.displacement(state.q).shape
(336, 3)

Quantities are SI. Arrays are numpy's, in C order; shapes are in the docstrings, with r the number of
coordinates that are stepped and n the number of vertices. Long calls release the interpreter lock.
Everything that the C library refuses raises a subclass of `thrum.Error` with its message.
SPDX-License-Identifier: Apache-2.0
"""

from ._errors import (BadFile, BadValue, Error, InvalidArgument, Missing, ModelMismatch, NotConverged, OutOfMemory,
                      ProgramFailed, Status, Unsupported)
from ._mesh import Mesh
from ._native import integrators, library_path, version
from ._program import (FrequencyGradient, Response, Run, check, compare, embed, export, frequency_gradient, identify, info,
                       mesh, precompute, program, response, run_program, simulate, static, tradeoff)
from .batch import Batch
from .equilibrium import Equilibrium
from .gradient import Gradient, Rollout, Touching, hessian_product, rollout, value_and_gradient
from .model import Model
from .monitor import Look, Monitor
from .scene import Body, Link, Load, Obstacle, Overlap, Pull, Scene, Touch
from .state import Energies, Report, State
from .stress import NodeStress, Stress, StressNodes, StressPoints
from .surface import Surface
from .view import View, view

__version__ = version()

__all__ = [
    "BadFile", "BadValue", "Batch", "Body", "Energies", "Equilibrium", "Error", "FrequencyGradient", "Gradient", "InvalidArgument", "Link", "Load",
    "Look", "Mesh", "Missing", "Model", "ModelMismatch", "Monitor", "NodeStress", "NotConverged", "Obstacle",
    "OutOfMemory", "Overlap", "ProgramFailed", "Pull", "Report", "Response", "Rollout", "Run", "Scene", "State", "Status", "Stress",
    "StressNodes", "StressPoints", "Surface", "Touch", "Touching", "Unsupported", "View",
    "check", "compare", "embed", "export", "frequency_gradient", "hessian_product", "identify", "info", "integrators", "library_path", "mesh", "precompute",
    "program", "response", "rollout", "run_program", "simulate", "static", "tradeoff", "value_and_gradient", "version", "view",
]
