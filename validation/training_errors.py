#!/usr/bin/env python3
"""What trained shapes and weights by share do to motion: errors of the six models at equal rank.

usage: validation/training_errors.py PROGRAM WORK_FOLDER [OUTPUT.csv]

For each model: the error of the displacement against the full order under its own load and the four tests of its recipe (0.5 s at
steps of 2 ms), of modes and derivatives alone, and of a basis that is trained on the own load, with weights by frequency and by share
(`--by-share`). The rank is 30, and 15 of the beam. WORK_FOLDER keeps the full-order runs. Into OUTPUT.csv
(validation/results/training/errors.csv).
SPDX-License-Identifier: Apache-2.0
"""
import csv
import json
import pathlib
import subprocess
import sys

from tables import MODELS, RESULTS, ROOT

LOADS = ["own", "sine", "gravity", "another", "elsewhere"]
KINDS = ["untrained", "trained", "share"]
RANKS = {"beam": 15}


def errors(program, work, model, kind):
    """Modes, rank and the errors under the loads."""
    recipe = json.loads((ROOT / "models" / f"{model}.json").read_text(encoding="utf-8"))
    load = recipe["load"]
    own = "square:{:g},{:g},{:g}@{}".format(*(load["force"] * d for d in load["direction"]), load["group"])
    command = [program, "precompute", model, "--modes", str(recipe["modes"]), "--rank", str(RANKS.get(model, 30)), "-o",
               "model.npz", "--train-time", "0.5", "--train-dt", "0.002", "--keep-runs", "kept", "--json", "-q",
               "--test" if kind == "untrained" else "--train", own]
    for test in recipe["tests"]:
        command += ["--test", test]
    if kind == "share":
        command += ["--by-share"]
    done = subprocess.run(command, cwd=work, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 3):
        raise SystemExit(done.stderr)
    made = json.loads(done.stdout.strip().splitlines()[-1])
    found = [item["error"] for item in made["training"]["loads"]]
    return recipe["modes"], made["rank"], ["" if error is None else f"{error:.4g}" for error in found]


def main(arguments):
    if len(arguments) not in (2, 3):
        sys.stderr.write(__doc__)
        return 2
    program, work = str(pathlib.Path(arguments[0]).resolve()), pathlib.Path(arguments[1])
    output = pathlib.Path(arguments[2]) if len(arguments) == 3 else RESULTS / "training" / "errors.csv"
    work.mkdir(parents=True, exist_ok=True)
    output.parent.mkdir(parents=True, exist_ok=True)
    with open(output, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["model", "basis", "modes", "rank", *LOADS])
        for model in MODELS:
            for kind in KINDS:
                modes, rank, found = errors(program, work, model, kind)
                writer.writerow([model, kind, modes, rank, *found])
                file.flush()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
