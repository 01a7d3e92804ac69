#!/usr/bin/env python3
"""What --handles does to motion: errors of the six models with the place of their load as a handle, and without.

usage: validation/handle_errors.py PROGRAM WORK_FOLDER [OUTPUT.csv]

For each model at its own rank and at 30: the error of the displacement against the full order under its own load and the four
tests of its recipe (0.5 s at steps of 2 ms), without a handle, and with `--handles` of the group of the load, whose six coordinates
come beside the rank. WORK_FOLDER keeps the full-order runs. Into OUTPUT.csv (validation/results/handles/errors.csv).
SPDX-License-Identifier: Apache-2.0
"""
import sys

from load_errors import LOADS, errors, recipe_of, write_table
from tables import MODELS


def rows(program, work):
    for model in MODELS:
        recipe = recipe_of(model)
        for rank in sorted({recipe["rank"], 30}):
            for handle, options in enumerate([[], ["--handles", recipe["load"]["group"]]]):
                made, found = errors(program, work, model, rank, options)
                yield [model, rank, handle, made, *found]


if __name__ == "__main__":
    sys.exit(write_table(__doc__, "handles", ["model", "rank_asked", "handle", "rank", *LOADS], rows))
