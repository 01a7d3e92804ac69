"""Frames as VTK's own reader of .vtu finds them, and the .pvd as ParaView's: the mesh, X + U q(t) of
the run's q, the times. SPDX-License-Identifier: Apache-2.0

usage: test_vtk.py PROGRAM vtk|paraview
"""
import os
import subprocess
import sys
import tempfile

import numpy as np

TETRA = 10  # VTK's number of it


def thrum(*arguments):
    subprocess.run([sys.argv[1], *arguments], check=True, stdout=subprocess.DEVNULL)


class Run:
    """What the run's own files hold."""

    def __init__(self):
        model = np.load("beam.npz")
        self.vertices, self.tets = model["vertices"], model["tets"]
        self.q = np.load("run/q.npy")
        self.basis = model["basis"][:, : self.q.shape[1]]
        self.times = np.loadtxt("run/energy.csv", delimiter=",", skiprows=1, usecols=1)

    def displacement(self, time):
        row = int(np.argmin(abs(self.times - time)))
        assert abs(self.times[row] - time) < 1e-12, f"no row at {time} s"
        return (self.basis @ self.q[row]).reshape(-1, 3)


def check_grid(grid, run, time):
    """One frame: any wrapped vtkUnstructuredGrid."""
    assert np.array_equal(grid.Points, run.vertices)
    assert set(grid.CellTypes) == {TETRA}
    assert np.array_equal(grid.Cells.reshape(-1, 5)[:, 1:], run.tets)
    shown, wanted = grid.PointData["displacement"], run.displacement(time)
    worst = abs(shown - wanted).max()
    assert worst <= 1e-14 * max(1, abs(wanted).max()), f"{time} s: off by {worst} m"
    stress = grid.CellData["von_mises_centre"]
    assert stress.shape == (len(run.tets),) and (stress >= 0).all() and stress.max() > 0
    return abs(wanted).max()


def read_vtu(path):
    from vtkmodules.numpy_interface.dataset_adapter import WrapDataObject
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    reader = vtkXMLUnstructuredGridReader()
    failed = []
    reader.AddObserver("ErrorEvent", lambda *_: failed.append(path))
    reader.SetFileName(path)
    reader.Update()
    assert not failed and reader.GetOutput().GetNumberOfPoints() > 0, path
    return WrapDataObject(reader.GetOutput())


def check_vtk():
    run = Run()
    frames = sorted(os.listdir("run/frames"))
    assert len(frames) == 10
    moved = 0
    for name in frames:
        grid = read_vtu("run/frames/" + name)
        moved = max(moved, check_grid(grid, run, grid.FieldData["TimeValue"][0]))
    assert moved > 0.05
    modes = read_vtu("modes.vtu")
    assert sum(name.startswith("mode_") for name in modes.PointData.keys()) == 4
    # a damaged file is not taken for a whole one
    with open("run/frames/" + frames[1], "rb") as file:
        whole = file.read()
    with open("cut.vtu", "wb") as file:
        file.write(whole[: len(whole) * 2 // 3])
    try:
        check_grid(read_vtu("cut.vtu"), run, 0)
    except Exception:  # whichever way it shows
        return
    raise AssertionError("a file cut short was read as whole")


def check_paraview():
    from paraview import servermanager
    from paraview.simple import PVDReader
    from vtkmodules.numpy_interface.dataset_adapter import WrapDataObject

    run = Run()
    reader = PVDReader(FileName=os.path.abspath("run/frames.pvd"))
    times = list(reader.TimestepValues)
    assert len(times) == 10 and times[0] == 0 and times == sorted(times)
    for time in times:
        reader.UpdatePipeline(time)
        check_grid(WrapDataObject(servermanager.Fetch(reader)), run, time)


def main():
    sys.argv[1] = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory(prefix="thrum-vtk-") as folder:
        os.chdir(folder)
        thrum("precompute", "beam:6x2x2@1x0.2x0.3,split=6", "--order", "1", "--fix", "x<0.001", "--modes", "4", "-q",
              "-o", "beam.npz", "--export-modes", "modes.vtu")
        thrum("simulate", "beam.npz", "-o", "run", "--time", "0.3", "--start", "mode:1,0.1",
              "--frames", "30", "--stress", "-q")
        {"vtk": check_vtk, "paraview": check_paraview}[sys.argv[2]]()
        os.chdir("/")


main()
