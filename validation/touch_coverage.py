#!/usr/bin/env python3
"""How the six models follow pulls all over their surface, without touch modes, with them up to rank 40 and up to rank 100.

usage: validation/touch_coverage.py PROGRAM WORK_FOLDER [OUTPUT.csv]

For each model of its recipe: the least and the mean share of the mesh's linear static answer (`thrum precompute --touch`), the
places, and the time of a step of `energy` at the default step in a swing of a twentieth of the longest side (`thrum bench step`,
the three in turns, the least of 60 batches of 16 steps). Into OUTPUT.csv (validation/results/touch/coverage.csv).
SPDX-License-Identifier: Apache-2.0
"""
import json
import subprocess
import sys

from load_errors import recipe_of, write_table
from tables import MODELS

LIMITS = [0, 40, 100]
TURNS = 3


def asked(work, *command):
    """The JSON line of a command; flagged models count."""
    done = subprocess.run(command, cwd=work, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 3):
        raise SystemExit(done.stderr)
    return json.loads(done.stdout.strip().splitlines()[-1])


def coverage_of(program, work, model, limit):
    """Makes the model; its rank, its touch modes, and how it follows."""
    file = f"{model}-{limit}.npz"
    if limit == 0:
        asked(work, program, "precompute", model, "-o", file, "--json", "-q")
        found = asked(work, program, "info", file, "--touch", "--json")
        return found["rank"], 0, found["touch"]
    made = asked(work, program, "precompute", model, "-o", file, "--touch", "--rank-max", str(limit), "--json", "-q")
    return made["rank"], made["touch"]["modes"], made["touch"]["after"]


def step_times(program, work, model):
    """Microseconds of a step of each of the three, in turns."""
    box = asked(work, program, "info", f"{model}-0.npz", "--json")
    longest = max(most - least for least, most in zip(box["box_min_m"], box["box_max_m"]))
    least = dict.fromkeys(LIMITS, float("inf"))
    for _ in range(TURNS):
        for limit in LIMITS:
            found = asked(work, program, "bench", "step", f"{model}-{limit}.npz", "--batches", "20", "--steps", "16", "--no-machine", "--swing",
                          f"{0.05 * longest:g}", "--json", "-q")
            row = found["rows"][0] if "rows" in found else found
            least[limit] = min(least[limit], row["us_per_step"])
    return least


def rows(program, work):
    for model in MODELS:
        made = {limit: coverage_of(program, work, model, limit) for limit in LIMITS}
        times = step_times(program, work, model)
        for limit, (rank, modes, touch) in made.items():
            yield [model, recipe_of(model)["modes"], limit, rank, modes, f"{touch['worst']:.4f}", f"{touch['mean']:.4f}",
                   touch["places"], touch["stiff_places"], f"{times[limit]:.2f}"]


if __name__ == "__main__":
    sys.exit(write_table(__doc__, "touch", ["model", "modes", "rank_max", "rank", "touch_modes", "worst", "mean", "places",
                                            "stiff_places", "us_per_step"], rows, "coverage.csv"))
