#!/usr/bin/env python3
"""The energy account of a box whose chamber is pumped for 3 million steps of `energy`.

A box of 40 x 15 x 15 cm with a cavity along its axis is held at one end. The pressure in the cavity
follows a sine about a mean, slow or near the first frequency of the body, so that the level changes
in each step. Nothing is damped. The energy of the body is to be the work of the pressure, to
rounding of the largest energy. Writes one row a run, in about two minutes; needs nothing but the
program and the standard library.

  pumped_chamber.py PROGRAM TABLE [--steps N]

SPDX-License-Identifier: Apache-2.0
"""

import argparse
import csv
import itertools
import json
import pathlib
import subprocess
import tempfile

CELLS, HOLE, SIDE = (8, 3, 3), ((1, 7), (1, 2), (1, 2)), 0.05
DT = 0.003
PRESSURES = ["sine:3e4,f=0.7", "sine:3e4,f=4.9"]


def write_box(path):
    """An Abaqus file of the box, the walls of its cavity in the set `inside`."""
    numbers, tets = {}, []

    def number(corner):
        return numbers.setdefault(corner, len(numbers) + 1)

    # six tetrahedra a cell: along its axes, in each order
    for cell in itertools.product(*map(range, CELLS)):
        if all(low <= x < high for x, (low, high) in zip(cell, HOLE)):
            continue
        for order in itertools.permutations(range(3)):
            at, tet = list(cell), [number(cell)]
            for axis in order:
                at[axis] += 1
                tet.append(number(tuple(at)))
            odd = order not in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
            tets.append([tet[0], tet[1], tet[3], tet[2]] if odd else tet)

    inside = [n for corner, n in numbers.items() if all(low <= x <= high for x, (low, high) in zip(corner, HOLE))]
    with open(path, "w", encoding="ascii") as file:
        print("*NODE", file=file)
        for corner, n in numbers.items():
            print(n, *(f"{SIDE * x:.9g}" for x in corner), sep=", ", file=file)
        print("*ELEMENT, TYPE=C3D4", file=file)
        for n, tet in enumerate(tets, 1):
            print(n, *tet, sep=", ", file=file)
        print("*NSET, NSET=inside", *inside, sep="\n", file=file)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("table", type=pathlib.Path)
    parser.add_argument("--steps", type=int, default=3000000)
    given = parser.parse_args()
    program = str(given.program.resolve())
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        write_box(pathlib.Path(folder) / "box.inp")
        options = "--young 1e6 --poisson 0.3 --density 1000 --order 1 --modes 4 --rank 8 --actuator air=chamber:inside -o box.npz -q"
        subprocess.run([program, "precompute", "box.inp", "--fix", "x<0.001", *options.split()], cwd=folder, check=True,
                       capture_output=True)
        for pressure in PRESSURES:
            done = subprocess.run(
                [program, "simulate", "box.npz", "-o", "run", "--dt", str(DT), "--time", str(given.steps * DT), "--record-every", "1000",
                 "--actuate", "air=constant:1e4", "--actuate", "air=" + pressure, "--json", "-q"],
                cwd=folder, check=True, capture_output=True, text=True)
            run = json.loads(done.stdout)
            work = run["work"]
            rows.append({"steps": given.steps, "pressure": pressure, "energy_most_j": run["energy_max_j"],
                         "energy_last_j": run["energy_last_j"], "work_j": work["actuators_j"], "balance_j": work["balance_j"],
                         "share": abs(work["balance_j"]) / run["energy_max_j"]})
    with open(given.table, "w", encoding="ascii", newline="") as file:
        table = csv.DictWriter(file, rows[0], lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


if __name__ == "__main__":
    main()
