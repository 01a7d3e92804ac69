#!/usr/bin/env python3
"""Draws what exact frequencies cost with linear and with ten-node tetrahedra, from the committed results, by gnuplot.

usage: orders.py OUTPUT_FOLDER

order_cost.png    the largest error of the first five frequencies against processor time, beam and horse
SPDX-License-Identifier: Apache-2.0
"""
import pathlib
import sys

from schemes import draw, panel
from tables import rows

NAMES = {"1": "linear tetrahedra", "2": "ten nodes"}
STYLES = {"1": "linespoints pt 7 ps 0.9 lw 1.6 lc rgb '#d2691e'", "2": "linespoints pt 5 ps 0.9 lw 1.6 lc rgb '#1769aa'"}


def main():
    panels = []
    for model in ("beam", "horse"):
        runs = [r for r in rows("models", "errors.csv") if r["model"] == model and float(r["seconds"]) > 0]
        curves = [(NAMES[order], STYLES[order], [(float(r["seconds"]), 100 * float(r["largest"])) for r in runs if r["order"] == order])
                  for order in ("1", "2")]
        panels.append(panel(model, ("processor time of thrum precompute, s", "largest error of the first five frequencies, %"),
                            [*curves, ("1 %", "lines dt 2 lw 1 lc rgb '#777777'", [(0.01, 1), (100, 1)])],
                            "set logscale xy\nset xrange [0.01:100]\nset format x '%g'\n"))
    draw(pathlib.Path(sys.argv[1]) / "order_cost.png", (900, 380), (1, 2), panels)


if __name__ == "__main__":
    main()
