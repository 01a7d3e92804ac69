#!/usr/bin/env python3
"""Takes model files with changed numbers, sizes and texts through every command that reads a model.

usage: commands.py PROGRAM [--seconds N] [--seed N]

A command may do its work (exit code 0 or 3) or refuse (1, with one line that says why). A signal, a report of a sanitizer,
any other exit code, silence, or 60 seconds without an end is a finding, and the model that led to it is left as finding.npz.
Prints how often each command did its work and refused. For a program that was built with sanitizers, but not only.
SPDX-License-Identifier: Apache-2.0
"""
import argparse
import collections
import io
import os
import pathlib
import random
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import zipfile

OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
SCENE = ('{"time": 0.03, "gravity": [0, 0, -9.81], "obstacles": [{"shape": "plane", "centre": [0, 0, -1.01]}], '
         '"bodies": [{"name": "a", "model": "m.npz", "start": "mode:1,0.01"}, {"name": "b", "model": "m.npz", "scale": 2, "rank": 1}], '
         '"probes": [{"body": "a", "at": "all"}], "outputs": {"frames": "every-5"}}')
COMMANDS = [
    "info m.npz --json", "info m.npz --load gravity:0,0,-1 --dt 0.01", "simulate m.npz -o run --time 0.03 --start mode:1,0.01 -q "
    "--frames every-5 --stress", "simulate m.npz -o run --time 0.03 --load constant:0,0,-1@all -q --integrator imexv --json",
    "simulate m.npz -o run --time 0.03 --rank 2 --start static:gravity:0,0,-1 -q", "simulate scene.json -o both -q --json",
    "static m.npz --load gravity:0,0,-1 -q -o q.npy --vtu q.vtu --json", "embed m.npz surface.obj -o s.npz -q",
    "export m.npz --vega-basis m.U --vega-cubic m.cub --matrices m", "view m.npz --no-open -o v.html -q",
    "precompute m.npz --modes 2 --rank 3 -q -o again.npz", "bench step m.npz --no-machine --batches 1 --steps 2 -q",
    "response m.npz --mode 1 -q -o curve --points 12 --no-check", "response m.npz --load sine:0,0,-1@all --damping-ratio 0.05 -q --json "
    "--points 12 --no-check", "identify m.npz ring.csv --start mode:1,0.01 --iterations 3 -q -o fit",
    "info m.npz --gradient --touch --json", "static m.npz --full --load constant:0,0,-1@all -q --vtu w.vtu --json",
    "simulate m.npz --full --time 0.01 --load constant:0,0,-1@all -q -o whole", "export m.npz --nlvib m.mat --damping-ratio 0.01 --at all",
    "export m.npz --numpy m.py", "export m.npz --header m.h", "export m.npz --fmu m.fmu --at all",
]
NUMBERS = [0.0, -0.0, 1.0, -1.0, 1e-320, 1e-160, 1e160, 1e308, float("nan"), float("inf"), 0.5, 7.0]
WHOLES = [0, 1, -1, 7, 255, 2**31 - 1, -2**31, 1000]


def changed(members, generator):
    """The members of a model file with a few of their numbers, or their sizes or texts, other than they were."""
    members = dict(members)
    for _ in range(generator.choice((1, 1, 1, 2, 4))):
        name = generator.choice(sorted(members))
        data = bytearray(members[name])
        begin = 10 + int.from_bytes(data[8:10], "little")
        kind = generator.randrange(8)
        if kind == 0:
            del members[name]
            continue
        if kind == 1 or len(data) == begin:
            data[generator.randrange(len(data))] ^= 1 << generator.randrange(8)
        elif b"<f8" in data[:begin]:
            at = begin + 8 * generator.randrange((len(data) - begin) // 8)
            old = struct.unpack_from("<d", data, at)[0]
            struct.pack_into("<d", data, at, generator.choice(NUMBERS + [-old, 2 * old, 1e6 * old, 1e-6 * old]))
        elif b"<i4" in data[:begin]:
            struct.pack_into("<i", data, begin + 4 * generator.randrange((len(data) - begin) // 4), generator.choice(WHOLES))
        else:
            data[generator.randrange(begin, len(data))] = generator.randrange(256)
        members[name] = bytes(data)
    return members


def archive(members):
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_STORED) as file:
        for name, data in members.items():
            file.writestr(name, data)
    return made.getvalue()


def wrong(done):
    """What is wrong with how a command ended; None: nothing."""
    errors = done.stderr.decode(errors="replace")
    if "Sanitizer" in errors or "runtime error:" in errors:
        return "a sanitizer reports"
    if done.returncode < 0:
        return f"signal {-done.returncode}"
    if done.returncode not in (0, 1, 3):
        return f"exit code {done.returncode}"
    return "refused without a word" if done.returncode == 1 and not errors.strip() else None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=os.path.abspath)
    parser.add_argument("--seconds", type=float, default=6)
    parser.add_argument("--seed", type=int, default=1)
    wanted = parser.parse_args()
    generator, ended, here = random.Random(wanted.seed), collections.Counter(), pathlib.Path.cwd()
    with tempfile.TemporaryDirectory(prefix="thrum-commands-") as name:
        folder = pathlib.Path(name)
        (folder / "scene.json").write_text(SCENE)
        (folder / "surface.obj").write_text(OBJ)
        (folder / "ring.csv").write_text("time_s,all.z_m\n" + "".join(f"{k / 500},{0.01 * (-1) ** (k // 9)}\n" for k in range(40)))
        (folder / "page.html").write_text('<script type="application/octet-stream" id="thrum-pack"></script>')
        environment = dict(os.environ, PATH="", OPENBLAS_NUM_THREADS="1", THRUM_VIEWER=str(folder / "page.html"),
                           XDG_CACHE_HOME=str(folder / "cache"))
        seeds = []
        held = ["--fix", "x<0.1"]
        for mesh, more in (("beam:2x1x1@2x1x1,split=6", held), ("beam:2x1x1@2x1x1,split=6", []),
                           ("beam:2x1x1@2x1x1,split=6", [*held, "--condense"]), ("beam:2x1x1@2x1x1,hex", held),
                           ("beam:3x2x1@2x1x0.05,hex", [*held, "--parameters"]),
                           ("beam:2x1x1@2x1x1,split=6", ["--spring", "x<0.1:1e4"])):
            subprocess.run([wanted.program, "precompute", mesh, "--order", "1", *more, "--modes", "2", "--rank", "4", "-q", "-o", "seed.npz"],
                           cwd=folder, check=True, capture_output=True, env=environment)
            with zipfile.ZipFile(folder / "seed.npz") as file:
                seeds.append({member: file.read(member) for member in file.namelist()})

        # with the models as they were made all commands run
        for command in COMMANDS:
            (folder / "m.npz").write_bytes(archive(seeds[0]))
            done = subprocess.run([wanted.program, *command.split(" ")], cwd=folder, capture_output=True, check=False,
                                  stdin=subprocess.DEVNULL, env=environment, timeout=60)
            if done.returncode not in (0, 3):
                sys.exit(f"thrum {command} ends with {done.returncode}: {done.stderr.decode(errors='replace')[:2000]}")

        until = time.monotonic() + wanted.seconds
        while time.monotonic() < until:
            (folder / "m.npz").write_bytes(archive(changed(generator.choice(seeds), generator)))
            command = generator.choice(COMMANDS)
            try:
                done = subprocess.run([wanted.program, *command.split(" ")], cwd=folder, capture_output=True, check=False,
                                      stdin=subprocess.DEVNULL, env=environment, timeout=60)
                found = wrong(done)
            except subprocess.TimeoutExpired:
                found = "no end after 60 s"
            if found:
                shutil.copy(folder / "m.npz", here / "finding.npz")
                sys.exit(f"finding: thrum {command}: {found}: {done.stderr.decode(errors='replace')[:2000]}")
            ended[command, done.returncode != 1] += 1
    for command in COMMANDS:
        print(f"{ended[command, True]:6} done {ended[command, False]:6} refused  {command[:80]}")
    print(f"{sum(ended.values())} commands, 0 findings")


if __name__ == "__main__":
    main()
