#!/usr/bin/env python3
"""Published problems of thin shells, solved with solid-shell hexahedra, one over the thickness.

usage: validation/shells.py THRUM OUTPUT.csv [--ccx PROGRAM] [--only NAME] [--quick]

Each mesh is a deck with its nodes on the normals of the exact surface, and each answer the equilibrium of the unreduced mesh
(`thrum static --full`); of linear problems the load is a thousandth, and the answer is scaled. A row of OUTPUT.csv
(validation/results/shells.csv) has the problem, the quantity, the mesh, the answer, the published one and the difference in per
cent, and of linear problems that of CalculiX's C3D8I on the same deck. It takes some minutes on one core.

Published: Scordelis-Lo roof and pinched hemisphere with an 18 degree hole: MacNeal & Harder 1985, Finite Elements in Analysis and Design 1,
3-20. Pinched cylinder with diaphragms: Belytschko, Stolarski, Liu, Carpenter & Ong 1985, Computer Methods in Applied Mechanics and
Engineering 51, 221-258. Cantilever under shear, slit annular plate and hemisphere under large
loads: Sze, Liu & Lo 2004, Finite Elements in Analysis and Design 40, 1551-1569. Cantilever under an end moment: a circle.
SPDX-License-Identifier: Apache-2.0
"""
import csv
import json
import math
import os
import subprocess
import sys
import tempfile

SMALL = 1e-3  # of the load of a linear problem


class Deck:
    """A grid of hexahedra over u, v in 0 to 1; `surface` gives a point of the middle surface and its unit normal."""

    def __init__(self, nu, nv, thickness, surface):
        self.nu, self.nv, self.points = nu, nv, []
        for k in range(2):
            for j in range(nv + 1):
                for i in range(nu + 1):
                    point, normal = surface(i / nu, j / nv)
                    self.points.append([p + (k - 0.5) * thickness * n for p, n in zip(point, normal)])
        self.sets = {}

    def node(self, i, j, k):
        return (k * (self.nv + 1) + j) * (self.nu + 1) + i + 1

    def group(self, name, where, levels=(0, 1)):
        """The nodes whose i and j satisfy `where`."""
        self.sets[name] = [self.node(i, j, k) for k in levels for j in range(self.nv + 1) for i in range(self.nu + 1)
                           if where(i, j)]

    def text(self, material):
        lines = ["*NODE"] + [f"{n + 1}, " + ", ".join(f"{x:.13g}" for x in p) for n, p in enumerate(self.points)]
        lines.append("*ELEMENT, TYPE=C3D8I, ELSET=ALL")
        for j in range(self.nv):
            for i in range(self.nu):
                corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
                nodes = [self.node(a, b, k) for k in range(2) for a, b in corners]
                lines.append(", ".join(str(n) for n in [j * self.nu + i + 1] + nodes))
        for name, members in self.sets.items():
            lines.append(f"*NSET, NSET={name}")
            lines += [", ".join(str(n) for n in members[at:at + 8]) for at in range(0, len(members), 8)]
        young, poisson, density = material
        lines += ["*MATERIAL, NAME=M", "*ELASTIC", f"{young}, {poisson}", "*DENSITY", f"{density},",
                  "*SOLID SECTION, ELSET=ALL, MATERIAL=M"]
        return "\n".join(lines) + "\n"


def run_thrum(thrum, deck, problem, factor):
    command = [thrum, "static", deck, "--full", "--unit", "m-kg-s", "--json", "--quiet", "--monitor", "off"]
    for fix in problem["fix"]:
        command += ["--fix", fix]
    for kind, load in problem["loads"]:
        name, _, at = load.partition("@")
        numbers = ",".join(repr(float(x) * factor) for x in name.split(","))
        command += ["--" + kind, numbers + "@" + at] if kind == "moment" else \
            ["--load", kind + ":" + numbers + ("@" + at if at else "")]
    for _, at, _, _ in problem["answers"]:
        command += ["--at", at]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    if not run.stdout:
        raise SystemExit(run.stderr)
    found = json.loads(run.stdout)["displacements"][-len(problem["answers"]):]
    return [shown["mean_m"][axis] / factor if factor != 1 else shown["mean_m"][axis]
            for shown, (_, _, axis, _) in zip(found, problem["answers"])]


def run_ccx(ccx, folder, deck, problem):
    """The same by CalculiX, linear."""
    lines = ["*BOUNDARY"]
    axes = "xyz"
    for fix in problem["fix"]:
        name, _, held = fix.partition(":")
        lines += [f"{name}, {axes.index(a) + 1}, {axes.index(a) + 1}" for a in held or axes]
    lines += ["*STEP", "*STATIC"]
    for kind, load in problem["loads"]:
        name, _, at = load.partition("@")
        vector = [float(x) for x in name.split(",")]
        size = math.sqrt(sum(x * x for x in vector))
        if kind == "gravity":
            lines += ["*DLOAD", f"ALL, GRAV, {size:.10g}, " + ", ".join(f"{x / size:.10g}" for x in vector)]
        else:
            share = len(deck.sets[at])
            lines += ["*CLOAD"] + [f"{at}, {a + 1}, {x / share:.10g}" for a, x in enumerate(vector) if x]
    for _, at, _, _ in problem["answers"]:
        lines += [f"*NODE PRINT, NSET={at}", "U"]
    lines.append("*END STEP")
    with open(os.path.join(folder, "c.inp"), "w", encoding="utf-8") as file:
        file.write(deck.text(problem["material"]) + "\n".join(lines) + "\n")
    subprocess.run([ccx, "-i", "c"], cwd=folder, capture_output=True, check=False, env=dict(os.environ, OMP_NUM_THREADS="1"))
    blocks = []
    with open(os.path.join(folder, "c.dat"), encoding="utf-8") as file:
        for line in file:
            words = line.split()
            if "displacements" in line:
                blocks.append([])
            elif len(words) == 4 and words[0].isdigit():
                blocks[-1].append([float(w) for w in words[1:]])
    return [sum(u[axis] for u in block) / len(block) for block, (_, _, axis, _) in zip(blocks, problem["answers"])]


def roof(n):
    """Scordelis-Lo: a quarter, R = 25, L = 50, 40 degrees, on rigid diaphragms, 90 a unit of area."""
    def surface(u, v):
        a = math.radians(40 * u)
        return (25 * math.sin(a), 25 * v, 25 * math.cos(a)), (math.sin(a), 0, math.cos(a))
    deck = Deck(n, n, 0.25, surface)
    deck.group("END", lambda i, j: j == 0)
    deck.group("MID", lambda i, j: j == n)
    deck.group("CROWN", lambda i, j: i == 0)
    deck.group("A", lambda i, j: i == n and j == n)
    return deck, {"material": (4.32e8, 0.0, 36.0), "fix": ["END:xz", "MID:y", "CROWN:x"],
                  "loads": [("gravity", "0,0,-10")], "answers": [("sag of the free edge", "A", 2, -0.3024)]}


def cylinder(n):
    """Pinched cylinder: an eighth, R = 300, L = 600, t = 3, rigid diaphragms, force 1."""
    def surface(u, v):
        a = math.pi / 2 * u
        return (300 * math.sin(a), 300 * v, 300 * math.cos(a)), (math.sin(a), 0, math.cos(a))
    deck = Deck(n, n, 3, surface)
    deck.group("END", lambda i, j: j == n)
    deck.group("MID", lambda i, j: j == 0)
    deck.group("CROWN", lambda i, j: i == 0)
    deck.group("SIDE", lambda i, j: i == n)
    deck.group("A", lambda i, j: i == 0 and j == 0)
    return deck, {"material": (3e6, 0.3, 1.0), "fix": ["END:xz", "MID:y", "CROWN:x", "SIDE:z"],
                  "loads": [("constant", "0,0,-0.25@A")], "answers": [("under the force", "A", 2, -1.8248e-5)]}


def hemisphere_deck(n):
    def surface(u, v):
        a, b = math.pi / 2 * u, math.radians(72) * v
        normal = (math.cos(b) * math.cos(a), math.cos(b) * math.sin(a), math.sin(b))
        return tuple(10 * x for x in normal), normal
    deck = Deck(n, n, 0.04, surface)
    deck.group("XZ", lambda i, j: i == 0)
    deck.group("YZ", lambda i, j: i == n)
    deck.group("A", lambda i, j: i == 0 and j == 0)
    deck.group("B", lambda i, j: i == n and j == 0)
    deck.group("HELD", lambda i, j: i == n // 2 and j == 0, levels=(0,))
    return deck


def hemisphere(n, force=2.0, answers=((0.094, 0.094))):
    """Pinched hemisphere with a hole of 18 degrees: a quarter, R = 10, t = 0.04."""
    half = force / 2
    return hemisphere_deck(n), {
        "material": (6.825e7, 0.3, 1.0), "fix": ["XZ:y", "YZ:x", "HELD:z"],
        "loads": [("constant", f"{half},0,0@A"), ("constant", f"0,{-half},0@B")],
        "answers": [("outward", "A", 0, answers[0]), ("inward", "B", 1, -answers[1])]}


def large_hemisphere(n):
    return hemisphere(n, 400.0, (4.067, 8.178))


def strip(n, length):
    deck = Deck(n, 1, 0.1, lambda u, v: ((length * u, v - 0.5, 0), (0, 0, 1)))
    deck.group("ROOT", lambda i, j: i == 0)
    deck.group("A", lambda i, j: i == n)
    return deck


def cantilever(n):
    """Sze, Liu & Lo: 10 x 1 x 0.1 under an end shear of 4."""
    return strip(n, 10), {"material": (1.2e6, 0.0, 1.0), "fix": ["ROOT"], "loads": [("constant", "0,0,4@A")],
                          "answers": [("across", "A", 2, 6.698), ("along", "A", 0, -3.286)]}


def circle(n):
    """Sze, Liu & Lo: 12 x 1 x 0.1 under an end moment that closes it to a circle, in ten steps of their load."""
    moment = 2 * math.pi * 1.2e6 * 0.1**3 / 12 / 12
    return strip(n, 12), {"material": (1.2e6, 0.0, 1.0), "fix": ["ROOT"], "loads": [("moment", f"0,{-moment},0@A")],
                          "answers": [("along", "A", 0, -12.0)]}


def annulus(n):
    """Sze, Liu & Lo: a slit annular plate, radii 6 and 10, t = 0.03, one end held, 0.8 a length lifts the other."""
    across = max(n // 8, 2)

    def surface(u, v):
        a, r = 2 * math.pi * u, 6 + 4 * v
        return (r * math.cos(a), r * math.sin(a), 0), (0, 0, 1)
    deck = Deck(n, across, 0.03, surface)
    # the normals point up where the grid goes round clockwise
    deck.points = [[p[0], -p[1], p[2]] for p in deck.points]
    deck.group("ROOT", lambda i, j: i == 0)
    deck.group("INNER", lambda i, j: i == n and 0 < j < across)
    deck.group("OUTER", lambda i, j: i == n and j in (0, across))
    deck.group("A", lambda i, j: i == n and j == 0)
    deck.group("B", lambda i, j: i == n and j == across)
    total = 0.8 * 4
    return deck, {"material": (21e6, 0.0, 1.0), "fix": ["ROOT"],
                  "loads": [("constant", f"0,0,{total * (across - 1) / across}@INNER"),
                            ("constant", f"0,0,{total / across}@OUTER")],
                  "answers": [("inner corner", "A", 2, 13.891), ("outer corner", "B", 2, 17.528)]}


PROBLEMS = {  # name: (makes it, meshes, linear)
    "Scordelis-Lo roof": (roof, (4, 8, 16), True),
    "pinched cylinder": (cylinder, (8, 16, 32), True),
    "pinched hemisphere": (hemisphere, (8, 16, 32), True),
    "cantilever, end shear": (cantilever, (8, 16, 32), False),
    "cantilever, end moment": (circle, (16, 32, 64), False),
    "slit annular plate": (annulus, (32, 64, 96), False),
    "hemisphere, large load": (large_hemisphere, (16, 24, 32), False),
}


def main():
    thrum, output = sys.argv[1:3]
    options = sys.argv[3:]
    ccx = options[options.index("--ccx") + 1] if "--ccx" in options else None
    only = options[options.index("--only") + 1] if "--only" in options else None
    with open(output, "w", newline="", encoding="utf-8") as file, tempfile.TemporaryDirectory() as folder:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["problem", "quantity", "mesh", "elements", "answer", "published", "error_percent",
                        "calculix_error_percent"])
        for name, (make, meshes, linear) in PROBLEMS.items():
            for n in meshes[:1] if "--quick" in options else meshes:
                if only not in (None, name):
                    continue
                deck, problem = make(n)
                path = os.path.join(folder, "deck.inp")
                with open(path, "w", encoding="utf-8") as written:
                    written.write(deck.text(problem["material"]))
                found = run_thrum(thrum, path, problem, SMALL if linear else 1)
                other = run_ccx(ccx, folder, deck, problem) if ccx and linear else [None] * len(found)
                for (quantity, _, _, published), answer, theirs in zip(problem["answers"], found, other):
                    table.writerow([name, quantity, f"{deck.nu}x{deck.nv}", deck.nu * deck.nv, f"{answer:.6g}", published,
                                    f"{100 * (answer / published - 1):.3g}",
                                    "" if theirs is None else f"{100 * (theirs / published - 1):.3g}"])
                file.flush()


if __name__ == "__main__":
    main()
