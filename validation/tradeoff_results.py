#!/usr/bin/env python3
"""Runs `thrum tradeoff` on the six models for the committed results: 5 % and 2 % under their own load.

usage: validation/tradeoff_results.py PROGRAM WORK_FOLDER [OUTPUT_FOLDER]

What WORK_FOLDER holds already (rE_MODEL.json, of an error of E %) is not run again. Into OUTPUT_FOLDER
(validation/results/tradeoff) go MODEL.csv and MODEL.about.json, all runs of the search for 2 %, and picks.json.
SPDX-License-Identifier: Apache-2.0
"""
import json
import pathlib
import shutil
import subprocess
import sys

from tables import MODELS, RESULTS, ROOT

ERRORS = ["5", "2"]
MODEL_FILES = ROOT / "models"
KEPT = ("modes", "rank", "trained", "masters", "integrator", "dt", "cost_s_per_s", "times_faster_than_full", "error",
        "projection_error", "cancels", "flag", "frequency_error", "cubature")


def run(program, work, model, error):
    """The printed object of one search."""
    name = f"r{error}_{model}"
    path = work / f"{name}.json"
    if not path.exists():
        command = [program, "tradeoff", model, "-o", name, "--quick", "--error", f"{error}%", "--keep-runs", "kept",
                   "--json", "-q"]
        for test in json.loads((MODEL_FILES / f"{model}.json").read_text(encoding="utf-8"))["tests"]:
            command += ["--test", test]
        done = subprocess.run(command, cwd=work, capture_output=True, text=True, check=False)
        if done.returncode not in (0, 3):
            raise SystemExit(done.stderr)
        path.write_text(done.stdout, encoding="utf-8")
    return json.loads(path.read_text(encoding="utf-8").strip().splitlines()[-1])


def pick(model, error, found):
    """What picks.json says of one search."""
    chosen = found["recommended"]
    item = {"model": model, "asked": float(error) / 100, "full": found["full"]}
    if chosen is not None:
        item.update({key: chosen[key] for key in KEPT}, basis_error=chosen["basis_errors"]["displacement"],
                    tests=found["tests"])
    return item


def main(arguments):
    if len(arguments) not in (2, 3):
        sys.stderr.write(__doc__)
        return 2
    program, work = str(pathlib.Path(arguments[0]).resolve()), pathlib.Path(arguments[1])
    output = pathlib.Path(arguments[2]) if len(arguments) == 3 else RESULTS / "tradeoff"
    work.mkdir(parents=True, exist_ok=True)
    picks = []
    for model in MODELS:
        for error in ERRORS:
            picks.append(pick(model, error, run(program, work, model, error)))
        for suffix in ("csv", "about.json"):
            shutil.copy(work / f"r2_{model}" / f"tradeoff.{suffix}", output / f"{model}.{suffix}")
    (output / "picks.json").write_text("[\n" + ",\n".join(json.dumps(item) for item in picks) + "\n]\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
