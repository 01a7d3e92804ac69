#!/usr/bin/env python3
"""thrum-mpi in a build with sanitizers, or under valgrind, by two processes and more.

Each command must end as it does without them, and nothing may be found but what Open MPI keeps until
its end: address.supp and valgrind.supp have a reason for each line.

usage: sanitize.py address MPIRUN THRUM_MPI
       sanitize.py valgrind MPIRUN THRUM_MPI VALGRIND

SPDX-License-Identifier: Apache-2.0
"""
import pathlib
import sys
import tempfile
import time

from test_mpi import HELD, SMALL, run

HERE = pathlib.Path(__file__).resolve().parent
FOUND = 77  # exit code of a process in which something was found
MODEL = ["-o", "model.npz", "-q"]
BLOCK = ["beam:6x2x2@1x0.2x0.15", *HELD, "--full", "-q"]
COMMANDS = {  # processes, arguments, exit code, and options of PETSc where there are some
    "a factor": (2, ["precompute", *SMALL, *HELD, *MODEL], 0),
    "a free body": (2, ["precompute", *SMALL, *MODEL], 0),
    "ten-node tetrahedra": (2, ["precompute", *SMALL, *HELD, "--order", "2", *MODEL], 0),
    "lumped mass, condensed": (2, ["precompute", *SMALL, *HELD, "--mass", "lumped", "--condense", *MODEL], 0),
    "conjugate gradients": (2, ["precompute", *SMALL, *HELD, "--solver", "cg", *MODEL], 0),
    "a free body by conjugate gradients": (2, ["precompute", *SMALL, "--solver", "cg", *MODEL], 0),
    "ten-node tetrahedra by conjugate gradients": (4, ["precompute", *SMALL, *HELD, "--order", "2", "--solver", "cg", *MODEL], 0),
    "several grids": (3, ["precompute", "beam:12x6x6@1x0.5x0.5,split=6", "--order", "1", *HELD, "--modes", "4", "--rank", "8", "--solver", "cg", "--check",
                          "search", *MODEL], 0),
    "gradients that do not converge": (2, ["precompute", "beam:20x2x2@100x0.1x0.1,split=6", "--order", "1", *HELD, "--modes", "2", "--rank", "3", "--solver",
                                           "cg", *MODEL], 1),
    "columns that PETSc solves": (2, ["precompute", "beam:3x1x1@1x0.2x0.15,split=6", "--order", "1", *HELD, "--modes", "2", "--rank", "4", "--solver", "cg",
                                      *MODEL], 0, "-thrum_pc_type jacobi"),
    "more processes than parts, by conjugate gradients": (4, ["precompute", "beam:1x1x1@1x1x1,split=6", "--order", "1", *HELD, "--modes", "2", "--rank", "3",
                                                              "--solver", "cg", *MODEL], 0),
    "more processes than parts": (4, ["precompute", "beam:1x1x1@1x1x1,split=6", "--order", "1", *HELD, "--modes", "2", "--rank", "3", *MODEL], 0),
    "a dry run": (2, ["precompute", *SMALL, *HELD, "--dry-run"], 0),
    "no such file": (2, ["precompute", "no_such_file.msh", *MODEL], 1),
    "a rank that is too large": (2, ["precompute", *SMALL, *HELD, "--rank", "28", *MODEL], 1),
    "no room for a solver": (2, ["precompute", "beam:24x8x8@1x0.25x0.25,split=6", "--order", "1", *HELD, "--modes", "1", "--rank", "1",
                                 "--memory", "60", *MODEL], 1),
    "statics": (2, ["static", *BLOCK, "--load", "constant:0,0,-5@tip"], 0),
    "statics past an indefinite tangent": (2, ["static", *BLOCK, "--move=-0.3,0,0.1@tip", "--law", "neo-hookean"], 0),
    "steps with two factors": (2, ["simulate", *BLOCK, "--integrator", "newmark", "--load", "impulse:0,0,-20@tip",
                                   "--time", "0.006", "-o", "run"], 0),
}


def address(_rest):
    """What starts a process of the build with sanitizers."""
    options = f"exitcode={FOUND}:fast_unwind_on_malloc=0"
    return ["env", f"ASAN_OPTIONS={options}", f"LSAN_OPTIONS=suppressions={HERE / 'address.supp'}:print_suppressions=0"]


def valgrind(rest):
    """What starts a process under valgrind, which keeps the names of modules that are unloaded."""
    return [rest[0], "-q", f"--suppressions={HERE / 'valgrind.supp'}", f"--error-exitcode={FOUND}", "--keep-debuginfo=yes",
            "--num-callers=60", "--leak-check=full", "--show-leak-kinds=definite", "--errors-for-leak-kinds=definite"]


def check(prefix, mpirun, program, case):
    """Empty, or what was found."""
    count, arguments, code, *petsc = case
    with tempfile.TemporaryDirectory() as folder:
        command = [mpirun, "--oversubscribe", "--wdir", folder, "-n", str(count), *prefix, program, *arguments]
        result = run(command, {"OPENBLAS_NUM_THREADS": "1", **{"PETSC_OPTIONS": options for options in petsc}})
    found = [word for word in ("Sanitizer", "runtime error", "== ") if word in result.stderr]
    if result.returncode == code and not found:
        return ""
    return f"exit {result.returncode}, not {code}\n{result.stderr[-6000:]}"


def main(arguments):
    if len(arguments) < 3 or arguments[0] not in ("address", "valgrind"):
        print(__doc__, file=sys.stderr)
        return 2
    tool, mpirun, program, *rest = arguments
    prefix, failed = {"address": address, "valgrind": valgrind}[tool](rest), 0
    for name, case in COMMANDS.items():
        began = time.monotonic()
        words = check(prefix, mpirun, str(pathlib.Path(program).resolve()), case)
        failed += words != ""
        print(f"{name}, {case[0]} processes: {words or 'nothing found'} ({time.monotonic() - began:.0f} s)", flush=True)
    print(f"{len(COMMANDS) - failed} of {len(COMMANDS)} commands clean ({tool})")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
