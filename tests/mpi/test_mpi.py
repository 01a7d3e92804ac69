#!/usr/bin/env python3
"""Models and equilibria that several processes make are those that one makes.

Each case makes a model by thrum precompute and by thrum-mpi, and compares frequencies, polynomial,
basis and every other array. Refusals and killed processes leave no model, or the earlier one.

usage: test_mpi.py MPIRUN THRUM THRUM_MPI [CASE ...]

SPDX-License-Identifier: Apache-2.0
"""
import json
import os
import signal
import subprocess
import sys
import tempfile
import time

import numpy

FREQUENCIES = 1e-9   # relative
POLYNOMIAL = 1e-8    # of its norm
ANGLES = 1e-6        # of the subspaces, as sines
STATICS = 1e-8       # of the largest displacement
STEPS = 1e-9         # of the norms of q and of its momenta at the end of a run
SECONDS = 900        # that any run may take

BEAM = ["beam", "--order", "1"]  # without middle nodes, so a sixth of the vertices
SMALL = ["beam:6x2x2@1x0.2x0.15", "--modes", "6", "--rank", "10"]
HELD = ["--fix", "x<0.001"]
CASES = {
    "beam, 1 process": (1, BEAM),
    "beam, 2 processes": (2, BEAM),
    "horse, 2 processes": (2, ["horse"]),
    "heart, 2 processes": (2, ["heart"]),
    "beam, 4 processes": (4, BEAM),
    "a free body, 2 processes": (2, SMALL),
    "ten-node tetrahedra, 2 processes": (2, SMALL + HELD + ["--order", "2"]),
    "lumped mass, condensed, 4 processes": (4, SMALL + HELD + ["--mass", "lumped", "--condense"]),
    "conjugate gradients, 2 processes": (2, SMALL + HELD + ["--solver", "cg"]),
    "conjugate gradients, 1 process": (1, SMALL + HELD + ["--solver", "cg"]),
    "a free body by conjugate gradients": (2, SMALL + ["--solver", "cg"]),
    "ten-node tetrahedra by conjugate gradients": (4, SMALL + HELD + ["--order", "2", "--solver", "cg"]),
    "horse by conjugate gradients": (2, ["horse", "--solver", "cg"]),
    "more processes than parts, by conjugate gradients": (4, ["beam:1x1x1@1x1x1", "--modes", "2", "--rank", "3", "--solver", "cg"] + HELD),
    "more processes than parts": (4, ["beam:1x1x1@1x1x1", "--modes", "2", "--rank", "3"] + HELD),
}


class Programs:
    def __init__(self, mpirun, thrum, thrum_mpi):
        self.mpirun, self.thrum, self.thrum_mpi = mpirun, thrum, thrum_mpi

    def alone(self, arguments):
        return run([self.thrum, *arguments])

    def command(self, count, arguments):
        return [self.mpirun, "--oversubscribe", "-n", str(count), self.thrum_mpi, *arguments]

    def together(self, count, arguments, **variables):
        return run(self.command(count, arguments), variables)


def run(command, variables=None):
    return subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False,
                          env={**os.environ, **(variables or {})})


def demand(condition, text):
    if not condition:
        raise AssertionError(text)


def read(path):
    with numpy.load(path) as file:
        arrays = {name: file[name] for name in file.files}
    return arrays, json.loads(bytes(arrays.pop("meta")))


def distance(found, wanted, least=1e-300):
    """Of two arrays, relative to the norm of the second, or to `least` where that is larger."""
    return numpy.linalg.norm(found - wanted) / max(numpy.linalg.norm(wanted), least)


def angle(found, wanted, rank):
    """The sine of the largest angle between the spans of two bases."""
    q, p = (numpy.linalg.qr(basis.reshape(-1, rank))[0] for basis in (found, wanted))
    return numpy.linalg.norm(q - p @ (p.T @ q), 2)


def compare(found_path, wanted_path):
    (found, meta), (wanted, wanted_meta) = read(found_path), read(wanted_path)
    demand(set(found) == set(wanted), f"other arrays: {sorted(set(found) ^ set(wanted))}")
    hertz = [numpy.array(m["frequencies_hz"]) for m in (meta, wanted_meta)]
    worst = numpy.max(numpy.abs(hertz[0] / hertz[1] - 1))
    demand(worst < FREQUENCIES, f"a frequency is off by {worst:.2g}")
    demand(meta["mode_check"]["complete"], "modes are missing")

    # the basis by its span and by its columns, whose signs and order are a convention of their own
    rank = wanted["omega2"].size
    sine = angle(found["basis"], wanted["basis"], rank)
    demand(sine < ANGLES, f"the bases span other spaces: {sine:.2g}")
    for name, array in wanted.items():
        demand(found[name].shape == array.shape, f"{name} has another shape")
        bound = POLYNOMIAL if array.dtype.kind == "f" else 0
        # a free body's is zero but for rounding: U is orthogonal to the rigid modes
        least = meta["mass_kg"]**0.5 if name == "axis_mass" else 1e-300
        off = distance(found[name].astype(float), array.astype(float), least)
        demand(off <= bound, f"{name} is off by {off:.2g}")
    return worst, max(distance(found[n], wanted[n]) for n in found if n.endswith(("c3", "c4"))), sine


def check_case(programs, folder, count, arguments):
    alone, together = (os.path.join(folder, name) for name in ("alone.npz", "together.npz"))
    plain = [a for i, a in enumerate(arguments) if "--solver" not in arguments[max(i - 1, 0):i + 1]]
    result = programs.alone(["precompute", *plain, "-o", alone, "-q"])
    demand(result.returncode == 0, f"thrum: {result.stderr}")
    result = programs.together(count, ["precompute", *arguments, "-o", together, "-q"])
    demand(result.returncode == 0, f"thrum-mpi: exit {result.returncode}: {result.stderr}")
    demand(not [n for n in os.listdir(folder) if "npz" in n and n not in ("alone.npz", "together.npz")],
           "something else was written")
    return "frequencies %.1g, polynomial %.1g, angle %.1g" % compare(together, alone)


def check_refusals(programs, folder):
    """What cannot be done says so in one line, and an earlier model stays."""
    model = os.path.join(folder, "model.npz")
    with open(model, "w", encoding="utf-8") as file:
        file.write("an earlier model")
    for arguments, code, words in (
            (["precompute", "no_such_file.msh", "-o", model], 1, "no_such_file.msh"),
            (["precompute", *SMALL, "-o", model, "--modes", "90000"], 1, "modes"),
            (["precompute", *SMALL, "-o", model, "--rank", "28"], 1, "rank"),
            (["precompute", *SMALL, "-o", model, "--cubature"], 1, "--cubature"),
            (["precompute", *SMALL, "--no-such-option"], 2, "--no-such-option"),
            (["info"], 2, "precompute")):
        result = programs.together(2, arguments)
        demand(result.returncode == code, f"{arguments}: exit {result.returncode}, not {code}")
        demand(words in result.stderr, f"{arguments}: {result.stderr}")
    with open(model, encoding="utf-8") as file:
        demand(file.read() == "an earlier model", "a refusal changed the model")
    return "6 refusals"


def check_one_process(programs, folder):
    """thrum goes on as the thrum-mpi beside it, also as a job that mpirun started, for cg or where a factor has no room."""
    alone, other = (os.path.join(folder, name) for name in ("alone.npz", "other.npz"))
    made = programs.alone(["precompute", *SMALL, *HELD, "-o", alone, "--json"])
    demand(made.returncode == 0, made.stderr)
    jobs = [programs.mpirun, "--oversubscribe", "-n", "2", programs.thrum]
    for command, name in (([programs.thrum], "cg"), (jobs, "cg")):
        result = run([*command, "precompute", *SMALL, *HELD, "-o", other, "--solver", name, "--json", "-q"])
        demand(result.returncode == 0, f"{command}: exit {result.returncode}: {result.stderr}")
        told = [json.loads(line)["solver"]["name"] for line in result.stdout.splitlines()]
        demand(told == [name] * (2 if command is jobs else 1), f"{told}")
        worst = compare(other, alone)

    # where there is no room for anything, thrum-mpi refuses as well
    result = programs.alone(["precompute", *SMALL, *HELD, "-o", other, "--memory", "2"])
    words = result.stderr.splitlines()
    demand(result.returncode == 1 and len(words) == 2, result.stderr)
    demand("thrum-mpi goes on" in words[0] and "are left" in words[1], result.stderr)
    return "frequencies %.1g, polynomial %.1g, angle %.1g" % worst


def check_memory(programs, folder):
    """A solver that does not fit is refused before it is made, and `auto` then tries the other."""
    model = os.path.join(folder, "model.npz")
    block = ["precompute", "beam:24x8x8@1x0.25x0.25,split=6", "--order", "1", *HELD, "--modes", "1", "--rank", "1", "-o", model]
    result = programs.together(2, [*block, "--memory", "4000", "--json"])
    demand(result.returncode == 0, result.stderr)
    use = json.loads(result.stdout)["solver"]
    demand(use["name"] == "factor" and use["cg_mb"] < use["factor_mb"] < use["room_mb"], f"{use}")
    os.remove(model)

    # what a process holds without a solver, and half of what each solver takes on top
    held = 4000 - use["room_mb"]
    for solver, words, room in (("factor", "--solver cg", 0.5 * use["factor_mb"]),
                                ("auto", "the multigrid would take", 0.2 * use["cg_mb"])):
        result = programs.together(2, [*block, "--memory", f"{held + room:.0f}", "--solver", solver])
        demand(result.returncode == 1, f"{solver}: exit {result.returncode}: {result.stderr}")
        demand(words in result.stderr and "use about" in result.stderr, result.stderr)
    demand(not os.listdir(folder), "a model was written")
    return f"a factor of {use['factor_mb']:.0f} MB, a multigrid of {use['cg_mb']:.0f} MB"


def check_dry_run(programs, folder):
    """A dry run says for both solvers what the run itself says, and makes nothing."""
    model = os.path.join(folder, "model.npz")
    made = json.loads(programs.together(2, ["precompute", *SMALL, *HELD, "-o", model, "--json", "-q"]).stdout)
    os.remove(model)
    result = programs.together(2, ["precompute", *SMALL, *HELD, "--dry-run", "--json"])
    demand(result.returncode == 0, f"exit {result.returncode}: {result.stderr}")
    told, use = json.loads(result.stdout), made["solver"]
    demand(told["processes"] == 2 and told["solver"] == "factor" and told["status"] == "fits", result.stdout)
    demand(told["free_dofs"] == made["free_dofs"], result.stdout)

    # PT-Scotch does not always cut a mesh into the same parts: two runs of this beam differ by up to 5 %
    for name, solver in told["solvers"].items():
        demand(abs(solver["more_mb"] / use[f"{name}_mb"] - 1) < 0.1, f"{name}: {solver} beside {use}")
        demand(solver["seconds"] > 0 and solver["memory_mb"] > solver["more_mb"], f"{name}: {solver}")

    # with half of the room that the factor of a larger block takes
    block = ["precompute", "beam:16x6x6@1x0.3x0.3,split=6", "--order", "1", *HELD, "--dry-run", "--solver", "factor"]
    factor = json.loads(programs.together(2, [*block, "--json"]).stdout)["solvers"]["factor"]
    limit = factor["memory_mb"] - 0.5 * factor["more_mb"]
    result = programs.together(2, [*block, "--memory", f"{limit:.0f}"])
    demand(result.returncode == 3, f"exit {result.returncode}: {result.stdout}{result.stderr}")
    demand("does NOT fit, but would into about" in result.stdout and "taken             the factor" in result.stdout,
           result.stdout)
    demand(not os.listdir(folder), "something was written")
    return f"{told['solvers']['factor']['seconds']:.2g} s by a factor, {told['solvers']['cg']['seconds']:.2g} s by cg"


def check_statics(programs, folder):
    """static --full comes to rest where one process does, also past tangents that are not positive definite."""
    rubber = ["--young", "1e6", "--poisson", "0.4", "--density", "1000"]
    block = ["beam:8x2x2@1x0.2x0.2", *HELD, *rubber]
    worst, counts = 0, []
    for count, arguments in ((2, ["beam", "--load", "constant:0,0,-30@tip"]), (2, ["horse", "--load", "constant:0,0,-30@load"]),
                             (4, [*block, "--load", "constant:-60,0,0.5@tip"]),
                             (2, [*block, "--move", "-0.3,0,0.1@tip", "--law", "neo-hookean"])):
        fields = [os.path.join(folder, name) for name in ("alone.npy", "together.npy")]
        command = ["static", *arguments, "--full", "--json", "-q", "--displacements"]
        results = [programs.alone([*command, fields[0]]), programs.together(count, [*command, fields[1]])]
        demand([r.returncode for r in results] == [0, 0], f"{arguments}: {results[0].stderr} {results[1].stderr}")
        told = [json.loads(r.stdout) for r in results]
        demand(all(told[0][key] == told[1][key] for key in ("status", "load_steps", "stable")), f"{arguments}: {told}")
        one, other = (numpy.load(field) for field in fields)
        worst = max(worst, numpy.abs(other - one).max() / numpy.abs(one).max())
        counts.append(told[1]["factorisations"] - told[1]["iterations"])
    demand(worst < STATICS, f"displacements differ by {worst:.1e}")
    demand(counts[-1] > 0, "no tangent was indefinite")

    # a model needs no other process
    result = programs.together(2, ["static", "beam", "--load", "gravity:0,0,-9"])
    demand(result.returncode == 2 and "add --full" in result.stderr, result.stderr)
    return f"displacements {worst:.1e}"


def check_steps(programs, folder):
    """simulate --full comes to where one process does, with the same files, by one factor and by two at a time."""
    block, worst = ["beam:6x2x2@1x0.2x0.15", *HELD, "--load", "impulse:0,0,-20@tip"], 0
    for count, arguments in ((2, ["beam", "--load", "impulse:0,0,-100@tip"]),
                             (2, ["horse", "--integrator", "newmark", "--load", "impulse:0,0,-10@load"]),
                             (1, [*block, "--integrator", "midpoint"]), (4, [*block, "--integrator", "newmark"])):
        runs = [os.path.join(folder, name) for name in ("alone", "together")]
        command = ["simulate", *arguments, "--full", "--time", "0.003", "--json", "-q", "-o"]
        results = [programs.alone([*command, runs[0]]), programs.together(count, [*command, runs[1]])]
        demand([r.returncode for r in results] == [0, 0], f"{arguments}: {results[0].stderr} {results[1].stderr}")
        told = [json.loads(r.stdout) for r in results]
        demand(told[0]["files"] == told[1]["files"] and told[0].keys() == told[1].keys(), f"{arguments}: {told}")
        one, other = (numpy.load(os.path.join(run, "end.npy")) for run in runs)
        worst = max(worst, *(distance(other[n], one[n]) for n in range(2)))
    demand(worst < STEPS, f"the ends differ by {worst:.1e}")
    result = programs.together(2, ["simulate", "beam", "-o", runs[0]])
    demand(result.returncode == 2 and "add --full" in result.stderr, result.stderr)
    return f"ends {worst:.1e}"


def check_growth(programs, folder):
    """The steps of a solve hardly grow with the mesh, and the solves of blocks are those that PETSc's own gradients find."""
    model, steps = os.path.join(folder, "model.npz"), []
    for cells in (5, 10):
        block = [f"beam:{2 * cells}x{cells}x{cells}@2x1x1", *HELD, "--modes", "2", "--rank", "3", "--solver", "cg", "--json", "-q"]
        result = programs.together(2, ["precompute", *block, "-o", model])
        demand(result.returncode == 0, result.stderr)
        use = json.loads(result.stdout)["solver"]
        steps.append(use["steps"] / use["solves"])
    demand(steps[1] < 1.5 * steps[0], f"{steps[0]:.3g} steps a solve, then {steps[1]:.3g}")

    # with another preconditioner PETSc solves column by column, and says no steps
    models = [os.path.join(folder, name) for name in ("blocks.npz", "columns.npz")]
    for path, options in zip(models, ("", "-thrum_pc_type jacobi -thrum_ksp_max_it 20000")):
        result = programs.together(2, ["precompute", *SMALL, *HELD, "--solver", "cg", "--json", "-q", "-o", path], PETSC_OPTIONS=options)
        demand(result.returncode == 0, result.stderr)
        demand(("steps" in json.loads(result.stdout)["solver"]) == (options == ""), result.stdout)
    worst = compare(*models)
    return "%.3g and %.3g steps a solve; frequencies %.1g, polynomial %.1g, angle %.1g" % (*steps, *worst)


def check_control(programs, folder):
    """Without the multigrid conjugate gradients do not come to their end in the steps they have."""
    model = os.path.join(folder, "model.npz")
    result = programs.together(2, ["precompute", "horse", "-o", model, "-q", "--solver", "cg"],
                               PETSC_OPTIONS="-thrum_pc_type none")
    demand(result.returncode == 1, f"exit {result.returncode}: {result.stderr}")
    demand("did not converge" in result.stderr, result.stderr)
    demand(not os.listdir(folder), "a model was written")
    return "no model without a preconditioner"


def check_other_files(programs, folder):
    """Process 0 alone reads and writes: what the folders of the others hold under the same names changes nothing.

    MUMPS adds in the order in which messages arrive, so two runs agree to the promised tolerances and not to the bit."""
    models, places = [], [os.path.join(folder, name) for name in ("first", "second")]
    for place, vertices in zip(places, ("1:9", "1:7")):
        os.mkdir(place)
        with open(os.path.join(place, "held.txt"), "w", encoding="utf-8") as file:
            file.write(vertices)

    # process 0 and the other one in these folders; the last pair is to differ
    for name, pair in (("same", (0, 0)), ("other", (0, 1)), ("control", (1, 1))):
        one = ["-n", "1", programs.thrum_mpi, "precompute", *SMALL, "--fix", "held.txt", "-o", "model.npz", "--reproducible", "-q"]
        result = run([programs.mpirun, "--oversubscribe", "--wdir", places[pair[0]], *one, ":", "--wdir", places[pair[1]], *one])
        demand(result.returncode == 0, result.stderr)
        models.append(os.path.join(folder, f"{name}.npz"))
        os.rename(os.path.join(places[pair[0]], "model.npz"), models[-1])
        demand(os.listdir(places[1]) == ["held.txt"], f"written by the second process: {os.listdir(places[1])}")

    worst = compare(models[1], models[0])[0]
    hertz = [numpy.array(read(path)[1]["frequencies_hz"]) for path in models]
    demand(numpy.max(numpy.abs(hertz[2] / hertz[0] - 1)) > 1e-3, "the files do not matter in this test")
    return f"the same model, frequencies to {worst:.2g}"


def children(parent):
    """The processes that `parent` started."""
    with open(f"/proc/{parent}/task/{parent}/children", encoding="ascii") as file:
        return [int(word) for word in file.read().split()]


def check_killed(programs, folder):
    """A process that is killed ends all within seconds; the earlier model stays, and nothing else."""
    model = os.path.join(folder, "model.npz")
    with open(model, "w", encoding="utf-8") as file:
        file.write("an earlier model")
    command = programs.command(2, ["precompute", "beam:40x12x12@1x0.3x0.3,split=6", "--order", "1", *HELD, "-o", model])
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as started:
        try:
            until = time.monotonic() + SECONDS
            while len(children(started.pid)) < 2 and time.monotonic() < until:
                time.sleep(0.05)
            time.sleep(1)
            demand(started.poll() is None, "it ended before it was killed")
            os.kill(children(started.pid)[1], signal.SIGKILL)
            began = time.monotonic()
            code = started.wait(SECONDS)
        finally:
            started.kill()
    demand(code != 0, "a killed process passes for success")
    with open(model, encoding="utf-8") as file:
        demand(file.read() == "an earlier model", "the earlier model is gone")
    demand(os.listdir(folder) == ["model.npz"], f"left behind: {os.listdir(folder)}")
    return f"all ended after {time.monotonic() - began:.1f} s"


def main(arguments):
    if len(arguments) < 3:
        print(__doc__, file=sys.stderr)
        return 2
    programs, failed = Programs(*arguments[:3]), 0
    checks = {name: lambda p, f, c=case: check_case(p, f, *c) for name, case in CASES.items()}
    checks.update({"refusals": check_refusals, "one process": check_one_process, "memory": check_memory, "a dry run": check_dry_run,
                   "statics": check_statics, "steps": check_steps, "no preconditioner": check_control, "growth": check_growth, "other files": check_other_files, "a killed process": check_killed})
    for name in arguments[3:] or checks:
        with tempfile.TemporaryDirectory() as folder:
            try:
                print(f"{name}: {checks[name](programs, folder)}", flush=True)
            except (AssertionError, subprocess.TimeoutExpired) as error:
                print(f"{name}: FAILED: {error}", flush=True)
                failed += 1
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
