#!/usr/bin/env python3
"""What each tuned constant of the runtime does: runs with the constant put out of effect.

usage: validation/without_constants.py WORK_FOLDER [dynamics | contact]

A copy of the sources is built in WORK_FOLDER in which the constants of the list below are variables that the environment sets, so
that one program serves all. A constant is put out of effect by a limit that nothing reaches, a share of 0 or 1, or a count of 1,
which is what the code would do if the constant and the lines that read it were gone.

dynamics: for each constant of runtime/dynamics the experiments of SETS run with its value and without it. A row of
validation/results/without_constants.csv says how many rows of the experiments moved by more than rounding, how many ended
otherwise, and where an error changed most. It takes about 40 minutes on one core.

contact: for each constant of runtime/contact and runtime/statics the scenes of examples/scenes in which bodies touch, and
equilibria on paths that buckle and snap. A row of validation/results/without_contact_constants.csv names those of which a bit
changed, and of these the ones that ended elsewhere. It takes about 5 minutes.

Runs that WORK_FOLDER has already are taken over. Needs git, cmake and a compiler. SPDX-License-Identifier: Apache-2.0
"""
import csv
import hashlib
import json
import math
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
RESULTS = ROOT / "validation" / "results"
RUNTIME = pathlib.Path("runtime")
NEVER = "1e30"

# which schemes a constant can act in, and the constants by file with what puts them out of effect
MONITOR, SOLVE, BALANCE = "imexv,quadratic", "energy,newmark", "fox-goodwin"
CONSTANTS = [
    (MONITOR, "dynamics/stability.c", {
        "NUMBER_NEAR": "1e9", "NUMBER_MOVED": "0", "NUMBER_DRIFT": "0", "ENERGY_STEPS": "8", "ENERGY_STEPS_FIRST": "32",
        "REFERENCE_WINDOWS": "1", "SWITCHED_STEPS": "1000000000", "ERROR_FAST": NEVER, "ERROR_URGENT": NEVER, "BLOCK_DRIFT": NEVER,
        "DRIFT_WINDOW": "0", "DRIFT_SUM": NEVER, "DRIFT_FORGET": "0", "INTEGRAL_GAIN": "0", "CORRECTION_MOST": NEVER,
        "CORRECTION_KINETIC": "0", "SWITCH_NEAR": NEVER, "DRIVEN": NEVER, "FOLLOW": NEVER, "DAMPING_ERROR": "0",
        "MOTION_KNOWN": NEVER, "FIRST_STEPS": "0", "LOAD_JUMP": NEVER, "MEMORY": NEVER, "FALLEN": NEVER}),
    (MONITOR, "dynamics/stability_number.c", {"RATE_FADES": "0", "NUMBER_GOOD": "1.6"}),
    (SOLVE, "dynamics/energy_correction.c", {
        "COMPARE_STEPS": "1", "ERROR_ROUNDING": "0", "STRETCH_MOST": NEVER}),
    (SOLVE, "dynamics/discrete_gradient.c", {"JUMP_MOST": NEVER, "STEP_FADE": "1", "CONTRACTION_FADE": "0"}),
    (SOLVE, "dynamics/discrete_gradient_trapezoid.c", {
        "CARRIED_MOST": NEVER, "MISSING_MOST": NEVER, "CHEAPER_CARRIED": "1", "ROUNDING_SHARE": "0", "WORK_FACTOR": NEVER,
        "LOSS_LEAST": "0"}),
    (SOLVE, "dynamics/quasi_newton.c", {
        "CARRIED_RESIDUAL": NEVER, "CARRIED_TOLERANCES": "1", "SINGLE_TOLERANCES": "1", "GUESS_POOR": NEVER, "LINEAR_KNOWN": "0",
        "GUESS_QUIET": NEVER, "INVERSES_APART": "0", "CORRECTION_FAR": NEVER, "RATE_MOST": NEVER, "CONTRACTION_MARGIN": "1",
        "TEACHING_LEAST": "0"}),
    (SOLVE, "dynamics/spurious_work.c", {"WORK_MOST": NEVER, "WORK_NOISE": "0", "WORK_FAR": NEVER}),
    (SOLVE, "dynamics/spurious_work.h", {"THRUM_HALVINGS_MOST": "0", "THRUM_WAIT_MOST": "1"}),
    (SOLVE, "dynamics/discrete_gradient_average.c", {"SCALE_MOST": NEVER, "ERROR_MOST": NEVER, "RESIDUAL_FOLLOWED": "0"}),
    (SOLVE, "dynamics/implicit_problem.c", {"CHEAPER_MOST": "1", "CHEAPER_LISTS": "1"}),
    (SOLVE, "dynamics/step.c", {"EAGER_STEPS": "0", "AVERAGE_FIELD_STEPS": "1"}),
    (SOLVE, "dynamics/kept_inverse.c", {"CHANGE_LEAST": "0"}),
    (BALANCE, "dynamics/fox_goodwin.c", {"DECAY_MOST": NEVER}),
    (BALANCE, "dynamics/energy_balance.c", {
        "BALANCE_FIRST": "0", "BALANCE_MOTION": NEVER, "BALANCE_FADE": "1", "BALANCE_GREW": "0.15", "BALANCE_MOVED": "0"}),
]

# the same of contact and statics, by file
CONTACT_CONSTANTS = [
    ("contact/contact_rows.c", {"ENTRY_HALVINGS": "1", "TOGETHER": "1"}),
    ("contact/contact_row.c", {"RECOVERY": "1"}),
    ("contact/contact_row.h", {"THRUM_SOON": "1", "THRUM_RESTING": "0"}),
    ("contact/contact_impact.c", {"SOFT": NEVER, "SLOWEST": "0", "SWEEPS_MAX": "1000000", "TOLERANCE": "0", "ROUNDING": "0"}),
    ("contact/contact_impact.h", {"THRUM_IMPACTS_MAX": "1"}),
    ("contact/contact_pairs_solve.c", {"HARDER": "1", "DEEP": NEVER}),
    ("contact/contact_pairs_energy.c", {"ROUNDING": "0", "TOO_DEEP": NEVER}),
    ("contact/contact_pairs_rows.c", {"DEEPEST": NEVER, "ALIKE": "-2"}),
    ("contact/contact_pairs_search.c", {"NEAR": "0", "MARGIN": "0", "STANDS_OUT": "0", "SHARP": "0", "ASKEW": "0"}),
    ("contact/contact_pairs_step.c", {"SEARCHES_MAX": "1", "TURNS_MAX": "1", "TURNED": "0", "MISSED": "0"}),
    ("contact/contact_pairs_solid.c", {"HALF_TURN": "0"}),
    ("contact/contact_distance.c", {"ADVANCES_MAX": "1000000", "CLOSE_ENOUGH": "1e-9"}),
    ("contact/contact_step.c", {"ROUNDING": "0"}),
    ("statics/equilibrium.c", {"CORRECTION": NEVER, "SHORTEST": "0x1p-45", "BEYOND": "0", "LINEAR": NEVER, "PLACE_TRIES": "1000000",
                               "PLACE_NEAR": "1e-14"}),
    ("statics/equilibrium_search.c", {"STALLED": "0", "SHORT": "0", "SHORT_MOST": "1000000", "LEAP_STEPS": "1",
                                      "NEAR_ITERATIONS": "1000000"}),
]
SCENES = ["collide", "crowd", "drop", "shapes", "wind"]
EQUILIBRIA = {"beam buckles": "beam --load constant:-30000,0,10@load", "tower buckles": "tower --load constant:0,0,-3e5@load",
              "basket snaps": "basket --load constant:0,0,-3000@load", "heart": "heart --load constant:0,0,-300@load"}

# folder, options of `thrum experiments`, table, and the columns that tell its rows apart
SETS = [("matrix", "--models beam,horse,tower --time 6", "runs.csv", ("model", "load", "damping", "scheme")),
        ("sweep", "--sweep --time 0.5", "sweep.csv", ("model", "start", "scheme", "dt_s")),
        ("long", "--long --steps 20000", "long.csv", ("model", "scheme", "amplitude")),
        ("extremes", "--extremes --steps 1000 --subjects load,snap,resonance,stiffness", "extremes.csv",
         ("subject", "case", "scheme"))]
ERRORS = ("energy_change", "energy_error", "total_worst", "high_change", "error")
ROUNDING = 1e-6  # errors below it are not compared
MOVED = 0.01     # share by which an error must change to count


def make_variables(source, files):
    """Turns the constants of the copied sources into an array that the program fills from the environment."""
    names, values = [], []
    for name, constants in files:
        path = source / RUNTIME / name
        text = path.read_text(encoding="utf-8")
        for constant in constants:
            text = re.sub(rf"^(#define {constant}) +\\\n +", r"\1 ", text, flags=re.M)
            found = re.search(rf"^#define {constant} +(\S+)", text, flags=re.M)
            cast = "" if re.search(r"[.p]|\de", found[1]) else "(int)"
            text = f"{text[:found.start()]}#define {constant} ({cast}thrum_varied[{len(names)}]){text[found.end():]}"
            names.append(f"{name}:{constant}")
            values.append(found[1])
        first = text.index("#include")
        path.write_text(f'{text[:first]}extern double thrum_varied[];\n{text[first:]}', encoding="utf-8")

    # read before main, so that nothing else has to change
    with open(source / RUNTIME / "dynamics" / "step.c", "a", encoding="utf-8") as step:
        step.write(f"""
#include <stdlib.h>
double thrum_varied[] = {{{", ".join(values)}}};
__attribute__((constructor)) static void vary(void) {{
  static const char *const names[] = {{{", ".join(f'"{n}"' for n in names)}}};
  const char *set = getenv("THRUM_VARIED");
  for (size_t k = 0; set && k < sizeof names / sizeof *names; k++)
    if (strlen(names[k]) == strcspn(set, "=") && strncmp(set, names[k], strlen(names[k])) == 0)
      thrum_varied[k] = strtod(set + strlen(names[k]) + 1, NULL);
}}
""")
    return dict(zip(names, values))


def build(work, files):
    """The program with variables; what the constants are."""
    source = work / "source"
    source.mkdir(parents=True, exist_ok=True)
    archive = subprocess.run(["git", "-C", ROOT, "archive", "HEAD"], check=True, capture_output=True).stdout
    subprocess.run(["tar", "x", "-C", source], input=archive, check=True)
    values = make_variables(source, files)
    subprocess.run(["cmake", "--preset", "release", "-DTHRUM_BUILD_TESTS=OFF", "-DCMAKE_C_FLAGS=-w"], cwd=source, check=True,
                   stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", source / "build" / "release", "--target", "thrum_program"], check=True,
                   stdout=subprocess.DEVNULL)
    return source / "build" / "release" / "thrum", values


def run(program, folder, schemes, varied):
    """The rows of all experiments by the columns that tell them apart; makes what the folder lacks."""
    rows = {}
    for name, options, table, key in SETS:
        where = folder / name
        if not (where / table).exists():
            where.mkdir(parents=True, exist_ok=True)
            done = subprocess.run([program, "experiments", *options.split(), "--schemes", schemes, "-o", where, "-q"],
                                  env=dict(os.environ, THRUM_VARIED=varied, XDG_CACHE_HOME=str(folder.parent / "cache")),
                                  stdout=subprocess.DEVNULL, check=False)
            if done.returncode not in (0, 3):  # 3: a run was lost, which is a result
                raise SystemExit(f"{varied}: exit code {done.returncode}")
        with open(where / table, encoding="utf-8") as file:
            rows.update({(name, *(row[column] for column in key)): row for row in csv.DictReader(file)})
    return rows


def number(row, column):
    return float(row.get(column) or "nan")


def compare(before, after):
    """How many rows moved and ended otherwise, the largest factor of an error, where, and the factor of iterations."""
    moved, ended, worst, where = 0, 0, 1.0, ""
    iterations = [0.0, 0.0]
    for key, row in before.items():
        other = after[key]
        factors = [number(other, c) / number(row, c) for c in ERRORS
                   if max(abs(number(row, c)), abs(number(other, c))) > ROUNDING and number(row, c) != 0]
        factors = [abs(f) for f in factors if f and not math.isnan(f)]
        moved += any(abs(f - 1) > MOVED for f in factors)
        ended += any(row.get(c) != other.get(c) for c in ("status", "outcome"))
        largest = max(factors, key=lambda f: abs(math.log(f)), default=1.0)
        if abs(math.log(largest)) > abs(math.log(worst)):
            worst, where = largest, " ".join(key)
        if not math.isnan(number(row, "mean_iterations") + number(other, "mean_iterations")):
            iterations[0] += number(row, "mean_iterations") * number(row, "steps")
            iterations[1] += number(other, "mean_iterations") * number(other, "steps")
    return {"rows": len(before), "moved": moved, "ended": ended, "worst_factor": f"{worst:.3g}", "worst_row": where,
            "iterations": f"{iterations[1] / iterations[0]:.3f}" if iterations[0] > 0 else ""}


def write(path, rows):
    with open(path, "w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


def try_dynamics(work):
    program, values = build(work, [(name, constants) for _, name, constants in CONSTANTS])
    made = []
    for schemes, name, constants in CONSTANTS:
        before = run(program, work / schemes.replace(",", "-"), schemes, "")
        for constant, without in constants.items():
            file = pathlib.Path(name).name
            after = run(program, work / f"{file}-{constant}", schemes, f"{name}:{constant}={without}")
            made.append({"constant": constant, "file": file, "value": values[f"{name}:{constant}"], "without": without,
                         "schemes": schemes.replace(",", " "), **compare(before, after)})
            print(made[-1], flush=True)
    write(RESULTS / "without_constants.csv", made)


def last_numbers(path):
    """The last row of a table, as numbers; an empty field is not one."""
    with open(path, encoding="utf-8") as file:
        rows = list(csv.reader(file))
    return [float(field or "nan") for field in rows[-1]]


def end_of_scene(program, name, folder, environment):
    """How a scene ended: its status, a hash of all its tables, and their last rows."""
    code = subprocess.run([program, "simulate", ROOT / "examples" / "scenes" / f"{name}.json", "-o", folder, "-q"], env=environment,
                          stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False).returncode
    tables = sorted(folder.rglob("energy.csv")) + sorted(folder.rglob("account.csv"))
    bits = hashlib.sha256(b"".join(path.read_bytes() for path in tables)).hexdigest()
    return code, bits, [last_numbers(path) for path in tables]


def end_of_path(program, options, folder, environment):
    """An equilibrium in the same form: its status, a hash of its coordinates, and its numbers."""
    folder.mkdir(parents=True, exist_ok=True)
    place = folder / "q.npy"
    done = subprocess.run([program, "static", *options.split(), "-o", place, "--json", "-q"], env=environment, capture_output=True,
                          text=True, check=False)
    answer = json.loads(done.stdout or "{}")
    numbers = [float(answer.get(key) or "nan") for key in ("energy_j", "load_energy_j", "critical_factor")]
    return done.returncode, hashlib.sha256(place.read_bytes() if place.exists() else b"").hexdigest(), [numbers]


def ends(program, folder, varied):
    """How all scenes and equilibria end with a constant varied."""
    environment = dict(os.environ, THRUM_VARIED=varied, XDG_CACHE_HOME=str(folder.parent / "cache"))
    found = {name: end_of_scene(program, name, folder / name, environment) for name in SCENES}
    return found | {name: end_of_path(program, options, folder / name, environment) for name, options in EQUILIBRIA.items()}


def ended_elsewhere(before, after):
    """Whether the status is another, or a last number by more than MOVED of the largest in its row."""
    if before[0] != after[0] or len(before[2]) != len(after[2]):
        return True
    for row, other in zip(before[2], after[2]):
        scale = max((abs(x) for x in row if not math.isnan(x)), default=0.0)
        if any(abs(x - y) > MOVED * scale or math.isnan(x) != math.isnan(y) for x, y in zip(row, other)):
            return True
    return False


def try_contact(work):
    program, values = build(work, CONTACT_CONSTANTS)
    before = ends(program, work / "as-it-is", "")
    made = []
    for name, constants in CONTACT_CONSTANTS:
        for constant, without in constants.items():
            after = ends(program, work / f"{pathlib.Path(name).name}-{constant}", f"{name}:{constant}={without}")
            changed = [run for run in before if before[run][1] != after[run][1]]
            made.append({"constant": constant, "file": name, "value": values[f"{name}:{constant}"], "without": without,
                         "changed": "; ".join(changed),
                         "ended_elsewhere": "; ".join(run for run in changed if ended_elsewhere(before[run], after[run]))})
            print(made[-1], flush=True)
    write(RESULTS / "without_contact_constants.csv", made)


if __name__ == "__main__":
    parts = {"dynamics": try_dynamics, "contact": try_contact}
    if len(sys.argv) not in (2, 3) or (sys.argv + ["dynamics"])[2] not in parts:
        raise SystemExit(__doc__)
    parts[(sys.argv + ["dynamics"])[2]](pathlib.Path(sys.argv[1]).resolve())
