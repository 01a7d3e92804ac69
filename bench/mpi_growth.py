#!/usr/bin/env python3
"""Memory and processor time of thrum-mpi as a mesh gets finer (docs/scale.md).

A block of 2 x 1 x 1 sides, held at one end, of 2 CELLS x CELLS x CELLS cells in six tetrahedra each, 20 modes and rank 30: each number
of cells adds a row to the table. Times of stages are those of process 0, processor time, and `cpu` is that of all processes together
from their start to their end; `peak_mb` is the most that one of them has held, `all_mb` the same for all by what they held at once, seen
ten times a second.

usage: mpi_growth.py run MPIRUN THRUM_MPI TABLE.csv SOLVER PROCESSES CELLS [CELLS ...]
       mpi_growth.py laws TABLE.csv SOLVER PROCESSES COMPONENTS [COMPONENTS ...]

The second prints the laws that the rows follow, and what they say for other numbers of components: powers by least squares of
logarithms, and for memory, which the libraries have a part of, straight lines by least squares, where it prints bytes a component.

SPDX-License-Identifier: Apache-2.0
"""
import csv
import json
import math
import os
import pathlib
import re
import resource
import subprocess
import sys
import tempfile
import time

STAGES = ["assemble", "factor", "modes", "derivatives", "basis", "polynomial"]
COLUMNS = ["cells", "free_components", "processes", "solver", *STAGES, "cpu", "wall", "peak_mb", "all_mb", "solves", "steps"]
BYTES = 2**20


def held(parent):
    """What the processes below this one hold now [2^20 bytes]."""
    total, left = 0, [parent]
    while left:
        process = left.pop()
        try:
            status = pathlib.Path(f"/proc/{process}/status").read_text(encoding="ascii")
            for task in pathlib.Path(f"/proc/{process}/task").iterdir():
                left += [int(child) for child in (task / "children").read_text(encoding="ascii").split()]
        except (FileNotFoundError, ProcessLookupError):
            continue
        found = re.search(r"VmRSS:\s+(\d+)", status)
        total += int(found[1]) / 1024 if found else 0
    return total


def measure(mpirun, program, solver, processes, cells):
    """A row of the table."""
    block = f"beam:{2 * cells}x{cells}x{cells}@2x1x1"
    with tempfile.TemporaryDirectory() as folder:
        command = [mpirun, "--oversubscribe", "-n", str(processes), program, "precompute", block, "--fix", "x<0.001", "--modes", "20",
                   "--rank", "30", "--solver", solver, "--check", "search", "--json", "-q", "-o", os.path.join(folder, "model.npz")]
        before, began, most = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic(), 0
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env={**os.environ, "OPENBLAS_NUM_THREADS": "1"}) as started:
            while started.poll() is None:
                most = max(most, held(started.pid))
                time.sleep(0.1)
            told = json.loads(started.stdout.read())
        wall, after = time.monotonic() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    stages = told["stages"]
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return [cells, told["free_dofs"], processes, told["solver"]["name"], *(f"{stages[name]['cpu_seconds']:.2f}" for name in STAGES),
            f"{cpu:.1f}", f"{wall:.1f}", f"{after.ru_maxrss / 1024:.0f}", f"{most:.0f}", f"{told['solver'].get('solves', 0):.0f}",
            f"{told['solver'].get('steps', 0):.0f}"]


def run(mpirun, program, table, solver, processes, sizes):
    table = pathlib.Path(table)
    for cells in sizes:
        row = measure(mpirun, program, solver, int(processes), int(cells))
        new = not table.exists()
        with table.open("a", encoding="ascii", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([COLUMNS, row] if new else [row])
        print(*row, flush=True)


def fit(points):
    """Factor and exponent of value = factor size^exponent."""
    logs = [(math.log(size), math.log(value)) for size, value in points if value > 0]
    mean = [sum(column) / len(logs) for column in zip(*logs)]
    slope = sum((x - mean[0]) * (y - mean[1]) for x, y in logs) / sum((x - mean[0])**2 for x, _ in logs)
    return math.exp(mean[1] - slope * mean[0]), slope


def fit_line(points):
    """Value at size 0, and slope."""
    mean = [sum(column) / len(points) for column in zip(*points)]
    slope = sum((x - mean[0]) * (y - mean[1]) for x, y in points) / sum((x - mean[0])**2 for x, _ in points)
    return mean[1] - slope * mean[0], slope


def laws(table, solver, processes, sizes):
    with open(table, encoding="ascii") as file:
        rows = [row for row in csv.DictReader(file) if row["solver"] == solver and row["processes"] == processes]
    print("quantity", "exponent_or_bytes", *sizes)
    for name in ["peak_mb", "all_mb"]:
        start, slope = fit_line([(float(row["free_components"]), float(row[name])) for row in rows])
        print(name, f"{slope * BYTES:.0f}", *(f"{start + slope * float(size):.4g}" for size in sizes))
    for name in [*STAGES, "cpu", "steps"]:
        factor, exponent = fit([(float(row["free_components"]), float(row[name])) for row in rows])
        print(name, f"{exponent:.2f}", *(f"{factor * float(size)**exponent:.4g}" for size in sizes))


def main(arguments):
    if len(arguments) > 6 and arguments[0] == "run":
        run(*arguments[1:6], arguments[6:])
    elif len(arguments) > 4 and arguments[0] == "laws":
        laws(*arguments[1:4], arguments[4:])
    else:
        print(__doc__, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
