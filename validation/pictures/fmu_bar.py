#!/usr/bin/env python3
"""Draws a bar as a Functional Mock-up Unit beside its linear model, from the committed results, by gnuplot.

usage: fmu_bar.py OUTPUT_FOLDER

fmu_bar.png    the sideways displacement of its end over time, lying and hanging
SPDX-License-Identifier: Apache-2.0
"""
import pathlib
import sys

from schemes import draw, panel
from tables import rows

CURVES = {"linear_m": ("linear model", "lines lw 1.4 dt (6,4) lc rgb '#b0430f'"),
          "mesh_m": ("unreduced mesh", "lines lw 3.4 lc rgb '#b8bec4'"),
          "unit_m": ("the unit", "lines lw 1.4 lc rgb '#1769aa'")}


def main():
    panels = []
    for case in ("lying", "hanging"):
        motion = [row for row in rows("fmu", "bar.csv") if row["case"] == case]
        curves = [(label, style, [(float(row["time_s"]), float(row[column])) for row in motion])
                  for column, (label, style) in CURVES.items()]
        panels.append(panel(case, ("time, s", "sideways displacement of the end, m"), curves, "set key below\n"))
    draw(pathlib.Path(sys.argv[1]) / "fmu_bar.png", (900, 360), (1, 2), panels)


if __name__ == "__main__":
    main()
