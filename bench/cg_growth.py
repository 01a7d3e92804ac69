#!/usr/bin/env python3
"""How many steps conjugate gradients take in thrum-mpi as a mesh gets finer (docs/scale.md).

A block of 2 x 1 x 1 sides, held at one end, of 2 CELLS x CELLS x CELLS cells in six tetrahedra each, on one process. `block`: the
conjugate gradients of thrum-mpi, sixteen columns at once with the grids in single precision; all solves of a precompute with two modes
count, of which it says the number and the steps together. `gamg`: PETSc's own gradients to 1e-12 of the residual; the first SOLVES are
counted one by one, then the precompute is stopped. `none` is the same without the multigrid, as a control. A row is added to the table
for each number of cells, so that large ones can be measured by themselves.

usage: cg_growth.py THRUM_MPI TABLE.csv block CELLS [CELLS ...]
       cg_growth.py THRUM_MPI TABLE.csv gamg|none SOLVES CELLS [CELLS ...]

SPDX-License-Identifier: Apache-2.0
"""
import csv
import json
import os
import pathlib
import re
import resource
import statistics
import subprocess
import sys
import tempfile

COLUMNS = ["cells", "free_components", "preconditioner", "solves", "steps_least", "steps_median", "steps_most", "steps_mean", "peak_mb"]
CONTROL_STEPS = 20000  # that a solve without the multigrid may take; thrum-mpi itself ends it after 250


def peak_mb(process):
    """The most memory that a process has held [2^20 bytes]."""
    status = pathlib.Path(f"/proc/{process}/status").read_text(encoding="ascii")
    return int(re.search(r"VmHWM:\s+(\d+)", status)[1]) / 1024


def precompute(program, cells, modes, *options):
    """The command that makes a model of a block."""
    block = f"beam:{2 * cells}x{cells}x{cells}@1x0.5x0.5"
    return [program, "precompute", block, "--fix", "x<0.001", "--modes", str(modes), "--rank", str(modes), "--solver", "cg", "-q",
            *options]


def measure_block(program, cells):
    """A row of the table for thrum-mpi's own gradients."""
    with tempfile.TemporaryDirectory() as folder:
        command = precompute(program, cells, 2, "--check", "search", "--json", "-o", os.path.join(folder, "model.npz"))
        ran = subprocess.run(command, check=True, capture_output=True, text=True, env={**os.environ, "OPENBLAS_NUM_THREADS": "1"})
    told = json.loads(ran.stdout)
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024  # of the largest so far: cells ascend
    solves, steps = told["solver"]["solves"], told["solver"]["steps"]
    return [cells, told["free_dofs"], "block", f"{solves:.0f}", "", "", "", f"{steps / solves:.2f}", f"{peak:.0f}"]


def measure(program, preconditioner, solves, cells):
    """A row of the table for PETSc's gradients."""
    # flexible gradients take the steps of plain ones, but are PETSc's own, which tell each solve
    options = "-thrum_ksp_converged_reason -thrum_ksp_type " + ("fcg" if preconditioner == "gamg" else "cg")
    if preconditioner == "none":
        options += f" -thrum_pc_type none -thrum_ksp_max_it {CONTROL_STEPS}"
    with tempfile.TemporaryDirectory() as folder:
        # its lines come one by one into a pipe, too
        command = ["stdbuf", "-oL", *precompute(program, cells, 1, "-o", os.path.join(folder, "model.npz"))]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                              env={**os.environ, "PETSC_OPTIONS": options, "OPENBLAS_NUM_THREADS": "1"}) as started:
            steps = []
            for line in started.stdout:
                found = re.search(r"CONVERGED\w* iterations (\d+)", line)
                steps += [int(found[1])] if found else []
                if len(steps) == solves:
                    break
            peak = peak_mb(started.pid)
            started.kill()
    return [cells, 6 * cells * (cells + 1)**2, preconditioner, len(steps), min(steps), statistics.median_low(steps), max(steps),
            f"{statistics.mean(steps):.2f}", f"{peak:.0f}"]


def main(arguments):
    block = len(arguments) > 3 and arguments[2] == "block"
    if not block and (len(arguments) < 5 or arguments[2] not in ("gamg", "none")):
        print(__doc__, file=sys.stderr)
        return 2
    program, table, preconditioner = arguments[0], pathlib.Path(arguments[1]), arguments[2]
    for cells in sorted(map(int, arguments[3 if block else 4:])):
        row = measure_block(program, cells) if block else measure(program, preconditioner, int(arguments[3]), cells)
        new = not table.exists()
        with table.open("a", encoding="ascii", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerows([COLUMNS, row] if new else [row])
        print(*row, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
