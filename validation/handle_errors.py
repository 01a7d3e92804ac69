#!/usr/bin/env python3
"""What --handles does to motion: errors of the six models with the place of their load as a handle, and without.

usage: validation/handle_errors.py PROGRAM WORK_FOLDER [OUTPUT.csv]

For each model at its own rank and at 30: the error of the displacement against the full order under its own load and the four
tests of its recipe (0.5 s at steps of 2 ms), without a handle, and with `--handles` of the group of the load, whose six coordinates
come beside the rank. WORK_FOLDER keeps the full-order runs. Into OUTPUT.csv (validation/results/handles/errors.csv).
SPDX-License-Identifier: Apache-2.0
"""
import csv
import json
import pathlib
import subprocess
import sys

from tables import MODELS, RESULTS, ROOT

LOADS = ["own", "sine", "gravity", "another", "elsewhere"]


def errors(program, work, model, rank, handle):
    """The errors under the loads, and the rank of the model."""
    recipe = json.loads((ROOT / "models" / f"{model}.json").read_text(encoding="utf-8"))
    load = recipe["load"]
    own = "square:{:g},{:g},{:g}@{}".format(*(load["force"] * d for d in load["direction"]), load["group"])
    command = [program, "precompute", model, "--modes", str(recipe["modes"]), "--rank", str(rank), "-o", "model.npz",
               "--train-time", "0.5", "--train-dt", "0.002", "--keep-runs", "kept", "--json", "-q"]
    for test in [own, *recipe["tests"]]:
        command += ["--test", test]
    if handle:
        command += ["--handles", load["group"]]
    done = subprocess.run(command, cwd=work, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 3):
        raise SystemExit(done.stderr)
    made = json.loads(done.stdout.strip().splitlines()[-1])
    found = [item["error"] for item in made["training"]["loads"]]
    return made["rank"], ["" if error is None else f"{error:.4g}" for error in found]


def main(arguments):
    if len(arguments) not in (2, 3):
        sys.stderr.write(__doc__)
        return 2
    program, work = str(pathlib.Path(arguments[0]).resolve()), pathlib.Path(arguments[1])
    output = pathlib.Path(arguments[2]) if len(arguments) == 3 else RESULTS / "handles" / "errors.csv"
    work.mkdir(parents=True, exist_ok=True)
    output.parent.mkdir(parents=True, exist_ok=True)
    with open(output, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["model", "rank_asked", "handle", "rank", *LOADS])
        for model in MODELS:
            recipe = json.loads((ROOT / "models" / f"{model}.json").read_text(encoding="utf-8"))
            for rank in sorted({recipe["rank"], 30}):
                for handle in (0, 1):
                    made, found = errors(program, work, model, rank, handle == 1)
                    writer.writerow([model, rank, handle, made, *found])
                    file.flush()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
