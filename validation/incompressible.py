#!/usr/bin/env python3
"""How far a cantilever bends near incompressibility: each law, linear and ten-node tetrahedra, against a finer mesh.

usage: validation/incompressible.py THRUM OUTPUT.csv

A beam of 1 x 0.2 x 0.2 m (E = 1 MPa), clamped at one end, hangs under half of its weight: the equilibrium of the unreduced
mesh (`thrum static --full`). A row of OUTPUT.csv (validation/results/incompressible.csv) has the law, Poisson's ratio, the order of
the tetrahedra, the mesh, the sag of the free end, and by how much it is short of that of the finest mesh of ten nodes, which errs
too. It takes some minutes on one core. SPDX-License-Identifier: Apache-2.0
"""
import csv
import json
import subprocess
import sys

LAWS = ("stvk", "corotational", "neo-hookean")
RATIOS = (0.3, 0.49, 0.499)
FINEST = (2, "16x4x4")
MESHES = ((1, "8x2x2"), (1, "16x4x4"), (2, "8x2x2"), FINEST)


def sag(thrum, law, ratio, order, mesh):
    """The mean displacement of the free end against z [m]."""
    run = subprocess.run(
        [thrum, "static", f"beam:{mesh}@1x0.2x0.2", "--full", "--law", law, "--order", str(order), "--fix", "x<0.001",
         "--young", "1e6", "--poisson", str(ratio), "--density", "1000", "--load", "gravity:0,0,-5",
         "--at", "right", "--json", "--quiet"],
        capture_output=True, text=True, check=True)
    return -json.loads(run.stdout)["displacements"][0]["mean_m"][2]


def main():
    thrum, output = sys.argv[1:3]
    with open(output, "w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["law", "poisson", "order", "mesh", "sag_m", "short_percent"])
        for law in LAWS:
            for ratio in RATIOS:
                sags = {kind: sag(thrum, law, ratio, *kind) for kind in MESHES}
                for (order, mesh), found in sags.items():
                    table.writerow([law, ratio, order, mesh, f"{found:.6g}", f"{100 * (1 - found / sags[FINEST]):.3g}"])
                file.flush()


if __name__ == "__main__":
    main()
