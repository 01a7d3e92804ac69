#!/usr/bin/env python3
"""The tables of the documentation, made of the committed results.

usage: validation/tables.py --write    write them between their marks into docs/
       validation/tables.py --check    exit with 1 where docs/ has another table

A table stands between the lines `<!-- table NAME -->` and `<!-- end of table -->`.
SPDX-License-Identifier: Apache-2.0
"""
import csv
import json
import math
import pathlib
import re
import sys

from report import THESIS_SPEEDUP

ROOT = pathlib.Path(__file__).resolve().parent.parent
RESULTS = ROOT / "validation" / "results"
MODELS = ["beam", "basket", "bridge", "horse", "tower", "heart"]
DEFAULT = "energy"  # the integrator of a state whose def says nothing
# these differ little from newmark and backward-euler, and stand in the wide tables of the reports alone
NARROW = ("newmark-newton", "semi-implicit-euler")
# those whose extremes stand in the pages; the others are in the report
EXTREMES = ["thesis-newton", "position", "newmark", "fox-goodwin", "imexv", "energy"]
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


def schemes(runs, without=()):
    """The names of the schemes, in the order of the table."""
    return [scheme for scheme in dict.fromkeys(r["scheme"] for r in runs) if scheme not in without]


def lost_time(run):
    return float(run["simulated_s"]) if "simulated_s" in run else float(run["steps"]) * float(run["dt_s"])


def stood_in(run):
    """How many steps were not the scheme's own."""
    return int(run["steps"]) - int(run["own_steps"])


def thousands(count):
    return f"{count:,}"


def matrix():
    runs = {(r["model"], r["load"], float(r["damping"]), r["scheme"]): r for r in rows("matrix", "runs.csv")}
    kinds = [(load, damping) for load in ("impulse", "square", "sine") for damping in (0, 0.3)]
    body = []
    for place, model in enumerate(MODELS):
        cells = [model]
        for kind in kinds:
            pair = [runs[(model, *kind, scheme)] for scheme in ("newmark-newton", "thesis-newton")]
            lost = any(r["status"] != "done" for r in pair)
            ratio = "–" if lost else f"{float(pair[0]['us_per_step']) / float(pair[1]['us_per_step']):.2f}"
            published = f" ({THESIS_SPEEDUP[kind][place]:.2f})" if kind in THESIS_SPEEDUP else ""
            cells.append(ratio + published)
        body.append(cells)
    return table(["model"] + [f"{load}, α = {damping}" for load, damping in kinds], body)


def outcomes():
    """One row for each scheme of the matrix: what was lost, what stepped, and its energy and time beside the others."""
    runs = rows("matrix", "runs.csv")
    newmark = {(r["model"], r["load"], r["damping"]): float(r["us_per_step"]) for r in runs if r["scheme"] == "newmark"}
    body = []
    for scheme in schemes(runs):
        own = [r for r in runs if r["scheme"] == scheme]
        done = [r for r in own if r["status"] == "done"]
        lost = [r for r in own if r["status"] != "done"]
        first = f", {min(map(lost_time, lost)):.2g} to {max(map(lost_time, lost)):.3g} s" if lost else ""
        changes = [float(r["energy_change"]) for r in done if r["energy_change"]]
        worst = f"{max(changes, key=abs):.0e}" if changes else "–"
        ratios = [float(r["us_per_step"]) / newmark[(r["model"], r["load"], r["damping"])] for r in done]
        time = f"{math.exp(sum(map(math.log, ratios)) / len(ratios)):.2f}" if ratios else "–"
        replaced = sum(map(stood_in, own))
        body.append([scheme, f"{len(done)} of {len(own)}", f"{len(lost)}{first}" if lost else "none",
                     thousands(sum(int(r["own_steps"]) for r in own)), thousands(replaced) if replaced else "none",
                     thousands(sum(int(r["corrections"]) for r in own)), worst, time])
    return table(["scheme", "runs that came to their end", "lost, and when", "steps by the scheme itself",
                  "by `energy` or shorter steps", "energy corrections", "worst change of the mean energy",
                  "time of a step, Newmark's is 1"], body)


def long():
    body = []
    for r in rows("long", "long.csv"):
        error = r["high_slope_error_correlated_per_s"]
        slope = f"{float(r['high_slope_per_s']) / float(error):.1f}" if error and float(error) > 0 else "–"
        changes = [f"{float(r[key]):.0e}" if r[key] and r["status"] == "done" else "–"
                   for key in ("total_change", "total_worst", "high_change")]
        body.append([r["model"], f"{100 * float(r['amplitude']):.0f} %", r["scheme"],
                     "done" if r["status"] == "done" else f"lost at {lost_time(r):.3g} s",
                     thousands(int(r["own_steps"])), thousands(stood_in(r)), thousands(int(r["corrections"])), *changes,
                     slope if r["status"] == "done" else "–"])
    return table(["model", "amplitude", "scheme", "status", "steps by the scheme itself", "by `energy` or shorter steps",
                  "energy corrections", "total energy, last against first 35 s", "worst 35 s", "high modes",
                  "their slope over its error"], body)


def step_cell(run, key):
    """An error of a run of the sweep, with a star where other steps stood in; or when it was lost."""
    if run["status"] != "done":
        return f"lost, {lost_time(run):.2g} s"
    return power(run[key]) + ("*" if stood_in(run) else "")


def swept(name, key):
    """Rows are bodies and time steps, columns schemes."""
    runs = rows(name, name + ".csv")
    cells = {(r["model"], r["dt_s"], r["shortest_dt_s"], r["scheme"]): r for r in runs}
    body = []
    for model, longest, shortest in dict.fromkeys(case[:3] for case in cells):
        step = longest if longest == shortest else f"{shortest} to {longest}"
        body.append([model, step] + [step_cell(cells[(model, longest, shortest, scheme)], key)
                                     for scheme in schemes(runs, NARROW)])
    return table(["model", "h [s]"] + schemes(runs, NARROW), body)


def sweep():
    return swept("sweep", "energy_error")


def sweep_error():
    return swept("sweep", "error")


def variable():
    return swept("variable", "energy_error")


def step_sizes():
    """Experiment 5.5: the largest amplitude and the energy at the end at each step."""
    runs = [r for r in rows("step_sizes", "runs.csv") if float(r["damping"]) == 0]
    dts = list(dict.fromkeys(r["dt_s"] for r in runs))
    cells = {(r["scheme"], r["dt_s"]): r for r in runs}
    body = []
    for scheme in schemes(runs):
        line = [scheme]
        for dt in dts:
            r = cells[(scheme, dt)]
            star = "*" if stood_in(r) else ""
            line.append(f"{float(r['energy_end_j']):.3f} J, {float(r['energy_change']):.0e}{star}" if r["status"] == "done"
                        else f"lost, {lost_time(r):.2g} s")
        body.append(line)
    return table(["scheme"] + [f"h = {dt} s" for dt in dts], body)


def cost_at(runs, error):
    """The least cost at which a scheme reaches an error, between two time steps on a straight line of the logarithms."""
    points = [(float(r["error"]), float(r["cost_s_per_s"])) for r in runs if r["status"] == "done"]
    costs = [cost for reached, cost in points if reached <= error]
    for (e0, c0), (e1, c1) in zip(points, points[1:]):
        if min(e0, e1) <= error < max(e0, e1):
            share = math.log(error / e0) / math.log(e1 / e0)
            costs.append(c0 * (c1 / c0) ** share)
    return min(costs) if costs else math.inf


WORK_ERRORS = (0.1, 0.03, 0.01, 0.001)


def work_costs():
    """For each body, start and error: the cost of each scheme, infinite where it does not reach the error."""
    runs = rows("work_precision", "work_precision.csv")
    return {(model, start, error): {scheme: cost_at([r for r in runs if (r["model"], r["start"], r["scheme"]) ==
                                                     (model, start, scheme)], error) for scheme in schemes(runs)}
            for model, start in dict.fromkeys((r["model"], r["start"]) for r in runs) for error in WORK_ERRORS}


def work_precision():
    """For each body, start and error: the cheapest scheme, and the cost of the default over its."""
    body = {}
    for (model, start, _), costs in work_costs().items():
        best = min(costs, key=costs.get)
        over = f"{DEFAULT} {costs[DEFAULT] / costs[best]:.2f}" if math.isfinite(costs[DEFAULT]) else f"{DEFAULT} –"
        body.setdefault((model, start), [model, start]).append(
            f"{best} {1e3 * costs[best]:.2g} ms, {over}" if math.isfinite(costs[best]) else "–")
    return table(["model", "start"] + [f"error {100 * error:g} %" for error in WORK_ERRORS], body.values())


def work_means():
    """For each scheme over all bodies, starts and errors: what it costs over the cheapest one."""
    costs = work_costs()
    best = {cell: min(each.values()) for cell, each in costs.items()}
    names = [name for name in next(iter(costs.values())) if name not in NARROW]

    # geometric means over the cells that are reached
    def mean(over, start):
        reached = [math.log(x) for cell, x in over.items() if start in (None, cell[1]) and math.isfinite(x)]
        return f"{math.exp(sum(reached) / len(reached)):.2f}"

    body = []
    for name in names:
        over = {cell: each[name] / best[cell] for cell, each in costs.items()}
        finite = [x for x in over.values() if math.isfinite(x)]
        body.append([f"`{name}`", str(sum(x == 1 for x in finite)), str(len(over) - len(finite)), mean(over, "smooth"),
                     mean(over, "impulse"), mean(over, None), f"{max(finite):.1f}"])
    return table(["scheme", "cheapest in", "does not reach", "mean after smooth starts", "after impulses", "of all", "worst"],
                 body)


def extreme_name(run):
    case = run["case"].replace("w1", "ω₁").replace("w6", "ω₆").replace("2 pi", "2π")
    case = case.replace("pi", "π") if "ω" in case else case
    case = case.replace("nu =", "ν =").replace("kg/m3", "kg/m³")
    named = {"size": "length", "density": "density", "load": "load", "snap": "arch,",
             "tet": "one tet,"}
    return f"{named[run['subject']]} {case}" if run["subject"] in named else case


def extreme_cell(run):
    if not run["energy_error"] and run["outcome"] != "stopped":
        return "–"
    counts = [(int(run[key]), one, many) for key, one, many in (
        ("newton", "newton", "newton"), ("switched", "switched", "switched"),
        ("energy", "energy step", "energy steps"), ("substep", "sub-step", "sub-steps"))]
    notes = ", ".join(f"{n} {one if n == 1 else many}" for n, one, many in counts if n > 0)
    cell = "**lost**" if run["outcome"] in ("lost", "stopped") else power(run["energy_error"])
    return f"{cell} ({notes})" if notes else cell


def extremes():
    cases = {}
    for r in rows("extremes", "extremes.csv"):
        cases.setdefault((r["subject"], r["case"]), {})[r["scheme"]] = r
    body = []
    for runs in cases.values():
        first = runs[EXTREMES[0]]
        if first["outcome"] == "refused":
            reason = "refused: " + first["reason"].split(";")[0]
            body.append([extreme_name(first), "–", reason] + ["–"] * (len(EXTREMES) - 1))
            continue
        span = "–".join(f"{float(first[key]):.2g}" for key in ("h_omega_first", "h_omega_last"))
        body.append([extreme_name(first), span] + [extreme_cell(runs[scheme]) for scheme in EXTREMES])
    return table(["case", "h ω, first to last"] + EXTREMES, body)


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


def picks():
    with open(RESULTS / "tradeoff" / "picks.json", encoding="utf-8") as file:
        return json.load(file)


def tradeoff():
    body = []
    for model in MODELS:
        runs = [r for r in rows("tradeoff", f"{model}.csv")
                if r["stable"] == "1" and r["trained"] == "0" and r["masters"] == "0"]
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


def calculix():
    """One row for each body and order, one column for each comparison; what no bound holds stands in italics."""
    runs = rows("calculix", "calculix.csv")
    kinds = list(dict.fromkeys(r["quantity"] for r in runs if r["body"] != "element"))
    cells = {(r["body"], r["order"], r["quantity"]): r for r in runs}
    body = []
    for name, order in dict.fromkeys((r["body"], r["order"]) for r in runs if r["body"] != "element"):
        line = [name, "four" if order == "1" else "ten"]
        for kind in kinds:
            cell = cells.get((name, order, kind))
            text = "–" if cell is None else f"{float(cell['difference']):.0e}".replace("e-0", "e-")
            line.append(text if cell is None or cell["bound"] else f"*{text}*")
        body.append(line)
    return table(["body", "nodes"] + kinds, body)


def basis_of(item):
    """What a pick steps: rank, the coordinates that are stepped, and whether it is trained."""
    name = f"{item['masters']:.0f} of {item['rank']:.0f}" if item["masters"] else f"{item['rank']:.0f}"
    points = item.get("cubature")
    return name + (", trained" if item["trained"] else "") + (f", {points['points']:.0f} points" if points else "")


def velocity_of(item):
    """The error of the velocity of a pick, which stands in the rows of its search."""
    runs = [r for r in rows("tradeoff", f"{item['model']}.csv") if r["stable"] == "1"]
    return float(min(runs, key=lambda r: abs(float(r["error_displacement"]) - item["error"]))["error_velocity"])


def tradeoff_picks():
    body = []
    for item in picks():
        body.append([item["model"], f"{100 * item['asked']:g} %", basis_of(item),
                     f"`{item['integrator']}`, {item['dt']:.3g} s"] +
                    [f"{100 * item['error']:.2g} %", f"{100 * velocity_of(item):.2g} %"] +
                    [f"{100 * item[key]:.2g} %" for key in ("basis_error", "projection_error")] +
                    [f"{item['times_faster_than_full']:,.0f}", f"{100 * item['full']['error']:.2g} %"])
    return table(["model", "asked", "rank", "stepped by", "error", "of the velocity", "of its basis", "of the projection",
                  "times cheaper than the full order", "full order, in time"], body)


def percent(share):
    """Two digits, and no power of ten."""
    return f"{100 * share:.0f} %" if share >= 0.0995 else f"{100 * share:.2g} %"


def tradeoff_tests():
    def percents(item, key):
        return [percent(test[key]) if test[key] is not None else "lost" for test in item["tests"]]

    body, all_picks = [], picks()
    for model in MODELS:
        mine = [item for item in all_picks if item["model"] == model]
        for item in mine:
            body.append([model, f"picked for {100 * item['asked']:g} %", percent(item["error"])] +
                        percents(item, "error"))
        own = [r for r in rows("tradeoff", f"{model}.csv") if r["modes"] == "0" and r["masters"] == "0"]
        body.append([model, f"own basis, rank {own[0]['rank']}", percent(float(own[0]["basis_error"]))] +
                    percents(mine[0], "own_basis_error"))
    return table(["model", "basis", "its own load", "half of it as a sine", "gravity aslant", "another direction",
                  "elsewhere"], body)


def tradeoff_imexv():
    """The cheapest run of each integrator that is at most 5 % off, as a multiple of the cheapest of all."""
    body = []
    for model in MODELS:
        runs = [r for r in rows("tradeoff", f"{model}.csv")
                if r["stable"] == "1" and r["disproved"] == "0" and float(r["error_displacement"]) <= 0.05]
        least = min(float(r["cost_s_per_s"]) for r in runs)
        cells = []
        for name in ("imexv", "newmark", "energy", "verlet"):
            costs = [float(r["cost_s_per_s"]) for r in runs if r["integrator"] == name]
            cells.append(f"{min(costs) / least:.2g}" if costs else "-")
        front = [r for r in rows("tradeoff", f"{model}.csv") if r["front"] == "1"]
        body.append([model] + cells + [f"{sum(r['integrator'] == 'imexv' for r in front)} of {len(front)}"])
    return table(["model", "`imexv`", "`newmark`", "`energy`", "`verlet`, condensed", "`imexv` on the front"], body)


def tets_for(runs, aim):
    """Ten-node tetrahedra of the mesh cut uniformly with which the first five frequencies err by at most `aim`, and the cuts:
    each error falls on as it does from edges cut in two to edges cut in three."""
    cuts = 1.0
    for i in range(1, 6):
        at = {c: float(runs["2", str(c)][f"error{i}"]) for c in (1, 2, 3)}
        known = [c for c in (1, 2, 3) if at[c] <= aim]
        order = math.log(at[2] / at[3]) / math.log(3 / 2)
        cuts = max(cuts, known[0] if known else 3 * (at[3] / aim) ** (1 / order))
    return float(runs["2", "1"]["tets"]) * cuts**3, cuts


def model_errors():
    body = []
    for model in MODELS:
        runs = {(r["order"], r["cuts"]): r for r in rows("models", "errors.csv") if r["model"] == model}
        if not runs:
            continue
        exact = [f"{float(runs['0', '0'][f'f{i}']):.4g}" for i in range(1, 6)]
        errors = [", ".join(f"{100 * float(runs[order, cuts][f'error{i}']):+.2g}" for i in range(1, 6))
                  for order, cuts in (("1", "1"), ("2", "1"), ("2", "2"), ("2", "3"))]
        tets, cuts = tets_for(runs, 0.01)
        body.append([model, ", ".join(exact), *errors, f"{float(f'{tets:.2g}'):,.0f}, {cuts:.1f}"])
    return table(["model", "f₁ to f₅ of the shape, Hz", "with linear tetrahedra, %", "with `--order 2`, %",
                  "`--order 2`, edges cut in two, %", "in three, %", "`--order 2` to 1 %: tetrahedra, cuts of an edge"], body)


DETAILS = {"whole": "all coordinates", "error": "`error` 5 %", "error_again": "the same, run again", "budget": "`budget` 1 µs",
           "detail": "`detail` beyond 8 m", "error_detail": "`error` 5 % and `detail`"}


def scene_detail():
    """The crowd by what its bodies say."""
    body = []
    for r in rows("scene_detail", "crowd.csv"):
        share = float(r["reduced_share"])
        body.append([DETAILS[r["variant"]], r["condensed"], f"{100 * share:.3g} %, {r['changes']}" if share > 0 else "-",
                     f"{1000 * float(r['largest_jump_m']):.2g}" if share > 0 else "-", f"{float(r['find_s']):.2g}",
                     f"{float(r['step_s']):.2g}", percent(float(r["error_mean"])), percent(float(r["error_worst"])),
                     percent(float(r["error_near"]))])
    return table(["", "condensed", "steps with fewer, changes", "largest jump, mm", "finding, s", "steps, s", "error, mean",
                  "worst", "near the eye"], body)


def scene_impacts():
    """What acts on a body with a level of detail while still, and while far."""
    return table(["what acts after 1 s", "`still`: error, steps with two", "`beyond`: error"],
                 [[r["what"], f"{percent(float(r['still_error']))}, {100 * float(r['still_share']):.2g} %",
                   percent(float(r["far_error"]))] for r in rows("scene_detail", "impacts.csv")])


def before_after():
    """What the models came with, and the cheapest that errs by at most 5 and 2 % now."""
    body = []
    for model in MODELS:
        runs = [r for r in rows("tradeoff", f"{model}.csv") if r["stable"] == "1" and r["disproved"] == "0"]
        own = [r for r in runs if r["modes"] == "0" and r["masters"] == "0"]
        best = min(own, key=lambda r: float(r["error_displacement"]))
        cells = [model, f"{best['rank']}: {percent(float(best['error_displacement']))} at {float(best['speedup']):,.0f}"]
        for asked in (0.05, 0.02):
            item = next(i for i in picks() if i["model"] == model and i["asked"] == asked)
            cells.append(f"{basis_of(item)}: {percent(item['error'])} at {item['times_faster_than_full']:,.0f}")
        body.append(cells)
    return table(["model", "before: rank, least error, times cheaper than the full order", "now, at most 5 %", "now, at most 2 %"],
                 body)


def basis_rank():
    """Errors of bases by how they are chosen, and by rank, of ten modes."""
    found = {(r["body"], r["selection"], r["rank"]): r for r in rows("basis", "rank.csv") if r["modes"] == "10"}
    body = []
    for name in dict.fromkeys(r["body"] for r in rows("basis", "rank.csv")):
        cases = [found[name, "mass", "20"], found[name, "modes", "20"], found[name, "modes", "30"]]
        cells = [", ".join(percent(float(r[key])) for r in cases) if cases[0][key] else "" for key in
                 ("own", "sine", "gravity", "another", "elsewhere")]
        body.append([name, *cells])
    return table(["body", "its own load", "half of it as a sine", "gravity aslant", "another direction", "elsewhere"], body)


def handles():
    """Errors of motion without and with a handle where the load pulls."""
    found = rows("handles", "errors.csv")
    body = []
    for without, with_one in zip(found[::2], found[1::2]):
        cells = [f"{percent(float(without[key]))}, {percent(float(with_one[key]))}"
                 for key in ("own", "sine", "gravity", "another", "elsewhere")]
        body.append([f"{without['model']}, {without['rank']} + 6", *cells])
    return table(["model, rank", "its own load", "half of it as a sine", "gravity aslant", "another direction", "elsewhere"],
                 body)


def cubature():
    """Points, and what they change of the motion, for each error of the force that was asked for."""
    runs = {(r["model"], r["error_asked"]): r for r in rows("cubature", "errors.csv")}
    errors = list(dict.fromkeys(error for _, error in runs))
    body = [[model] + [f"{int(runs[model, error]['points']):,} points, {percent(float(runs[model, error]['motion_error']))}"
                       for error in errors] for model in MODELS]
    return table(["model"] + [f"{100 * float(error):g} % of the force" for error in errors], body)


def cubature_refined():
    """Force and motion by as many points of the mesh and by ones with learned gradients."""
    runs = {(r["model"], int(r["points"]), r["steps"] != "0"): r for r in rows("cubature", "refined.csv")}
    counts = sorted({count for _, count, _ in runs})

    def cell(model, count, key):
        return " → ".join(percent(float(runs[model, count, refined][key])) for refined in (False, True))

    body = [[model] + [cell(model, count, key) for key in ("force_error", "motion_error") for count in counts] for model in MODELS]
    return table(["model"] + [f"{what}, {count} points" for what in ("force", "motion") for count in counts], body)


def point_picks():
    with open(RESULTS / "tradeoff_points" / "picks.json", encoding="utf-8") as file:
        return json.load(file)


def tradeoff_points():
    """What is picked with polynomials alone and with points beside them; of another law with points alone."""
    body = []
    for item in point_picks():
        tried = "points alone" if item["law"] != "stvk" else "polynomials alone" if item["tried"] == "off" else "both"
        cells = ["-"] * 5
        if "rank" in item:
            cells = [basis_of(item), f"`{item['integrator']}`, {item['dt']:.3g} s", f"{100 * item['error']:.3g} %",
                     f"{100 * item['basis_error']:.3g} %", f"{item['times_faster_than_full']:,.0f}"]
        body.append([item["model"], item["law"], f"{100 * item['asked']:g} %", tried, *cells])
    return table(["model", "law", "asked", "tried", "rank", "stepped by", "error", "of its basis",
                  "times cheaper than the full order"], body)


def touch():
    """How pulls are followed without touch modes, with modes that follow, and with modes that are stepped."""
    found = {(r["model"], r["kind"]): r for r in rows("touch", "coverage.csv")}
    body = []
    for model in MODELS:
        runs = [found[model, kind] for kind in ("usual", "follows", "stepped-40", "stepped-100")]
        usual = float(runs[0]["us_per_step"])
        cells = [f"{r['stepped']}: {percent(float(r['worst']))}, {percent(float(r['mean']))}"
                 + ("" if r is runs[0] else f", {float(r['us_per_step']) / usual:.2g}") for r in runs]
        body.append([model, *cells])
    return table(["model", "without: stepped, worst, mean", "`--touch`: the same, times a step", "stepped, up to rank 40",
                  "stepped, up to rank 100"], body)


def touch_pulls():
    """Errors of the motion under a pull, of the place and of the body, as it rises."""
    found = {(r["model"], r["touch_modes"]): r for r in rows("touch", "pulls.csv")}
    body = []
    for model in MODELS:
        runs = [found[model, kind] for kind in ("usual", "follows")]
        cells = [", ".join(percent(float(r[key])) for r in runs) for key in ("rising_place", "rising_body", "free_place", "free_body")]
        body.append([f"{model}, {runs[1]['stepped']} of {runs[1]['rank']}", *cells, percent(float(runs[1]["vibration_share"]))])
    return table(["model, stepped", "place, while the force rises", "body, the same", "place, let go", "body, let go", "vibration share"], body)


def plastic():
    """The shapes in which a bent beam stays."""
    body = []
    for r in rows("plastic", "shapes.csv"):
        options = "the same, `--cubature-error 0.02`" if r["model"] == "trained_fewer" else f"`{r['options']}`"
        body.append([options, r["points"], f"{float(r['point_stiffness']):.3g}",
                     percent(float(r["error_30"])), percent(float(r["error_80"]))])
    return table(["model", "points", "their stiffness", "after 30 N", "after 80 N"], body)


def training():
    """Errors of motion of bases without training, with it, and with weights by what the training shows."""
    found = {(r["model"], r["basis"]): r for r in rows("training", "errors.csv")}
    body = []
    for model in MODELS:
        bases = [found[model, basis] for basis in ("untrained", "trained", "share")]
        cells = [", ".join(percent(float(r[key])) for r in bases) for key in ("own", "sine", "gravity", "another", "elsewhere")]
        body.append([f"{model}, {bases[0]['modes']}, {bases[0]['rank']}", *cells])
    return table(["model, modes, rank", "its own load", "half of it as a sine", "gravity aslant", "another direction",
                  "elsewhere"], body)


def mujoco():
    """The same bar in Thrum and in MuJoCo."""
    body = []
    for r in json.loads((RESULTS / "mujoco" / "bar.json").read_text(encoding="utf-8"))["rows"]:
        if r["engine"] == "thrum":
            name = f"Thrum, rank {r['rank']}" + (", of linear tetrahedra" if r["order"] == 1 else "")
        else:
            name = f"MuJoCo, `{r['dof']}`" + (f", {r['cells'][0]} cells" if "cells" in r else "")
        body.append([name, str(r["coordinates"]), f"`{r['integrator']}`", f"{1000 * r['dt']:g}", percent(r["error"]),
                     f"{r['us']:.3g}", f"{float(format(1e6 / r['us'], '.2g')):,.0f}",
                     f"{float(format(r['us'] / r['dt'] / 1000, '.2g')):g}"])
    return table(["body", "coordinates", "integrator", "step, ms", "error", "µs a step", "steps a second",
                  "ms for a second of motion"], body)


TABLES = {made.__name__: made for made in (matrix, outcomes, long, step_sizes, sweep, sweep_error, variable,
                                           work_precision, work_means, extremes, linear, tradeoff,
                                           tradeoff_picks, tradeoff_tests, tradeoff_imexv, calculix, scene_detail, scene_impacts, handles, basis_rank, touch, touch_pulls, cubature, cubature_refined, tradeoff_points,
                                           plastic,
                                           before_after, mujoco, model_errors, training)}


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
