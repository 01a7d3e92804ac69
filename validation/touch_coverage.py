#!/usr/bin/env python3
"""How the six models follow pulls all over their surface: without touch modes, with modes that follow, and with modes that are stepped.

usage: validation/touch_coverage.py PROGRAM WORK_FOLDER [OUTPUT.csv]

For each model of its recipe, without, with `--touch`, and with `--touch-stepped` up to rank 40 and up to rank 100: the least and the
mean share of the mesh's linear static answer, the places, and the time of a step of `energy` at the default step in a swing of a
twentieth of the longest side (`thrum bench step`, the four in turns, the least of 60 batches of 16 steps). Into OUTPUT.csv
(validation/results/touch/coverage.csv).
SPDX-License-Identifier: Apache-2.0
"""
import json
import subprocess
import sys

from load_errors import recipe_of, write_table
from tables import MODELS

KINDS = {"usual": [], "follows": ["--touch"], "stepped-40": ["--touch-stepped", "--rank-max", "40"],
         "stepped-100": ["--touch-stepped", "--rank-max", "100"]}
TURNS = 3


def asked(work, *command):
    """The JSON line of a command; flagged models count."""
    done = subprocess.run(command, cwd=work, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 3):
        raise SystemExit(done.stderr)
    return json.loads(done.stdout.strip().splitlines()[-1])


def make_model(program, work, model, kind):
    """The file of the model, which is made where the folder has none."""
    file = f"{model}-{kind}.npz"
    if not (work / file).exists():
        asked(work, program, "precompute", model, "-o", file, "--json", "-q", *KINDS[kind])
    return file


def coverage_of(program, work, model, kind):
    """The rank of the model, and how it follows."""
    found = asked(work, program, "info", make_model(program, work, model, kind), "--touch", "--json")
    return found["rank"], found["touch"]


def step_times(program, work, model):
    """Microseconds of a step of each, in turns."""
    box = asked(work, program, "info", f"{model}-usual.npz", "--json")
    longest = max(most - least for least, most in zip(box["box_min_m"], box["box_max_m"]))
    least = dict.fromkeys(KINDS, float("inf"))
    for _ in range(TURNS):
        for kind in KINDS:
            found = asked(work, program, "bench", "step", f"{model}-{kind}.npz", "--batches", "20", "--steps", "16", "--no-machine", "--swing",
                          f"{0.05 * longest:g}", "--json", "-q")
            row = found["rows"][0] if "rows" in found else found
            least[kind] = min(least[kind], row["us_per_step"])
    return least


def rows(program, work):
    for model in MODELS:
        made = {kind: coverage_of(program, work, model, kind) for kind in KINDS}
        times = step_times(program, work, model)
        usual = made["usual"][0]
        for kind, (rank, touch) in made.items():
            yield [model, recipe_of(model)["modes"], kind, rank, usual if kind == "follows" else rank, rank - usual, f"{touch['worst']:.4f}", f"{touch['mean']:.4f}",
                   touch["places"], touch["stiff_places"], f"{times[kind]:.2f}"]


if __name__ == "__main__":
    sys.exit(write_table(__doc__, "touch", ["model", "modes", "kind", "rank", "stepped", "touch_modes", "worst", "mean", "places",
                                            "stiff_places", "us_per_step"], rows, "coverage.csv"))
