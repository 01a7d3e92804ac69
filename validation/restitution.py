#!/usr/bin/env python3
"""Bounces of near-rigid blocks over the restitution, the step and Young's modulus.

A block of 0.1 m falls flat on a plane, and another flies flat against a third at rest, middle on
middle and turned by 30 degrees against it, so that edges and faces meet and neither is spun. The
ratio of the speeds after and before is to be the restitution, whatever the step and the stiffness
are.
The speed is a small share of the speed of sound in the block (sqrt(E / density)), so that the
block is near-rigid. Writes one row a bounce; needs nothing but the program and the standard
library.

SPDX-License-Identifier: Apache-2.0
"""

import argparse
import csv
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile

STEPS = [0.0002, 0.0005, 0.001, 0.002, 0.004]
YOUNG = [1e5, 1e6, 1e7, 1e8, 1e9]
RESTITUTION = [0.0, 0.2, 0.5, 0.8, 1.0]
DENSITY = 1000.0
SIDE = 0.1
MACH = 0.005  # speed over that of sound
APART = 0.004


def speed_of(young):
    return min(1.0, MACH * math.sqrt(young / DENSITY))


def places(folder):
    """Rows of places.npy: seven doubles each."""
    data = (folder / "places.npy").read_bytes()
    begin = 10 + struct.unpack("<H", data[8:10])[0]
    numbers = struct.unpack(f"<{(len(data) - begin) // 8}d", data[begin:])
    return [numbers[n : n + 7] for n in range(0, len(numbers), 7)]


def block(name, young, angle, z, speed):
    """A block that is turned about the vertical axis through its middle [degrees]."""
    turn = math.radians(angle)
    return {
        "name": name,
        "model": f"beam:2x2x2@{SIDE}x{SIDE}x{SIDE}",
        "material": {"young": young, "density": DENSITY},
        "free": True,
        # the mesh begins at x = 0, about which it is turned
        "position": [-0.5 * SIDE * math.cos(turn), -0.5 * SIDE * math.sin(turn), z],
        "rotation": {"axis": [0, 0, 1], "angle": angle},
        "velocity": [0, 0, speed],
    }


def scene_of(restitution, step, young, kind):
    """One scene: a block against a plane or against another block."""
    speed = speed_of(young)
    thickness = SIDE * math.sqrt(3) / 250
    half = 0.5 * SIDE
    scene = {"dt": step, "time": 4 * APART / speed + 0.4}
    if kind == "plane":
        scene["bodies"] = [block("b", young, 0, half + APART, -speed)]
        scene["obstacles"] = [{"shape": "plane", "restitution": restitution}]
        scene["collide"] = False
    else:
        scene["bodies"] = [
            block("a", young, 0, 0, 0),
            block("b", young, 30, SIDE + thickness + APART, -speed),
        ]
        scene["collisions"] = {"restitution": restitution}
    return scene


def slope(rows, axis, step):
    """Mean speed over the last quarter of the run [m/s]."""
    first = 3 * len(rows) // 4
    return (rows[-1][axis] - rows[first][axis]) / ((len(rows) - 1 - first) * step)


def bounce(program, work, restitution, step, young, kind):
    """Speed after over speed before."""
    path, run = work / "scene.json", work / "run"
    path.write_text(json.dumps(scene_of(restitution, step, young, kind)))
    command = [program, "simulate", str(path), "-o", str(run), "--quiet", "--json"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in (0, 4):
        sys.exit(f"{' '.join(command)}: {done.stderr}")
    after = slope(places(run / "b"), 2, step)
    if kind == "bodies":
        after -= slope(places(run / "a"), 2, step)
    return after / speed_of(young)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", default="build/release/thrum")
    parser.add_argument("--quick", action="store_true", help="the ends of each range alone")
    parser.add_argument("-o", "--output", default="validation/results/restitution.csv")
    asked = parser.parse_args()
    ends = (lambda all_of: [all_of[0], all_of[-1]]) if asked.quick else (lambda all_of: all_of)

    rows, worst = [], 0.0
    with tempfile.TemporaryDirectory() as folder:
        for kind in ("plane", "bodies"):
            for restitution in RESTITUTION:
                for young in ends(YOUNG):
                    for step in ends(STEPS):
                        e = bounce(asked.program, pathlib.Path(folder), restitution, step, young, kind)
                        rows.append([kind, restitution, young, step, f"{e:.4f}"])
                        worst = max(worst, abs(e - restitution))
                        print(*rows[-1], flush=True)
    with open(asked.output, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["against", "restitution", "young_pa", "dt_s", "bounce"])
        writer.writerows(rows)
    print(f"largest difference: {worst:.4f}")


if __name__ == "__main__":
    main()
