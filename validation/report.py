#!/usr/bin/env python3
"""Makes the page of an experiment from the tables that it wrote.

usage: report.py KIND TABLE.csv

KIND is matrix, step_sizes, long, sweep, variable, work_precision, extremes, linear or tradeoff. The page (HTML with its plots in it, so that it needs nothing
else) is written next to the table. `thrum experiments` and `thrum tradeoff` call this script; called by hand it makes the
page again. Beside TABLE.csv the script reads TABLE.about.json, which says where the figures were measured, and the other
tables of the experiment. Only the standard library of Python 3 is needed; gnuplot draws the plots, and without it the page
has the tables alone. SPDX-License-Identifier: Apache-2.0
"""
import csv
import html
import itertools
import json
import math
import os
import pathlib
import shlex
import shutil
import subprocess
import sys

# the schemes of validation/experiments/scheme.h, in its order
COLOURS = {"thesis": "#1769aa", "thesis-newton": "#7fb2dd", "position": "#7b3fb3", "quadratic": "#c77dd8",
           "verlet": "#9aa0a6", "midpoint": "#b8860b", "newmark": "#d2691e", "newmark-newton": "#f0b080",
           "fox-goodwin": "#c0143c", "imexv": "#17a2c4", "energy": "#2e8b57", "backward-euler": "#8b5a2b",
           "semi-implicit-euler": "#5f6b7a", "rk4": "#111111"}
# strokes and points of gnuplot by which their curves are told apart where colours are not
DASHES = {"thesis": "(9,4)", "thesis-newton": "(9,4,2,4)", "position": "(4,3)", "quadratic": "(2,3)", "verlet": "(14,4)",
          "midpoint": "(14,4,2,4)", "newmark": "(6,2)", "newmark-newton": "(6,2,2,2)", "fox-goodwin": "(9,3,2,3,2,3)",
          "imexv": "(12,6)", "energy": "1", "backward-euler": "(2,5)", "semi-implicit-euler": "(5,5)", "rk4": "(16,3,3,3)"}
MARKS = {"thesis": 8, "thesis-newton": 9, "position": 4, "quadratic": 5, "verlet": 1, "midpoint": 2, "newmark": 10,
         "newmark-newton": 11, "fox-goodwin": 12, "imexv": 13, "energy": 7, "backward-euler": 3, "semi-implicit-euler": 15,
         "rk4": 14}
LEVELS = {"newton": "full Newton", "energy": "energy steps", "substep": "sub-steps",
          "switched": "after a switch to energy", "split_changes": "split changes",
          "scheme_switches": "scheme switches", "corrections": "corrections"}
SUBJECTS = {"stiffness": "Young's modulus", "poisson": "Poisson's ratio", "size": "length of the body",
            "density": "density", "load": "load", "snap": "snap-through of a shallow arch",
            "tet": "one tetrahedron", "square": "repeated frequencies", "rank": "rank",
            "resonance": "h times a frequency", "rate": "rates of haptics and of sound"}
WINDOW_SECONDS = 35.0

# The thesis: time of Newmark over time of IMEXv by load and damping, explicit/implicit modes, and when its IMEXv was lost
# under the sine [s]. Its tables of the undamped impulse and the undamped sine repeat columns of others and are left out.
THESIS_MODELS = ["beam", "basket", "bridge", "horse", "tower", "heart"]
THESIS_SPEEDUP = {
    ("impulse", 0.3): [1.05, 1.40, 3.45, 3.36, 1.51, 2.57],
    ("square", 0): [1.50, 1.87, 1.65, 1.58, 1.41, 2.37],
    ("square", 0.3): [1.35, 2.32, 1.42, 1.61, 1.10, 1.75],
    ("sine", 0.3): [1.29, 1.96, 1.67, 1.59, 1.24, 1.46],
}
THESIS_SPLIT = {"beam": "9/6", "basket": "15/5", "bridge": "13/2", "horse": "9/6", "tower": "11/9", "heart": "27/3"}
THESIS_LOST = {("beam", 0): 6.86, ("beam", 0.3): 7.12, ("tower", 0): 10.53}

STYLE = """body{font:15px/1.45 system-ui,sans-serif;margin:2em auto;max-width:1180px;padding:0 1em;color:#222;background:#fff}
.wide{overflow-x:auto}table{border-collapse:collapse;margin:1em 0;font-size:12px}
th,td{padding:2px 5px;text-align:right;border-bottom:1px solid #ddd}td{white-space:nowrap}
td.w{white-space:normal;min-width:9em}.wide svg{max-width:none}
th{border-bottom:2px solid #888;vertical-align:bottom}
td:first-child,th:first-child,.l{text-align:left}
.bad{color:#b00020;font-weight:600}.dim{color:#777}svg{margin:2px;max-width:100%;height:auto}"""


# --- numbers and cells ---------------------------------------------------------------------------------------------------

def number(text):
    """The value of a field; NaN where the table leaves it empty."""
    return float(text) if text else math.nan


def percent(value, form="{:.1f} %"):
    """A share in per cent; one of a run that was lost may be any number, and is shown by its power of ten."""
    return show(100 * value, form if not abs(value) >= 1e4 else "{:.1e} %")


def show(value, form="{:.2f}"):
    """A number for people, or a dash where there is none."""
    return form.format(value) if math.isfinite(value) else "–"


def fill(template, *values):
    """HTML from a template and texts. It is the one place where a text becomes HTML, and it escapes all of them."""
    return template.format(*(html.escape(str(value)) for value in values))


class Cell:
    """The text of a table's cell with its class and colour; `plain` strings become cells of their own."""

    def __init__(self, text, style="", colour=None):
        self.text, self.style, self.colour = str(text), style, colour

    def html(self, tag="td"):
        style = f' class="{self.style}"' if self.style else ""
        colour = f' style="color:{self.colour}"' if self.colour else ""
        return fill(f"<{tag}{style}{colour}>{{}}</{tag}>", self.text)


def scheme(name):
    return Cell(name, "l", COLOURS.get(name))


def status(row):
    """How a run ended: done, or lost, when and why."""
    if row["status"] == "done":
        return Cell("done", "l")
    time = number(row["simulated_s"]) if "simulated_s" in row else float(row["steps"]) * float(row["dt_s"])
    return Cell(f"lost at {time:.4g} s: {row['reason']}", "l w bad")


def table(head, rows):
    """An HTML table; every text becomes a Cell, which escapes it."""
    def line(cells, tag):
        made = [cell if isinstance(cell, Cell) else Cell(cell) for cell in cells]
        return "<tr>" + "".join(cell.html(tag) for cell in made) + "</tr>\n"

    # on a narrow screen a table scrolls by itself, and the page does not
    return "<div class=wide><table>\n" + line(head, "th") + "".join(line(row, "td") for row in rows) + "</table></div>\n"


# how many steps there were, and where not all were the scheme's own, what stepped the others and what its monitor did
STEPPED = ["steps", Cell("of them own, others, and what the monitor did", "l")]


def stepped(row):
    others = [f"{row[name]} {what}" for name, what in LEVELS.items() if int(row[name] or 0) > 0]
    return [row["steps"], Cell(", ".join([f"{row['own_steps']} own", *others]) if others else "all own", "l w")]


def stepped_by_energy(rows, samples, *keys):
    """What the integrator energy stepped after a switch, for the label of an axis: "; imexv: 98 % by energy". The rows of `rows`
    that agree with one of `samples` in `keys` and scheme say so."""
    shares = []
    for sample in samples:
        for row in rows:
            if (row["scheme"] == sample["scheme"] and all(row[key] == sample[key] for key in keys)
                    and int(row["switched"] or 0) > 0):
                shares.append(f"{row['scheme']}: {100 * int(row['switched']) / int(row['steps']):.3g} %")
    return "; " + ", ".join(shares) + " by energy" if shares else ""


def groups(rows, *keys):
    """Rows that follow each other and agree in `keys`."""
    return [list(group) for _, group in itertools.groupby(rows, key=lambda row: [row[key] for key in keys])]


# --- plots ---------------------------------------------------------------------------------------------------------------

def quoted(text):
    """A text for gnuplot, which takes none of it for a command."""
    return "'" + str(text).replace("'", "''").replace("\n", " ") + "' noenhanced"


def curve(name, kind="lines", size=0.6):
    """How a scheme's curve is drawn: its strokes, its points or, as in a key, both."""
    strokes, points = f"lw 1.4 dt {DASHES[name]}", f"pt {MARKS[name]} ps {size}"
    return {"lines": f"lines {strokes}", "points": f"points {points}", "linespoints": f"linespoints {points}",
            "both": f"linespoints {strokes} {points}"}[kind]


def marked(name, points):
    """A scheme's curve with a few marks, which stand where no other scheme has its own, so that curves that lie over each other
    are told apart."""
    place, colour = list(COLOURS).index(name), COLOURS[name]
    apart = max(1, len(points) // (2 * len(COLOURS)))
    return [(name, colour, curve(name), points),
            (None, colour, curve(name, "points"), points[apart * (place + 1)::apart * len(COLOURS)])]


class Plots:
    """Collects plots and draws all of them in one run of gnuplot."""

    def __init__(self):
        self.scripts = []

    def add(self, title, axes, size, series, log="", y_range=None):
        """A mark that draw() replaces. `series`: (label, colour, gnuplot style, [(x, y), ...]); key() says what the curves are."""
        data, curves = "", []
        for _, colour, style, points in series:
            points = [p for p in points if all(map(math.isfinite, p))
                      and ("x" not in log or p[0] > 0) and ("y" not in log or p[1] > 0)]
            if not points:
                continue
            block = f"$data{len(curves)}"
            data += f"{block} << END\n" + "".join(f"{x:.8g} {y:.8g}\n" for x, y in thin(points)) + "END\n"
            curves.append(f"{block} using 1:2 with {style} lc rgb '{colour}' notitle")
        if not curves:
            return "<p class=dim>There is nothing to plot.</p>"
        formats = "".join(f"set format {axis} '" + ("10^{%T}" if axis in log else "%g") + "'\n" for axis in "xy")
        return self.script(
            size, f"set title {quoted(title)} font ',12'\nset xlabel {quoted(axes[0])}\nset ylabel {quoted(axes[1])}\n"
            "set border 3 lc rgb '#777777'\nset tics nomirror\nset grid lc rgb '#e4e4e4' lt 1\nset rmargin 4\n" + formats
            + (f"set logscale {log}\n" if log else "") + (f"set yrange [{y_range}]\n" if y_range else "") + data
            + "plot " + ", ".join(curves) + "\n")

    def key(self, series):
        """The key of plots that have the same curves: each label once, in a picture of its own that covers no curve."""
        shown = {label: f"NaN with {style} lc rgb '{colour}' title {quoted(label)}" for label, colour, style, points in series
                 if label and points}
        if not shown:
            return ""
        columns = max(1, min(len(shown), 1110 // (8 * max(map(len, shown)) + 60)))
        lines = math.ceil(len(shown) / columns)
        return "<div class=wide>" + self.script((1110, 18 * lines + 12),
                           "unset border\nunset tics\nset xrange [0:1]\nset yrange [0:1]\nset lmargin 0\nset rmargin 0\n"
                           "set tmargin 0\nset bmargin 0\n"
                           f"set key at graph 0, graph 1 left top Left reverse samplen 4 maxrows {lines}\n"
                           + "plot " + ", ".join(shown.values()) + "\n") + "</div>"

    def script(self, size, text):
        """Notes what gnuplot is told of one picture, and returns the mark of its place."""
        self.scripts.append(f"reset\nset terminal svg size {size[0]},{size[1]} font 'sans-serif,11' name "
                            f"'plot{len(self.scripts)}_'\nset encoding utf8\n" + text)
        return f"<!--plot {len(self.scripts) - 1}-->"

    def draw(self, page):
        if not self.scripts:
            return page
        drawn, reason = [], "gnuplot is not installed"
        if shutil.which("gnuplot"):
            run = subprocess.run(["gnuplot", "-d"], input="".join(self.scripts) + "unset output\n", text=True,
                                 capture_output=True, encoding="utf-8")
            drawn = ["<svg" + part.split("</svg>")[0] + "</svg>" for part in run.stdout.split("<svg")[1:]]
            reason = "gnuplot failed"
        if len(drawn) != len(self.scripts):
            print(f"report.py: the page has no plots: {reason}", file=sys.stderr)
            drawn = [f"<p class=dim>No plot: {reason}.</p>"] * len(self.scripts)
        for place, picture in enumerate(drawn):
            page = page.replace(f"<!--plot {place}-->", picture, 1)
        return page


def thin(points, most=400):
    """The least and the largest of each stretch of a long curve, which looks the same and is a tenth of the size."""
    if len(points) <= most:
        return points
    kept, stretch = [], 2 * len(points) // most
    for begin in range(0, len(points), stretch):
        part = points[begin:begin + stretch]
        kept += sorted({min(part, key=lambda p: p[1]), max(part, key=lambda p: p[1])})
    return kept


# --- the pages -----------------------------------------------------------------------------------------------------------

def matrix_curves(rows, runs_of, plots):
    """The energy over time of each body, load, damping and step."""
    page = ("<h2>Energy over time</h2>\n<p>Schemes that keep the energy alike lie over each other, and have their marks beside "
            "each other; the table has the numbers.</p>\n")
    for body in groups(rows, "model"):
        page += fill("<h3>{}</h3>\n", body[0]["model"])
        page += plots.key([(name, colour, curve(name, "both"), [r for r in body if r["scheme"] == name][:1])
                           for name, colour in COLOURS.items()])
        for damping in sorted({row["damping"] for row in body}, key=float):
            for panel in groups([row for row in body if row["damping"] == damping], "load", "dt_s"):
                # a run that was lost leaves the picture at twice what energy reaches
                runs = groups(panel, "scheme")
                kept = [number(r["total_j"]) for run in runs for r in run if r["scheme"] in ("energy", "newmark")]
                by_energy = stepped_by_energy(runs_of, [run[0] for run in runs], "model", "load", "damping", "dt_s")
                page += plots.add(
                    f"{panel[0]['load']}, α = {damping}, h = {panel[0]['dt_s']} s", (f"time [s]{by_energy}", "energy [J]"),
                    (370, 270), [series for run in runs for series in marked(
                        run[0]["scheme"], thin([(float(r["time_s"]), number(r["total_j"])) for r in run], 50))],
                    y_range=f"0:{2 * max(kept)}" if kept else "0:*")
            page += "<br>"
    return page


def speed(rows):
    """Newmark's time over that of the thesis' scheme, both with the thesis' solver, beside the ratios of the thesis."""
    cases = {(r["model"], r["load"], float(r["damping"]), r["scheme"]): number(r["us_per_step"]) for r in rows
             if r["status"] == "done"}
    kinds = list(dict.fromkeys((r["load"], float(r["damping"])) for r in rows))
    head, body = ["model"], []
    for load, damping in kinds:
        head += [f"{load}, α = {damping:g}", Cell("thesis", "dim")]
    for model in dict.fromkeys(r["model"] for r in rows):
        line = [model]
        for kind in kinds:
            ratio = cases.get((model, *kind, "newmark-newton"), math.nan) / cases.get((model, *kind, "thesis-newton"), math.nan)
            known = kind in THESIS_SPEEDUP and model in THESIS_MODELS
            published = THESIS_SPEEDUP[kind][THESIS_MODELS.index(model)] if known else math.nan
            line += [show(ratio), Cell(show(published), "dim")]
        body.append(line)
    return ("<h2>Speed: time of Newmark over time of the thesis' scheme</h2>\n<p>Both with a Jacobian and its inverse in each "
            "iteration; processor time of the same steps of the runs that were not lost, beside the ratio of the thesis (other "
            "meshes, forces and machine).</p>\n" + table(head, body))


def matrix(path, rows, about, plots):
    done = {name: [row["status"] == "done" for row in rows if row["scheme"] == name] for name in COLOURS}
    ended = "; ".join(f"{name} {sum(runs)} of {len(runs)}" for name, runs in done.items() if runs)
    dts = ", ".join(dict.fromkeys(row["dt_s"] for row in rows))
    page = fill(
        "<p>Each body is held at its fixed set and pushed at one place, by an impulse (0.003 s), a constant force (0.3 s) "
        "or a sine of 1 Hz, with damping α = 0 or 0.3 s<sup>−1</sup>, at h = {} s. The forces were found so that, without "
        "damping, the sine displaces the loaded part by a tenth of the body's length or more, the other loads by a twentieth "
        "or more. Runs that came to their end: {}; IMEXv of the thesis: 33 of 36. A run is lost when a step cannot be made, "
        "or at ten times the energy that <i>energy</i> reaches under the same force.</p>\n", dts, ended)
    models = list(dict.fromkeys(r["model"] for r in rows))
    if about["kind"] == "matrix":
        page += speed(rows)

    # the split at rest is that of the first recorded row
    curves = read(path.with_name("curves.csv"))
    body = []
    for model in models:
        first = next((r for r in curves if r["model"] == model and r["scheme"] in ("thesis", "imexv")), None)
        rank = next(int(r["explicit_modes"]) + int(r["implicit_modes"]) for r in rows if r["model"] == model)
        if first:
            explicit = int(float(first["explicit_modes"]))
            body.append([model, rank, f"{explicit}/{rank - explicit}", Cell(THESIS_SPLIT.get(model, "–"), "dim")])
    if body:
        page += "<h2>Bodies</h2>\n" + table(["model", "rank", "explicit/implicit at rest", "thesis"], body)
    if curves:
        page += matrix_curves(curves, rows, plots)

    body = []
    for r in rows:
        lost = THESIS_LOST.get((r["model"], float(r["damping"])), math.nan)
        lost = lost if r["scheme"] == "thesis" and r["load"] == "sine" else math.nan
        body.append([r["model"], Cell(r["load"], "l"), show(number(r["force_n"]), "{:.3g}"), r["damping"], r["dt_s"],
                     scheme(r["scheme"]), status(r), Cell(show(lost, "{:.4g}"), "dim"),
                     show(number(r["us_per_step"])), show(number(r["mean_iterations"])),
                     percent(number(r["peak_amplitude"])), show(number(r["energy_peak_j"]), "{:.3g}"),
                     show(number(r["energy_end_j"]), "{:.3g}"), show(number(r["energy_change"]), "{:.1e}"), *stepped(r)])
    return page + ("<h2>All runs</h2>\n<p>Change: of the mean energy from the first to the last tenth of the time after the "
                   "load, without damping. The last columns count what stepped: the scheme itself, what needed more than "
                   "quasi-Newton, and what the stability monitor did.</p>\n") + table(
        ["model", Cell("load", "l"), "force [N]", "α [1/s]", "h [s]", Cell("scheme", "l"), Cell("status", "l"),
         "thesis lost at [s]", "µs a step", "iterations", "amplitude", "peak energy [J]", "end [J]", "change",
         *STEPPED], body)


def long_steady(row):
    """Whether the slope of the high modes is within two standard errors of zero."""
    error = number(row["high_slope_error_correlated_per_s"])
    if not math.isfinite(error):
        return "–"
    return "yes" if abs(number(row["high_slope_per_s"])) <= 2 * error else "no"


def long(path, rows, about, plots):
    page = ("<p>Undamped, after an impulse of 0.003 s that makes the loaded part swing to the given share of the body's "
            "length. The thesis, on its horse over 10,000 s: total energy +2 %, high modes −28 %.</p>\n")
    page += table(
        ["model", "amplitude", Cell("scheme", "l"), Cell("status", "l"), "µs a step",
         "total energy, last against first 35 s", "worst 35 s", "high modes, last against first",
         "slope of the high modes [1/s]", "± standard error", "of windows that follow each other", "within two of these",
         *STEPPED],
        [[r["model"], percent(number(r["reached"])), scheme(r["scheme"]), status(r),
          show(number(r["us_per_step"])),
          *(show(number(r[key]), "{:.1e}") for key in
            ("total_change", "total_worst", "high_change", "high_slope_per_s", "high_slope_error_per_s",
             "high_slope_error_correlated_per_s")),
          long_steady(r), *stepped(r)] for r in rows])

    # the means of all windows over the first; a lost run leaves the picture at five times
    windows = read(path.with_name(path.stem + "_windows.csv"))
    for case in groups(windows, "model", "amplitude"):
        page += "<div>"
        by_energy = stepped_by_energy(rows, [run[0] for run in groups(case, "scheme")], "model", "amplitude")
        for key, what in (("total_j", "total energy"), ("high_j", "high modes")):
            series, highest, runs = [], 0, groups(case, "scheme")
            for run in runs:
                first = number(run[0][key])
                points = [(float(r["begin_s"]) + 0.5 * WINDOW_SECONDS, number(r[key]) / first) for r in run if first > 0]
                series += marked(run[0]["scheme"], points)
                highest = max([highest, *(y for _, y in points)])
            page += plots.add(f"{case[0]['model']}, {100 * float(case[0]['amplitude']):.0f} %: {what}",
                              (f"time [s]{by_energy}", "mean over 35 s / the first"), (560, 280), series,
                              y_range="*:5" if highest > 5 else None)
        page += plots.key([(run[0]["scheme"], COLOURS[run[0]["scheme"]], curve(run[0]["scheme"], "both"), run)
                           for run in groups(case, "scheme")]) + "</div>\n"
    return page


def sweep_table(rows):
    def error(row, key):
        return "–" if row["status"] == "lost" else show(number(row[key]), "{:.1e}")

    return table(
        ["model", Cell("start", "l"), "h [s]", "drawn from", Cell("scheme", "l"), Cell("status", "l"), "µs a step",
         "µs for a simulated second", "iterations", "error of q", "of the reference", "energy error", "change", "amplitude",
         *STEPPED],
        [[r["model"], Cell(r["start"], "l"), r["dt_s"], r["shortest_dt_s"] if r["shortest_dt_s"] != r["dt_s"] else "",
          scheme(r["scheme"]), status(r), show(number(r["us_per_step"])), show(1e6 * number(r["cost_s_per_s"]), "{:.0f}"),
          show(number(r["mean_iterations"])), error(r, "error"), show(number(r["reference_error"]), "{:.1e}"),
          error(r, "energy_error"), error(r, "energy_change"), percent(number(r["peak_amplitude"])),
          *stepped(r)] for r in rows])


def kept_points(rows, name, x, y):
    """The points of one scheme in a plot; a lost run's numbers say nothing, and rounding nothing below 1e-15."""
    return [(number(r[x]), max(number(r[y]), 1e-15)) for r in rows if r["scheme"] == name and r["status"] == "done"]


ERROR_OF_Q = ("Error of q: over the first second, the root mean square of q − q<sub>ref</sub> over that of q<sub>ref</sub> in "
              "the norm of the mass, where q<sub>ref</sub> is <i>energy</i> at a step of 3.125 µs; its own error comes from "
              "the run with twice that step.")


def sweep(path, rows, about, plots):
    page = ("<p>Undamped, from the momentum that an impulse leaves, so that the energy is known: ½|p|². Energy error: the "
            "largest deviation from it; change: of the mean over the last tenth of the time. Lost: a step cannot be made, or "
            "the energy is above ten times its value, or its mean at the end above twice. " + ERROR_OF_Q +
            " The thesis calls 0.01 s its limit.</p>\n")
    for body in groups(rows, "model"):
        page += "<div>"
        for key, what in (("energy_error", "largest relative error of the energy"), ("error", "error of q")):
            # where steps are drawn, marks stand at their longest, and constant ones are a line
            series = [(name, colour, curve(name, "linespoints"),
                       kept_points([r for r in body if r["shortest_dt_s"] == r["dt_s"]], name, "dt_s", key))
                      for name, colour in COLOURS.items()]
            series += [(f"{name}, drawn steps", colour, curve(name, "points", 1.2),
                        kept_points([r for r in body if r["shortest_dt_s"] != r["dt_s"]], name, "dt_s", key))
                       for name, colour in COLOURS.items()]
            page += plots.add(body[0]["model"], ("time step [s]", what), (560, 340), series, "xy")
        page += plots.key(series) + "</div>\n"
    return page + sweep_table(rows)


def work_precision(path, rows, about, plots):
    page = ("<p>Undamped, the first second after an impulse at the loaded group, and after momentum in the first basis vector "
            "alone (smooth), both of a swing of a twentieth of the length. " + ERROR_OF_Q + fill(
                " Cost: processor time of the steps, the least of five rounds over all runs. Runs that are lost within {} s are "
                "left out; they are in {} beside this page.</p>\n", f"{about['time']:g}", path.name))
    page += plots.key([(name, colour, curve(name, "linespoints"), [r for r in rows if r["scheme"] == name][:1])
                       for name, colour in COLOURS.items()])
    for case in groups(rows, "model", "start"):
        page += plots.add(f"{case[0]['model']}, {case[0]['start']}", ("processor time for a second [s]", "error of q"),
                          (560, 400), [(name, colour, curve(name, "linespoints"),
                                        kept_points(case, name, "cost_s_per_s", "error"))
                                       for name, colour in COLOURS.items()], "xy", "1e-7:2")
    return page


def extremes(path, rows, about, plots):
    page = ("<p>From rest under a constant load, by default a tenth of what would bend the body by its length if it were "
            "linear, for half of the steps; then without. Energy error: the largest |E − work| in any step over the most work "
            "that was done. Outcome: runs (quasi-Newton solved every step), the last fallback level that was needed, lost (at "
            "the end the error is above all work), stopped (a step said that it could not be solved), or refused.</p>\n")
    for subject in groups(rows, "subject"):
        body = []
        for r in subject:
            bad = r["outcome"] in ("stopped", "lost", "not_finite")
            h_omega = [number(r["h_omega_first"]), number(r["h_omega_last"])]
            body.append([r["case"], " – ".join(show(x, "{:.2g}") for x in h_omega) if math.isfinite(h_omega[0]) else "",
                         scheme(r["scheme"]), Cell(r["outcome"], "l bad" if bad else "l"),
                         show(number(r["energy_error"]), "{:.1e}"), percent(number(r["peak_amplitude"])),
                         show(number(r["mean_iterations"])), f"{r['explicit_modes']}/{r['implicit_modes']}",
                         *stepped(r), Cell(r["reason"], "l w")])
        name = subject[0]["subject"]
        page += fill("<h2>{}</h2>\n", SUBJECTS.get(name, name)) + table(
            ["case", "h ω", Cell("scheme", "l"), Cell("outcome", "l"), "energy error", "amplitude", "iterations",
             "explicit/ implicit at the end", *STEPPED, Cell("reason", "l")], body)
    return page + (
        "<h2>Units</h2>\n<p>The same body in other units, step by step beside itself in SI: the largest difference of where "
        "the loaded part is, as a share of its largest displacement; iterations, and in SI; whether the same fallback levels "
        "were used.</p>\n") + table(
        ["case", Cell("units", "l"), Cell("scheme", "l"), "difference", "iterations", "in SI", "fallback levels"],
        [[r["case"], Cell(r["units"], "l"), scheme(r["scheme"]), show(number(r["difference"]), "{:.1e}"),
          r["iterations"], r["iterations_si"], "same" if r["same_levels"] == "1" else "others"]
         for r in read(path.with_name("units.csv"))])


def linear(path, rows, about, plots):
    page = ("<p>Error of linear modal analysis: |q<sub>lin</sub> − q|/|q|, the displacement of the whole body in the norm of "
            "the mass, against the same reduced model with its cubic and quartic terms; so the basis is the same in both. "
            "Deflection: of the loaded group, as a share of the body's length, in the nonlinear answer; after an impulse its "
            "peak.</p>\n<div>")
    for body in groups(read(path.with_name(path.stem + "_curves.csv")), "model"):
        series = []
        for kind, label, colour in (("static", "at rest", "#1769aa"), ("dynamic", "a period after an impulse", "#d2691e")):
            points = []
            for r in body:
                # a swing may come no further although the impulse grows
                if r["kind"] == kind and (not points or 100 * number(r["deflection"]) > points[-1][0]):
                    points.append((100 * number(r["deflection"]), 100 * number(r["error"])))
            series.append((label, colour, f"linespoints pt {7 if kind == 'static' else 8} ps 0.6", points))
        page += plots.add(body[0]["model"], ("deflection, % of the length", "error of linear, %"), (370, 280), series, "xy")
    return page + plots.key(series) + "</div>\n" + table(
        ["model", "r", "5 % at rest", "20 % at rest", "5 % in motion", "20 % in motion", "R(q) [µs]", "imexv step [µs]",
         "linear step [µs]", "nonlinearity costs [µs]"],
        [[r["model"], r["rank"],
          *(show(100 * number(r[key]), "{:.2f} %") for key in ("static_5", "static_20", "dynamic_5", "dynamic_20")),
          show(number(r["force_us"])), show(number(r["step_us"])), show(number(r["linear_step_us"]), "{:.3f}"),
          show(number(r["nonlinear_us"]))] for r in rows])


def cubature_points(row):
    """How many cubature points a model has in place of the polynomial; tables of before have no column of them."""
    return int(row.get("points") or 0)


def tradeoff_table(rows, chosen=None):
    """A table of runs; those that are cheaper than the chosen one say why they are not taken."""
    def errs(row, key):
        return show(100 * number(row[key]), "{:.3g} %")

    def energy(row):
        return f"{cubature_points(row)} points" if cubature_points(row) else f"polynomial, {row['precision']}"

    def note(row):
        if row is chosen:
            return Cell("recommended", "l")
        cheaper = chosen is None or number(row["cost_s_per_s"]) < number(chosen["cost_s_per_s"])
        return Cell(row.get("barred") or "" if cheaper else "", "l")

    return table(
        [Cell("integrator", "l"), "modes", "rank", "energy by", "h [s]", "tolerance", "µs a step", "cost [s/s]",
         "times faster than full", "displacement", "velocity", "energy", "of the basis", "in time", "frequency", "drift",
         Cell("why not", "l")],
        [[scheme(r["integrator"]), r["modes"] if r["modes"] != "0" else "own", r["rank"], energy(r), r["dt_s"],
          r["tolerance"], show(number(r["us_per_step"])), show(number(r["cost_s_per_s"]), "{:.2e}"),
          show(number(r["speedup"]), "{:.0f}"),
          errs(r, "error_displacement") if r["stable"] == "1" else Cell("lost", "bad"),
          *(errs(r, key) for key in ("error_velocity", "error_energy", "basis_error", "time_error")),
          errs(r, "frequency_error") if "frequency_error" in r else "",
          show(number(r["drift"]), "{:.1e}"), note(r)] for r in rows])


def tradeoff(path, rows, about, plots):
    full = about["full"]
    page = ""
    if about.get("model"):
        page += fill("<p>Model {}, under {}.<br><code>{}</code></p>\n", about["model"], " and ".join(about["loads"]),
                     shlex.join(about["command"]))
    law = f", of {full['law']} material" if full.get("law", "stvk") != "stvk" else ""
    page += fill("<p>{}</p>\n", (
        f"{about['time_s']:g} s of the load, {len(rows)} runs. Reference: the full order of the same mesh{law}, "
        f"{full['components']:.0f} components, stepped by the energy-conserving integrator at {full['dt']:g} s; it takes "
        f"{1e-3 * full['us_per_step']:.3g} ms a step, {full['cost_s_per_s']:.3g} s for a second. Its own error in time is about "
        f"{show(100 * (full['error'] if full['error'] is not None else math.nan), '{:.2g}')} %, below which no error here means "
        "anything. Errors are relative, root mean square over the time in the norm of the mass; of the energy the largest. "
        "Cost: processor time for a simulated second."))
    if full.get("mesh_error"):
        page += fill("<p>The mesh itself has one of its first frequencies about {} too high, for its linear tetrahedra lock; "
                     "no error here says so.</p>\n", percent(full["mesh_error"], "{:.2g} %"))
    chosen = about.get("recommended_row")
    taken = rows[chosen] if chosen is not None else None
    if about.get("wanted"):
        page += fill("<h2>Recommended for {}</h2>\n", about["wanted"])
        page += tradeoff_table([taken], taken) if taken is not None else "<p>No setting that was tried.</p>\n"

    # the front as a line, the runs of each integrator as dots, in the order of their cost
    rows = sorted(rows, key=lambda r: number(r["cost_s_per_s"]))
    points = lambda keep: [(number(r["cost_s_per_s"]), number(r["error_displacement"])) for r in rows
                           if r["stable"] == "1" and keep(r)]
    series = [("front", "#111111", "lines", points(lambda r: r["front"] == "1"))]
    series += [(name, colour, curve(name, "points", 0.7),
                points(lambda r: r["integrator"] == name and not cubature_points(r))) for name, colour in COLOURS.items()]
    series += [(f"{name}, cubature points", colour, curve(name, "points", 1.6),
                points(lambda r: r["integrator"] == name and cubature_points(r))) for name, colour in COLOURS.items()]
    page += plots.add("error against cost", ("processor time for a second [s]", "displacement error"), (760, 420), series, "xy")
    return (page + plots.key(series) + "<h2>The front</h2>\n" + tradeoff_table([r for r in rows if r["front"] == "1" or r is taken], taken) +
            "<h2>All runs</h2>\n" + tradeoff_table(rows, taken))


# kind: the page, its title and file (None: that of the table), the command
PAGES = {
    "matrix": (matrix, "The experiments of the thesis", "report.html", "thrum experiments"),
    "long": (long, "The long run", None, "thrum experiments --long"),
    "step_sizes": (matrix, "Step sizes", None, "thrum experiments --step-sizes"),
    "sweep": (sweep, "Time steps", None, "thrum experiments --sweep"),
    "variable": (sweep, "Steps whose length varies", None, "thrum experiments --variable"),
    "work_precision": (work_precision, "Work and precision", None, "thrum experiments --work-precision"),
    "extremes": (extremes, "Extremes", None, "thrum experiments --extremes"),
    "linear": (linear, "Linear against nonlinear", None, "thrum experiments --linear"),
    "tradeoff": (tradeoff, "Speed against accuracy", None, "thrum tradeoff"),
}


def read(path):
    """The rows of a table; none where it is not there."""
    if not path.exists():
        return []
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def lacking(about):
    """The jobs that the tables lack, where they were collected before all were done."""
    missing = about.get("missing_jobs", [])
    return fill("<p class=bad>Not whole: {} jobs are missing: {}.</p>\n", len(missing), ", ".join(missing)) if missing else ""


def main(kind, table_path):
    make, title, name, command = PAGES[kind]
    path = pathlib.Path(table_path)
    with open(path.with_name(path.stem + ".about.json"), encoding="utf-8") as file:
        about = json.load(file)
    plots = Plots()
    body = make(path, read(path), about, plots)

    where = "Thrum {version}, {compiler}, {machine}, BLAS core {blas_core}.".format(**about)
    page = ("<!DOCTYPE html>\n<html lang=en><head><meta charset=utf-8>\n<meta name=viewport content='width=device-width'>\n" +
            fill("<title>{}</title>\n", title) + f"<style>\n{STYLE}\n</style></head><body>\n" + fill("<h1>{}</h1>\n", title) +
            fill("<p class=dim>{} <code>{}</code></p>\n", where, command) + lacking(about) + body + "</body></html>\n")

    # renamed into place, so that a reader never sees half a page
    target = path.with_name(name or path.stem + ".html")
    part = target.with_name(target.name + ".part")
    part.write_text(plots.draw(page), encoding="utf-8")
    os.replace(part, target)


if __name__ == "__main__":
    if len(sys.argv) != 3 or sys.argv[1] not in PAGES:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2])
