#!/usr/bin/env python3
"""What trained shapes and weights by share do to motion: errors of the six models at equal rank.

usage: validation/training_errors.py PROGRAM WORK_FOLDER [OUTPUT.csv]

For each model: the error of the displacement against the full order under its own load and the four tests of its recipe (0.5 s at
steps of 2 ms), of modes and derivatives alone, and of a basis that is trained on the own load, with weights by frequency and by share
(`--by-share`). The rank is 30, and 15 of the beam. WORK_FOLDER keeps the full-order runs. Into OUTPUT.csv
(validation/results/training/errors.csv).
SPDX-License-Identifier: Apache-2.0
"""
import sys

from load_errors import LOADS, errors, recipe_of, write_table
from tables import MODELS

# a basis, the option that the own load is given by, and more options
BASES = [("untrained", "--test", []), ("trained", "--train", []), ("share", "--train", ["--by-share"])]
RANKS = {"beam": 15}


def rows(program, work):
    for model in MODELS:
        for basis, own, options in BASES:
            rank, found = errors(program, work, model, RANKS.get(model, 30), options, own)
            yield [model, basis, recipe_of(model)["modes"], rank, *found]


if __name__ == "__main__":
    sys.exit(write_table(__doc__, "training", ["model", "basis", "modes", "rank", *LOADS], rows))
