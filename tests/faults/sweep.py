#!/usr/bin/env python3
"""Fails the n-th allocation, or the n-th access to files, of every command, and looks at what comes out.

usage: sweep.py allocation PROGRAM LIBRARY [--points N] [--command NAME] [--show]
       sweep.py files PROGRAM INJECTOR [--points N] [--command NAME] [--show]

PROGRAM is thrum, LIBRARY what allocation_fault.c makes, INJECTOR what file_fault.c makes. Without --points every n is tried,
else N of them for each command and kind of fault: the first ones, and the rest evenly. A run may end in three ways:

  exit code 0 or 3   the output and all files are those of an undisturbed run, up to rounding (times and memory left out)
  exit code 1        a line says why, with the reason that the kernel gave; nothing is there, or what was there before, or
                     what would be there after it, whole
  exit code 127      the loader itself found no memory, before the program began

A crash inside of a library of linear algebra, which looks at no memory of its own, is counted apart. Anything else, a signal
included, is a finding. A command that ends with exit code 0 or 3 and other results is the worst of
them: a wrong result that looks right. Prints a table, and exits with 1 where there is a finding.
SPDX-License-Identifier: Apache-2.0
"""
import argparse
import array
import collections
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile

SCENE = {"time": 0.03, "bodies": [{"name": "one", "model": "m.npz", "start": "mode:1,0.01"},
                                  {"name": "two", "model": "f.npz", "free": True, "position": [0, 0, 1.1],
                                   "velocity": [0, 0, -10]},
                                  {"name": "spun", "model": "f.npz", "free": True, "coupled": True, "integrator": "energy",
                                   "position": [0, 3, 2], "spin": [0, 3, 0]}],
         "links": [{"name": "hinge", "kind": "hinge", "body": "spun", "place": [0, 3, 2], "axis": [0, 1, 0]},
                   {"name": "spring", "kind": "spring", "body": "two", "other": "one", "place": [2, 0, 1.6],
                    "other_place": [2, 0, 0.5], "stiffness": 10, "until": 0.02}],
         "gravity": [0, 0, -9.81], "obstacles": [{"shape": "plane", "centre": [0, 0, -0.6]}],
         "probes": [{"body": "one", "at": "all"}], "outputs": {"frames": "every-5", "accept_error": "100%"}}
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"

# commands: OUT is the folder of the case, the other files lie in the folder of the inputs
COMMANDS = {
    "precompute": "precompute beam:2x1x1@2x1x1,split=6 --order 1 --fix x<0.1 --modes 2 --rank 4 -q -o OUT/m.npz --json",
    "precompute_free": "precompute mesh.veg --modes 2 --rank 4 -q -o OUT/m.npz --json",
    "precompute_dry": "precompute mesh.veg --dry-run --json",
    "check": "check mesh.veg --json",
    "convert": "convert mesh.msh OUT/m.vtu",
    "convert_back": "convert mesh.inp OUT/m.msh --json",
    "simulate": "simulate m.npz -o OUT/run --time 0.03 --start mode:1,0.01 -q --frames every-5 --json",
    "simulate_motion": "simulate m.npz -o OUT/run --time 0.03 --base-motion quake.csv --load gravity:0,0,-9.81 -q --stress "
                       "--json",
    "simulate_full": "simulate mesh.veg --full --fix x<0.1 -o OUT/run --time 0.015 --load gravity:0,0,-1 -q --json",
    "scene": "simulate scene.json -o OUT/run -q --json",
    "static": "static m.npz --load gravity:0,0,-1 -q -o OUT/q.npy --vtu OUT/q.vtu --path OUT/q.csv --json",
    "info": "info m.npz --json",
    "info_load": "info f.npz --load gravity:0,0,-1",
    "embed": "embed m.npz surface.obj -o OUT/s.npz -q --json",
    "export": "export m.npz --vega-basis OUT/m.U --vega-cubic OUT/m.cub --matrices OUT/m --json",
    "export_motion": "export run --glb OUT/m.glb --pc2 OUT/m.pc2 --mdd OUT/m.mdd --obj OUT/m.obj --json",
    "export_scene": "export scene_run --glb OUT/m.glb --json",
    "export_code": "export m.npz --header OUT/m.h --numpy OUT/m_numpy.py --torch OUT/m_torch.py --jax OUT/m_jax.py --json",
    "export_fmu": "export m.npz --fmu OUT/m.fmu --fmi 2 --json",
    "export_fmu_3": "export m.npz --fmu OUT/m.fmu --fmi 3 --json",
    "info_gradient": "info m.npz --gradient --json",
    "compare": "compare run longer_run --json",
    "info_run": "info run --json",
    "static_full": "static mesh.veg --full --fix x<0.1 --load gravity:0,0,-1 -q --reactions OUT/r.csv --json",
    "response": "response m.npz --load sine:0,0,1@tip --damping-ratio 0.05,0.05,0.05,0.05 --from 3 --to 5 --harmonics 5 -o "
                "OUT/curve --json",
    "response_branch": "response m.npz --mode 2 --harmonics 5 --points 90 --branch 1 --no-check --stability off -q -o OUT/curve "
                       "--json",
    "identify": "identify m.npz recording.csv --start mode:1,0.01 --iterations 2 -q -o OUT/fit --json",
    "mesh_sheet": "mesh roof.obj -o OUT/sheet.vtu --thickness 0.01 --layers 2 -q --json",
    "precompute_actuator": "precompute beam:2x1x1@2x1x1,split=6 --order 1 --fix x<0.1 --modes 2 --rank 4 "
                           "--actuator arm=muscle:1,1,0,0 --actuator pull=tendon:vertex=1,at:1,0,0,vertex=12 -q -o OUT/m.npz --json",
    "precompute_parameters": "precompute beam:2x1x1@2x1x1,split=6 --order 1 --fix x<0.1 --modes 2 --rank 4 --parameters -q "
                             "-o OUT/m.npz --json",
    "simulate_actuate": "simulate acts.npz -o OUT/run --time 0.02 --actuate arm=constant:0.1 -q --json",
    "precompute_touch": "precompute mesh.veg --order 1 --fix x<0.1 --modes 2 --rank 4 --touch --rank-max 8 -q -o OUT/m.npz --json",
    "precompute_points": "precompute mesh.veg --order 1 --fix x<0.1 --modes 2 --rank 4 --cubature --cubature-error 0.2 -q "
                         "-o OUT/m.npz --json",
    "precompute_train": "precompute mesh.veg --order 1 --fix x<0.1 --modes 2 --rank 4 --train gravity:0,0,-1 --train-time 0.02 "
                        "--train-dt 0.005 -q -o OUT/m.npz --json",
    "view_run": "view run --no-open -o OUT/v.html -q --json",
    "experiments": "experiments --models m.npz --loads impulse --schemes newmark --time 0.06 -q -o OUT/made --json",
    "job": "experiments --models m.npz --loads impulse --schemes newmark --time 0.06 -q -o OUT/made --json --job 1",
    "tradeoff": "tradeoff m.npz -o OUT/trade --load square:0,0,-9@all --time 0.03 --ranks 0 --integrators newmark --dts 0.003 "
                "--tolerances 1e-6 --full-dt 0.005 -q --json",
    "view": "view m.npz --no-open -o OUT/v.html -q --json",
    "view_scene": "view scene.json --no-open -o OUT/v.html -q --json",
    "schema": "schema simulate",
    "help": "help --reference",
    "bench": "bench step m.npz --no-machine --batches 1 --steps 2 -q --json",
}

# commands whose folder holds an earlier result, made by this one, which they replace
EARLIER = {
    "simulate_again": "simulate m.npz -o OUT/run --time 0.06 --start mode:2,0.01 -q --frames every-10",
    "scene_again": "simulate scene.json -o OUT/run -q",
    "precompute_again": "precompute beam:2x1x1@2x1x1,split=6 --order 1 --fix x<0.1 --modes 2 --rank 3 -q -o OUT/m.npz",
    "static_again": "static m.npz --load gravity:0,0,-2 -q -o OUT/q.npy --vtu OUT/q.vtu --path OUT/q.csv",
    "export_again": "export run --glb OUT/m.glb --fps 60",
    "collect": COMMANDS["job"],
}
COMMANDS.update({
    "simulate_again": COMMANDS["simulate"],
    "scene_again": "simulate longer.json -o OUT/run -q --json",
    "precompute_again": COMMANDS["precompute"],
    "static_again": COMMANDS["static"],
    "export_again": "export run --glb OUT/m.glb --json",
    "collect": COMMANDS["experiments"] + " --collect",
})

# the share of a command's allocations in which it reads its mesh, after the first few, which are the program's own
READS_MESH = {"convert": (0.05, 0.5), "convert_back": (0.05, 0.43)}

# kinds of access to files that fail, and what the kernel then says (tests/faults/file_fault.c)
FILE_FAULTS = {"open": "Too many open files", "read": "Input/output error", "write": "Input/output error",
               "full": "No space left on device", "fsync": "Input/output error", "close": "Input/output error",
               "rename": "Input/output error", "folder": "Permission denied", "remove": "Permission denied"}

# libraries that crash or end the program themselves where they find no memory
LIBRARIES = ("mumps", "gfortran", "cholmod", "metis", "arpack", "openblas", "lapack")

# what MUMPS itself prints where a table of its own finds no memory, which it then does without
LIBRARY_LINES = (b" Problem allocating L0_OMP_MAPPING",)

# what differs from run to run: times, memory, processes; and the size of a factor, which CHOLMOD orders otherwise where METIS
# finds no memory
VOLATILE = re.compile(r"factor_nonzeros|second|time_s$|took|peak_mb|us_per|_us|cpu|gflop|speedup|cost|machine|processor|model_hash|per_second|rate_mb|allocated")
Fault = collections.namedtuple("Fault", "name environment prefix")


# --- results of a run ----------------------------------------------------------------------------------------------------

def steady(value):
    """A value of JSON without what differs from run to run."""
    if isinstance(value, dict):
        return {key: steady(item) for key, item in value.items() if not VOLATILE.search(key)}
    return [steady(item) for item in value] if isinstance(value, list) else value


def normal(data, names):
    """The bytes of a file or of the output, comparable between runs. `names`: paths that differ."""
    for name in names:
        data = data.replace(str(name).encode(), b"OUT")
    lines = []
    for line in data.split(b"\n"):
        if line.startswith(LIBRARY_LINES):
            continue
        try:
            made = json.loads(line)
        except ValueError:
            made = None
        lines.append(json.dumps(steady(made)).encode() if isinstance(made, (dict, list)) else line)
    return b"\n".join(lines)


def files_of(folder):
    """The files in a folder, and in place of archives their members; the text of a model's recipe on a line of its own."""
    files = {}
    for path in sorted(folder.rglob("*")):
        # pages are made of the tables by another program, and tell times
        if path.suffix == ".html" and path.stem != "v":
            continue
        name = str(path.relative_to(folder))
        if path.suffix == ".npz":
            with zipfile.ZipFile(path) as archive:
                files.update({f"{name}:{member}": archive.read(member) for member in archive.namelist()})
            meta = files.pop(f"{name}:meta.npy", None)
            if meta is not None:
                files[f"{name}:meta"] = meta[10 + int.from_bytes(meta[8:10], "little"):]
        elif path.is_file():
            files[name] = path.read_bytes()
    return files


NUMBER = re.compile(rb"[-+]?[0-9]+\.?[0-9]*(?:[eE][-+]?[0-9]+)?")


def numbers_of(data):
    """The numbers of a file, and all else of it."""
    if data[:6] == b"\x93NUMPY":
        begin = 10 + int.from_bytes(data[8:10], "little")
        form = "d" if b"<f8" in data[:begin] else "i" if b"<i4" in data[:begin] else "B"
        values = array.array(form, data[begin:])
        return list(values), data[:begin]
    return [float(text) for text in NUMBER.findall(data)], NUMBER.sub(b"0", data)


def part_of(name):
    """What is there as a whole or not at all: the folder of a run, else the file, with all members where it is an archive."""
    return name.split("/")[0] if name.startswith("run") else name.split(":")[0]


HASHES = re.compile(rb'"model_(arrays_)?hash": *"[0-9a-f]*"')


def is_close(data, other):
    """Equal up to rounding: an order of the sparse factor that METIS made with less memory gives other last digits, and a
    model that is made with it other hashes."""
    (a, rest), (b, other_rest) = (numbers_of(HASHES.sub(b"", text)) for text in (data, other))
    least = 1e-11 * max([1, *(abs(x) for x in a)])
    return rest == other_rest and len(a) == len(b) and all(
        math.isclose(x, y, rel_tol=1e-6, abs_tol=least) for x, y in zip(a, b))


class Case:
    """One command in its folder of inputs."""

    def __init__(self, program, inputs, name):
        self.program, self.inputs, self.name = program, inputs, name
        self.masks, self.wanted, self.earlier = {}, None, {}
        self.earlier_folder = None
        self.environment = dict(os.environ, OPENBLAS_NUM_THREADS="1", THRUM_MODELS=str(inputs), PATH=str(inputs / "programs"),
                                THRUM_VIEWER=str(inputs / "page.html"))
        if name in EARLIER:
            # the same place for all, since results hold the names of their folders
            self.earlier_folder = inputs.parent / f"earlier-{name}"
            self.earlier_folder.mkdir()
            done = self.call(EARLIER[name], self.earlier_folder, environment=self.environment)
            if done.returncode not in (0, 3):
                sys.exit(f"{EARLIER[name]}: {done.stderr}")
            self.earlier = {file: normal(data, [self.earlier_folder])
                            for file, data in files_of(self.earlier_folder).items()}

    def call(self, command, out, prefix=(), environment=None):
        arguments = [part.replace("OUT", str(out)) for part in command.split(" ")]
        return subprocess.run([*prefix, self.program, *arguments], cwd=self.inputs, env=environment,
                              stdin=subprocess.DEVNULL, capture_output=True, timeout=300, check=False)

    def run(self, fault, at, extra=None):
        out = pathlib.Path(tempfile.mkdtemp(prefix="out-", dir=self.inputs.parent))
        if self.earlier_folder:
            shutil.copytree(self.earlier_folder, out, dirs_exist_ok=True)
        environment = dict(self.environment, **fault.environment(at), **(extra or {}))
        done = self.call(COMMANDS[self.name], out, fault.prefix(at), environment)
        if at == 0 and done.returncode not in (0, 3):
            sys.exit(f"{self.name}: an undisturbed run ends with {done.returncode}: {done.stderr.decode(errors='replace')}")
        names = [out, *([self.earlier_folder] if self.earlier_folder else [])]
        results = {name: normal(data, names) for name, data in files_of(out).items()}
        results["standard output"] = normal(done.stdout, names)
        shutil.rmtree(out)
        return done.returncode, results, done.stderr.decode(errors="replace").replace(str(out), "OUT")

    def learn(self, fault):
        """The results of undisturbed runs, and which lines of them differ from run to run."""
        runs = [self.run(fault, 0) for _ in range(3)]
        code, wanted, _ = runs[0]
        self.wanted = (code, wanted)
        for _, other, _ in runs[1:]:
            for name, data in wanted.items():
                if other[name] != data:
                    self.masks.setdefault(name, set()).update(
                        n for n, (a, b) in enumerate(zip(data.split(b"\n"), other[name].split(b"\n"))) if a != b)

    def half(self, results, errors):
        """A file of a run that failed which is neither missing nor whole; None: there is none."""
        # without any memory a folder cannot even be looked through, so a work folder stays, as of a killed run
        parts = collections.defaultdict(dict)
        for name, data in results.items():
            if name != "standard output" and ".thrum-partial/" not in name:
                parts[part_of(name)][name] = data

        # a new run that could not be put in its place is kept beside it, and the message says so
        for part in [part for part in parts if re.search(r"\.new-\d+$", part) and f"is kept in OUT/{part}" in errors]:
            moved = re.sub(r"\.new-\d+$", "", part)
            kept = {moved + name[len(part):]: data for name, data in parts.pop(part).items()}
            if self.differs(self.wanted[0], kept, part=moved):
                return part

        # each file or folder is the earlier one or the new one, as a whole
        for part in {*parts, *(part_of(name) for name in self.earlier)}:
            earlier = {name: data for name, data in self.earlier.items() if part_of(name) == part}
            if parts[part] == earlier:
                continue
            wrong = self.differs(self.wanted[0], parts[part], part=part)
            left = [name for name in parts[part] if name not in self.wanted[1]]
            if wrong or left:
                return wrong or left[0]
        return None

    def differs(self, code, results, part=None):
        """What of the results, or of this file or folder among them, is not that of an undisturbed run; None: all is."""
        if code != self.wanted[0]:
            return f"exit code {code}"
        for name, data in self.wanted[1].items():
            if part is not None and part_of(name) != part:
                continue
            if name not in results:
                return f"{name} is missing"
            if name in self.masks:
                hide = lambda text: [b"" if n in self.masks[name] else line for n, line in enumerate(text.split(b"\n"))]
                data, other = b"\n".join(hide(data)), b"\n".join(hide(results[name]))
            else:
                other = results[name]
            if other != data and not is_close(data, other):
                return name
        return None


def make_inputs(program, inputs):
    """The models, meshes and files that the commands read."""
    inputs.mkdir()
    (inputs / "scene.json").write_text(json.dumps(SCENE))
    (inputs / "longer.json").write_text(json.dumps(dict(SCENE, time=0.06)))
    # without gnuplot there are no plots, which may be missing without being wrong
    (inputs / "programs").mkdir()
    (inputs / "programs" / "python3").symlink_to(sys.executable)
    (inputs / "page.html").write_text('<script type="application/octet-stream" id="thrum-pack"></script>')
    (inputs / "surface.obj").write_text(OBJ)
    (inputs / "roof.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.1\nf 1 2 3 4\n")
    (inputs / "recording.csv").write_text("time_s,tip.z_m\n" + "".join(f"{0.01 * n},{0.01 * math.cos(0.25 * n)}\n" for n in range(40)))
    (inputs / "quake.csv").write_text("t,ax,ay,az\n" + "".join(f"{0.01 * n},{n % 3},0,{n % 2}\n" for n in range(6)))
    for line in ("convert beam:2x1x1@2x1x1 mesh.veg", "convert beam:2x1x1@2x1x1 mesh.msh",
                 "convert beam:2x1x1@2x1x1 mesh.inp",
                 "precompute beam:2x1x1@2x1x1,split=6 --order 1 --fix x<0.1 --modes 2 --rank 4 -q -o m.npz",
                 "precompute beam:2x1x1@2x1x1,split=6 --order 1 --modes 2 --rank 4 -q -o f.npz",
                 "precompute beam:2x1x1@2x1x1,split=6 --order 1 --fix x<0.1 --modes 2 --rank 4 --actuator arm=muscle:1,1,0,0 -q "
                 "-o acts.npz",
                 "simulate m.npz -o run --time 0.03 --start mode:1,0.01 -q",
                 "simulate m.npz -o longer_run --time 0.03 --dt 0.0015 --start mode:1,0.01 -q", "simulate scene.json -o scene_run -q"):
        done = subprocess.run([program, *line.split(" ")], cwd=inputs, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            sys.exit(f"{line}: {done.stderr}")


# --- the sweep -----------------------------------------------------------------------------------------------------------

def chosen(count, points):
    """All of 1..count, or so many of them: the first ones, and the rest evenly."""
    if not points or points >= count:
        return list(range(1, count + 1))
    first = points // 4
    return list(range(1, first + 1)) + [first + 1 + k * (count - first - 1) // (points - first) for k in range(points - first)]


def leaves_out_mesh(case, errors, fault, share):
    """Whether a run that had no memory to read its mesh does not say which mesh that was. `share`: of its allocations, before."""
    least, most = READS_MESH.get(case.name, (1, 0))
    return fault == "one" and least < share < most and "mesh." not in errors


def judge(case, code, results, errors, fault, share):
    """A finding, as its kind and a text; None: the run ended as it may."""
    reason = FILE_FAULTS.get(fault)  # what a message must say; None: anything
    if code < 0 or code == 139:
        libraries = re.findall(r" (\S+?):", errors[errors.rfind(" in "):])
        if libraries and any(part in name for name in libraries[:4] for part in LIBRARIES):
            return "crash of a library", f"a crash in {libraries[0]}"
        return "crash", f"signal {-code}"
    if code in (0, 3) and fault == "fsync":
        return "fault not told", f"exit code {code}, though the disk did not keep what was written"
    if code in (0, 3):
        wrong = case.differs(code, results)
        return None if wrong is None else ("wrong result", f"exit code {code} and another {wrong}")
    if code == 127 and "error while loading shared libraries" in errors:
        return None
    if code != 1:
        return "exit code", f"exit code {code}"
    if not errors.strip():
        return "silent", "exit code 1 without a word"
    if reason and reason not in errors and "standard output could not be written" not in errors:
        return "another reason", "the message has not the reason"
    if leaves_out_mesh(case, errors, fault, share):
        return "no file named", "the message has not the name of the mesh"
    half = case.half(results, errors)
    return ("half a file", half) if half else None


def sweep_allocations(case, library, points, show):
    """Every n-th allocation alone, then all from the n-th on."""
    count_path = case.inputs / "count"
    base = Fault("none", lambda at: {}, lambda at: [])
    case.learn(base)
    case.run(Fault("count", lambda at: {"LD_PRELOAD": library, "THRUM_FAULT_COUNT": str(count_path)}, lambda at: []), 0)
    count = int(count_path.read_text())
    yield from sweep(case, [
        (Fault("one", lambda at: {"LD_PRELOAD": library, "THRUM_FAULT_AT": str(at)}, lambda at: []), count),
        (Fault("all from", lambda at: {"LD_PRELOAD": library, "THRUM_FAULT_AT": str(at), "THRUM_FAULT_ALL": "1"},
               lambda at: []), count)], points, show)


def sweep_files(case, injector, points, show):
    """Every n-th call of each kind that reads or writes files."""
    count_path = case.inputs / "count"
    case.learn(Fault("none", lambda at: {}, lambda at: []))

    # one run counts the calls of every kind
    case.run(Fault("count", lambda at: {}, lambda at: [injector, "open", str(count_path), "0"]), 0)
    counts = dict(line.split() for line in count_path.read_text().splitlines())
    faults = [(Fault(kind, lambda at: {}, lambda at, kind=kind: [injector, kind, "-", str(at)]), int(counts[kind]))
              for kind in FILE_FAULTS]
    yield from sweep(case, faults, points, show)


def sweep(case, faults, points, show):
    for fault, count in faults:
        findings, codes, crashes = collections.Counter(), collections.Counter(), 0
        for at in chosen(count, points):
            code, results, errors = case.run(fault, at)
            codes[code] += 1
            found = judge(case, code, results, errors, fault.name, at / count)
            if found and found[0] == "crash of a library":
                crashes += 1
            elif found:
                findings[found[0]] += 1
                if show:
                    print(f"  {case.name}, {fault.name} {at} of {count}: {found[1]}: {errors.strip()[:200]}", flush=True)
        yield fault.name, crashes, codes, findings


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=["allocation", "files"])
    parser.add_argument("program", type=os.path.abspath)
    parser.add_argument("tool", type=os.path.abspath)
    parser.add_argument("--points", type=int, default=0)
    parser.add_argument("--command", action="append")
    parser.add_argument("--show", action="store_true")
    wanted = parser.parse_args()
    total = collections.Counter()
    with tempfile.TemporaryDirectory(prefix="thrum-faults-") as folder:
        inputs = pathlib.Path(folder) / "inputs"
        make_inputs(wanted.program, inputs)
        if wanted.kind == "files" and subprocess.run([wanted.tool, "read", "-", "0", "/bin/true"], check=False).returncode == 125:
            sys.exit("skipped: this system lets no process trace another")
        print(f"{'command':16} {'fault':10} {'points':>7} {'done':>6} {'refused':>8} {'libs':>8}  findings")
        sweep_all = sweep_allocations if wanted.kind == "allocation" else sweep_files
        for name in wanted.command or COMMANDS:
            case = Case(wanted.program, inputs, name)
            for fault, crashes, codes, findings in sweep_all(case, wanted.tool, wanted.points, wanted.show):
                print(f"{name:16} {fault:10} {sum(codes.values()):7} {codes[0] + codes[3]:6} {codes[1]:8} {crashes:8}  "
                      f"{', '.join(f'{n} {what}' for what, n in findings.items()) or 'none'}", flush=True)
                total["runs"] += sum(codes.values())
                total.update(findings)
    findings = sum(total.values()) - total["runs"]
    print(f"{total['runs']} runs, {findings} findings, {total['wrong result']} wrong results with exit code 0 or 3")
    sys.exit(1 if findings else 0)


if __name__ == "__main__":
    main()
