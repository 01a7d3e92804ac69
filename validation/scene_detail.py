#!/usr/bin/env python3
"""What levels of detail save and cost in the crowd of 100 bodies (examples/scenes/crowd.json).

usage: validation/scene_detail.py PROGRAM WORK_FOLDER [OUTPUT.csv]

The crowd is run with all coordinates, with the "error" that it names (without and with what an earlier run has found), with a
"budget" and with a "detail" while the eye flies over it. A row is a variant: how many bodies are condensed and in which share of
their steps the bodies are reduced, seconds for finding the numbers and for all steps (the least of three runs in turns, on the
clock), and the error of the shapes against the run with all coordinates, as relative root mean squares over the time: mean and
worst of the bodies, and the mean while a body is within the distance of its detail. Into OUTPUT.csv
(validation/results/scene_detail/crowd.csv).

A second table has what a level of detail does to a body that rests until something acts on it after 1 s: the error of the run
with a detail while still, and while far. Into impacts.csv beside the first. SPDX-License-Identifier: Apache-2.0
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


BEAM = {"name": "b", "model": "beam"}
DAMPED = {"time": 3, "damping": [0.6, 0]}
FLOOR = {"time": 2, "gravity": [0, 0, -9.81], "obstacles": [{"shape": "plane"}]}
FREE = {"name": "b", "model": "beam:8x2x2@0.8x0.2x0.2", "free": True, "position": [0, 0, 1]}
BALL = {"shape": "sphere", "radius": 0.05, "centre": [0.9, 0.075, 1.5], "velocity": [0, 0, -1]}
# what acts: the scene, and the body in it
IMPACTS = {
    "an impact along the beam": (DAMPED, {**BEAM, "loads": "impulse:40,0,0@load,from=1"}),
    "an impact across it": (DAMPED, {**BEAM, "loads": "impulse:0,0,-40@load,from=1"}),
    "an impact across it, half way": (DAMPED, {**BEAM, "loads": "impulse:0,40,0@vertex=91,from=1.002"}),
    "a push of 0.3 s": (DAMPED, {**BEAM, "loads": "square:0,13,0@load,from=1,until=1.3"}),
    "a sine of 2 Hz": (DAMPED, {**BEAM, "loads": "sine:0,0,-6.5@load,f=2,from=1"}),
    "a ground that shakes for 0.5 s": ({**DAMPED, "base_motion": "sine:0,20,0,f=2,from=1,until=1.5"}, BEAM),
    "a ball that hits it": ({**DAMPED, "obstacles": [BALL]}, BEAM),
    "a free beam drops on a floor": (FLOOR, FREE),
    "it drops askew": (FLOOR, {**FREE, "rotation": {"axis": [1, 0.3, 0], "angle": 20}}),
    "an impact at the tower": (DAMPED, {**BEAM, "model": "tower", "loads": "impulse:2000,0,0@load,from=1"}),
}
LEVELS = {"whole": None, "still": {"condense": 2, "still": 0.02, "jump": 0.002},
          "far": {"condense": 2, "beyond": 1, "jump": 0.002}}


def impact(program, work, name):
    """The row of one thing that acts."""
    scene, body = IMPACTS[name]
    found, shapes = {"what": name}, {}
    for level, detail in LEVELS.items():
        made = {**scene, "dt": 0.002, "eye": [-50, 0, 0], "bodies": [{**body, "detail": detail} if detail else body]}
        (work / "impact.json").write_text(json.dumps(made), encoding="utf-8")
        done = subprocess.run([program, "simulate", "impact.json", "-o", "impact", "--json", "-q"], cwd=work, capture_output=True,
                              text=True, check=False)
        if done.returncode != 0:
            raise SystemExit(done.stderr)
        shapes[level] = read_rows(work / "impact" / "b" / "q.npy")
        if detail:
            away = sum((a - b) ** 2 for p, q in zip(shapes[level], shapes["whole"]) for a, b in zip(p, q))
            size = sum(b * b for q in shapes["whole"] for b in q)
            report = json.loads(done.stdout.strip().splitlines()[-1])
            found[f"{level}_error"] = f"{math.sqrt(away / size):.4g}"
            found[f"{level}_share"] = f"{report['bodies'][0]['detail']['reduced_steps'] / report['steps']:.4g}"
    return found


def write(path, found):
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(found[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(found)


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
    write(output, rows)
    write(output.with_name("impacts.csv"), [impact(program, work, name) for name in IMPACTS])
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
