#!/usr/bin/env python3
"""Kills the program at random moments while it replaces a run, the run of a scene or a model, and looks at what is there.

usage: kill.py PROGRAM [--kills N]

After each kill the earlier result or the new one must be there, whole, with the user's own file beside it once the next one
has been written. Prints how often each was found, and exits with 1 at the first that is neither.

SPDX-License-Identifier: Apache-2.0
"""
import argparse
import collections
import json
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import time
import zipfile

SCENE = ('{"time": %g, "bodies": [{"name": "a", "model": "m.npz", "start": "mode:1,0.01"}, '
         '{"name": "b", "model": "m.npz"}], "outputs": {"frames": "every-5"}}')
BEAM = ["precompute", "beam:2x1x1@2x1x1,split=6", "--order", "1", "--fix", "x<0.1", "-q", "--modes", "2", "--rank"]


def simulate(variant):
    return ["simulate", "m.npz", "-o", "run", "--time", ("0.03", "0.06")[variant], "--start", "mode:1,0.01", "-q", "--frames",
            "every-5"]


def run_variant(folder):
    """Which of the two runs is in the folder; fails where it is not whole."""
    report = json.loads((folder / "run.json").read_text())
    rows = len((folder / "energy.csv").read_text().splitlines()) - 1
    assert report["rows"] == rows, f"{folder}: {rows} rows, not {report['rows']}"
    frames = [path for path in (folder / "frames").iterdir() if path.name.startswith("frame_")]
    assert len(frames) == report["frames"], f"{folder}: {len(frames)} frames, not {report['frames']}"
    assert (folder / "q.npy").stat().st_size >= 8 * 4 * rows, f"{folder}: q.npy is short"
    return {10: 0, 20: 1}[report["steps"]]


def scene_variant(folder):
    scene = json.loads((folder / "scene.json").read_text())
    bodies = {run_variant(folder / body["name"]) for body in scene["bodies"]}
    assert len(bodies) == 1, f"{folder}: bodies of two runs"
    return bodies.pop()


def model_variant(path):
    with zipfile.ZipFile(path) as archive:
        assert archive.testzip() is None, f"{path}: damaged"
        return {8 * 3: 0, 8 * 4: 1}[len(archive.read("omega2.npy")) - 128]


# the command of each of two variants, what says which one is there, and the user's own file
TARGETS = {
    "run": (simulate, lambda: run_variant(pathlib.Path("run")), "run/notes.txt"),
    "scene": (lambda variant: ["simulate", f"scene{variant}.json", "-o", "both", "-q"],
              lambda: scene_variant(pathlib.Path("both")), "both/b/notes.txt"),
    "model": (lambda variant: BEAM + ["34"[variant], "-o", "replaced.npz"],
              lambda: model_variant(pathlib.Path("replaced.npz")), None),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=os.path.abspath)
    parser.add_argument("--kills", type=int, default=1000)
    wanted = parser.parse_args()
    random.seed(1)

    # without gnuplot a run is short, so that more of the kills meet the replacement
    environment = dict(os.environ, OPENBLAS_NUM_THREADS="1", PATH="")
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "env": environment}
    with tempfile.TemporaryDirectory(prefix="thrum-kill-") as folder:
        os.chdir(folder)
        subprocess.run([wanted.program, *BEAM, "4", "-o", "m.npz"], check=True, **quiet)
        for variant, seconds in enumerate((0.03, 0.06)):
            pathlib.Path(f"scene{variant}.json").write_text(SCENE % seconds)
        for name, (command, variant_of, notes) in TARGETS.items():
            found = collections.Counter()
            subprocess.run([wanted.program, *command(0)], check=True, **quiet)
            began = time.monotonic()
            subprocess.run([wanted.program, *command(0)], check=True, **quiet)
            length = time.monotonic() - began
            if notes:
                pathlib.Path(notes).write_text("mine")

            for _ in range(wanted.kills // len(TARGETS)):
                before, new = variant_of(), random.randrange(2)
                child = subprocess.Popen([wanted.program, *command(new)], **quiet)
                time.sleep(random.random() * 1.3 * length)
                child.kill()
                ended = child.wait() == 0
                after = variant_of()
                assert after in (before, new) and (after == new or not ended), f"{name}: {before}, then {after}, not {new}"
                found["ended" if ended else "same" if before == new else "new" if after == new else "earlier"] += 1

            # the next one clears what is left, and the user's file is there
            subprocess.run([wanted.program, *command(1)], check=True, **quiet)
            assert variant_of() == 1 and (notes is None or pathlib.Path(notes).read_text() == "mine"), name
            left = [path.name for path in pathlib.Path(".").iterdir() if "thrum-" in path.name]
            assert not left, f"{name}: {left} left behind"
            print(f"{name:6} {sum(found.values())} kills: " + ", ".join(f"{n} {what}" for what, n in sorted(found.items())),
                  flush=True)


if __name__ == "__main__":
    try:
        main()
    except AssertionError as finding:
        sys.exit(f"finding: {finding}")
