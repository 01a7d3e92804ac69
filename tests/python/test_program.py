"""The program from Python: runs, statics, refusals. SPDX-License-Identifier: Apache-2.0"""
import inspect
import os
import pickle
import re
import signal
import subprocess
import threading
import time
import unittest
import warnings
from types import SimpleNamespace
from unittest import mock

import numpy as np
from support import FOLDER, beam, beam_file, block

import thrum
from thrum._program import arguments

SOLID = {"young": 1e6, "poisson": 0.3, "density": 1000.0}


def box(nodes=4):
    """A bar of 2 x 1 x 1 m of twelve tetrahedra, with nodes in the middle of edges where it has ten a tetrahedron."""
    place = {}
    corners, tets = [], []

    def vertex(*at):
        if at not in place:
            place[at] = len(corners)
            corners.append(at)
        return place[at]

    # six tetrahedra around the diagonal of each cell
    for x in (0.0, 1.0):
        for first, second in ((0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)):
            at = [x, 0.0, 0.0]
            tet = [vertex(*at)]
            for axis in (first, second, 3 - first - second):
                at[axis] += 1.0
                tet.append(vertex(*at))
            if np.linalg.det(np.array([corners[v] for v in tet[1:]]) - corners[tet[0]]) < 0:
                tet[1:3] = tet[2], tet[1]
            tets.append(tet)
    if nodes == 10:
        for tet in tets:
            ends = [np.array(corners[v]) for v in tet]
            for a, b in ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)):
                tet.append(vertex(*(0.5 * (ends[a] + ends[b])).tolist()))
    return np.array(corners), np.array(tets)


class Keywords(unittest.TestCase):
    def test_each_option_of_a_command_is_a_keyword(self):
        # what a report says of frequencies is a function of its own
        left = {"json", "quiet", "help", "output", "verbose", "gradient", "shape-gradient"}
        for name in ("check", "compare", "embed", "export", "info", "mesh"):
            text = subprocess.run([thrum.program(), name, "--help"], capture_output=True, text=True, check=True).stdout
            options = set(re.findall(r"^ {2,6}(?:-\w, )? *--([a-z-]+)(?: |$)", text, re.MULTILINE)) - left
            keywords = {keyword.rstrip("_").replace("_", "-") for keyword in inspect.signature(getattr(thrum, name)).parameters}
            self.assertLessEqual(options, keywords, name)


class Interrupts(unittest.TestCase):
    """An interrupt is obeyed within a tenth of a second, which a busy machine makes a few."""

    def interrupted(self, call, after=0.3):
        timer = threading.Timer(after, os.kill, (os.getpid(), signal.SIGINT))
        began = time.monotonic()
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            call()
        self.assertLess(time.monotonic() - began, after + 1.5)

    def test_programs_end(self):
        # a stand-in that never ends by itself, and does not obey either
        script = FOLDER + "/endless"
        with open(script, "w", encoding="ascii") as file:
            file.write("#!/bin/sh\ntrap '' INT\necho $$ > " + FOLDER + "/pid\nwhile :; do sleep 0.02; done\n")
        os.chmod(script, 0o755)
        with mock.patch.dict(os.environ, THRUM_PROGRAM=script):
            self.interrupted(lambda: thrum.static(beam_file()))
        with open(FOLDER + "/pid", encoding="ascii") as file:
            number = int(file.read())
        with self.assertRaises(ProcessLookupError):
            os.kill(number, 0)

    def test_a_run_that_was_left_keeps_what_it_steps(self):
        model = beam()
        self.interrupted(lambda: thrum.rollout(model, 500000, q=np.full(model.rank, 1e-4)), after=0.1)
        for _ in range(200):
            model.state().step(3)

    def test_calls_of_the_library_end(self):
        # the search goes on by itself, with what it needs, and the model stays whole
        model = beam()
        load = model.external_load((0, 0, -1e-3), group="tip")
        with mock.patch("thrum.equilibrium.lib") as library:
            library.thrum_equilibrium_def_init = thrum._native.lib.thrum_equilibrium_def_init
            library.thrum_equilibrium_size = thrum._native.lib.thrum_equilibrium_size
            library.thrum_equilibrium = lambda *_: time.sleep(3) or 0
            self.interrupted(lambda: model.equilibrium(load))
        self.assertTrue(model.equilibrium(load).stable)

        state = model.state()
        self.interrupted(lambda: model.batch([state]).step(10**9))
        scene = thrum.Scene()
        scene.add_body(model)
        self.interrupted(lambda: scene.step(10**9))


class Arguments(unittest.TestCase):
    def test_options(self):
        given = {"fix": ["x<0.1", "tip:z"], "spin": (0, 3.5, 0), "yield_": 0.01, "full": True, "stress": False, "rank": None,
                 "train_dt": 0.1, "ranks": np.array([10, 20])}
        self.assertEqual(arguments(given), ["--fix=x<0.1", "--fix=tip:z", "--spin=0.0,3.5,0.0", "--yield=0.01", "--full",
                                            "--train-dt=0.1", "--ranks=10,20"])


class Meshes(unittest.TestCase):
    def made(self, mesh, **options):
        return thrum.Model.precompute(mesh, **{**SOLID, "order": "auto", "modes": 3, "rank": 3, **options})

    def test_groups_and_regions(self):
        vertices, tets = box()
        far = vertices[:, 0] > 1.5
        named = np.where(tets.max(axis=1) >= 8, "hard part", "soft")
        mesh = thrum.Mesh(vertices, tets, {"far": far, "Far": np.flatnonzero(far)[:1]}, named)
        self.assertIn("'Far', 'far'", repr(mesh))
        model = self.made(mesh, fix="x<0.1", order=1, material=["hard part:2e6,0.3,1000", "soft:1e6,0.2,900"])
        np.testing.assert_array_equal(model.group("far"), np.flatnonzero(far))
        self.assertEqual(len(model.group("Far")), 1)
        np.testing.assert_array_equal(np.sort(model.material[:, 0]), [1e6, 2e6])
        np.testing.assert_array_equal(model.vertices, vertices)

        # what is named wrongly is refused before anything is written
        for wrong in ({"groups": {"a": far[1:]}}, {"groups": {"a": [99]}}, {"groups": {'a"': [0]}}, {"regions": [1]},
                      {"groups": {"a": [0.5]}}, {"regions": np.ones(len(tets))}):
            with self.assertRaisesRegex(ValueError, "groups|regions"):
                thrum.Mesh(vertices, tets, **wrong)

    def test_ten_nodes(self):
        """Ten nodes in arrays are those that the program makes of four: a wrong order would turn elements inside out."""
        linear = self.made(box(), fix="x<0.1", order=2)
        quadratic = self.made(box(10), fix="x<0.1")
        self.assertEqual(quadratic.vertex_count, linear.vertex_count)
        np.testing.assert_allclose(quadratic.frequencies, linear.frequencies, rtol=1e-9)
        self.assertEqual(thrum.check(box(10))["order"], 2)

    def test_vertices_to_hold(self):
        vertices, tets = box()
        held = vertices[:, 0] < 0.1
        wanted = self.made((vertices, tets), fix="x<0.1", order=1)
        sliding = np.zeros((len(vertices), 3), bool)
        sliding[held] = True, True, False
        sliding[np.flatnonzero(held)[0]] = True
        for fix in (held, np.flatnonzero(held), np.flatnonzero(held).tolist(), [held, "x<0.1"]):
            np.testing.assert_array_equal(self.made((vertices, tets), fix=fix, order=1).fixed, wanted.fixed)
        found = self.made((vertices, tets), fix=sliding, order=1).fixed
        np.testing.assert_array_equal([[bits >> axis & 1 for axis in range(3)] for bits in found], sliding)

        # of a Model, by its vertices; of a file the numbers are not those of arrays
        model = thrum.Model.precompute(wanted, fix=held, modes=3, rank=3)
        np.testing.assert_array_equal(model.fixed, wanted.fixed)
        with self.assertRaisesRegex(ValueError, "fix: vertices of a mesh file"):
            self.made("beam:2x1x1@2x1x1", fix=held)
        with self.assertRaisesRegex(ValueError, "fix: it names no vertex"):
            self.made((vertices, tets), fix=np.zeros(len(vertices), bool))
        with self.assertRaisesRegex(ValueError, "fix: a mask has 12 entries"):
            self.made((vertices, tets), fix=np.ones(3, bool))

    def test_meshio(self):
        vertices, tets = box()
        far = np.flatnonzero(vertices[:, 0] > 1.5)
        cells = [SimpleNamespace(type="triangle", data=far[None, :3]), SimpleNamespace(type="tetra", data=tets)]
        given = SimpleNamespace(points=vertices, cells=cells, point_sets={"end": far},
                                cell_data={"gmsh:physical": [np.array([7]), np.where(np.arange(len(tets)) < 6, 1, 2)]},
                                field_data={"face": (7, 2), "left": (1, 3)})
        model = self.made(given, fix="x<0.1", order=1, material="left:2e6,0.3,1000")
        np.testing.assert_array_equal(model.group("end"), far)
        np.testing.assert_array_equal(model.group("face"), np.sort(far[:3]))
        self.assertEqual(sorted(model.material[:, 0]), [1e6, 2e6])
        with self.assertRaisesRegex(ValueError, "tetra or tetra10"):
            self.made(SimpleNamespace(points=vertices, cells=cells[:1]))


class Program(unittest.TestCase):
    def test_simulate_has_the_bits_of_a_state(self):
        run = thrum.simulate(beam_file(), FOLDER + "/run", time=0.3, start="mode:1,0.1", accept_error="100%")
        self.assertEqual(run.report["status"], "done")
        model = beam()
        state = model.state()
        state.set(model.start(0, 0.1))
        state.step(100)
        np.testing.assert_array_equal(run.q[-1], state.q)
        self.assertAlmostEqual(run.energy["total_j"][-1] / state.energies.total, 1.0, 12)
        again = thrum.Run(run.folder)
        self.assertEqual(again.report["command"], "simulate")
        with self.assertRaises(FileNotFoundError):
            run.array("frames")

    def test_full_order(self):
        run = thrum.simulate(beam_file(), FOLDER + "/full", time=0.03, load="constant:0,0,-1@tip", full=True)
        self.assertIsNotNone(run.report["full"])

    def test_static(self):
        model = beam()
        report = thrum.static(beam_file(), load="gravity:0,0,-9.81")
        found = model.equilibrium(model.external_load(gravity=(0, 0, -9.81)))
        self.assertAlmostEqual(report["energy_j"] / found.energy, 1.0, 9)

    def test_models_stand_for_files(self):
        model = beam()
        self.assertEqual(model._file("unused"), beam_file())
        report = thrum.info(model, dt=0.001)
        self.assertEqual(report["rank"], model.rank)
        by_file, by_model = (thrum.static(given, load="gravity:0,0,-9.81") for given in (beam_file(), model))
        self.assertEqual(by_model["energy_j"], by_file["energy_j"])

        # a model without a file, or whose file has changed, is written beside the run, which refers to it
        with open(beam_file(), "rb") as file:
            bare = thrum.Model.from_bytes(file.read())
        run = thrum.simulate(bare, FOLDER + "/bare/", time=0.03, start="mode:1,0.01", accept_error="100%")
        self.assertTrue(os.path.exists(FOLDER + "/bare.model.npz"))
        self.assertIn("done", repr(run))
        half = thrum.simulate(bare, FOLDER + "/half", time=0.03, dt=0.0015, start="mode:1,0.01", accept_error="100%")
        apart = thrum.compare(run, half)
        self.assertEqual(apart, thrum.compare(run.folder, half.folder))
        self.assertIn("warnings", thrum.info(run))
        thrum.export(run, obj=FOLDER + "/bare.obj", glb=FOLDER + "/bare.glb", fps=0)
        self.assertTrue(os.path.getsize(FOLDER + "/bare.glb") > 0)

        # a condensed model has none
        with self.assertRaisesRegex(ValueError, "no file"):
            thrum.info(model.condense(6))
        model.close()
        with self.assertRaisesRegex(ValueError, "closed"):
            thrum.info(model)

    def test_frequencies_change_with_places(self):
        vertices, tets = box()
        vertices = vertices * [0.5, 0.15, 0.1]
        options = {"fix": "x<0.001", "order": 1, "modes": 3, "rank": 3, **SOLID}
        random = np.random.default_rng(5)
        along = random.standard_normal(vertices.shape) * (vertices[:, :1] > 0.2)

        def frequencies(by):
            moved = thrum.Mesh(vertices + by * along, tets)
            return thrum.Model.precompute(moved, FOLDER + "/moved.npz", **options)

        found = thrum.frequency_gradient(frequencies(0.0), places=True)
        slopes = (found.place * along).sum(axis=(1, 2))
        high, low = (frequencies(by).frequencies for by in (1e-5, -1e-5))
        np.testing.assert_allclose((high - low) / 2e-5 / found.frequency, slopes, rtol=1e-6, atol=1e-6)
        np.testing.assert_allclose(found.young.sum(axis=1), 0.5, rtol=1e-8)

        # a corner of straight ten-node tetrahedra takes its middle nodes along
        ten = thrum.Model.precompute(thrum.Mesh(vertices, tets), FOLDER + "/ten.npz", **{**options, "order": 2})
        nodes, middle = ten.vertices, np.zeros((len(ten.vertices), 3))
        for n, place in enumerate(nodes):
            ends = [(a, b) for tet in tets for a in tet for b in tet
                    if np.allclose(0.5 * (vertices[a] + vertices[b]), place, atol=1e-12)]
            middle[n] = 0.5 * (along[ends[0][0]] + along[ends[0][1]])
        slopes = (thrum.frequency_gradient(ten, places=True).place * middle).sum(axis=(1, 2))
        high, low = (thrum.Model.precompute(thrum.Mesh(vertices + by * along, tets), FOLDER + "/ten.npz", **{**options, "order": 2})
                     for by in (1e-5, -1e-5))
        np.testing.assert_allclose((high.frequencies - low.frequencies) / 2e-5 / ten.frequencies, slopes, rtol=1e-5, atol=1e-5)

    def test_frequencies_of_other_elements_change_with_places(self):
        # a row of skewed hexahedra, whole or cut into wedges
        random = np.random.default_rng(7)
        nodes = np.array([(x, y, z) for x in range(4) for z in (0, 1) for y in (0, 1)], float) * [0.2, 0.15, 0.1]
        nodes += 0.01 * random.standard_normal(nodes.shape) * (nodes[:, :1] > 0.1)
        along = random.standard_normal(nodes.shape) * (nodes[:, :1] > 0.1)
        boxes = [[4 * x + k for k in (1, 5, 6, 2, 3, 7, 8, 4)] for x in range(3)]
        wedges = [[box[k] for k in corners] for box in boxes for corners in ((0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7))]
        for name, elements, kind, order in (("C3D8", boxes, "auto", 1), ("C3D6", wedges, "auto", 1), ("C3D8", boxes, "shell", 1),
                                            ("C3D8", boxes, "auto", 2), ("C3D6", wedges, "auto", 2)):
            def model(by, name=name, elements=elements, kind=kind, order=order):
                rows = ["*NODE", *(f"{n + 1}, {', '.join(map(repr, place.tolist()))}" for n, place in enumerate(nodes + by * along)),
                        f"*ELEMENT, TYPE={name}", *(f"{n + 1}, {', '.join(map(str, row))}" for n, row in enumerate(elements))]
                with open(FOLDER + "/solid.inp", "w", encoding="ascii") as file:
                    file.write("\n".join(rows) + "\n")
                path = FOLDER + f"/solid{by}.npz"
                return thrum.Model.precompute(FOLDER + "/solid.inp", path, fix="x<0.001", element=kind, order=order, modes=3, rank=3,
                                              **SOLID)
            here = model(0.0)

            # nodes that are not in the file go along
            high, low = model(1e-5), model(-1e-5)
            ways = (high.vertices - low.vertices) / 2e-5
            slopes = (thrum.frequency_gradient(here, places=True).place * ways).sum(axis=(1, 2))
            np.testing.assert_allclose((high.frequencies - low.frequencies) / 2e-5 / here.frequencies, slopes, rtol=1e-5, atol=1e-5,
                                       err_msg=f"{name} {kind} {order}")

    def test_modes_that_share_a_frequency_change_in_the_mean(self):
        options = {"fix": "x<0.001", "order": 1, "modes": 2, "rank": 2, **SOLID}
        square = thrum.Model.precompute("beam:4x2x2@1x0.1x0.1", FOLDER + "/square.npz", **options)
        found = thrum.frequency_gradient(square, places=True)
        np.testing.assert_array_equal(found.place[0], found.place[1])
        wider = (found.place[0, :, 1] * square.vertices[:, 1]).sum()
        mesh = [thrum.Mesh(square.vertices * [1, 1 + by, 1], square.tets) for by in (1e-5, -1e-5)]
        high, low = (thrum.Model.precompute(one, FOLDER + "/square.npz", **options).frequencies.mean() for one in mesh)
        self.assertAlmostEqual((high - low) / 2e-5 / found.frequency.mean() / wider, 1.0, 6)

    def test_identify(self):
        run = thrum.simulate(beam_file(), FOLDER + "/ring", time=1.5, dt=0.002, start="mode:1,0.05", damping_ratio=0.04, probe="tip")
        with open(os.path.join(run.folder, "probes.csv"), encoding="utf-8") as file:
            names = file.readline().strip().split(",")
        rows = np.loadtxt(os.path.join(run.folder, "probes.csv"), delimiter=",", skiprows=1)
        columns = {name: rows[:, names.index(name)] for name in ("time_s", "tip.z_m")}
        report = thrum.identify(beam_file(), columns, start="mode:1,0.05", dt=0.002)
        young, ratio = report["parameters"]
        self.assertAlmostEqual(young["value"] / young["first"], 1.0, 4)
        self.assertAlmostEqual(ratio["value"] / 0.04, 1.0, 3)

        # a place may have commas
        columns = {"time_s": columns["time_s"], "near:1,0,0.z_m": columns["tip.z_m"]}
        young = thrum.identify(beam_file(), columns, start="mode:1,0.05", dt=0.002)["parameters"][0]
        self.assertAlmostEqual(young["value"] / young["first"], 1.0, 2)
        with self.assertRaisesRegex(thrum.ProgramFailed, "recording"):
            thrum.identify(beam_file(), {"time_s": [0.0, 1.0], "tip.z_m": [0.0, 1.0]}, start="mode:1,0.05")

    def test_response(self):
        folder = FOLDER + "/backbone"
        curve = thrum.response(beam_file(), mode=1, amplitude=0.05, harmonics=5, output=folder)
        count = len(curve.frequency)
        self.assertEqual(count, curve.report["points"])
        self.assertEqual(curve.peak.shape, (count, 1))
        self.assertEqual(curve.coefficients.shape[:2], (count, 11))
        self.assertTrue((curve.unstable == 0).all())
        self.assertIn("motions", repr(curve))
        self.assertTrue(os.path.exists(folder + "/response.csv"))

        # a curve that keeps no files is the same
        again = thrum.response(thrum.Model.load(beam_file()), mode=1, amplitude=0.05, harmonics=5)
        np.testing.assert_array_equal(again.coefficients, curve.coefficients)
        drawn = mock.Mock()
        self.assertIs(curve.plot(drawn), drawn)
        self.assertEqual(drawn.plot.call_count, 3)
        with self.assertRaisesRegex(thrum.ProgramFailed, "which curve"):
            thrum.response(beam_file())

    def test_surfaces(self):
        model = block()
        thrum.embed(model, (model.vertices, model.outer_triangles()), FOLDER + "/skin.npz")
        self.assertEqual(thrum.info(FOLDER + "/skin.npz")["vertices"], model.vertex_count)
        with self.assertRaisesRegex(thrum.ProgramFailed, "^surface"):
            thrum.mesh(([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]), FOLDER + "/open.msh")
        self.assertFalse(os.path.exists(FOLDER + "/open.msh"))
        with self.assertRaisesRegex(ValueError, "triangles are not m x 3"):
            thrum.mesh((model.vertices, model.tets), FOLDER + "/none.msh")

    def test_view(self):
        # a stand-in for the viewer's page, which not every build has: the program fills its slot with the model
        page = FOLDER + "/page.html"
        with open(page, "w", encoding="utf-8") as file:
            file.write('<html><script type="application/octet-stream" id="thrum-pack"></script></html>')
        with mock.patch.dict(os.environ, THRUM_VIEWER=page):
            shown = thrum.view(beam(), height=300)
        self.assertIn('height="300"', shown._repr_html_())
        self.assertNotIn("<script", shown._repr_html_())
        shown.save(FOLDER + "/shown.html")
        self.assertEqual(os.path.getsize(FOLDER + "/shown.html"), len(shown.page.encode()))

    def test_warnings(self):
        with self.assertWarnsRegex(RuntimeWarning, "its linear tetrahedra are too stiff"):
            thrum.precompute("beam:8x1x1@1x0.1x0.1", FOLDER + "/thin.npz", fix="x<0.001", order=1, modes=2,
                             rank=4)

        # a refusal has its own line alone, and what was warned of before it is a warning of the line that called
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            with self.assertRaises(thrum.ProgramFailed) as refused:
                thrum.Model.precompute("beam:8x1x1@1x0.1x0.1", fix="x<0.001", order=1, density=1e5, handles="nowhere", rank=4)
        self.assertNotIn("warning", str(refused.exception))
        self.assertNotIn("\n", str(refused.exception))
        self.assertEqual({warning.filename for warning in caught}, {__file__})

    def test_unit(self):
        """A mesh in millimetres is asked about in Python's names, and a unit or a scale answers."""
        corner = np.array([[0, 0, 0], [100, 0, 0], [0, 100, 0], [0, 0, 100]]), [[0, 1, 2, 3]]
        solid = {"young": 1e9, "poisson": 0.3, "density": 1000, "order": 1, "modes": 2, "rank": 2}
        asked = "^mesh: the body is 100 m long: is its file in millimetres. scale 0.001, or unit mm-t-s"
        with self.assertWarnsRegex(RuntimeWarning, asked):
            thrum.precompute(corner, FOLDER + "/corner.npz", **solid)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            thrum.precompute(corner, FOLDER + "/corner.npz", scale=0.001, **solid)
        self.assertFalse([warning for warning in caught if "long" in str(warning.message)])

    def test_hostile_names(self):
        # names of files that look like options, or are no UTF-8, are names of files
        for name in ("--help", f"--options={beam_file()}"):
            with self.assertRaisesRegex(thrum.ProgramFailed, "kind of mesh|No such file"):
                thrum.precompute(name, FOLDER + "/none.npz")
        with self.assertRaisesRegex(thrum.ProgramFailed, "caf"):
            thrum.precompute(os.fsdecode(b"caf\xe9.veg"), FOLDER + "/none.npz")
        corner = np.vstack([np.zeros(3), np.eye(3)])
        with self.assertRaisesRegex(ValueError, "mesh: real numbers"):
            thrum.precompute((corner * 1j, [[0, 1, 2, 3]]), FOLDER + "/none.npz")

    def test_refusals(self):
        with self.assertRaisesRegex(thrum.ProgramFailed, "nosuch") as caught:
            thrum.simulate("nosuch.npz", FOLDER + "/none")
        self.assertEqual(caught.exception.exit_code, 1)
        self.assertEqual(pickle.loads(pickle.dumps(caught.exception)).exit_code, 1)
        with self.assertRaises(thrum.ProgramFailed) as caught:
            thrum.static(beam_file(), no_such_option=3)
        self.assertEqual(caught.exception.exit_code, 2)
        self.assertNotIn("--no", str(caught.exception))

        # options and meshes have the names that the caller gave them
        with self.assertRaisesRegex(thrum.ProgramFailed, r"^dt wants a number above 0 s, not '-1'$"):
            thrum.simulate(beam_file(), FOLDER + "/none", dt=-1)
        vertices, tets = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2, 3]]
        with self.assertRaisesRegex(thrum.ProgramFailed, "^mesh does not say what it is made of: give young, poisson"):
            thrum.precompute((vertices, tets), FOLDER + "/none.npz")
        with self.assertRaises(thrum.ProgramFailed) as caught:
            thrum.precompute((vertices, tets), FOLDER + "/none.npz", young=1e6, poisson=0.3, density=1000, fix="nosuch")
        self.assertNotIn("given-mesh", str(caught.exception))
        self.assertNotIn("/thrum-", str(caught.exception))
        with mock.patch.dict(os.environ, {"THRUM_PROGRAM": "", "PATH": "/nonexistent"}):
            with self.assertRaisesRegex(thrum.ProgramFailed, "not installed"):
                thrum.program()
        with mock.patch.dict(os.environ, {"THRUM_PROGRAM": "/nonexistent/thrum"}):
            with self.assertRaisesRegex(thrum.ProgramFailed, "THRUM_PROGRAM: /nonexistent/thrum"):
                thrum.program()


if __name__ == "__main__":
    unittest.main()
