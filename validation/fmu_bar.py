#!/usr/bin/env python3
"""A flexible bar as a Functional Mock-up Unit, beside its linear model and its unreduced mesh, for `results/fmu`.

A rubber bar of 1 m is held at one end and pulled sideways at the other, until it bends by a fifth of its length: once lying,
and once hanging, where its weight straightens it. The unit steps inside the importer of the tests. The linear model is each
mode by itself, solved exactly, which is what a body is in programs that take frequencies and shapes alone.

usage: fmu_bar.py PROGRAM OUTPUT_FOLDER

bar.csv      the sideways displacement of the end over time
errors.csv   the largest distance of the end from that of the mesh, over the largest displacement of the mesh
SPDX-License-Identifier: Apache-2.0
"""
import csv
import math
import os
import pathlib
import struct
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "tests" / "python"))
from fmu_importer import OK, Fmu  # noqa: E402

BAR = ["beam:16x1x1@1x0.05x0.05", "--fix", "x<0.001", "--modes", "10", "--rank", "30"]
STEP, TIME = 0.01, 6.0
CASES = {"lying": (-0.8, 0.0), "hanging": (-1.7, 9.81)}  # force [N], gravity along the bar [m/s^2]
AXES = [f"tip.displacement.{axis}" for axis in "xyz"]


def mesh(program, model, folder, force, gravity):
    """The displacement of the end by the unreduced mesh, a row each step."""
    loads = ["--load", f"square:0,0,{force}@tip,until={2 * TIME}"] + (["--load", f"gravity:{gravity},0,0"] if gravity else [])
    subprocess.run([program, "simulate", model, "--full", "--integrator", "energy", "--dt", str(STEP), "--time", str(TIME), *loads,
                    "--probe", "tip", "-o", folder, "-q"], check=True, stdout=subprocess.DEVNULL,
                   env={**os.environ, "THRUM_GNUPLOT": ""})
    with open(pathlib.Path(folder, "probes.csv"), encoding="utf-8", newline="") as file:
        return [[float(x) for x in row[-3:]] for row in list(csv.reader(file))[1:]]


def unit(fmu, steps, force, gravity):
    """The same by the unit."""
    one = fmu.instance()
    one.begin(step=STEP, tip_force_z=force, acceleration_x=-gravity)
    rows = [one.get(*AXES)]
    for n in range(steps):
        if one.step(n * STEP, STEP) != OK:
            raise SystemExit(one.said[-1])
        rows.append(one.get(*AXES))
    one.free()
    return rows


def linear(fmu, steps, force, gravity):
    """The same by the modes and their loads alone, from the numbers in the unit."""
    data = pathlib.Path(fmu.folder, "resources", "body.bin").read_bytes()
    rank, = struct.unpack_from("i", data, 48)
    omega2, mass, *places = (struct.unpack_from(f"{count}d", data, 56 + 8 * at) for count, at in
                             ((rank, 4), (rank, 4 + rank), *((rank, 4 + (4 + axis) * rank) for axis in range(3))))
    load = [force * places[2][i] + gravity * mass[i] for i in range(rank)]
    coordinates = [[load[i] / omega2[i] * (1 - math.cos(math.sqrt(omega2[i]) * n * STEP)) for i in range(rank)]
                   for n in range(steps + 1)]
    return [[sum(row[i] * q[i] for i in range(rank)) for row in places] for q in coordinates]


def main():
    program, output = os.path.abspath(sys.argv[1]), pathlib.Path(sys.argv[2])
    output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as work, open(output / "bar.csv", "w", encoding="utf-8") as motion, \
            open(output / "errors.csv", "w", encoding="utf-8") as errors:
        model, path = f"{work}/bar.npz", f"{work}/bar.fmu"
        subprocess.run([program, "precompute", *BAR, "-o", model, "-q"], check=True, stdout=subprocess.DEVNULL)
        subprocess.run([program, "export", model, "--fmu", path, "--at", "tip"], check=True, stdout=subprocess.DEVNULL)
        fmu = Fmu(path, f"{work}/bar")
        print("case,time_s,mesh_m,unit_m,linear_m", file=motion)
        print("case,force_N,largest_m,unit_error,linear_error", file=errors)
        for case, (force, gravity) in CASES.items():
            full = mesh(program, model, f"{work}/{case}", force, gravity)
            steps = len(full) - 1
            others = [made(fmu, steps, force, gravity) for made in (unit, linear)]
            for n, rows in enumerate(zip(full, *others)):
                print(f"{case},{n * STEP:.2f}," + ",".join(f"{row[2]:.7g}" for row in rows), file=motion)
            largest = max(math.hypot(*row) for row in full)
            wrong = [max(map(math.dist, full, other)) / largest for other in others]
            print(f"{case},{force:g},{largest:.6g},{wrong[0]:.4g},{wrong[1]:.4g}", file=errors)


if __name__ == "__main__":
    main()
