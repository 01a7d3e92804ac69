#!/usr/bin/env python3
"""What levels of detail save and cost in the crowd of 100 bodies (examples/scenes/crowd.json).

usage: validation/scene_detail.py PROGRAM WORK_FOLDER [OUTPUT.csv]

The crowd is run with all coordinates, with the "error" that it names (without and with what an earlier run has found), with a
"budget" and with a "detail" while the eye flies over it. A row is a variant: how many bodies are condensed and in which share of
their steps the bodies are reduced, seconds for finding the numbers and for all steps (the least of three runs in turns, on the
clock), and the error of the shapes against the run with all coordinates, as relative root mean squares over the time: mean and
worst of the bodies, and the mean while a body is within the distance of its detail. Into OUTPUT.csv
(validation/results/scene_detail/crowd.csv). SPDX-License-Identifier: Apache-2.0
"""
import array
import csv
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys

from tables import RESULTS

ROOT = pathlib.Path(__file__).resolve().parent.parent
EYE, VELOCITY, BEYOND = [-6, 13, 2], [8, 0, 0], 8
DETAIL = {"condense": 2, "beyond": BEYOND, "jump": 0.001}
# what each body says in place of its "error"; None: as it is
VARIANTS = {"whole": {}, "error": None, "error_again": None, "budget": {"budget": 1.0e-6}, "detail": {"detail": DETAIL},
            "error_detail": {"error": 0.05, "detail": DETAIL}}
TURNS = 3
HEAD = ["variant", "condensed", "reduced_share", "changes", "largest_jump_m", "find_s", "step_s", "error_mean", "error_worst",
        "error_near"]


def write_scene(work, variant):
    """The crowd of the variant as a file."""
    scene = json.loads((ROOT / "examples" / "scenes" / "crowd.json").read_text(encoding="utf-8"))
    scene.update(eye=EYE, eye_velocity=VELOCITY)
    for body in scene["bodies"]:
        if VARIANTS[variant] is not None:
            del body["error"]
            body.update(VARIANTS[variant])
    path = work / f"{variant}.json"
    path.write_text(json.dumps(scene), encoding="utf-8")
    return path


def run(program, work, variant):
    """The object of one run. What an earlier run has found is there for error_again alone."""
    cache = work / "cache"
    if variant != "error_again":
        for found in (cache / "thrum").glob("detail-*"):
            found.unlink()
    done = subprocess.run([program, "simulate", write_scene(work, variant).name, "-o", f"run_{variant}", "--json", "-q"],
                          cwd=work, env=dict(os.environ, XDG_CACHE_HOME=str(cache)), capture_output=True, text=True, check=False)
    if done.returncode not in (0, 3):  # 3: a monitor does not believe one of the bodies
        raise SystemExit(done.stderr)
    return json.loads(done.stdout.strip().splitlines()[-1])


def read_rows(path):
    """The rows of a file of numpy with doubles."""
    data = path.read_bytes()
    size = int.from_bytes(data[8:10], "little")
    shape = json.loads(data[10:10 + size].decode().split("'shape':")[1].split(")")[0].replace("(", "[") + "]")
    numbers = array.array("d", data[10 + size:])
    return [numbers[n * shape[1]:(n + 1) * shape[1]] for n in range(shape[0])]


def distance(body, time):
    """From the eye to where the body stands, as nearly as matters here."""
    eye = [EYE[axis] + VELOCITY[axis] * time for axis in range(3)]
    return math.dist(eye, body["position"])


def errors(work, variant, bodies, dt):
    """The errors of all bodies, over all of the time and while each is near."""
    whole, near = [], []
    for body in bodies:
        sums = [[0, 0], [0, 0]]
        for step, (q, right) in enumerate(zip(read_rows(work / f"run_{variant}" / body["name"] / "q.npy"),
                                              read_rows(work / "run_whole" / body["name"] / "q.npy"))):
            away = sum((a - b) ** 2 for a, b in zip(q, right))
            size = sum(b ** 2 for b in right)
            for which in range(2):
                if which == 0 or distance(body, step * dt) < BEYOND:
                    sums[which][0] += away
                    sums[which][1] += size
        whole.append(math.sqrt(sums[0][0] / sums[0][1]))
        if sums[1][1] > 0:
            near.append(math.sqrt(sums[1][0] / sums[1][1]))
    return whole, near


def row(work, variant, made, find, step):
    scene = json.loads((ROOT / "examples" / "scenes" / "crowd.json").read_text(encoding="utf-8"))
    details = [body["detail"] for body in made["bodies"] if body.get("detail")]
    reduced = sum(detail["reduced_steps"] for detail in details)
    whole, near = errors(work, variant, scene["bodies"], made["dt_s"])
    return {"variant": variant, "condensed": sum(1 for body in made["bodies"] if body.get("condensed")),
            "reduced_share": f"{reduced / (100 * made['steps']):.4g}", "changes": sum(int(d["changes"]) for d in details),
            "largest_jump_m": f"{max((d['largest_jump_m'] for d in details), default=0):.3g}", "find_s": f"{find:.4g}",
            "step_s": f"{step:.4g}", "error_mean": f"{sum(whole) / len(whole):.4g}", "error_worst": f"{max(whole):.4g}",
            "error_near": f"{sum(near) / len(near):.4g}"}


def main(arguments):
    if len(arguments) not in (2, 3):
        sys.stderr.write(__doc__)
        return 2
    program, work = str(pathlib.Path(arguments[0]).resolve()), pathlib.Path(arguments[1])
    output = pathlib.Path(arguments[2]) if len(arguments) == 3 else RESULTS / "scene_detail" / "crowd.csv"
    shutil.rmtree(work, ignore_errors=True)
    (work / "cache").mkdir(parents=True)
    work = work.resolve()

    # in turns, so that other work on the machine is spread over the variants
    made = {variant: [] for variant in VARIANTS}
    for _ in range(TURNS):
        for variant in VARIANTS:
            made[variant].append(run(program, work, variant))
    rows = []
    for variant, runs in made.items():
        find, step = (min(one["seconds"][key] for one in runs) for key in ("find", "step"))
        rows.append(row(work, variant, runs[-1], find, step))
    output.parent.mkdir(parents=True, exist_ok=True)
    with open(output, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, HEAD, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
