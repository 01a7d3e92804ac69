#!/usr/bin/env python3
"""The table of errors in docs/which_integrator.md: how far each integrator is off at h = 0.003 s.

The body is the clamped beam of `thrum bench` at rank 15. It starts at rest in shape with a momentum, either in the
first basis vector alone (smooth) or that of an impulse at its tip (impulse), scaled so that the tip swings by a share
of the length within 3 s. The error is the root mean square of q - q_ref over 0.6 s, relative to that of q_ref, where
q_ref is stepped by `energy` at h/32.

usage: integrator_error.py THRUM     (needs numpy; works in a temporary folder)
SPDX-License-Identifier: Apache-2.0
"""
import json
import os
import subprocess
import sys
import tempfile

import numpy as np

STEP, TIME, FINER = 0.003, 0.6, 32
RANK, LENGTH = 15, 1.0
ALONE = ["--adaptive", "off", "--fallback", "off"]
CASES = {
    "imexv": ["--integrator", "imexv"],
    "position, alone": ["--integrator", "imexv", *ALONE],
    "thesis, alone": ["--integrator", "imexv", "--split-form", "thesis", *ALONE],
    "quadratic, alone": ["--integrator", "imexv", "--split-form", "quadratic", *ALONE],
    "newmark": ["--integrator", "newmark"],
    "fox-goodwin, alone": ["--integrator", "fox-goodwin", "--adaptive", "off"],
    "energy": ["--integrator", "energy"],
    "midpoint": ["--integrator", "midpoint"],
}


def thrum(*arguments):
    done = subprocess.run([sys.argv[1], *arguments], capture_output=True, text=True)
    if done.returncode not in (0, 3):
        sys.exit(done.stderr)
    return done.stdout


def run(momentum, step, time, options):
    """The rows of q, and what run.json says, of a run from q = 0 and this momentum."""
    np.save("start.npy", np.stack([np.zeros(RANK), momentum]))
    out = thrum("simulate", "beam.npz", "-o", "run", "--dt", repr(step), "--time", repr(time), "--start", "start.npy",
                "-q", "--json", *options)
    return np.load("run/q.npy"), json.loads(out)


def tip_rows(model):
    """The three rows that give the mean displacement of the group `tip`."""
    name = bytes(model["group_names"]).split(b"\0").index(b"tip")
    begin = model["group_ends"][name - 1] if name else 0
    vertices = model["group_vertices"][begin : model["group_ends"][name]]
    return model["basis"].reshape(-1, 3, RANK)[vertices].mean(axis=0)


def scaled(direction, share, tip):
    """The multiple of this momentum under which the tip swings by the share of the length."""
    factor = share * LENGTH
    for _ in range(8):
        q, _ = run(factor * direction, STEP, 3.0, CASES["energy"])
        factor *= share * LENGTH / np.abs(q @ tip.T).max()
    return factor * direction


def main():
    thrum("precompute", "beam:20x3x3@1x0.15x0.15,split=6", "--order", "1", "--fix", "x<0.001",
          "--modes", "8", "--rank", str(RANK), "-q", "-o", "beam.npz")
    tip = tip_rows(np.load("beam.npz"))
    starts = {"smooth": np.eye(RANK)[0], "impulse": tip[2] / np.linalg.norm(tip[2])}

    print("| start | swing | " + " | ".join(CASES) + " |")
    for start, direction in starts.items():
        for share in (0.02, 0.05, 0.1, 0.2, 0.3, 0.4):
            momentum = scaled(direction, share, tip)
            reference = run(momentum, STEP / FINER, TIME, CASES["energy"])[0][::FINER]
            cells = []
            for options in CASES.values():
                q, _ = run(momentum, STEP, TIME, options)
                rows = min(len(q), len(reference))
                error = np.sqrt(((q[:rows] - reference[:rows]) ** 2).sum() / (reference[:rows] ** 2).sum())
                cells.append(f"{100 * error:.2g} %" if error < 1 else "lost")
            print(f"| {start} | {100 * share:g} % | " + " | ".join(cells) + " |", flush=True)


with tempfile.TemporaryDirectory() as folder:
    sys.argv[1] = os.path.abspath(sys.argv[1])
    os.chdir(folder)
    main()
