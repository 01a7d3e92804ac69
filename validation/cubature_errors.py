#!/usr/bin/env python3
"""What cubature does to motion: runs of the six models by points beside runs by the polynomial of the same basis.

usage: validation/cubature_errors.py PROGRAM WORK_FOLDER [OUTPUT.csv]

Each model with the modes of its recipe at rank 30, by the polynomial and by points for three errors of the force, under its own
load (0.5 s at steps of 2 ms, energy). motion_error is the root mean square over the run of the displacement's difference in the
norm of the mass, over that of the displacement: what points add to the error of the basis. Into OUTPUT.csv
(validation/results/cubature/errors.csv). Needs NumPy.
SPDX-License-Identifier: Apache-2.0
"""
import json
import subprocess
import sys

import numpy

from load_errors import recipe_of, write_table
from tables import MODELS

ERRORS = [0.05, 0.01, 0.003]
RANK = 30


def call(program, work, *arguments):
    """The printed object of a command; 3 says that points miss their error, which the table shows."""
    done = subprocess.run([program, *arguments, "--json", "-q"], cwd=work, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 3):
        raise SystemExit(done.stderr)
    return json.loads(done.stdout.strip().splitlines()[-1])


def run(program, work, model, options):
    """What precompute says of the model, and its coordinates over the time."""
    recipe = recipe_of(model)
    load = recipe["load"]
    square = "square:{:g},{:g},{:g}@{}".format(*(load["force"] * d for d in load["direction"]), load["group"])
    made = call(program, work, "precompute", model, "--modes", str(recipe["modes"]), "--rank", str(RANK), "-o", "model.npz",
                *options)
    call(program, work, "simulate", "model.npz", "-o", "run", "--load", square, "--time", "0.5", "--dt", "0.002",
         "--monitor", "off")
    return made, numpy.load(work / "run" / "q.npy")


def rows(program, work):
    for model in MODELS:
        _, exact = run(program, work, model, [])
        for error in ERRORS:
            made, q = run(program, work, model, ["--cubature", "--cubature-error", str(error)])
            points = made["cubature"]
            difference = numpy.sqrt(numpy.sum((q - exact) ** 2) / numpy.sum(exact ** 2))
            yield [model, RANK, error, points["range"], points["points"], f"{points['test_error']:.4g}",
                   f"{points['force_cost']:.3g}", f"{difference:.4g}"]


if __name__ == "__main__":
    sys.exit(write_table(__doc__, "cubature", ["model", "rank", "error_asked", "range", "points", "force_error", "force_cost",
                                               "motion_error"], rows))
