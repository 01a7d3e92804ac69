#!/usr/bin/env python3
"""What each tuned constant of the integrators does: runs with the constant put out of effect.

usage: validation/without_constants.py WORK_FOLDER

A copy of the sources is built in WORK_FOLDER in which the constants of the list below are variables that the environment sets, so
that one program serves all. A constant is put out of effect by a limit that nothing reaches, a share of 0 or 1, or a count of 1,
which is what the code would do if the constant and the lines that read it were gone.

For each constant of the schemes and the guards the experiments of SETS run with its value and without it. A row of
validation/results/without_constants.csv says how many rows of the experiments moved by more than rounding, how many ended
otherwise, and where an error changed most. It takes about 40 minutes on one core. without_contact_constants.py does the same for
contact and statics.

A program and runs that WORK_FOLDER has already are taken over. Needs git, cmake and a compiler. SPDX-License-Identifier: Apache-2.0
"""
import csv
import json
import math
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
RESULTS = ROOT / "validation" / "results"
NEVER = "1e30"

# which schemes a constant can act in, and the constants by file with what puts them out of effect
MONITOR, SOLVE, BALANCE = "imexv,quadratic", "energy,newmark", "fox-goodwin"
CONSTANTS = [
    (MONITOR, "runtime/guard/stability.c", {
        "NUMBER_NEAR": "1e9", "NUMBER_MOVED": "0", "NUMBER_DRIFT": "0", "ENERGY_STEPS": "8", "ENERGY_STEPS_FIRST": "32",
        "REFERENCE_WINDOWS": "1", "SWITCHED_STEPS": "1000000000", "ERROR_FAST": NEVER, "ERROR_URGENT": NEVER, "BLOCK_DRIFT": NEVER,
        "DRIFT_WINDOW": "0", "DRIFT_SUM": NEVER, "DRIFT_FORGET": "0", "INTEGRAL_GAIN": "0", "CORRECTION_MOST": NEVER,
        "CORRECTION_KINETIC": "0", "SWITCH_NEAR": NEVER, "DRIVEN": NEVER, "FOLLOW": NEVER, "DAMPING_ERROR": "0",
        "MOTION_KNOWN": NEVER, "FIRST_STEPS": "0", "LOAD_JUMP": NEVER, "MEMORY": NEVER, "FALLEN": NEVER}),
    (MONITOR, "runtime/guard/stability_number.c", {"RATE_FADES": "0", "NUMBER_GOOD": "1.6"}),
    (SOLVE, "runtime/guard/energy_correction.c", {
        "COMPARE_STEPS": "1", "ERROR_ROUNDING": "0", "STRETCH_MOST": NEVER}),
    (SOLVE, "core/schemes/discrete_gradient.c", {"JUMP_MOST": NEVER, "STEP_FADE": "1", "CONTRACTION_FADE": "0"}),
    (SOLVE, "core/schemes/discrete_gradient_trapezoid.c", {
        "CARRIED_MOST": NEVER, "MISSING_MOST": NEVER, "CHEAPER_CARRIED": "1", "ROUNDING_SHARE": "0", "WORK_FACTOR": NEVER,
        "LOSS_LEAST": "0"}),
    (SOLVE, "core/solve/quasi_newton.c", {
        "CARRIED_RESIDUAL": NEVER, "CARRIED_TOLERANCES": "1", "SINGLE_TOLERANCES": "1", "GUESS_POOR": NEVER, "LINEAR_KNOWN": "0",
        "GUESS_QUIET": NEVER, "INVERSES_APART": "0", "CORRECTION_FAR": NEVER, "RATE_MOST": NEVER, "CONTRACTION_MARGIN": "1",
        "TEACHING_LEAST": "0"}),
    (SOLVE, "core/solve/spurious_work.c", {"WORK_MOST": NEVER, "WORK_NOISE": "0", "WORK_FAR": NEVER}),
    (SOLVE, "core/solve/spurious_work.h", {"THRUM_HALVINGS_MOST": "0", "THRUM_WAIT_MOST": "1"}),
    (SOLVE, "core/schemes/discrete_gradient_average.c", {"SCALE_MOST": NEVER, "ERROR_MOST": NEVER, "RESIDUAL_FOLLOWED": "0"}),
    (SOLVE, "core/solve/implicit_problem.c", {"CHEAPER_MOST": "1", "CHEAPER_LISTS": "1"}),
    (SOLVE, "core/step/step.c", {"EAGER_STEPS": "0", "AVERAGE_FIELD_STEPS": "1"}),
    (SOLVE, "core/step/kept_inverse.c", {"CHANGE_LEAST": "0"}),
    (BALANCE, "runtime/comparison/fox_goodwin.c", {"DECAY_MOST": NEVER}),
    (BALANCE, "runtime/guard/energy_balance.c", {
        "BALANCE_FIRST": "0", "BALANCE_MOTION": NEVER, "BALANCE_FADE": "1", "BALANCE_GREW": "0.15", "BALANCE_MOVED": "0"}),
]

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
        path = source / name
        text = path.read_text(encoding="utf-8")
        for constant in constants:
            text = re.sub(rf"^(#define {constant}) +\\\n +", r"\1 ", text, flags=re.M)
            found = re.search(rf"^#define {constant} +(.+?)(?= *(?:/\*|//|$))", text, flags=re.M)
            cast = "" if re.search(r"[.p]|\de", found[1]) else "(int)"
            text = f"{text[:found.start()]}#define {constant} ({cast}thrum_varied[{len(names)}]){text[found.end():]}"
            names.append(f"{name}:{constant}")
            values.append(found[1])
        first = text.index("#include")
        path.write_text(f'{text[:first]}extern double thrum_varied[];\n{text[first:]}', encoding="utf-8")

    # read before main, so that nothing else has to change
    with open(source / "core" / "step" / "step.c", "a", encoding="utf-8") as step:
        step.write(f"""
#include <float.h>
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
    """The program with variables; what the constants are. A program that the folder has already is taken over."""
    source, kept = work / "source", work / "values.json"
    program = source / "build" / "release" / "thrum"
    if kept.exists():
        return program, json.loads(kept.read_text(encoding="utf-8"))

    # the committed sources alone
    source.mkdir(parents=True, exist_ok=True)
    archive = subprocess.run(["git", "-C", ROOT, "archive", "HEAD"], check=True, capture_output=True).stdout
    subprocess.run(["tar", "x", "-C", source], input=archive, check=True)
    values = make_variables(source, files)
    subprocess.run(["cmake", "--preset", "release", "-DTHRUM_BUILD_TESTS=OFF", "-DCMAKE_C_FLAGS=-w"], cwd=source, check=True,
                   stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", source / "build" / "release", "--target", "thrum_program"], check=True,
                   stdout=subprocess.DEVNULL)
    kept.write_text(json.dumps(values), encoding="utf-8")
    return program, values


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


if __name__ == "__main__":
    if len(sys.argv) != 2:
        raise SystemExit(__doc__)
    try_dynamics(pathlib.Path(sys.argv[1]).resolve())
