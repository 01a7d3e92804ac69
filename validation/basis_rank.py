#!/usr/bin/env python3
"""What a basis is worth by modes, rank and selection: six models in motion, arches, a column, a plate, a free bar.

usage: validation/basis_rank.py PROGRAM WORK_FOLDER [OUTPUT.csv]

The selections are those of `thrum precompute --selection`: `mass` as versions up to 0.2 had it, and `modes`. Into OUTPUT.csv
(validation/results/basis/rank.csv):

- the six models: the error of the displacement against the full order under the own load and the four tests of the recipe (0.5 s at
  steps of 2 ms);
- arches: the load at the crown at which a clamped cosine arch (length 1, thickness and width 0.02) gives way, over that of 25 modes
  at rank 75, less 1;
- column: the critical load of a steel column over Euler's, less 1;
- plate: the deflection of a clamped square plate that a force at its middle presses, over that of `static --full`, less 1;
- bar: the stretch of a free bar by its spin over that of the closed form rho w^2 L^3 / (24 E), less 1.

WORK_FOLDER keeps the full-order runs.
SPDX-License-Identifier: Apache-2.0
"""
import itertools
import json
import math
import subprocess
import sys

from load_errors import LOADS, errors, write_table
from tables import MODELS

SELECTIONS = ["mass", "modes"]
# modes, and the rank: twice as many, or the usual one
CASES = [(5, 10), (5, 12), (10, 20), (10, 30), (20, 40), (20, 50)]
RISES = [0.03, 0.06, 0.15]
SOFT = ["--order", "2", "--young", "1e6", "--poisson", "0.3", "--density", "1000"]
COLUMN = ["--order", "2", "--young", "2.1e11", "--poisson", "0.28", "--density", "7850", "--fix", "x<1e-9"]
EULER = math.pi**2 * 2.1e11 * 0.1**4 / 12 / (4 * 3**2)
SPIN = 200  # degrees/s
PUSH = -0.5  # N
KNOWN = {}  # what is compared with, found once


def write_block(path, cells, size, shape, groups):
    """A block of cells cut into six, moved by `shape`, as Gmsh 2.2; cells are mirrored, so that the mesh is symmetric."""
    counts = [n + 1 for n in cells]

    def place(i, j, k):
        return (i * counts[1] + j) * counts[2] + k

    flat = [[size[a] * n / cells[a] - (size[a] / 2 if a > 0 else 0) for a, n in enumerate(corner)]
            for corner in itertools.product(*(range(n) for n in counts))]
    points = [shape(*p) for p in flat]
    tets = []
    for cell in itertools.product(*(range(n) for n in cells)):
        for order in itertools.permutations(range(3)):
            corner, path_of = [0, 0, 0], [(0, 0, 0)]
            for axis in order:
                corner[axis] = 1
                path_of.append(tuple(corner))
            tets.append([place(*(n + (1 - c if n % 2 else c) for n, c in zip(cell, at))) + 1 for at in path_of])
    names = list(groups)
    elements = [f"15 2 {g + 2} {g + 2} {v + 1}" for g, name in enumerate(names) for v, p in enumerate(flat) if groups[name](*p)]
    elements += [f"4 2 1 1 {t[0]} {t[1]} {t[2]} {t[3]}" for t in tets]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names) + 1), '3 1 "body"',
             *(f'0 {g + 2} "{name}"' for g, name in enumerate(names)), "$EndPhysicalNames", "$Nodes", str(len(points)),
             *(f"{n + 1} {p[0]:.17g} {p[1]:.17g} {p[2]:.17g}" for n, p in enumerate(points)), "$EndNodes", "$Elements",
             str(len(elements)), *(f"{n + 1} {element}" for n, element in enumerate(elements)), "$EndElements"]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def near(a, b):
    return abs(a - b) < 1e-9


def write_meshes(work):
    for rise in RISES:
        write_block(work / f"arch{rise}.msh", (40, 2, 2), (1, 0.02, 0.02),
                    lambda x, y, z, rise=rise: (x, y, z + rise / 2 * (1 - math.cos(2 * math.pi * x))),
                    {"ends": lambda x, y, z: near(x, 0) or near(x, 1), "load": lambda x, y, z: near(x, 0.5) and near(z, 0.01)})
    write_block(work / "plate.msh", (12, 12, 1), (1, 1, 0.02), lambda x, y, z: (x, y, z),
                {"ends": lambda x, y, z: near(x, 0) or near(x, 1) or near(abs(y), 0.5),
                 "load": lambda x, y, z: near(x, 0.5) and near(y, 0) and near(z, 0.01)})


def run(work, *command):
    done = subprocess.run(list(map(str, command)), cwd=work, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 3):
        raise SystemExit(f"{' '.join(map(str, command))}: {done.stderr}")
    return json.loads(done.stdout.strip().splitlines()[-1])


def make(program, work, mesh, selection, modes, rank, options):
    run(work, program, "precompute", mesh, "--selection", selection, "--modes", modes, "--rank", rank, "-o", "body.npz", "-q", "--json",
        *options)


def gives_way(program, work, mesh, selection, modes, rank, options, load):
    """The first factor of the load at which the body gives way."""
    make(program, work, mesh, selection, modes, rank, options)
    return run(work, program, "static", "body.npz", "--json", "--load", load)["critical_factor"]


def arch_errors(program, work, rise, case):
    """Of an arch, of the case (selection, modes, rank)."""
    options, load = [*SOFT, "--fix", "ends"], f"constant:0,0,{-5 * rise}@load"
    mesh = f"arch{rise}.msh"
    if (mesh, "known") not in KNOWN:
        KNOWN[mesh, "known"] = gives_way(program, work, mesh, "modes", 25, 75, options, load)
    return gives_way(program, work, mesh, *case, options, load) / KNOWN[mesh, "known"] - 1


def column_error(program, work, case):
    load = 980665
    return gives_way(program, work, "beam:30x2x2@3x0.1x0.1", *case, COLUMN, f"constant:-{load},0,0@right") * load / EULER - 1


def plate_error(program, work, case):
    options, push = [*SOFT, "--fix", "ends"], ["--load", f"constant:0,0,{PUSH}@load"]
    if "plate" not in KNOWN:
        whole = run(work, program, "static", "plate.msh", "--full", "--json", *options, *push)
        KNOWN["plate"] = whole["displacements"][0]["mean_m"][2]
    make(program, work, "plate.msh", *case, options)
    return run(work, program, "static", "body.npz", "--json", *push)["displacements"][0]["mean_m"][2] / KNOWN["plate"] - 1


def bar_error(program, work, case):
    make(program, work, "beam:20x2x2@1x0.05x0.05", *case, SOFT)
    spun = run(work, program, "simulate", "body.npz", "-o", "spun", "--json", "-q", "--spin", f"0,0,{SPIN}", "--damping", 400, "--time", 1,
               "--dt", 0.002)
    return spun["peak_displacement_m"] / (1000 * math.radians(SPIN)**2 / (24 * 1e6)) - 1


def rows(program, work):
    write_meshes(work)
    bodies = [(f"arch of rise {rise}", lambda case, rise=rise: arch_errors(program, work, rise, case)) for rise in RISES]
    bodies += [(name, lambda case, error=error: error(program, work, case))
               for name, error in [("column", column_error), ("plate", plate_error), ("bar", bar_error)]]
    for name, error in bodies:
        for selection in SELECTIONS:
            for modes, rank in CASES:
                yield [name, selection, modes, rank, f"{error((selection, modes, rank)):.4g}", "", "", "", ""]
    for model in MODELS:
        for selection in SELECTIONS:
            for modes, rank in CASES:
                made, found = errors(program, work, model, rank, ["--selection", selection], modes=modes)
                yield [model, selection, modes, made, *found]


if __name__ == "__main__":
    sys.exit(write_table(__doc__, "basis", ["body", "selection", "modes", "rank", *LOADS], rows, "rank.csv"))
