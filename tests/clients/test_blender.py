#!/usr/bin/env python3
"""A bake in Blender without a display: as many frames as the run has rows, each where the run has it, one rendered.

usage: test_blender.py SOURCE PROGRAM     SPDX-License-Identifier: Apache-2.0
"""
import os
import re
import struct
import subprocess
import sys
import tempfile

import numpy as np


def obj_vertices(path):
    with open(path, encoding="utf-8") as file:
        return np.array([line.split()[1:4] for line in file if line.startswith("v ")], dtype=float)


def mdd_rows(path):
    data = open(path, "rb").read()
    frames, vertices = struct.unpack(">2i", data[:8])
    return np.frombuffer(data, ">f4", offset=8 + 4 * frames).reshape(frames, vertices, 3)


def main():
    source, program = (os.path.abspath(argument) for argument in sys.argv[1:3])
    with tempfile.TemporaryDirectory() as work:
        os.chdir(work)
        subprocess.run([program, "simulate", "beam", "-o", "run", "--time", "1", "--load", "impulse:0,0,-1480@load", "-q"],
                       check=True, stdout=subprocess.DEVNULL)
        subprocess.run([program, "export", "run", "--obj", "body.obj", "--mdd", "body.mdd", "--fps", "24"], check=True,
                       stdout=subprocess.DEVNULL)
        said = subprocess.run(["blender", "--background", "--factory-startup", "--python-exit-code", "7", "--python",
                               os.path.join(source, "examples/blender/bind_bake.py"), "--", "body.obj", "body.mdd", "--check",
                               "--render", "12", "frame.png"], check=True, capture_output=True, text=True).stdout

        # frames and vertices, then the same vertex in each frame as the cache and Blender have it
        rest, rows = obj_vertices("body.obj"), mdd_rows("body.mdd")
        found = re.search(r"^frames (\d+) vertices (\d+) vertex (\d+)$", said, re.M)
        frames, vertices, number = (int(text) for text in found.groups())
        assert (frames, vertices) == rows.shape[:2] and vertices == len(rest), (frames, vertices, rows.shape)
        moved = 0.0
        for line in re.findall(r"^frame (.*)$", said, re.M):
            frame, *place = line.split()
            place = np.array(place, dtype=float)
            assert np.allclose(place, rows[int(frame) - 1, number], atol=1e-5), (frame, place, rows[int(frame) - 1, number])
            moved = max(moved, np.linalg.norm(place - rest[number]))
        assert moved > 0.01, moved
        assert os.path.getsize("frame.png") > 20000
        print(f"{frames} frames of {vertices} vertices, vertex {number} moved by up to {moved:.4g} m; frame 12 is rendered")


if __name__ == "__main__":
    main()
