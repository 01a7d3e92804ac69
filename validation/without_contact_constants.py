#!/usr/bin/env python3
"""What each tuned constant of contact and statics does: short cases with the constant put out of effect.

usage: validation/without_contact_constants.py WORK_FOLDER

The program is built as for without_constants.py, with the constants below as variables. contact_cases.py has the cases: scenes of
a second at most, and equilibria. A row of validation/results/without_contact_constants.csv says of a constant in how many cases a
bit of the run changed, which cases moved, where most, and what became of the work: sweeps over the rows between bodies, or Newton
iterations of equilibria.

A case has moved where it ends otherwise, or where a figure of it differs by more than 1 % of its scale and three times as far as
under any of four small changes of the case itself: bodies that begin up to 10 nm elsewhere, loads that differ by 1e-9. That is
its noise; what collides is chaotic. It takes some 5 minutes on one core; answers that WORK_FOLDER has already are taken over.
Needs git, cmake and a compiler. SPDX-License-Identifier: Apache-2.0
"""
import csv
import hashlib
import json
import math
import os
import pathlib
import resource
import subprocess
import sys

from contact_cases import EQUILIBRIA, scenes
from without_constants import MOVED, NEVER, RESULTS, build, write

# by file; what puts each out of effect
CONSTANTS = [
    ("contact/contact_rows.c", {"ENTRY_HALVINGS": "1", "TOGETHER": "1"}),
    ("contact/contact_row.c", {"RECOVERY": "1"}),
    ("contact/contact_row.h", {"THRUM_SOON": "1", "THRUM_RESTING": "0", "THRUM_ROUNDING": "0"}),
    ("contact/contact_impact.c", {"SOFT": NEVER, "SWEEPS_MAX": "5000", "TOLERANCE": "0", "ROUNDING": "0",
                                  "HALVINGS": "0"}),
    ("contact/contact_impact.h", {"THRUM_IMPACTS_MAX": "1"}),
    ("contact/contact_pairs_private.h", {"THRUM_NEAR": "0", "THRUM_PAIRS_THICKNESS": "8e-3"}),
    ("contact/contact_pairs_solve.c", {"HARDER": "1"}),
    ("contact/contact_pairs_energy.c", {"TOO_DEEP": NEVER}),
    ("contact/contact_pairs_rows.c", {"DEEPEST": NEVER}),
    ("contact/contact_pairs_search.c", {"MARGIN": "0", "STANDS_OUT": "0", "SHARP": "0", "ASKEW": "0"}),
    ("contact/contact_skin.h", {"THRUM_SKIN_FLAT": "0"}),
    ("contact/contact_pairs_step.c", {"REPEATS_MAX": "1", "MISSED": "0"}),
    ("contact/contact_pairs_solid.c", {"HALF_TURN": "0"}),
    ("contact/contact_distance.c", {"ADVANCES_MAX": "6400"}),
    ("contact/contact_distance.h", {"THRUM_MET": "1e-9"}),
    ("runtime/statics/equilibrium.c", {"CORRECTION": NEVER, "SHORTEST": "0x1p-45", "BEYOND": "0", "LINEAR": NEVER, "PLACE_TRIES": "4000",
                               "PLACE_NEAR": "0"}),
    ("runtime/statics/equilibrium_search.c", {"ROUNDING": "0", "STALLED": "0", "SHORT": "0", "SHORT_MOST": "1000000", "LEAP_STEPS": "1",
                                      "NEAR_ITERATIONS": "1000"}),
]
NOISE = (-1.0, -0.3, 0.3, 1.0)  # small changes of a case
PATIENCE = 10                   # seconds of processor time: a run that takes longer has ended otherwise
THICKNESS = 7e-4                # between two blocks [m]: a body that went less far is at rest


def answer_of(status, files, figures, work):
    """How a case ended: its status, a hash of what it wrote, figures with their scales, and the work it took."""
    bits = hashlib.sha256(b"".join(path.read_bytes() for path in files if path.exists())).hexdigest()
    return {"status": status, "bits": bits, "figures": figures, "work": work}


def run(command, varied, work):
    """The JSON that a command prints, and its exit code; nothing where it took too long."""
    environment = dict(os.environ, THRUM_VARIED=varied, XDG_CACHE_HOME=str(work / "cache"), OPENBLAS_NUM_THREADS="1")
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False,
                          preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (PATIENCE, PATIENCE)))
    return json.loads(done.stdout or "{}"), done.returncode


def figures_of_place(folder):
    """Where a free body is at the end, against how far it went, and how its x and z axes point."""
    data = (folder / "places.npy").read_bytes()
    rows = memoryview(data[10 + int.from_bytes(data[8:10], "little"):]).cast("d")
    start, place, (w, x, y, z) = rows[:3], rows[-7:-4], rows[-4:]
    way = max(math.dist(start, place), THICKNESS)
    axes = (1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y),
            2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y))
    return {**{f"place {axis}": (at, way) for axis, at in zip("xyz", place)},
            **{f"axis {n}": (cosine, 1) for n, cosine in enumerate(axes)}}


def figures_of_scene(folder, answer):
    """Places of free bodies, energies against the largest, and counts; and the sweeps that were made."""
    figures, shared = {}, answer["collisions"] or {}
    reports, energy = [shared] if shared else [], max(body["energy_max_j"] for body in answer["bodies"])
    for body in answer["bodies"]:
        place = folder / body["name"]
        if (place / "places.npy").exists():
            figures.update({f"{body['name']} {figure}": found for figure, found in figures_of_place(place).items()})
        report = json.loads((place / "run.json").read_text(encoding="utf-8")).get("contact")
        reports += [report] if report else []

    # what contact lost, and the steps that it had to make again, with obstacles and between bodies
    for key, scale in (("lost_j", energy), ("redone_steps", 1), ("declined_steps", 1), ("dropped_touches", 1)):
        figures[key] = (sum(report[key] for report in reports), scale)
    figures["deepest"] = (shared.get("deepest_of_thickness", 0), 1)
    return figures, shared.get("sweeps", 0)


def try_scene(program, scene, folder, varied, change):
    made = json.loads(json.dumps(scene))
    for n, body in enumerate(made["bodies"]):
        if body.get("free"):
            body["position"] = [x + change * 1e-8 * (n + axis + 1) / 5 for axis, x in enumerate(body["position"])]
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "case.json").write_text(json.dumps(made), encoding="utf-8")
    answer, code = run([program, "simulate", folder / "case.json", "-o", folder / "run", "--json", "-q"], varied, folder.parents[1])
    if "bodies" not in answer:
        return answer_of(code, [], {}, 0)
    places = [folder / "run" / body["name"] for body in answer["bodies"]]
    files = [place / name for place in places for name in ("end.npy", "energy.csv", "places.npy")]
    return answer_of(f"{code} {answer['status']}", files, *figures_of_scene(folder / "run", answer))


def try_equilibrium(program, model, load, folder, varied, change):
    folder.mkdir(parents=True, exist_ok=True)
    answer, code = run([program, "static", model, "--load", load, "--factor", repr(1 + change * 1e-9), "-o", folder / "q.npy",
                        "--path", folder / "path.csv", "--json", "-q"], varied, folder.parents[1])
    keys = ("peak_displacement_m", "energy_j", "least_eigenvalue", "critical_factor", "critical_factor_linear")
    figures = {key: (answer[key], abs(answer[key])) for key in keys if answer.get(key) is not None}
    ended = f"{code} {answer.get('status')} {answer.get('instability')} {sorted(figures)}"
    return answer_of(ended, [folder / "q.npy", folder / "path.csv"], figures, answer.get("iterations", 0))


def make_model(program, options, work):
    """The model file of a mesh with options, made once with the constants as they are; a name stays."""
    mesh, *others = options.split()
    if not others:
        return mesh
    path = work / (hashlib.sha256(options.encode()).hexdigest()[:12] + ".npz")
    if not path.exists():
        subprocess.run([program, "precompute", mesh, *others, "-o", path, "-q"], check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
    return path


def cases_of(file):
    """The cases in which a constant can act: scenes, equilibria, or all where no file is named."""
    return [*({} if file.startswith("runtime/statics") else scenes()), *({} if file.startswith("contact") else EQUILIBRIA)]


def try_all(program, work, name, file="", varied="", change=0.0):
    """The answers of the cases for a constant of a file; WORK_FOLDER keeps them."""
    folder, kept = work / "runs", work / f"{name}.json"
    answers = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {}
    for case in cases_of(file):
        if case in answers:
            continue
        if case in EQUILIBRIA:
            mesh, load = EQUILIBRIA[case]
            answers[case] = try_equilibrium(program, make_model(program, mesh, work), load, folder / case, varied, change)
        else:
            answers[case] = try_scene(program, scenes()[case], folder / case, varied, change)
        kept.write_text(json.dumps(answers), encoding="utf-8")
    return answers


def difference(before, after, figure):
    """Of a figure, in its scale; infinite where one of the answers lacks it."""
    if figure not in after["figures"]:
        return math.inf
    value, scale = before["figures"][figure]
    return abs(after["figures"][figure][0] - value) / scale if scale > 0 else 0.0


def largest_move(before, after, others):
    """How far the figure of a case moved that moved most, beyond noise, and which; 0 where none did."""
    largest, which = 0.0, ""
    for figure in before["figures"]:
        moved = difference(before, after, figure)
        noise = max(difference(before, other, figure) for other in others)
        if moved > max(MOVED, 3 * noise) and moved > largest:
            largest, which = moved, figure
    return largest, which


def compare(cases, before, after, noisy):
    """What a constant did: counts of cases, the case that moved most, and the work of scenes or of equilibria."""
    changed = [case for case in cases if before[case]["bits"] != after[case]["bits"]]
    ended = [case for case in cases if before[case]["status"] != after[case]["status"]
             and all(other[case]["status"] == before[case]["status"] for other in noisy)]
    moves = {case: largest_move(before[case], after[case], [other[case] for other in noisy]) for case in cases}
    moved = [case for case in cases if moves[case][0] > 0]
    most = max(moved, key=lambda case: moves[case][0], default=None)
    work = [sum(answers[case]["work"] for case in cases) for answers in (before, after)]
    return {"cases": len(cases), "changed": len(changed), "moved": len(moved), "ended_otherwise": "; ".join(ended),
            "moved_most": f"{most}: {moves[most][1]}" if most else "", "by": f"{moves[most][0]:.2g}" if most else "",
            "work": f"{work[1] / work[0]:.3f}", "moved_cases": "; ".join(moved)}


def main(work):
    program, values = build(work, CONSTANTS)
    before = try_all(program, work, "as-it-is")
    noisy = [try_all(program, work, f"noise{change}", change=change) for change in NOISE]
    made = []
    for file, constants in CONSTANTS:
        for constant, without in constants.items():
            kept = f"{pathlib.Path(file).name}-{constant}"
            after = try_all(program, work, kept, file, f"{file}:{constant}={without}")
            made.append({"constant": constant, "file": file, "value": values[f"{file}:{constant}"], "without": without,
                         **compare(cases_of(file), before, after, noisy)})
            print(*made[-1].values(), sep=" | ", flush=True)
    write(RESULTS / "without_contact_constants.csv", made)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        raise SystemExit(__doc__)
    main(pathlib.Path(sys.argv[1]).resolve())
