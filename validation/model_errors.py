#!/usr/bin/env python3
"""How far the first five frequencies of the six models are from those of their shapes, and what exact ones cost.

usage: model_errors.py THRUM OUTPUT.csv [MODEL...]

The shape of a model is the polyhedron that its committed mesh fills. Each tetrahedron of that mesh is cut into c³, so that its
edges have 1/c of their length, and the frequencies of linear and of ten-node tetrahedra are computed for several c. Those of
the shape are extrapolated from ten-node tetrahedra at c = 1, 2 and 3 (Richardson): f(c) = f + a c^-p, with p between 1 and 4.
A row is a mesh: its frequencies, their errors, and, for the models of the plot, the processor time of the stages of `thrum
precompute` on one thread, with the modes and the rank of the model; 0 where only the frequencies were computed. The row of order 0
is the limit. Rows of other models in OUTPUT.csv stay. SPDX-License-Identifier: Apache-2.0
"""
import csv
import itertools
import json
import os
import pathlib
import subprocess
import sys
import tempfile

MODELS = pathlib.Path(__file__).resolve().parent.parent / "models"
NAMES = ["beam", "basket", "bridge", "horse", "tower", "heart"]
COUNT = 5  # frequencies
# cuts c of an edge by the order of the elements; more for the models of the plot
CUTS = {1: [1, 2, 3], 2: [1, 2, 3]}
MORE_CUTS = {"beam": {1: [1, 2, 3, 4, 5, 6, 8], 2: [1, 2, 3]}, "horse": {1: [1, 2, 3, 4], 2: [1, 2, 3]}}
HEAD = ["model", "order", "cuts", "tets", "vertices", "seconds", *(f"f{i}" for i in range(1, COUNT + 1)),
        *(f"error{i}" for i in range(1, COUNT + 1)), "largest"]


def read_mesh(path):
    """Vertices, tetrahedra, and the triangles of the group `fixed` of a mesh in Gmsh 2.2 with all nodes numbered from 1."""
    lines = iter(path.read_text().split("\n"))
    fixed, points, tets, held = None, [], [], []
    for line in lines:
        if line == "$PhysicalNames":
            for _ in range(int(next(lines))):
                _, tag, name = next(lines).split()
                fixed = int(tag) if name == '"fixed"' else fixed
        elif line == "$Nodes":
            points = [tuple(map(float, next(lines).split()[1:])) for _ in range(int(next(lines)))]
        elif line == "$Elements":
            for _ in range(int(next(lines))):
                words = list(map(int, next(lines).split()))
                nodes = [n - 1 for n in words[3 + words[2]:]]
                if words[1] == 4:
                    tets.append(nodes)
                elif words[1] == 2 and words[3] == fixed:
                    held.append(nodes)
    return points, tets, held


def pieces(cuts):
    """The c³ tetrahedra of the simplex c >= x >= y >= z >= 0 (Freudenthal): corners in whole coordinates."""
    found = []
    for corner in itertools.product(range(cuts), repeat=3):
        for path in itertools.permutations(range(3)):
            at, tet = list(corner), [corner]
            for axis in path:
                at[axis] += 1
                tet.append(tuple(at))
            if all(cuts >= x >= y >= z >= 0 for x, y, z in tet):
                found.append(tet)
    assert len(found) == cuts ** 3
    return found


def cut(points, tets, held, cuts):
    """The mesh with each edge cut into equal parts: points, tets, and the points on held triangles."""
    made, order, new, kept = {}, [], [], set()
    triangles = {frozenset(t) for t in held}
    corners_held = {v for t in held for v in t}
    for tet in tets:
        # in the order of their numbers, which neighbours share
        a = sorted(tet)
        on_held = [t for t in map(frozenset, itertools.combinations(a, 3)) if t in triangles]
        for piece in pieces(cuts):
            nodes = []
            for x, y, z in piece:
                # shares of the four corners in a point, which name it
                name = tuple((v, s) for v, s in zip(a, (cuts - x, x - y, y - z, z)) if s)
                if name not in made:
                    made[name] = len(order)
                    order.append(name)
                carrier = {v for v, _ in name}
                if (len(name) == 1 and name[0][0] in corners_held) or any(carrier <= t for t in on_held):
                    kept.add(made[name])
                nodes.append(made[name])
            new.append(nodes)
    places = [tuple(sum(points[v][axis] * s for v, s in name) / cuts for axis in range(3)) for name in order]
    return places, new, sorted(kept)


def write_mesh(path, points, tets, kept, material):
    """A mesh for VegaFEM with its material, and beside it a list of its held vertices, from 1."""
    with open(path, "w", encoding="ascii") as file:
        file.write(f"*VERTICES\n{len(points)} 3 0 0\n")
        file.writelines(f"{i} {x!r} {y!r} {z!r}\n" for i, (x, y, z) in enumerate(points, 1))
        file.write(f"\n*ELEMENTS\nTET\n{len(tets)} 4 0\n")
        file.writelines(f"{i} {' '.join(str(v + 1) for v in t)}\n" for i, t in enumerate(tets, 1))
        file.write("\n*MATERIAL BODY\nENU, {density}, {young}, {poisson}\n\n*REGION\nallElements, BODY\n".format(**material))
    path.with_suffix(".bou").write_text(", ".join(str(v + 1) for v in kept) + "\n")


def run(thrum, mesh, order, modes, rank):
    command = [thrum, "precompute", mesh, "--fix", mesh.with_suffix(".bou"), "--order", order, "--modes", modes,
               "--rank", rank, "--threads", 1, "--json", "-q", "-o", mesh.with_suffix(".npz")]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)
    assert done.returncode in (0, 3), done.stderr
    return json.loads(done.stdout)


def limit(f1, f2, f3):
    """What f(c) tends to for c to infinity, from c = 1, 2 and 3."""
    def quotient(p):
        return (1 - 2 ** -p) / (2 ** -p - 3 ** -p)
    low, high = 1.0, 4.0
    wanted = (f1 - f2) / (f2 - f3) if f2 != f3 else quotient(high)
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if quotient(middle) < wanted else (low, middle)
    return f3 - (f2 - f3) * 3 ** -low / (2 ** -low - 3 ** -low)


def measure(thrum, name, folder):
    recipe = json.loads((MODELS / f"{name}.json").read_text())
    mesh = read_mesh(MODELS / recipe["mesh"])
    rows, meshes = [], {}
    plan = MORE_CUTS.get(name, CUTS)
    for order in (2, 1):
        for cuts in plan[order]:
            if cuts not in meshes:
                meshes[cuts] = folder / f"{name}{cuts}.veg"
                write_mesh(meshes[cuts], *cut(*mesh, cuts), recipe["material"])
            timed = name in MORE_CUTS and (order == 1 or cuts < 3)
            found = run(thrum, meshes[cuts], order, recipe["modes"] if timed else COUNT,
                        recipe["rank"] if timed else COUNT)
            seconds = sum(stage["cpu_seconds"] for stage in found["stages"].values()) if timed else 0
            rows.append([name, order, cuts, found["tets"], found["vertices"], seconds, found["frequencies_hz"][:COUNT]])
            print(*rows[-1], file=sys.stderr, flush=True)

    # errors against the limit of ten-node tetrahedra
    at = {row[2]: row[6] for row in rows if row[1] == 2}
    exact = [limit(at[1][i], at[2][i], at[3][i]) for i in range(COUNT)]
    for row in rows:
        errors = [f / e - 1 for f, e in zip(row[6], exact)]
        row[5:] = [f"{row[5]:.4g}", *(f"{f:.7g}" for f in row[6]), *(f"{e:.3g}" for e in errors),
                   f"{max(map(abs, errors)):.3g}"]
    return [[name, 0, 0, 0, 0, 0, *(f"{f:.7g}" for f in exact), *[0] * COUNT, 0], *sorted(rows, key=lambda r: r[1:3])]


def main():
    thrum, output, names = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]), sys.argv[3:] or NAMES
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    kept = []
    if output.exists():
        with open(output, newline="", encoding="utf-8") as file:
            kept = [list(row.values()) for row in csv.DictReader(file)]
    for name in names:
        with tempfile.TemporaryDirectory() as folder:
            rows = measure(thrum, name, pathlib.Path(folder))
        kept = [row for row in kept if row[0] != name] + rows
        kept.sort(key=lambda row: NAMES.index(row[0]))
        with open(output, "w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows([HEAD, *kept])


if __name__ == "__main__":
    main()
