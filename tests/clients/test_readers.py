#!/usr/bin/env python3
"""Files that Thrum writes, read by other programs: ParaView's own Python, numpy and scipy, with what they must hold.

usage: test_readers.py PROGRAM [PVPYTHON]     SPDX-License-Identifier: Apache-2.0
"""
import json
import os
import subprocess
import sys
import tempfile

import numpy as np
import scipy.io
import scipy.sparse.linalg

# what pvpython prints of each file: points, cells, names of point data, extent of x, number of times
PARAVIEW = r'''
import json, sys
from paraview import simple, servermanager
for path in sys.argv[1:]:
    reader = simple.OpenDataFile(path)
    times = list(getattr(reader, "TimestepValues", []) or [])
    simple.UpdatePipeline(time=times[-1] if times else 0, proxy=reader)
    information = reader.GetDataInformation()
    data = servermanager.Fetch(reader)
    while data.IsA("vtkMultiBlockDataSet"):
        data = [data.GetBlock(k) for k in range(data.GetNumberOfBlocks()) if data.GetBlock(k)][0]
    peak = 0.0
    moved = data.GetPointData().GetArray("displacement")
    if moved:
        peak = max(sum(x * x for x in moved.GetTuple(k)) ** 0.5 for k in range(moved.GetNumberOfTuples()))
    bounds = information.GetBounds()
    print(json.dumps({"path": path, "points": information.GetNumberOfPoints(), "cells": information.GetNumberOfCells(),
                      "x": bounds[:2], "times": len(times), "peak": peak,
                      "arrays": [data.GetPointData().GetArrayName(k) for k in range(data.GetPointData().GetNumberOfArrays())]}))
'''


def write_all(program):
    """One file of every kind that others read; the reports of the program by command."""
    def thrum(*words):
        return json.loads(subprocess.run([program, *words, "--json"], check=True, capture_output=True, text=True).stdout)

    mesh = "beam:12x3x3@1x0.2x0.2"
    thrum("precompute", mesh, "--fix", "x<0.001", "--modes", "5", "--rank", "10", "-o", "beam.npz", "--export-modes", "modes.vtu", "-q")
    run = thrum("simulate", "beam.npz", "-o", "run", "--time", "0.3", "--start", "mode:1,0.1", "--frames", "30", "--stress", "-q")
    static = thrum("static", "beam.npz", "--load", "gravity:0,0,-9.81", "-o", "sag.npy", "--vtu", "sag.vtu")
    for suffix in ("vtk", "vtu", "msh"):
        subprocess.run([program, "convert", mesh, f"mesh.{suffix}"], check=True, capture_output=True)
    subprocess.run([program, "convert", mesh, "ascii.vtu", "--ascii"], check=True, capture_output=True)
    thrum("export", "run", "--obj", "body.obj", "--glb", "body.glb", "--pc2", "body.pc2", "--mdd", "body.mdd")
    thrum("export", "beam.npz", "--matrices", "beam")
    return run, static


def check_arrays(static):
    """numpy and scipy."""
    model = np.load("beam.npz")
    rank, vertices = len(model["omega2"]), len(model["vertices"])
    assert model["basis"].shape == (3 * vertices, rank) and np.load("run/q.npy").shape[1] == rank
    assert np.load("run/end.npy").size >= 2 * rank and np.isfinite(np.load("sag.npy")).all()

    # the matrices are those in which the basis is orthonormal and its stiffness diagonal
    stiffness, mass = (scipy.io.mmread(f"beam.{name}.mtx").tocsr() for name in "KM")
    with open("beam.rows.txt", encoding="ascii") as file:
        rows = [line.split() for line in file if line[0].isdigit()]
    free = stiffness.shape[0]
    assert free == mass.shape[0] == len(rows) and abs(stiffness - stiffness.T).max() == 0
    places = [3 * (int(vertex) - 1) + ("xyz".index(axis) if axis in "xyz" else int(axis)) for vertex, axis in rows]
    basis = model["basis"][places]
    omega2 = model["omega2"]
    assert np.abs(basis.T @ (mass @ basis) - np.eye(rank)).max() < 1e-12
    assert np.abs(basis.T @ (stiffness @ basis) - np.diag(omega2)).max() < 1e-10 * omega2[-1]
    # those of all components lie below those of the basis, and the first ones close
    lowest = np.sort(scipy.sparse.linalg.eigsh(stiffness, 3, mass, sigma=0, return_eigenvectors=False))
    assert (lowest < omega2[:3] * (1 + 1e-9)).all() and np.allclose(lowest, omega2[:3], rtol=1e-4), (lowest, omega2[:3])
    print(f"numpy and scipy: rank {rank}, {vertices} vertices, {free} free components, frequencies agree")
    return vertices, len(model["tets"])


def check_paraview(pvpython, run, static, vertices, tets):
    names = ["run/frames.pvd", "sag.vtu", "modes.vtu", "mesh.vtk", "mesh.vtu", "ascii.vtu", "body.obj"]
    with open("look.py", "w", encoding="utf-8") as file:
        file.write(PARAVIEW)
    done = subprocess.run([pvpython, "--force-offscreen-rendering", "look.py", *names], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stdout + done.stderr)
    found = {row["path"]: row for row in map(json.loads, (line for line in done.stdout.splitlines() if line.startswith("{")))}
    assert list(found) == names, (list(found), done.stderr)
    for name, row in found.items():
        solid = name != "body.obj"
        assert not solid or (row["points"], row["cells"]) == (vertices, tets), row
        assert 0 < row["points"] and 0 < row["cells"], row
        print(f"pvpython: {name}: {row['points']} points, {row['cells']} cells, {row['times']} times, {row['arrays']}")
    assert found["run/frames.pvd"]["times"] >= 9 and "displacement" in found["run/frames.pvd"]["arrays"]
    assert np.isclose(found["sag.vtu"]["peak"], static["peak_displacement_m"], rtol=1e-5), (found["sag.vtu"], static)
    assert len(found["modes.vtu"]["arrays"]) >= 5


def main():
    program = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as work:
        os.chdir(work)
        run, static = write_all(program)
        vertices, tets = check_arrays(static)
        if len(sys.argv) > 2 and sys.argv[2]:
            check_paraview(sys.argv[2], run, static, vertices, tets)


if __name__ == "__main__":
    main()
