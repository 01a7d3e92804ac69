#!/usr/bin/env python3
"""The tables of the documentation, made of the committed results.

usage: validation/tables.py --write    write them between their marks into docs/
       validation/tables.py --check    exit with 1 where docs/ has another table

A table stands between the lines `<!-- table NAME -->` and `<!-- end of table -->`.
SPDX-License-Identifier: Apache-2.0
"""
import csv
import pathlib
import re
import sys

from report import THESIS_SPEEDUP

ROOT = pathlib.Path(__file__).resolve().parent.parent
RESULTS = ROOT / "validation" / "results"
MODELS = ["beam", "basket", "bridge", "horse", "tower", "heart"]
INTEGRATORS = ["imexv", "newmark", "energy"]
MARKED = re.compile(r"(<!-- table (\w+) -->\n).*?(<!-- end of table -->)", re.DOTALL)

def rows(*path):
    with open(RESULTS.joinpath(*path), newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def table(head, body):
    lines = ["| " + " | ".join(cells) + " |\n" for cells in (head, *body)]
    return lines[0] + "|" + "---|" * len(head) + "\n" + "".join(lines[1:])


def power(text):
    """One digit and a power of ten without leading zeros: 2e-15."""
    digit, exponent = f"{float(text):.0e}".split("e")
    return f"{digit}e{int(exponent)}"


def matrix():
    runs = {(r["model"], r["load"], float(r["damping"]), r["integrator"]): float(r["us_per_step"])
            for r in rows("matrix", "runs.csv")}
    kinds = [(load, damping) for load in ("impulse", "square", "sine") for damping in (0, 0.3)]
    body = []
    for place, model in enumerate(MODELS):
        cells = [model]
        for kind in kinds:
            ratio = runs[(model, *kind, "newmark")] / runs[(model, *kind, "imexv")]
            published = f" ({THESIS_SPEEDUP[kind][place]:.2f})" if kind in THESIS_SPEEDUP else ""
            cells.append(f"{ratio:.2f}{published}")
        body.append(cells)
    return table(["model"] + [f"{load}, α = {damping}" for load, damping in kinds], body)


def long():
    def slope(run, error):
        return f"{float(run['high_slope_per_s']) / float(run[error]):.1f}" if run[error] else "–"

    body = []
    for r in rows("long", "long.csv"):
        lost = "" if r["status"] == "done" else ", lost"
        body.append([r["model"], f"{100 * float(r['amplitude']):.0f} %", r["integrator"],
                     r["steps"] + lost, f"{float(r['total_change']):.1e}",
                     f"{float(r['total_worst']):.1e}", f"{float(r['high_change']):.1e}",
                     slope(r, "high_slope_error_per_s"),
                     slope(r, "high_slope_error_correlated_per_s"), r["switched"], r["corrections"]])
    return table(["model", "amplitude", "integrator", "steps", "total, last against first 35 s",
                  "worst 35 s", "high modes", "their slope over its error, independent windows",
                  "following windows", "switched to the energy integrator", "corrections"], body)


def sweep():
    runs = {(r["model"], float(r["dt_s"]), r["integrator"]): r for r in rows("sweep", "sweep.csv")}
    body = []
    for model, dt in dict.fromkeys(key[:2] for key in runs):
        cells = [model, f"{dt:g}"]
        for integrator in INTEGRATORS:
            r = runs[(model, dt, integrator)]
            iterations = f"{float(r['mean_iterations']):.1f}"
            if r["status"] != "done":
                cells.append(f"lost, {iterations}")
                continue
            handed = ", switched to the energy integrator" if int(r["scheme_switches"]) > 0 else ""
            cells.append(f"done, {float(r['energy_error']):.0e}, {iterations}{handed}")
        body.append(cells)
    return table(["model", "h [s]"] + INTEGRATORS, body)


def extreme_name(run):
    case = run["case"].replace("w1", "ω₁").replace("w6", "ω₆").replace("2 pi", "2π")
    case = case.replace("pi", "π") if "ω" in case else case
    case = case.replace("nu =", "ν =").replace("kg/m3", "kg/m³")
    named = {"size": "length", "density": "density", "load": "load", "snap": "arch,",
             "tet": "one tet,"}
    return f"{named[run['subject']]} {case}" if run["subject"] in named else case


def extreme_cell(run):
    if not run["energy_error"]:
        return "–"
    counts = [(int(run[key]), one, many) for key, one, many in (
        ("newton", "newton", "newton"), ("switched", "switched", "switched"),
        ("energy", "energy step", "energy steps"), ("substep", "sub-step", "sub-steps"))]
    notes = ", ".join(f"{n} {one if n == 1 else many}" for n, one, many in counts if n > 0)
    cell = "**lost**" if run["outcome"] == "lost" else power(run["energy_error"])
    return f"{cell} ({notes})" if notes else cell


def extremes():
    cases = {}
    for r in rows("extremes", "extremes.csv"):
        cases.setdefault((r["subject"], r["case"]), {})[r["integrator"]] = r
    body = []
    for runs in cases.values():
        first = runs["imexv"]
        if first["outcome"] == "refused":
            body.append([extreme_name(first), "–", "refused: " + first["reason"].split(";")[0], "–", "–"])
            continue
        span = "–".join(f"{float(first[key]):.2g}" for key in ("h_omega_first", "h_omega_last"))
        body.append([extreme_name(first), span] + [extreme_cell(runs[i]) for i in INTEGRATORS])
    return table(["case", "h ω, first to last"] + INTEGRATORS, body)


def linear():
    body = []
    for r in rows("linear", "linear.csv"):
        shares = [f"{100 * float(r[key]):.2f}"
                  for key in ("static_5", "static_20", "dynamic_5", "dynamic_20")]
        body.append([r["model"], r["rank"], *shares, f"{float(r['force_us']):.2f}",
                     f"{float(r['step_us']):.1f}", f"{float(r['linear_step_us']):.3f}",
                     f"{float(r['nonlinear_us']):.1f}"])
    return table(["model", "r", "5 %, at rest", "20 %, at rest", "5 %, in motion",
                  "20 %, in motion", "R(q)", "step of imexv", "linear step", "nonlinearity costs"],
                 body)


def tradeoff():
    body = []
    for model in MODELS:
        runs = [r for r in rows("tradeoff", f"{model}.csv") if r["stable"] == "1"]
        own = [r for r in runs if r["modes"] == "0"]
        ten = [r for r in runs if r["modes"] != "0" and r["rank"] == "10"]
        best = min(own, key=lambda r: float(r["error_displacement"]))
        full = float(best["speedup"]) * float(best["cost_s_per_s"])
        body.append([model, f"{full:.3g}", best["rank"]] +
                    [f"{100 * float(text):.3g} %" for text in (
                        own[0]["basis_error"], ten[0]["basis_error"], best["error_displacement"])] +
                    [f"{float(best['speedup']):.0f}"])
    return table(["model", "full order, s for a second", "rank", "error of the own basis",
                  "of rank 10", "least error of a run", "its times faster than full"], body)


TABLES = {made.__name__: made for made in (matrix, long, sweep, extremes, linear, tradeoff)}


def main(arguments):
    if arguments not in (["--write"], ["--check"]):
        sys.stderr.write(__doc__.split("\n\n", 1)[1])
        return 2
    found, stale = set(), []
    for page in sorted((ROOT / "docs").glob("*.md")):
        text = page.read_text(encoding="utf-8")
        made = MARKED.sub(lambda m: m[1] + TABLES[m[2]]() + m[3], text)
        found.update(match[1] for match in MARKED.findall(text))
        if made == text:
            continue
        if arguments == ["--write"]:
            page.write_text(made, encoding="utf-8")
        else:
            stale.append(page.name)
    for name in sorted(set(TABLES) - found):
        stale.append(f"no page has the table {name}")
    for line in stale:
        print(f"{line}: not what validation/results holds; run validation/tables.py --write")
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
