#!/usr/bin/env python3
"""Does anything pass through anything in scenes that are drawn?

Each scene has a floor with faces and two to five blocks, bars and plates of three meshes, with sizes, moduli,
densities, places, turns and spins that are drawn, thrown at a point above the floor. Speed times step is at most
BOUND thicknesses of the smallest body. Every few steps the vertices of each body are looked for inside the deformed
tetrahedra of all others and inside the floor, without the library. Writes one row a scene; ends with 1 where a
vertex is inside something or a touch was deeper than the thickness, and the run did not say so.

The Python module has to be built (PYTHONPATH=build/release/python), and numpy to be there.

SPDX-License-Identifier: Apache-2.0
"""

import argparse
import csv
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
import thrum

MESHES = {"block": "beam:2x2x2@0.1x0.1x0.1", "bar": "beam:4x1x1@0.2x0.05x0.05", "plate": "beam:4x4x1@0.2x0.2x0.04"}
BOUND = 10.0  # speed times step, in thicknesses
THICKNESS = 4e-3  # of a diagonal, the default of contact between bodies
STEPS = 200
LOOK = 10  # steps between two looks


def models_of(program, folder):
    """A model of each mesh."""
    made = {}
    for name, mesh in MESHES.items():
        path = folder / f"{name}.npz"
        subprocess.run([program, "precompute", mesh, "--modes", "6", "--rank", "10", "-q", "-o", str(path)], check=True,
                       capture_output=True)
        made[name] = thrum.Model.load(path)
    return made


def any_inside(points, vertices, tets):
    """How many points lie in one of the tetrahedra."""
    corner = vertices[tets[:, 0]]
    edges = np.stack([vertices[tets[:, k]] - corner for k in (1, 2, 3)], axis=2)
    inverse = np.linalg.inv(edges)
    shares = np.einsum("tij,ptj->pti", inverse, points[:, None, :] - corner[None, :, :])
    inside = (shares > 0).all(axis=2) & (shares.sum(axis=2) < 1)
    return int(inside.any(axis=1).sum())


def places_of(body):
    """The vertices of a body in the world."""
    return np.array([body.vertex(n)[0] for n in range(body.model.vertex_count)])


def draw(scene, models, random, dt):
    """Adds the bodies; returns the largest speed times the step over the least thickness."""
    count = int(random.integers(2, 6))
    chosen = [str(random.choice(list(MESHES))) for _ in range(count)]
    scales = random.uniform(0.5, 2.0, count)
    least = min(scale * np.linalg.norm(np.ptp(models[name].vertices, axis=0)) for name, scale in zip(chosen, scales))
    speed = min(BOUND * THICKNESS * least / dt, 20.0)
    for n in range(count):
        model = models[chosen[n]]
        size = scales[n] * np.linalg.norm(np.ptp(model.vertices, axis=0))
        angle = 2 * math.pi * n / count
        place = np.array([0.6 * math.cos(angle), 0.6 * math.sin(angle), 0.3 + size])
        turn = random.normal(size=4)
        way = np.array([0.0, 0.0, 0.3]) + 0.1 * random.normal(size=3) - place
        scene.add_body(model, triangles=model.outer_triangles(), free=True, scale=scales[n],
                       stiffness=10 ** random.uniform(0, 4), density=10 ** random.uniform(-0.5, 0.9), position=place,
                       rotation=turn / np.linalg.norm(turn), spin=random.uniform(-3, 3, 3),
                       velocity=0.5 * speed * random.uniform(0.2, 1) * way / np.linalg.norm(way))
    return speed * dt / (THICKNESS * least)


def run(seed, models):
    """One scene: its row."""
    random = np.random.default_rng(seed)
    dt = 10 ** random.uniform(math.log10(5e-4), math.log10(4e-3))
    inside = 0
    with thrum.Scene(dt=dt) as scene:
        scene.gravity = (0, 0, -9.81)
        scene.set_collisions(restitution=random.uniform(0, 1), friction=random.uniform(0, 1))
        scene.add_solid(shape="box", half=(3, 3, 0.5), position=(0, 0, -0.5))
        fast = draw(scene, models, random, dt)
        for _ in range(STEPS // LOOK):
            scene.step(LOOK)
            shapes = [places_of(body) for body in scene.bodies]
            for n, points in enumerate(shapes):
                inside += int((points[:, 2] < 0).sum())
                for m, vertices in enumerate(shapes):
                    if m != n:
                        inside += any_inside(points, vertices, scene.bodies[m].model.tets)
        report = scene.collisions
    return {"seed": seed, "bodies": len(shapes), "dt_s": f"{dt:.5f}", "speed_of_thickness": f"{fast:.2f}",
            "deepest_of_thickness": f"{report['deepest_share']:.3f}", "inside": inside, "redone": report["redone"],
            "declined": report["declined"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", default="build/release/thrum")
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0, help="seed of the first scene")
    parser.add_argument("-o", "--output", default="validation/results/pass_through.csv")
    asked = parser.parse_args()

    rows = []
    with tempfile.TemporaryDirectory() as folder, open(asked.output, "w", newline="", encoding="utf-8") as file:
        models = models_of(asked.program, pathlib.Path(folder))
        for seed in range(asked.first, asked.first + asked.count):
            rows.append(run(seed, models))
            writer = csv.DictWriter(file, rows[0], lineterminator="\n")
            if len(rows) == 1:
                writer.writeheader()
            writer.writerow(rows[-1])
            file.flush()
            if rows[-1]["inside"] or float(rows[-1]["deepest_of_thickness"]) >= 1:
                print(rows[-1], flush=True)

    deep = [row for row in rows if float(row["deepest_of_thickness"]) >= 1]
    silent = [row for row in rows if row["inside"] and row not in deep]
    print(f"{len(rows)} scenes: {len(deep)} deeper than the thickness, which runs say; {len(silent)} passed unsaid")
    return 1 if silent else 0


if __name__ == "__main__":
    sys.exit(main())
