#!/usr/bin/env python3
"""Draws the pictures of docs/ that compare schemes, from the committed results, by gnuplot.

usage: schemes.py OUTPUT_FOLDER

long_energy.png      mean energies over the long runs
energy_schemes.png   change of the energy over 30 s at three time steps, all schemes
step_sizes.png       experiment 5.5 of the thesis: the first second, three time steps over each other
work_impulse.png, work_smooth.png   error against processor time after the two starts
tradeoff_fronts.png  error against cost of reduced models, before and after training and condensation
tradeoff_MODEL.png   the same, one for each model, with the model as it comes
tradeoff_points.png  error against cost of cubature points and of polynomials
SPDX-License-Identifier: Apache-2.0
"""
import pathlib
import subprocess
import sys

SOURCE = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(SOURCE))
from report import COLOURS, DASHES, MARKS, groups, number, read  # noqa: E402
from tables import MODELS, lost_time, picks, point_picks, stood_in  # noqa: E402

RESULTS = SOURCE / "results"
# the widest first, and broken ones over it, so that curves that lie over each other are seen
STEP_LINES = {"0.001": "lw 3.2 dt 1 lc rgb '#b8bec4'", "0.005": "lw 1.6 dt (9,5) lc rgb '#1769aa'",
              "0.01": "lw 1.6 dt (2,4) lc rgb '#b0430f'"}
HEAD = """set encoding utf8
set terminal pngcairo size {}, {} font 'DejaVu Sans,10' background '#ffffff'
set output '{}'
set border 3 lc rgb '#777777'
set tics nomirror
set grid lc rgb '#e6e6e6' lt 1
set format y '%g'
set key samplen 2 spacing 1.1
"""


def quoted(text):
    return "'" + text.replace("'", "''") + "' noenhanced"


def panel(title, axes, curves, settings=""):
    """One plot. `curves`: (label, style of gnuplot, points); one without points stands in the key alone."""
    script, parts = f"set title {quoted(title)}\nset xlabel {quoted(axes[0])}\nset ylabel {quoted(axes[1])}\n{settings}", []
    for place, (label, style, points) in enumerate(curves):
        rows = "".join(f"{x:.7g} {y:.7g}\n" for x, y in points) or "NaN NaN\n"
        script += f"$data{place} << END\n{rows}END\n"
        parts.append(f"$data{place} using 1:2 with {style} " + (f"title {quoted(label)}" if label else "notitle"))
    return script + "plot " + ", ".join(parts) + "\n"


def draw(path, size, layout, panels, margins=""):
    text = HEAD.format(*size, path) + f"set multiplot layout {layout[0]}, {layout[1]} {margins}\n" + "".join(panels) + "unset multiplot\n"
    subprocess.run(["gnuplot", "-d"], input=text, text=True, encoding="utf-8", check=True)


def line(scheme, width=1.6):
    return f"lines lw {width} dt {DASHES[scheme]} lc rgb '{COLOURS[scheme]}'"


def ended(run):
    """A run in the key: when it was lost, and how many steps were the scheme's own where others stood in."""
    name = run["scheme"]
    if run["status"] != "done":
        name += f", lost at {lost_time(run):.3g} s" if lost_time(run) < 100 else f", lost at {lost_time(run):,.0f} s"
    if stood_in(run):
        name += f": {int(run['own_steps']):,} own steps, then energy"
    return name


def long_energy(path):
    """Horse and beam at two swings; a scheme that was lost before the first mean stands in the key alone."""
    runs = {(r["model"], float(r["amplitude"]), r["scheme"]): r for r in read(RESULTS / "long" / "long.csv")}
    windows = {(w[0]["model"], float(w[0]["amplitude"]), w[0]["scheme"]): w
               for w in groups(read(RESULTS / "long" / "long_windows.csv"), "model", "amplitude", "scheme")}
    panels = []
    for model, swing in (("horse", 0.05), ("beam", 0.1)):
        curves = []
        for (m, a, scheme), run in runs.items():
            if (m, a) != (model, swing) or scheme in ("verlet", "quadratic", "semi-implicit-euler", "rk4"):
                continue
            points = [(float(w["begin_s"]) + 17.5, number(w["total_j"]) / number(run["energy_j"]))
                      for w in windows.get((m, a, scheme), [])]
            curves.append((ended(run), line(scheme, 5 if scheme == "energy" else 1.6), points))
        # the widest curve first, under the others
        curves.sort(key=lambda curve: "lw 5" not in curve[1])
        panels.append(panel(f"{model}, undamped, swinging by {100 * swing:g} % of its length",
                            ("simulated time [s]", "mean energy over 35 s / energy at the start"), curves,
                            "set xrange [0:9000]\nset yrange [0:2.2]\nset bmargin 8\nset key below Left reverse width -10 maxrows 5 font ',8'\n"))
    draw(path, (1260, 620), (1, 2), panels)


def energy_schemes(path):
    """The beam after the square load: by how much the energy of each scheme has changed so far, at each step."""
    curves = read(RESULTS / "step_sizes" / "curves.csv")
    shown = [scheme for scheme in COLOURS if any(r["scheme"] == scheme for r in curves)]
    panels = []
    for dt in STEP_LINES:
        own = {run[0]["scheme"]: [r for r in run if float(r["time_s"]) > 0.3]
               for run in groups([r for r in curves if r["dt_s"] == dt], "scheme")}
        keyed, parts = dt == "0.001", []
        for place, scheme in enumerate(shown):
            points, most = [], 0.0
            for r in own.get(scheme, []):
                most = max(most, abs(number(r["total_j"]) / number(own[scheme][0]["total_j"]) - 1))
                points.append((float(r["time_s"]), most))
            points = [point for point in points if point[1] > 0]

            # marks stand where no other scheme has its own, so that curves that lie over each other are seen
            note = {"energy": "energy: rounding alone"}.get(scheme, scheme)
            parts += [(None, line(scheme, 1.3), points),
                      (None, f"points pt {MARKS[scheme]} ps 1 lc rgb '{COLOURS[scheme]}'",
                       points[6 + 4 * place::5 * len(shown)]),
                      (note if keyed else None,
                       f"linespoints lw 1.3 dt {DASHES[scheme]} pt {MARKS[scheme]} ps 1 lc rgb '{COLOURS[scheme]}'", [])]
        panels.append(panel(f"h = {dt} s", ("time [s]", "largest change of the energy so far, relative"), parts,
                            "set logscale xy\nset xrange [0.3:30]\nset yrange [1e-8:10]\nset format y '10^{%T}'\n"
                            "set key at screen 0.995, screen 0.93 right top samplen 4 font ',9'\n"))
    draw(path, (1260, 460), (1, 3), panels, "margins 0.06, 0.8, 0.13, 0.9 spacing 0.055, 0.1")


def step_sizes(path):
    """The first second of the energy and of the displacement, side by side for each scheme."""
    curves = read(RESULTS / "step_sizes" / "curves.csv")
    shown = [s for s in ("thesis-newton", "position", "newmark", "fox-goodwin", "imexv", "energy", "backward-euler",
                         "semi-implicit-euler", "rk4") if any(r["scheme"] == s for r in curves)]
    panels = []
    for scheme in shown:
        own = {run[0]["dt_s"]: run for run in groups([r for r in curves if r["scheme"] == scheme], "dt_s")}
        for key, what, reach in (("total_j", "energy [J]", "0.7:0.82"), ("amplitude", "displacement / length", "0:0.1")):
            panels.append(panel(
                scheme, ("time [s]", what),
                [(f"h = {dt} s" if (scheme, key) == (shown[0], "amplitude") else None, f"lines {style}",
                  [(float(r["time_s"]), number(r[key])) for r in own[dt] if float(r["time_s"]) <= 1])
                 for dt, style in STEP_LINES.items()],
                f"set xrange [0:1]\nset yrange [{reach}]\nset key at screen 0.62, screen 0.15 top left Left reverse font ',9'\n"))

    # one key for all, in the room beside the last scheme
    draw(path, (1260, 210 * ((len(shown) + 1) // 2)), ((len(shown) + 1) // 2, 4), panels)


def work(start):
    def picture(path):
        rows = read(RESULTS / "work_precision" / "work_precision.csv")
        panels = []
        for model in MODELS:
            curves = []
            for scheme, colour in COLOURS.items():
                if not any(r["scheme"] == scheme for r in rows):
                    continue
                # runs that were lost are left out; a ring stands around h = 1 ms
                own = [r for r in rows if r["status"] == "done"
                       and (r["model"], r["start"], r["scheme"]) == (model, start, scheme)]
                points = [(1e3 * number(r["cost_s_per_s"]), number(r["error"])) for r in own]
                curves.append((scheme if model == MODELS[0] else None,
                               f"linespoints lw 1.2 pt {MARKS[scheme]} ps 0.8 lc rgb '{colour}'", points))
                curves.append((None, f"points pt 6 ps 2 lc rgb '{colour}'",
                               [point for r, point in zip(own, points) if r["dt_s"] == "0.001"]))
            panels.append(panel(model, ("processor time for a second [ms]", "error of q"), curves,
                                "set logscale xy\nset yrange [*:2]\nset format x '%g'\nset format y '10^{%T}'\n"
                                "set key at screen 0.995, screen 0.95 right top font ',9'\n"))
        # the key stands beside all panels
        draw(path, (1200, 700), (2, 3), panels, "margins 0.06, 0.83, 0.08, 0.95 spacing 0.055, 0.14")
    return picture


def front(runs):
    """The runs that no other beats in both, as a falling line."""
    points, least = [], float("inf")
    for cost, error in sorted((number(r["cost_s_per_s"]), 100 * number(r["error_displacement"])) for r in runs):
        if error < least:
            least = error
            points.append((cost, error))
    return points


def believed_runs(model):
    """The runs of the trade-off that came to their end and are believed."""
    return [r for r in read(RESULTS / "tradeoff" / f"{model}.csv") if r["stable"] == "1" and r["disproved"] == "0"]


def tradeoff_before_after(model):
    """One model: what it came with, what modes and derivatives can do, and what all of it can."""
    def picture(path):
        runs = believed_runs(model)
        mine = [item for item in picks() if item["model"] == model]
        full = mine[0]["full"]["cost_s_per_s"]
        plain = [r for r in runs if r["trained"] == "0" and r["masters"] == "0"]
        points = [(number(r["cost_s_per_s"]), 100 * number(r["error_displacement"])) for r in plain if r["modes"] == "0"]
        curves = [("before: the model as it comes, all settings", "points pt 2 ps 0.9 lc rgb '#d2691e'", points),
                  ("before: modes and derivatives of any rank", "linespoints lw 1.6 dt (8,4) pt 6 ps 0.8 lc rgb '#d2691e'", front(plain)),
                  ("after: with trained and condensed bases", "linespoints lw 1.6 pt 7 ps 0.6 lc rgb '#111111'", front(runs)),
                  ("picked for 5 and 2 %", "points pt 4 ps 1.6 lw 1.6 lc rgb '#b00020'",
                   [(item["cost_s_per_s"], 100 * item["error"]) for item in mine]),
                  ("the full order", "points pt 9 ps 1.4 lc rgb '#1769aa'", [(full, 100 * mine[0]["full"]["error"])])]
        settings = ("set logscale xy\nset format x '10^{%T}'\n" + f"set xrange [1e-5:{2 * full:.6g}]\nset yrange [0.03:150]\n"
                    "set bmargin 8\nset key at screen 0.07, screen 0.15 left top Left reverse maxrows 3 font ',9'\n")
        draw(path, (760, 460), (1, 1),
             [panel(f"{model}, under its own load", ("processor time for a second [s]", "error [%]"), curves, settings)])
    return picture


def tradeoff_fronts(path):
    """A plot for each model: the front of modes and derivatives, the front of all, and of imexv within it."""
    panels = []
    for model in MODELS:
        runs = believed_runs(model)
        before = [r for r in runs if r["trained"] == "0" and r["masters"] == "0"]
        mine = [item for item in picks() if item["model"] == model]
        full = mine[0]["full"]["cost_s_per_s"]
        keyed = model == MODELS[0]
        curves = [("modes and derivatives" if keyed else None, "linespoints lw 1.6 dt (8,4) pt 6 ps 0.8 lc rgb '#d2691e'",
                   front(before)),
                  ("with trained and condensed" if keyed else None, "linespoints lw 1.6 pt 7 ps 0.6 lc rgb '#111111'",
                   front(runs)),
                  ("of those, imexv" if keyed else None, "linespoints lw 1 dt (2,4) pt 8 ps 0.8 lc rgb '#1769aa'",
                   front(r for r in runs if r["integrator"] == "imexv")),
                  ("picked for 5 and 2 %" if keyed else None, "points pt 4 ps 1.6 lw 1.6 lc rgb '#b00020'",
                   [(item["cost_s_per_s"], 100 * item["error"]) for item in mine])]
        panels.append(panel(f"{model} (full order {full:.2g} s)", ("processor time for a second [s]", "error [%]"), curves,
                            "set logscale xy\nset format x '10^{%T}'\n" + f"set xrange [1e-5:{full:.6g}]\nset yrange [0.03:150]\n"
                            "set key at screen 0.995, screen 0.95 right top font ',9'\n"))
    draw(path, (1200, 700), (2, 3), panels, "margins 0.06, 0.81, 0.08, 0.95 spacing 0.055, 0.14")


def tradeoff_points(path):
    """A plot for each case: the fronts of polynomials, condensed or not, of the search without points, that of points of the other,
    and what is picked. An error counts as no less than that of its basis, below which only a cancellation brings it."""
    def fronts(item, tried, keep):
        runs = [r for r in read(RESULTS / "tradeoff_points" / f"{item['model']}_{item['law']}_{tried}.csv")
                if r["stable"] == "1" and r["disproved"] == "0" and keep(r)]
        return front({**r, "error_displacement": max(number(r["error_displacement"]), number(r["basis_error"]))} for r in runs)

    panels = []
    mine = [item for item in point_picks() if item["tried"] == "auto"]
    for item in mine:
        keyed, full, stvk = item is mine[0], item["full"]["cost_s_per_s"], item["law"] == "stvk"
        curves = [("polynomials" if keyed else None, "linespoints lw 1.6 pt 7 ps 0.6 lc rgb '#d2691e'",
                   fronts(item, "off", lambda r: r["masters"] == "0") if stvk else []),
                  ("condensed" if keyed else None, "linespoints lw 1.2 dt (2,4) pt 8 ps 0.8 lc rgb '#5f6b7a'",
                   fronts(item, "off", lambda r: r["masters"] != "0") if stvk else []),
                  ("cubature points" if keyed else None, "linespoints lw 1.6 pt 4 ps 0.7 lc rgb '#1769aa'",
                   fronts(item, "auto", lambda r: r["points"] != "0")),
                  ("picked" if keyed else None, "points pt 6 ps 2 lw 1.6 lc rgb '#b00020'",
                   [(item["cost_s_per_s"], 100 * max(item["error"], item["basis_error"]))] if "error" in item else []),
                  ("the full order" if keyed else None, "points pt 9 ps 1.4 lc rgb '#111111'",
                   [(full, 100 * item["full"]["error"])])]
        title = f"{item['model']}, {item['law']}, {100 * item['asked']:g} % asked"
        panels.append(panel(title, ("processor time for a second [s]", "error, at least that of the basis [%]"), curves,
                            "set logscale xy\nset format x '10^{%T}'\n" + f"set xrange [1e-4:{2 * full:.6g}]\nset yrange [0.03:150]\n"
                            "set key at screen 0.995, screen 0.9 right top font ',9'\n"))
    draw(path, (1200, 380), (1, len(panels)), panels, "margins 0.05, 0.86, 0.15, 0.9 spacing 0.05, 0.1")


PICTURES = {"long_energy.png": long_energy, "energy_schemes.png": energy_schemes, "step_sizes.png": step_sizes,
            "work_impulse.png": work("impulse"), "work_smooth.png": work("smooth"),
            "tradeoff_fronts.png": tradeoff_fronts, "tradeoff_points.png": tradeoff_points,
            **{f"tradeoff_{model}.png": tradeoff_before_after(model) for model in MODELS}}

if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    for name, made in PICTURES.items():
        made(pathlib.Path(sys.argv[1]) / name)
