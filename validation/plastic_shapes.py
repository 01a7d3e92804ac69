#!/usr/bin/env python3
"""The shape in which a bent beam stays: models of cubature points beside the unreduced mesh.

usage: validation/plastic_shapes.py PROGRAM WORK_FOLDER [OUTPUT.csv]

A beam of 1 m of corotational material, with a yield strain of 0.02, is pulled at its tip by 30 and by 80 N for 0.3 s, let go and
stopped by damping. For each model: its points, their largest stiffness over that of the body, the rms of the displacement at 1.2 s
less that of the unreduced mesh, over the latter, and the plastic work over that of the mesh. Into OUTPUT.csv
(validation/results/plastic/shapes.csv). SPDX-License-Identifier: Apache-2.0
"""
import array
import base64
import json
import math
import re
import subprocess
import sys

from load_errors import write_table

BEAM = ["beam:10x2x2@1x0.15x0.15", "--young", "1e6", "--fix", "x<0.001", "--law", "corotational"]
TRAINED = ["--modes", "8", "--rank", "20", "--yield", "0.02", "--train", "square:0,0,-80@tip,until=0.3", "--train-time", "1.2",
           "--train-dt", "0.002", "--train-damping", "6"]
ELASTIC = ["--modes", "8", "--rank", "30"]
MODELS = {
    "few": ["--modes", "4", "--rank", "9", "--cubature-error", "0.05"],
    "elastic30": [*ELASTIC, "--cubature-error", "0.005"],
    "elastic60": ["--modes", "20", "--rank", "60", "--cubature-error", "0.005"],
    "trained": [*TRAINED, "--cubature-error", "0.005"],
    "trained_fewer": [*TRAINED, "--cubature-error", "0.02"],
}
PULLS = (30, 80)


def thrum(program, *arguments):
    run = subprocess.run([program, *arguments, "-q"], capture_output=True, text=True)
    if run.returncode not in (0, 3):
        raise SystemExit(run.stderr)


def end_of(program, folder, body, pull):
    """The displacements at the end of a run, and its figures."""
    steps = 600
    accepted = [] if "--full" in body else ["--untrained-flow", "on"]
    thrum(program, "simulate", *body, *accepted, "-o", str(folder), "--yield", "0.02", "--load", f"square:0,0,-{pull}@tip,until=0.3",
          "--time", "1.2", "--dt", "0.002", "--damping", "6", "--frames", f"every-{steps}")
    frame = sorted((folder / "frames").glob("*.vtu"))[-1].read_text(encoding="ascii")
    numbers = array.array("d")
    numbers.frombytes(base64.b64decode(re.search(r'Name="displacement"[^>]*>\s*([A-Za-z0-9+/=]+)', frame)[1])[8:])
    return numbers, json.loads((folder / "run.json").read_text(encoding="utf-8"))


def rows(program, work):
    mesh = {pull: end_of(program, work / f"mesh_{pull}", [*BEAM, "--full"], pull) for pull in PULLS}
    for name, options in MODELS.items():
        model = work / f"{name}.npz"
        thrum(program, "precompute", *BEAM, "--cubature", *options, "-o", str(model))
        row = []
        for pull in PULLS:
            shape, figures = end_of(program, work / "model", [str(model)], pull)
            right, whole = mesh[pull]
            error = math.sqrt(sum((a - b) ** 2 for a, b in zip(shape, right)) / sum(b * b for b in right))
            row += [f"{error:.4g}", f"{figures['work']['plastic_j'] / whole['work']['plastic_j']:.4g}"]
        info = subprocess.run([program, "info", str(model), "--json"], capture_output=True, text=True, check=True)
        yield [name, " ".join(options), json.loads(info.stdout)["cubature_points"], f"{figures['point_stiffness']:.4g}", *row]


if __name__ == "__main__":
    sys.exit(write_table(__doc__, "plastic", ["model", "options", "points", "point_stiffness", "error_30", "work_30", "error_80",
                                              "work_80"], rows, "shapes.csv"))
