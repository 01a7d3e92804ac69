"""Errors of the six models under their own load and the tests of their recipes, for tables that compare bases.

Made by `thrum precompute`, against the full order, over 0.5 s at steps of 2 ms. SPDX-License-Identifier: Apache-2.0
"""
import csv
import json
import pathlib
import subprocess
import sys

from tables import RESULTS, ROOT

LOADS = ["own", "sine", "gravity", "another", "elsewhere"]


def recipe_of(model):
    return json.loads((ROOT / "models" / f"{model}.json").read_text(encoding="utf-8"))


def errors(program, work, model, rank, options, own="--test", modes=None):
    """The rank of the model and its errors under LOADS; own: the option that the model's own load is given by;
    modes: those of the recipe where they are not given."""
    recipe = recipe_of(model)
    load = recipe["load"]
    square = "square:{:g},{:g},{:g}@{}".format(*(load["force"] * d for d in load["direction"]), load["group"])
    command = [program, "precompute", model, "--modes", str(modes or recipe["modes"]), "--rank", str(rank), "-o", "model.npz",
               "--train-time", "0.5", "--train-dt", "0.002", "--keep-runs", "kept", "--json", "-q", own, square, *options]
    for test in recipe["tests"]:
        command += ["--test", test]
    done = subprocess.run(command, cwd=work, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 3):
        raise SystemExit(done.stderr)
    made = json.loads(done.stdout.strip().splitlines()[-1])
    found = [item["error"] for item in made["training"]["loads"]]
    return made["rank"], ["" if error is None else f"{error:.4g}" for error in found]


def write_table(usage, folder, columns, rows, name="errors.csv"):
    """The script: PROGRAM WORK_FOLDER [OUTPUT.csv]. Writes rows(program, work) as they come; returns the exit code."""
    arguments = sys.argv[1:]
    if len(arguments) not in (2, 3):
        sys.stderr.write(usage)
        return 2
    program, work = str(pathlib.Path(arguments[0]).resolve()), pathlib.Path(arguments[1])
    output = pathlib.Path(arguments[2]) if len(arguments) == 3 else RESULTS / folder / name
    work.mkdir(parents=True, exist_ok=True)
    output.parent.mkdir(parents=True, exist_ok=True)
    with open(output, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        for row in rows(program, work):
            writer.writerow(row)
            file.flush()
    return 0
