"""Runs as functions of PyTorch, with their gradients: `import thrum.autograd` needs torch.

>>> q, p = thrum.autograd.rollout(model, 100, q0, p0, force, alpha, beta, stiffness, density)
>>> loss = (q[:, -1] - target).square().sum()
>>> loss.backward()

SPDX-License-Identifier: Apache-2.0
"""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np

from .gradient import Rollout
from .model import Model

# its types take mypy two minutes to read
torch: Any = importlib.import_module("torch")

_SCALARS = ("alpha", "beta", "stiffness", "density")


class _Run(torch.autograd.Function):  # type: ignore[misc]
    @staticmethod
    def forward(context: Any, model: Model, steps: int, options: dict[str, Any], q: Any, p: Any, force: Any, actuation: Any,
                *scalars: Any) -> Any:
        count = q.shape[0]
        rows = [value.detach().numpy() for value in (q, p, force, actuation)]
        acts = actuation.shape[2] > 0
        alpha, beta, stiffness, density = (float(value) for value in scalars)
        given = {**options, "damping_alpha": alpha, "damping_beta": beta}
        context.runs = [Rollout(model, steps, rows[0][n], rows[1][n], rows[2][n], stiffness, density, given,
                                rows[3][n] if acts else None)
                        for n in range(count)]
        return tuple(torch.from_numpy(np.stack([getattr(run, name) for run in context.runs])) for name in ("q", "p"))

    @staticmethod
    @torch.autograd.function.once_differentiable  # type: ignore[misc]
    def backward(context: Any, q_bar: Any, p_bar: Any) -> Any:
        found = [run.pull_back(q_bar[n].numpy(), p_bar[n].numpy()) for n, run in enumerate(context.runs)]
        rows = [torch.from_numpy(np.stack([getattr(g, name) for g in found])) for name in ("q", "p", "force")]
        sums = [torch.tensor(sum(getattr(g, name) for g in found), dtype=torch.float64) for name in _SCALARS]
        levels = torch.from_numpy(np.stack([g.actuation for g in found])) if found[0].actuation is not None else None
        return (None, None, None, *rows, levels, *sums)


def rollout(model: Model, steps: int, q: Any = None, p: Any = None, force: Any = None, alpha: Any = 0.0, beta: Any = 0.0,
            stiffness: Any = 1.0, density: Any = 1.0, actuation: Any = None, **options: Any) -> tuple[Any, Any]:
    """q and p after each step, the start first, as tensors of doubles that carry gradients.

    q, p: r, or batch x r; force: steps x model.shown, or with a batch before it; actuation: steps x model.actuators,
    likewise; None: zero. alpha, beta (damping), stiffness and density
    (factors) are one number for all. The results are (steps + 1) x r, with the batch before it where one was given. options:
    as for `thrum.rollout`.
    """
    given = {"q": (q, (model.rank,)), "p": (p, (model.rank,)), "force": (force, (steps, model.shown)),
             "actuation": (actuation, (steps, len(model.actuators)))}
    tensors = {name: torch.zeros(shape, dtype=torch.float64) if value is None else torch.as_tensor(value, dtype=torch.float64)
               for name, (value, shape) in given.items()}
    for name, (_, shape) in given.items():
        have = tuple(tensors[name].shape)
        if have[-len(shape):] != shape or len(have) > len(shape) + 1:
            raise ValueError(f"{name}: its shape is {have}, not {shape}, or that with a batch before it")
    batched = any(tensors[name].dim() > len(shape) for name, (_, shape) in given.items())
    counts = {tensors[name].shape[0] for name, (_, shape) in given.items() if tensors[name].dim() > len(shape)}
    if len(counts) > 1:
        raise ValueError(f"q, p, force and actuation have batches of {', '.join(map(str, sorted(counts)))}")
    count = counts.pop() if counts else 1
    rows = [tensors[name].expand(count, *shape) for name, (_, shape) in given.items()]
    scalars = [torch.as_tensor(value, dtype=torch.float64) for value in (alpha, beta, stiffness, density)]
    q_run, p_run = _Run.apply(model, steps, options, *rows, *scalars)
    return (q_run, p_run) if batched else (q_run[0], p_run[0])
