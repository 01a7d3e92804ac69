#!/usr/bin/env python3
"""Compares Thrum with CalculiX, a finite-element program by others, on the same meshes.

Each body is written by `thrum convert` as an .inp file, which both programs read. Compared are the equilibrium under a
large load, the lowest natural frequencies, and a free vibration of large amplitude, stepped by Newmark's method at the
same time step. Under NLGEOM, CalculiX takes *ELASTIC as a linear law between the second Piola-Kirchhoff stress and the
Green strain: the Saint Venant-Kirchhoff material. The script checks that too, on single elements whose forces follow
from a few lines of numpy.

CalculiX integrates the forces of ten-node tetrahedra at four points, which is exact for small strains alone. Thrum does
the same with `--quadrature four`; what its exact integration changes is a row of its own.

usage: compare.py THRUM FOLDER [--quick]     (needs numpy and ccx)

FOLDER gets calculix.csv and calculix.about.json; without it (-) nothing is written. --quick takes one small body,
--body NAME one of the others, whose rows then replace those that are there. All of it takes half an hour on one core.
Exits with 1 when a difference is larger than its bound.
SPDX-License-Identifier: Apache-2.0
"""
import argparse
import base64
import json
import os
import platform
import re
import struct
import subprocess
import sys
import tempfile

import numpy as np

MODELS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "models")

# mesh, what is held, Young's modulus, Poisson's ratio, load (total force, group)
BODIES = {
    "small beam": ("beam:6x2x2@1x0.15x0.15", "x<0.001", 5e6, 0.4, ((0, 0, -40), "tip")),
    "beam": ("beam.msh", "fixed", 3e6, 0.4, ((0, 0, -33), "load")),
    "horse": ("horse.msh", "fixed", 8.5e7, 0.4, ((0, 4000, 0), "load")),
    # under twice this load struts of ten nodes buckle, and the two programs find different ones
    "tower": ("tower.msh", "fixed", 1.5e7, 0.4, ((1000, 0, 0), "load")),
}
DENSITY = 1000.0
FREQUENCIES = 10
STEP, STEPS = 0.003, 100

# residuals and corrections at which CalculiX ends its iterations, far below what it prints
TIGHT = "*CONTROLS,PARAMETERS=FIELD\n1e-10,1e-10,,,1e-10,,,\n*CONTROLS,PARAMETERS=TIME INCREMENTATION\n50,60,,200,60,,,10\n"


def refuse(line):
    sys.exit("compare.py: " + line)


# --- the two programs ------------------------------------------------------------------------------------------------


def thrum(program, *arguments):
    done = subprocess.run([program, *arguments], capture_output=True, text=True)
    if done.returncode not in (0, 3):
        refuse("%s\nthrum %s" % (done.stderr.strip(), " ".join(arguments)))
    return done.stdout


def calculix(name, deck):
    """Runs a deck; the blocks of its .dat file, each a list of rows of numbers, behind their titles."""
    with open(name + ".inp", "w") as file:
        file.write(deck)
    for suffix in (".dat", ".sta"):
        if os.path.exists(name + suffix):
            os.remove(name + suffix)
    done = subprocess.run(["ccx", name], capture_output=True, text=True)
    if done.returncode != 0 or "*ERROR" in done.stdout or not os.path.exists(name + ".dat"):
        refuse("ccx failed on %s:\n%s" % (name, done.stdout[-2000:]))

    blocks = []
    with open(name + ".dat") as file:
        for line in file:
            try:
                blocks[-1][1].append([float(word) for word in line.split()] if line.strip() else None)
            except (ValueError, IndexError):
                blocks.append((line.strip(), []))
    return [(title, np.array([row for row in rows if row])) for title, rows in blocks if any(rows)]


def number(value):
    """CalculiX, as Abaqus, reads twenty characters of a number."""
    return "%.12e" % value


def vtu_points(path, name):
    """A point vector of a .vtu file as Thrum writes it."""
    with open(path, encoding="utf-8") as file:
        text = re.search(r'type="Float64" Name="%s"[^>]*format="binary">\s*([^<\s]*)' % name, file.read()).group(1)
    data = base64.b64decode(text)
    (size,) = struct.unpack_from("<Q", data)
    return np.frombuffer(data, "<f8", size // 8, 8).reshape(-1, 3)


# --- Saint Venant-Kirchhoff on one element ---------------------------------------------------------------------------

EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]


def four_points():
    near, far = (5 + 3 * 5**0.5) / 20, (5 - 5**0.5) / 20
    return [(np.where(np.arange(4) == n, near, far), 0.25) for n in range(4)]


def many_points():
    """Gauss's rule on the cube, collapsed to the tetrahedron: exact far beyond degree 4."""
    place, weight = np.polynomial.legendre.leggauss(6)
    place, weight = (place + 1) / 2, weight / 2
    rule = []
    for i in range(6):
        for j in range(6):
            for k in range(6):
                r = place[i]
                s = place[j] * (1 - r)
                t = place[k] * (1 - r - s)
                scale = 6 * weight[i] * weight[j] * weight[k] * (1 - r) * (1 - r - s)
                rule.append((np.array([1 - r - s - t, r, s, t]), scale))
    return rule


def shape(nodes, place):
    """The shape functions."""
    if nodes == 4:
        return place
    return np.concatenate([place * (2 * place - 1), [4 * place[a] * place[b] for a, b in EDGES]])


def slopes(nodes, place):
    """Derivatives of the shape functions by l_1, l_2, l_3."""
    by_place = np.zeros((nodes, 4))
    if nodes == 4:
        by_place = np.eye(4)
    else:
        for corner in range(4):
            by_place[corner, corner] = 4 * place[corner] - 1
        for edge, (a, b) in enumerate(EDGES):
            by_place[4 + edge, a], by_place[4 + edge, b] = 4 * place[b], 4 * place[a]
    return by_place[:, 1:] - by_place[:, :1]


def element_forces(places, u, young, poisson, rule):
    """Forces that hold an element displaced: the sum over points of w F S g."""
    lam = young * poisson / ((1 + poisson) * (1 - 2 * poisson))
    mu = young / (2 * (1 + poisson))
    forces = np.zeros_like(places)
    for place, weight in rule:
        slope = slopes(len(places), place)
        jacobian = places.T @ slope
        gradient = slope @ np.linalg.inv(jacobian)
        deformation = np.eye(3) + u.T @ gradient
        strain = (deformation.T @ deformation - np.eye(3)) / 2
        stress = lam * np.trace(strain) * np.eye(3) + 2 * mu * strain
        forces += weight * np.linalg.det(jacobian) / 6 * (gradient @ (deformation @ stress).T)
    return forces


def single_elements(rows):
    """The law and the rule of CalculiX, on elements all of whose nodes are displaced by a third of their size."""
    random = np.random.default_rng(26)
    corners = np.array([[0, 0, 0], [1, 0.1, 0], [0.2, 0.9, 0.1], [0.1, 0.2, 1.1]])
    for nodes in (4, 10):
        places = corners if nodes == 4 else np.vstack([corners] + [(corners[a] + corners[b]) / 2 for a, b in EDGES])
        u = 0.3 * places @ random.normal(size=(3, 3)).T + 0.1 * random.normal(size=places.shape)
        deck = ["*NODE,NSET=ALL"]
        deck += ["%d,%s" % (n + 1, ",".join(number(x) for x in place)) for n, place in enumerate(places)]
        deck += ["*ELEMENT,TYPE=C3D%d,ELSET=E" % nodes, "1,%s" % ",".join(str(n + 1) for n in range(nodes))]
        deck += ["*MATERIAL,NAME=M", "*ELASTIC", "1000.,0.3", "*SOLID SECTION,ELSET=E,MATERIAL=M"]
        deck += ["*STEP,NLGEOM", "*STATIC,DIRECT", "1.,1.", "*BOUNDARY"]
        deck += ["%d,%d,%d,%s" % (n + 1, k + 1, k + 1, number(u[n, k])) for n in range(nodes) for k in range(3)]
        deck += ["*NODE PRINT,NSET=ALL", "RF", "*END STEP", ""]
        found = calculix("element", "\n".join(deck))[-1][1][:, 1:]
        rules = [("one element, forces", four_points())]
        if nodes == 10:
            rules.append(("one element, exact integration", many_points()))
        for what, rule in rules:
            wanted = element_forces(places, u, 1000.0, 0.3, rule)
            bound = 1e-6 if rule is rules[0][1] else None
            rows.add("element", 1 if nodes == 4 else 2, what, difference(wanted, found), bound)


# --- bodies ----------------------------------------------------------------------------------------------------------


def difference(thrum_value, other):
    """The largest difference of any component, relative to the largest of them."""
    return float(np.abs(thrum_value - other).max() / np.abs(other).max())


def about_of(path):
    """What a model file says of itself."""
    return json.loads(bytes(np.load(path)["meta"]))


class Body:
    """A body as both programs have it."""

    def __init__(self, program, name, order):
        mesh, fix, young, poisson, self.load = BODIES[name]
        self.program, self.name, self.order = program, name, order
        path = mesh if mesh.startswith("beam:") else os.path.join(MODELS, mesh)
        thrum(program, "convert", path, "body.inp", "--order", str(order))
        # the order is told: linear elements that lock would be taken with ten nodes
        for out, mass in (("consistent.npz", "consistent"), ("body.npz", "lumped")):
            thrum(program, "precompute", "body.inp", "--order", str(order), "--fix", fix, "--young", repr(young),
                  "--poisson", repr(poisson), "--density", repr(DENSITY), "--mass", mass, "--modes", str(FREQUENCIES),
                  "-o", out, "-q")
        self.model = np.load("body.npz")
        self.about = about_of("body.npz")
        self.vertices = len(self.model["vertices"])

        # CalculiX reads the nodes and elements of that file; what it is made of, and held by, is said here
        with open("body.inp") as file:
            text = file.read()
        cards = re.split(r"(?m)^(?=\*)", text)
        cards = [card for card in cards if re.match(r"\*(NODE|ELEMENT|HEADING)\b", card)]
        deck = "".join(cards)
        deck += "*NSET,NSET=EVERY,GENERATE\n1,%d,1\n" % self.vertices
        deck += "*SOLID SECTION,ELSET=allElements,MATERIAL=M\n*BOUNDARY\n"
        for vertex, bits in enumerate(self.model["fixed"]):
            deck += "".join("%d,%d,%d\n" % (vertex + 1, k + 1, k + 1) for k in range(3) if bits >> k & 1)
        law = "*MATERIAL,NAME=M\n*ELASTIC\n%s,%s\n*DENSITY\n" % (number(young), number(poisson))
        self.own_mass = deck + law + number(DENSITY) + "\n"
        self.deck = deck + law + number(1e-9 * DENSITY) + "\n" + self.masses()

    def nodes(self):
        """The nodes of each element."""
        elements = self.model["tets"]
        return elements if self.order == 1 else np.hstack([elements, self.model["midsides"]])

    def masses(self):
        """Point masses: of each tetrahedron, the diagonal of its mass matrix scaled to its mass."""
        nodes = self.nodes()
        shares = np.zeros(nodes.shape[1])
        for place, weight in many_points():
            shares += weight * shape(nodes.shape[1], place) ** 2
        corners = self.model["vertices"][nodes[:, :4]]
        volume = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6
        mass = np.zeros(self.vertices)
        np.add.at(mass, nodes, DENSITY * volume[:, None] * shares / shares.sum())
        deck = ""
        for vertex in range(self.vertices):
            deck += "*ELEMENT,TYPE=MASS,ELSET=POINT%d\n" % vertex
            deck += "%d,%d\n*MASS,ELSET=POINT%d\n%s\n" % (len(nodes) + vertex + 1, vertex + 1, vertex,
                                                         number(mass[vertex]))
        return deck

    def group(self, name):
        names = bytes(self.model["group_names"]).split(b"\0")
        at = names.index(name.encode())
        begin = self.model["group_ends"][at - 1] if at else 0
        return self.model["group_vertices"][begin:self.model["group_ends"][at]]

    def quadrature(self):
        return ["--quadrature", "four"] if self.order == 2 else []


def statics(body, rows):
    force, group = body.load
    vertices = body.group(group)
    deck = body.deck + "*STEP,NLGEOM,INC=1000\n*STATIC\n0.25,1.\n" + TIGHT + "*CLOAD\n"
    for vertex in vertices:
        for k in range(3):
            if force[k]:
                deck += "%d,%d,%s\n" % (vertex + 1, k + 1, number(force[k] / len(vertices)))
    deck += "*NODE PRINT,NSET=EVERY\nU\n*END STEP\n"
    found = calculix("statics", deck)[-1][1][:, 1:]

    load = "constant:%s@%s" % (",".join("%r" % x for x in force), group)
    for what, options in (("equilibrium", body.quadrature()), ("equilibrium, exact integration", [])):
        if what != "equilibrium" and body.order == 1:
            continue
        thrum(body.program, "static", "body.npz", "--full", "--load", load, "--vtu", "rest.vtu", "--tolerance",
              "1e-13", "-q", *options)
        u = vtu_points("rest.vtu", "displacement")
        rows.add(body.name, body.order, what, difference(u, found), 1e-6 if what == "equilibrium" else None,
                 "largest displacement %.3g m" % np.linalg.norm(found, axis=1).max())


def frequencies(body, rows):
    """With point masses at the nodes, as both programs have them; and each with its own mass matrix."""
    cases = (("%d frequencies" % FREQUENCIES, body.deck, "body.npz", 1e-6),
             ("each with its own mass", body.own_mass, "consistent.npz", None))
    for what, deck, path, bound in cases:
        # twice as many are asked for: the last ones have not converged to all digits
        deck += "*STEP\n*FREQUENCY\n%d\n*END STEP\n" % (2 * FREQUENCIES)
        table = [block for _, block in calculix("modes", deck) if block.shape[1] == 5][0]
        found = np.sqrt(table[:FREQUENCIES, 1]) / (2 * np.pi)
        ours = np.array(about_of(path)["frequencies_hz"])[:FREQUENCIES]
        rows.add(body.name, body.order, what, float(np.abs(ours / found - 1).max()), bound,
                 "first %.6g Hz" % found[0])


def transient(body, rows):
    # from rest in shape, with velocities that carry the body to some tenths of its size
    rank = body.model["basis"].shape[1]
    momentum = np.zeros((2, rank))
    size = np.ptp(body.model["vertices"], axis=0).max()
    shape = np.abs(body.model["basis"][:, 0]).max()
    momentum[1, 0] = 0.1 * size / shape * 2 * np.pi * body.about["frequencies_hz"][0]
    np.save("start.npy", momentum)
    velocity = (body.model["basis"] @ momentum[1]).reshape(-1, 3)

    deck = body.deck + "*INITIAL CONDITIONS,TYPE=VELOCITY\n"
    for vertex in range(body.vertices):
        deck += "".join("%d,%d,%s\n" % (vertex + 1, k + 1, number(velocity[vertex, k])) for k in range(3)
                        if velocity[vertex, k])
    deck += "*STEP,NLGEOM,INC=%d\n*DYNAMIC,ALPHA=0.,DIRECT\n%r,%r\n" % (2 * STEPS, STEP, STEP * STEPS) + TIGHT
    deck += "*NODE PRINT,NSET=EVERY\nU\n*END STEP\n"
    found = np.array([block[:, 1:] for _, block in calculix("motion", deck) if len(block) == body.vertices])

    thrum(body.program, "simulate", "body.npz", "-o", "run", "--full", "--integrator", "newmark", "--dt", repr(STEP),
          "--time", repr(STEP * STEPS), "--start", "start.npy", "--frames", "every-1", "-q", *body.quadrature())
    frames = sorted(name for name in os.listdir("run/frames") if name.endswith(".vtu"))
    ours = np.array([vtu_points("run/frames/" + name, "displacement") for name in frames])[1:STEPS + 1]
    if found.shape != ours.shape:
        refuse("%s: %d rows of CalculiX and %d of Thrum" % (body.name, len(found), len(ours)))
    rows.add(body.name, body.order, "%d steps of Newmark" % STEPS, difference(ours, found), 1e-3,
             "largest displacement %.3g m" % np.linalg.norm(found, axis=2).max())


# --- the table -------------------------------------------------------------------------------------------------------


class Rows:
    def __init__(self):
        self.rows = []

    def add(self, body, order, what, found, bound, note=""):
        self.rows.append((body, order, what, found, bound, note))
        print("%-12s order %d  %-32s %.2e  %s  %s" % (body, order, what, found, "" if bound is None else
              "within %g" % bound if found <= bound else "BEYOND %g" % bound, note), flush=True)

    def failed(self):
        return any(not (found <= bound) for _, _, _, found, bound, _ in self.rows if bound is not None)

    def write(self, folder):
        # rows of bodies that were left out stay
        path = os.path.join(folder, "calculix.csv")
        kept = []
        if os.path.exists(path):
            with open(path, newline="") as file:
                mine = {row[0] for row in self.rows}
                kept = [line for line in list(file)[1:] if line.split(",")[0] not in mine]
        with open(path, "w") as file:
            file.write("body,order,quantity,difference,bound,note\n")
            file.writelines(kept)
            for body, order, what, found, bound, note in self.rows:
                file.write('%s,%d,"%s",%.3g,%s,"%s"\n' % (body, order, what, found, "" if bound is None else bound,
                                                           note))
        version = subprocess.run(["ccx", "-v"], capture_output=True, text=True).stdout.strip()
        cpu = ""
        if os.path.exists("/proc/cpuinfo"):
            with open("/proc/cpuinfo") as file:
                cpu = next((line.split(":")[1].strip() for line in file if line.startswith("model name")), "")
        about = about_of("body.npz")
        with open(os.path.join(folder, "calculix.about.json"), "w") as file:
            json.dump({"calculix": version, "thrum": about["version"], "compiler": about["compiler"],
                       "blas_core": about["blas_core"], "machine": platform.machine(), "cpu": cpu,
                       "step_s": STEP, "steps": STEPS}, file, indent=1)
            file.write("\n")


def converted_deck(program, rows):
    """A deck of thrum convert as it is: its sets, sections and materials, those of two regions, serve in CalculiX."""
    thrum(program, "convert", "beam:4x1x1@1x0.2x0.2", "plain.inp", "--order", "2")
    with open("plain.inp") as file:
        text = file.read()

    # the same elements in two regions, one of whose names needs quotes, of two materials
    text = text[:text.index("*SOLID SECTION")]
    text += '*ELSET,ELSET=steel,GENERATE\n1,12,1\n*ELSET,ELSET="soft part",GENERATE\n13,24,1\n'
    for name, material, young in (("steel", "a", 2e6), ('"soft part"', "b", 1e6)):
        text += "*SOLID SECTION,ELSET=%s,MATERIAL=%s\n*MATERIAL,NAME=%s\n*ELASTIC\n%g,0.3\n*DENSITY\n1000\n" % (
            name, material, material, young)
    with open("two.inp", "w") as file:
        file.write(text)
    thrum(program, "convert", "two.inp", "converted.inp")

    deck = "*INCLUDE,INPUT=converted.inp\n*BOUNDARY\nleft,1,3\n*STEP\n*STATIC\n"
    deck += "*CLOAD\ntip,3,-1e-5\n*NODE PRINT,NSET=tip\nU\n*END STEP\n"
    moved = calculix("includes", deck)[0][1]
    force = "constant:0,0,%g@tip" % (-1e-5 * len(moved))
    answer = json.loads(thrum(program, "static", "converted.inp", "--full", "--fix", "left", "--load", force, "--at",
                              "tip", "--monitor", "off", "--json"))
    mean = answer["displacements"][0]["mean_m"]
    rows.add("converted", 2, "small load, deck included", abs(mean[2] / moved[:, 3].mean() - 1), 1e-5)


def main():
    parser = argparse.ArgumentParser(description="Compares Thrum with CalculiX on the same meshes.")
    parser.add_argument("thrum")
    parser.add_argument("folder", nargs="?", default="-")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--body", action="append")
    options = parser.parse_args()
    program, folder = os.path.abspath(options.thrum), os.path.abspath(options.folder)

    rows = Rows()
    bodies = ["small beam"] if options.quick else options.body or [name for name in BODIES if name != "small beam"]
    with tempfile.TemporaryDirectory() as work:
        os.chdir(work)
        single_elements(rows)
        converted_deck(program, rows)
        for name in bodies:
            for order in (1, 2):
                body = Body(program, name, order)
                statics(body, rows)
                frequencies(body, rows)
                transient(body, rows)
        if options.folder != "-":
            rows.write(folder)
        os.chdir("/")
    return 1 if rows.failed() else 0


if __name__ == "__main__":
    sys.exit(main())
