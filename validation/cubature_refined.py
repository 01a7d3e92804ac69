#!/usr/bin/env python3
"""What learned gradients of cubature points gain: the six models with as many points of both kinds.

usage: validation/cubature_refined.py PROGRAM WORK_FOLDER [OUTPUT.csv]

Each model with the modes of its recipe at rank 30 and 30 and 60 points, once as the least squares choose them and once with
--cubature-refine 10000. force_error is that in states that were not trained on; motion_error is made as by cubature_errors.py.
Into OUTPUT.csv (validation/results/cubature/refined.csv). Needs NumPy.
SPDX-License-Identifier: Apache-2.0
"""
import sys

import numpy

from cubature_errors import RANK, run
from load_errors import write_table
from tables import MODELS

POINTS = [30, 60]
STEPS = 10000


def rows(program, work):
    for model in MODELS:
        _, exact = run(program, work, model, [])
        for count in POINTS:
            # the error is out of reach, so that the number of points decides
            options = ["--cubature", "--cubature-error", "1e-9", "--cubature-points", str(count)]
            for steps in (0, STEPS):
                made, q = run(program, work, model, [*options, "--cubature-refine", str(steps)])
                points = made["cubature"]
                difference = numpy.sqrt(numpy.sum((q - exact) ** 2) / numpy.sum(exact ** 2))
                yield [model, RANK, steps, points["points"], points["states"], f"{points['train_error']:.4g}",
                       f"{points['test_error']:.4g}", f"{difference:.4g}"]


if __name__ == "__main__":
    sys.exit(write_table(__doc__, "cubature", ["model", "rank", "steps", "points", "states", "train_error", "force_error",
                                               "motion_error"], rows, "refined.csv"))
