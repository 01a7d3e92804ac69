#!/usr/bin/env python3
"""Draws the six models under load, the picture of the README.

usage: models.py THRUM OUTPUT.png

Each model is brought to rest under a load at its group `load` by `thrum static`, which is raised until the group has moved
by a share of the body's length. Colour is the displacement over the largest; gnuplot sorts the triangles by depth and draws
them. SPDX-License-Identifier: Apache-2.0
"""
import base64
import json
import math
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
from collections import Counter

# direction of the load, displacement over the length, the two angles of `set view` [degrees] and its scale
MODELS = {
    "horse": ((0, 1, 0), 0.15, 76, 150, 2.3), "tower": ((1, 0, 0), 0.18, 80, 28, 1.75),
    "bridge": ((0, 0, -1), 0.07, 70, 26, 2.2), "basket": ((1, 0, 0), 0.22, 68, 24, 1.9),
    "heart": ((1, 0, 0), 0.22, 80, 16, 1.9), "beam": ((0, 0, -1), 0.35, 72, 32, 2.05),
}
PALETTE = "0 '#4d80c7', 0.2 '#8ac4e6', 0.4 '#e6f2e6', 0.6 '#ffd98c', 0.8 '#f78c52', 1 '#cc2933'"
FORMATS = {"Float64": ("d", 8), "Int32": ("i", 4), "Int64": ("q", 8)}
# faces of a tetrahedron, each going round outwards, and where VTK has the middle node of an edge
FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
MIDDLES = {(0, 1): 4, (1, 2): 5, (0, 2): 6, (0, 3): 7, (1, 3): 8, (2, 3): 9}


def read_vtu(path):
    """The arrays of a .vtu that `thrum static --vtu` wrote: each in base64 after its size in 8 bytes."""
    arrays = {}
    for tag, text in re.findall(r'<DataArray ([^>]*format="binary")>\s*(.*?)\s*</DataArray>', path.read_text(), re.S):
        kind, name = re.search(r'type="(\w+)" Name="(\w+)"', tag).groups()
        if kind in FORMATS:
            letter, width = FORMATS[kind]
            array = base64.b64decode(text)
            arrays[name] = struct.unpack_from(f"<{(len(array) - 8) // width}{letter}", array, 8)
    return arrays


def bend(thrum, name, folder):
    """Points at rest, displacements and tetrahedra of a model under the load that bends it that far."""
    direction, share = MODELS[name][:2]
    path, factor = folder / f"{name}.vtu", 1.0
    for _ in range(6):
        load = "constant:" + ",".join(f"{factor * d:.6g}" for d in direction) + "@load"
        run = subprocess.run([thrum, "static", name, "--load", load, "--vtu", path, "--json", "-q"], capture_output=True,
                             text=True, check=False)
        assert run.returncode in (0, 3), run.stderr
        arrays = read_vtu(path)
        points = [arrays["Points"][n:n + 3] for n in range(0, len(arrays["Points"]), 3)]
        length = max(max(axis) - min(axis) for axis in zip(*points))
        moved = math.hypot(*json.loads(run.stdout)["displacements"][0]["mean_m"]) / length
        # the first load is 1 N: far from there the answer is not linear, so the way is taken in bounded steps
        factor *= min(share / moved, 1e9)
    moves = [arrays["displacement"][n:n + 3] for n in range(0, len(arrays["displacement"]), 3)]
    nodes = arrays["offsets"][0]  # four or ten, in all cells
    tets = [arrays["connectivity"][n:n + nodes] for n in range(0, len(arrays["connectivity"]), nodes)]
    return points, moves, tets


def triangles(tet, face):
    """A face of a tetrahedron, in four triangles where its edges have middle nodes."""
    a, b, c = (tet[n] for n in face)
    if len(tet) == 4:
        return [(a, b, c)]
    ab, bc, ca = (tet[MIDDLES[tuple(sorted((face[n], face[(n + 1) % 3])))]] for n in range(3))
    return [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]


def surface(tets):
    """The triangles of the faces that belong to one tetrahedron only, each going round outwards."""
    count = Counter(tuple(sorted(tet[n] for n in face)) for tet in tets for face in FACES)
    return [triangle for tet in tets for face in FACES if count[tuple(sorted(tet[n] for n in face))] == 1
            for triangle in triangles(tet, face)]


def quads(points, values, faces):
    """gnuplot's surfaces with a value at each point: each face as two lines, the second from its third corner to the middle
    of its second side."""
    lines = []
    for a, b, c in faces:
        middle = [0.5 * (x + y) for x, y in zip(points[b], points[c])]
        corners = [(points[a], values[a]), (points[b], values[b]), (points[c], values[c]),
                   (middle, 0.5 * (values[b] + values[c]))]
        rows = [f"{x:.6g} {y:.6g} {z:.6g} {value:.9g}\n" for (x, y, z), value in corners]
        lines.append(rows[0] + rows[1] + "\n" + rows[2] + rows[3] + "\n\n")
    return "".join(lines)


def draw_model(thrum, name, place, folder):
    """Writes the data of one model and returns the script that draws it: grey at rest, and coloured as it is moved."""
    points, moves, tets = bend(thrum, name, folder)
    moved = [[x + u for x, u in zip(p, m)] for p, m in zip(points, moves)]
    sizes, faces = [math.hypot(*move) for move in moves], surface(tets)
    (folder / f"{name}.rest").write_text(quads(points, [0xECECEC] * len(points), faces))
    (folder / f"{name}.moved").write_text(quads(moved, [size / max(sizes) for size in sizes], faces))

    # one cube around both shapes, so that both are seen at the same scale
    low = [min(axis) for axis in zip(*points, *moved)]
    high = [max(axis) for axis in zip(*points, *moved)]
    half = 0.5 * max(h - l for l, h in zip(low, high))
    ranges = [f"set {axis}range [{0.5 * (l + h) - half:.6g}:{0.5 * (l + h) + half:.6g}]\n"
              for axis, l, h in zip("xyz", low, high)]
    tilt, turn, scale = MODELS[name][2:]
    column, row = place % 3, place // 3
    return (f"set origin {column}/3.0,{0.54 - row * 0.46}\nset size 1/3.0,0.46\nset view {tilt},{turn},{scale}\n" +
            "".join(ranges) + "set pm3d depthorder nolighting\n"
            f"splot '{folder}/{name}.rest' using 1:2:3:4 with pm3d fc rgb variable\n"
            "set pm3d depthorder lighting primary 0.45 specular 0.1\n"
            f"set label 1 '{name}' at screen {(column + 0.5) / 3},{0.545 - row * 0.46} center\n"
            f"splot '{folder}/{name}.moved' using 1:2:3:4 with pm3d\nunset label 1\n")


def main(thrum, output):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        script = (f"set encoding utf8\nset terminal pngcairo size 1260,830 font 'DejaVu Sans,13'\nset output '{folder}/all.png'\n"
                  f"set multiplot\nunset key\nunset border\nunset tics\nset palette defined ({PALETTE})\nset cbrange [0:1]\n"
                  "set view equal xyz\nset pm3d corners2color mean\nunset colorbox\n")
        script += "".join(draw_model(thrum, model, place, folder) for place, model in enumerate(MODELS))
        # the scale of the colours is drawn with a plot of nothing
        script += ("set origin 0,0\nset size 1,0.08\nset label 1 'at rest' at screen 0.361,0.04 right\n"
                   "set label 2 'largest displacement' at screen 0.639,0.04 left\n"
                   "set colorbox horizontal user origin screen 0.373,0.03 size screen 0.254,0.02\nset format cb ''\n"
                   "set xrange [0:1]\nset yrange [0:1]\nplot NaN with points palette\nunset multiplot\n")
        subprocess.run(["gnuplot", "-d"], input=script, text=True, check=True)
        shutil.move(folder / "all.png", output)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2])
