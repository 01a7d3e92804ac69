#!/usr/bin/env python3
"""The table of long runs in docs/which_integrator.md: how many keep their energy with each integrator.

The six models of models/ start at rest in shape with a momentum, either in the first basis vector alone (smooth) or
that of an impulse at the group `load` along its softest axis (impulse), scaled so that the group moves by 5, 10 or
20 % of the length of the model within 3 s. A run of 200,000 undamped steps counts as lost when its energy doubles.

usage: integrator_long.py THRUM [INTEGRATOR ...]     (needs numpy; works in a temporary folder; an hour or less)
SPDX-License-Identifier: Apache-2.0
"""
import os
import subprocess
import sys
import tempfile

import numpy as np

MODELS = ("horse", "beam", "heart", "tower", "bridge", "basket")
SWINGS, STEPS_OF_TIME, STEPS = (0.05, 0.1, 0.2), (0.001, 0.003, 0.01), 200_000


def thrum(*arguments):
    return subprocess.run([sys.argv[1], *arguments], capture_output=True, text=True).returncode


def simulate(model, momentum, step, time, *options):
    np.save("start.npy", np.stack([np.zeros(len(momentum)), momentum]))
    return thrum("simulate", model, "-o", "run", "--dt", repr(step), "--time", repr(time), "--start", "start.npy", "-q",
                 *options)


def rows_of_load(model):
    """The three rows that give the mean displacement of the group `load`."""
    name = bytes(model["group_names"]).split(b"\0").index(b"load")
    begin = model["group_ends"][name - 1] if name else 0
    vertices = model["group_vertices"][begin : model["group_ends"][name]]
    rank = model["omega2"].shape[0]
    return model["basis"].reshape(-1, 3, rank)[vertices].mean(axis=0)


def scaled(name, direction, reach, rows):
    """The multiple of this momentum under which the group moves by `reach`."""
    factor = reach
    for _ in range(10):
        simulate(name, factor * direction, 0.003, 3.0, "--integrator", "energy")
        moved = np.linalg.norm(np.load("run/q.npy") @ rows.T, axis=1).max()
        if abs(moved / reach - 1) < 0.01:
            break
        factor *= reach / moved
    return factor * direction


def lost(name, momentum, step, integrator):
    code = simulate(name, momentum, step, STEPS * step, "--integrator", integrator, "--record-every", "500",
                    "--monitor", "off")
    if code not in (0, 3) or not os.path.exists("run/energy.csv"):
        return True
    total = np.atleast_1d(np.genfromtxt("run/energy.csv", delimiter=",", names=True)["total_j"])
    return len(total) <= STEPS // 500 or not total.max() < 2 * total[0]


def main(integrators):
    counts = {}
    for name in MODELS:
        file = f"{name}.npz"
        thrum("precompute", name, "-o", file, "-q")
        model = np.load(file)
        rows, vertices = rows_of_load(model), model["vertices"].reshape(-1, 3)
        length = np.ptp(vertices, axis=0).max()
        softness = (rows**2 / model["omega2"]).sum(axis=1)
        starts = {"smooth": np.eye(rows.shape[1])[0], "impulse": rows[softness.argmax()]}
        for start, direction in starts.items():
            for swing in SWINGS:
                momentum = scaled(file, direction, swing * length, rows)
                for step in STEPS_OF_TIME:
                    for integrator in integrators:
                        gone = lost(file, momentum, step, integrator)
                        cell = counts.setdefault((step, start, integrator), [])
                        cell.append(f"{name} {100 * swing:g} %" if gone else None)

    print("| h | start | " + " | ".join(integrators) + " |")
    for step in STEPS_OF_TIME:
        for start in ("smooth", "impulse"):
            cells = [counts[step, start, integrator] for integrator in integrators]
            kept = [f"{sum(run is None for run in cell)} of {len(cell)}" for cell in cells]
            print(f"| {1000 * step:g} ms | {start} | " + " | ".join(kept) + " |")
    for key, cell in counts.items():
        print(*key, *[run for run in cell if run], sep=", ", file=sys.stderr)


with tempfile.TemporaryDirectory() as folder:
    sys.argv[1] = os.path.abspath(sys.argv[1])
    os.chdir(folder)
    main(sys.argv[2:] or ["newmark", "fox-goodwin", "energy"])
