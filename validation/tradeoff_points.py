#!/usr/bin/env python3
"""What cubature points gain in `thrum tradeoff`: picks with and without them, and those of another law.

usage: validation/tradeoff_points.py PROGRAM WORK_FOLDER [OUTPUT_FOLDER]

Each case is `thrum tradeoff MODEL --quick --error E` under the model's own load, once with --cubature off and once with auto; of
another law there are points alone. What WORK_FOLDER holds already is not run again; it keeps the full-order runs, so that both are
against the same one. Into OUTPUT_FOLDER (validation/results/tradeoff_points) go the runs of each search,
MODEL_LAW_CUBATURE.csv and .about.json, and picks.json. SPDX-License-Identifier: Apache-2.0
"""
import json
import pathlib
import shutil
import subprocess
import sys

from tables import RESULTS
from tradeoff_results import pick

# model, error in per cent, law
CASES = [("bridge", "2", "stvk"), ("horse", "2", "stvk"), ("heart", "5", "neo-hookean")]


def run(program, work, case, cubature):
    """The printed object of one search, and the folder that it wrote."""
    model, error, law = case
    name = f"{model}_{error}_{law}_{cubature}"
    path = work / f"{name}.json"
    if not path.exists():
        command = [program, "tradeoff", model, "-o", name, "--quick", "--error", f"{error}%", "--law", law, "--cubature",
                   cubature, "--test", "none", "--keep-runs", "kept", "--json", "-q"]
        done = subprocess.run(command, cwd=work, capture_output=True, text=True, check=False)
        if done.returncode not in (0, 3):
            raise SystemExit(done.stderr)
        path.write_text(done.stdout, encoding="utf-8")
    return json.loads(path.read_text(encoding="utf-8").strip().splitlines()[-1]), work / name


def main(arguments):
    if len(arguments) not in (2, 3):
        sys.stderr.write(__doc__)
        return 2
    program, work = str(pathlib.Path(arguments[0]).resolve()), pathlib.Path(arguments[1])
    output = pathlib.Path(arguments[2]) if len(arguments) == 3 else RESULTS / "tradeoff_points"
    work.mkdir(parents=True, exist_ok=True)
    output.mkdir(parents=True, exist_ok=True)
    picks = []
    for case in CASES:
        model, error, law = case
        for cubature in ("off", "auto") if law == "stvk" else ("auto",):
            found, folder = run(program, work, case, cubature)
            picks.append({"law": law, "tried": cubature, **pick(model, error, found)})
            for suffix in ("csv", "about.json"):
                shutil.copy(folder / f"tradeoff.{suffix}", output / f"{model}_{law}_{cubature}.{suffix}")
    (output / "picks.json").write_text("[\n" + ",\n".join(json.dumps(item) for item in picks) + "\n]\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
