#!/usr/bin/env python3
"""How the six models move under a pull at the place that their usual model follows least.

usage: validation/touch_pulls.py PROGRAM WORK_FOLDER [OUTPUT.csv]

For each model of its recipe: the place that it follows least without touch modes (`thrum info --touch`), pulled in a direction drawn
once, over a patch of a twentieth of the body's diagonal. The force rises in 0.15 s to where the place moves by 0.5 % of the diagonal
(linear), is let go, and the body swings until 0.3 s. The usual model and the one with touch modes that follow (`--touch`) are compared
with the one that steps them (`--touch-stepped`, up to rank 100). Errors are of 15 pictures, rms over the rms of its motion: of the patch,
and of the whole body, while the force rises and after it is let go. Into OUTPUT.csv (validation/results/touch/pulls.csv). Needs NumPy.
Models that the folder has from touch_coverage.py are not made again.
SPDX-License-Identifier: Apache-2.0
"""
import base64
import json
import pathlib
import re
import subprocess
import sys

import numpy as np

from load_errors import write_table
from tables import MODELS
from touch_coverage import make_model

KINDS = ("usual", "follows", "stepped-100")  # of touch_coverage.py
PATCH, REACH = 0.05, 0.005  # of the diagonal
RISE, END, DT, EVERY = 0.15, 0.3, 0.002, 10


def run(program, work, *options):
    """A command; flagged runs count."""
    done = subprocess.run([program, *options], cwd=work, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 3):
        raise SystemExit(done.stderr)
    return done.stdout


def surface_of(arrays):
    """The corners of the tetrahedra that lie on one triangle alone."""
    count = {}
    for tet in arrays["tets"]:
        for face in ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)):
            key = tuple(sorted(tet[list(face)]))
            count[key] = count.get(key, 0) + 1
    return np.array(sorted({v for face, times in count.items() if times == 1 for v in face}))


def patch_of(arrays, middle):
    """Vertices of the patch, and their shares of the force."""
    places, surface = arrays["vertices"], surface_of(arrays)
    away = np.linalg.norm(places[surface] - places[middle], axis=1) / (PATCH * diagonal_of(arrays))
    near = (away < 1) & (arrays["fixed"][surface] == 0)
    share = 1 - away[near] ** 2
    return surface[near], share / share.sum()


def diagonal_of(arrays):
    return np.linalg.norm(np.ptp(arrays["vertices"], axis=0))


def loads_of(arrays, vertices, share):
    """The options of the pull, by the linear answer of a model that follows it."""
    along = np.random.default_rng(7).normal(size=3)
    along /= np.linalg.norm(along)
    force = np.zeros(arrays["vertices"].size)
    for vertex, part in zip(vertices, share):
        force[3 * vertex:3 * vertex + 3] = part * along
    answer = (arrays["basis"] @ ((arrays["basis"].T @ force) / arrays["omega2"])).reshape(-1, 3)
    size = REACH * diagonal_of(arrays) / np.linalg.norm(share @ answer[vertices])
    options = []
    for vertex, part in zip(vertices, share):
        x, y, z = size * part * along
        options += ["--load", f"ramp:{x:.9g},{y:.9g},{z:.9g}@vertex={vertex + 1},until={RISE}"]
    return options


def motion(program, work, model, folder, loads):
    """Pictures x vertices x 3 of a run, and its report."""
    run(program, work, "simulate", model, "-o", folder, "--dt", str(DT), "--time", str(END), "--frames", f"every-{EVERY}", "-q",
        *loads)
    pictures = []
    for file in sorted((work / folder / "frames").iterdir()):
        text = re.search(r'Name="displacement"[^>]*format="binary">\s*([A-Za-z0-9+/=]+)', file.read_text(encoding="ascii"), re.IGNORECASE)
        data = base64.b64decode(text.group(1))
        pictures.append(np.frombuffer(data[8:8 + int.from_bytes(data[:8], "little")], "<f8").reshape(-1, 3))
    return np.array(pictures), json.loads((work / folder / "run.json").read_text(encoding="utf-8"))


def error(found, wanted):
    return f"{np.sqrt(((found - wanted) ** 2).sum() / (wanted ** 2).sum()):.4f}"


def rows(program, work):
    work = pathlib.Path(work)
    for model in MODELS:
        for kind in KINDS:
            make_model(program, work, model, kind)
        usual = json.loads(run(program, work, "info", f"{model}-usual.npz", "--touch", "--json"))
        arrays = np.load(work / f"{model}-follows.npz")
        vertices, share = patch_of(arrays, usual["touch"]["vertex"] - 1)
        loads = loads_of(arrays, vertices, share)
        wanted, _ = motion(program, work, f"{model}-stepped-100.npz", f"{model}-stepped", loads)
        risen = int(RISE / DT / EVERY) + 1  # the picture after the last before it is let go
        for kind in KINDS[:2]:
            found, report = motion(program, work, f"{model}-{kind}.npz", f"{model}-{kind}", loads)
            rank = np.load(work / f"{model}-{kind}.npz")["omega2"].size
            condensed = report.get("condensed") or {}
            cells = []
            for part in (slice(1, risen), slice(risen, len(wanted))):
                patch = [np.einsum("pvi,v->pi", m[part][:, vertices], share) for m in (found, wanted)]
                cells += [error(*patch), error(found[part], wanted[part])]
            yield [model, kind, usual["touch"]["vertex"], rank, condensed.get("masters", rank), *cells,
                   f"{condensed.get('vibration_share', 0):.4f}", report["status"]]


if __name__ == "__main__":
    sys.exit(write_table(__doc__, "touch", ["model", "touch_modes", "vertex", "rank", "stepped", "rising_place", "rising_body", "free_place",
                                            "free_body", "vibration_share", "status"], rows, "pulls.csv"))
