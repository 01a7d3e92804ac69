"""Models from Python. SPDX-License-Identifier: Apache-2.0"""
import copy
import os
import pickle
import tempfile
import types
import unittest
import warnings

import numpy as np
from support import FOLDER, beam, beam_file, block, model_file

import thrum


class Loading(unittest.TestCase):
    def test_numbers(self):
        model = beam()
        self.assertEqual((model.rank, model.shown, model.masters), (12, 12, 0))
        self.assertEqual(model.vertices.shape, (81, 3))
        self.assertEqual(model.tets.shape, (model.tet_count, 4))
        self.assertEqual(model.basis.shape, (243, 12))
        self.assertEqual(model.material.tolist(), [[5e6, 0.4, 1000.0]])
        self.assertEqual(model.laws, ["stvk"])
        self.assertEqual(model.meta["tool"], "thrum")
        self.assertIn("tip", model.groups)
        # held vertices have zero rows
        held = np.flatnonzero(model.fixed)
        self.assertEqual(np.abs(model.basis.reshape(81, 3, 12)[held]).max(), 0.0)

    def test_regions_have_laws_of_their_own(self):
        arrays = {"format": np.array([4, 0], "<i4"), "omega2": np.ones(1), "point_weights": np.ones(3),
                  "point_moduli": np.ones((2, 3)), "point_gradients": np.ones((27, 1)),
                  "point_region": np.array([0, 1, 1], "<i4"), "region_law": np.array([0, 2], "u1")}
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "regions.npz")
            np.savez(path, **arrays)
            self.assertEqual(thrum.Model.load(path).laws, ["stvk", "neo-hookean"])

    def test_views_are_read_only_and_not_copied(self):
        model = beam()
        self.assertEqual(model.basis.ctypes.data, model.basis.ctypes.data)
        with self.assertRaises(ValueError):
            model.vertices[0, 0] = 1.0

    def test_bytes_and_files(self):
        with open(beam_file(), "rb") as file:
            data = file.read()
        # a buffer at an odd address too
        crooked = memoryview(b"x" + data)[1:]
        q = np.linspace(-0.1, 0.1, 12)
        energies = {thrum.Model.from_bytes(given).strain_energy(q) for given in (data, crooked, bytearray(data))}
        self.assertEqual(energies, {beam().strain_energy(q)})
        beam().save(FOLDER + "/copy.npz")
        with open(FOLDER + "/copy.npz", "rb") as file:
            self.assertEqual(file.read(), data)

    def test_refusals(self):
        for data, kind in ((b"", thrum.BadFile), (b"no model", thrum.BadFile)):
            with self.assertRaises(kind):
                thrum.Model.from_bytes(data)
        with open(beam_file(), "rb") as file:
            data = bytearray(file.read())
        data[len(data) // 2] ^= 1
        with self.assertRaises(thrum.BadFile) as caught:
            thrum.Model.from_bytes(data)
        self.assertEqual(caught.exception.status, thrum.Status.BAD_CHECKSUM)
        with self.assertRaisesRegex(thrum.BadFile, "nowhere.npz"):
            thrum.Model.load("nowhere.npz")
        with self.assertRaises(OSError):
            thrum.Model.load("nowhere.npz")
        with self.assertRaisesRegex(TypeError, "Model.load"):
            thrum.Model(beam_file())

        # numbers that would be cut, or texts that would be read as numbers
        for q in (np.zeros(beam().rank, complex), ["0"] * beam().rank):
            with self.assertRaisesRegex(ValueError, "q: real numbers"):
                beam().internal_force(q)
        with self.assertRaisesRegex(TypeError, "state 0 of the batch is a str"):
            beam().batch("x")

    def test_closed(self):
        with beam() as model:
            vertices = model.vertices
        with self.assertRaisesRegex(ValueError, "closed"):
            model.rank
        # a view made before keeps what it needs
        self.assertTrue(np.isfinite(vertices).all())

    def test_pickle(self):
        q = np.full(12, 0.01)
        model = beam()
        for original in (model, model.truncate(5), model.scale(length=2.0), model.condense(4)):
            again = pickle.loads(pickle.dumps(original))
            at = q[:original.rank]
            self.assertEqual(again.strain_energy(at), original.strain_energy(at))
        self.assertEqual(copy.deepcopy(model).rank, 12)


class Mechanics(unittest.TestCase):
    def test_force_is_the_gradient_and_tangent_its_derivative(self):
        model, generator = beam(), np.random.default_rng(1)
        q, direction = generator.normal(size=(2, 12)) * 0.02
        # V is a quartic: the fourth-order difference has no truncation error
        step = 1e-3
        values = [model.strain_energy(q + k * step * direction) for k in (-2, -1, 1, 2)]
        slope = (values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * step)
        self.assertAlmostEqual(slope / (model.internal_force(q) @ direction), 1.0, 9)
        forces = [model.internal_force(q + k * step * direction) for k in (-2, -1, 1, 2)]
        change = (forces[0] - 8 * forces[1] + 8 * forces[2] - forces[3]) / (12 * step)
        tangent = model.tangent_stiffness(q)
        np.testing.assert_array_equal(tangent, tangent.T)
        np.testing.assert_allclose(tangent @ direction, change, rtol=1e-7)

    def test_loads(self):
        model = beam()
        tip = model.group("tip")
        force = np.array([1.0, 2.0, 3.0])
        reduced = model.external_load(force, group="tip")
        np.testing.assert_allclose(reduced, model.external_load(force, vertices=tip), rtol=1e-14)
        field = np.zeros((81, 3))
        field[tip] = force / len(tip)
        np.testing.assert_allclose(reduced, model.external_load(field=field), rtol=1e-12)
        np.testing.assert_allclose(reduced, model.basis.T @ field.ravel(), rtol=1e-12)
        for wrong in ({"force": (1, 2)}, {"group": "tip"}, {"force": (1, 2, 3), "group": "tip", "vertex": 3},
                      {"force": (1, 2, 3), "vertex": 81}, {"force": (1, 2, 3), "vertices": [0.5]},
                      {"force": (1, 2, 3), "vertices": []}):
            with self.assertRaises((ValueError, TypeError)):
                model.external_load(**wrong)
        with self.assertRaisesRegex(KeyError, "tip"):
            model.external_load((1, 2, 3), group="nose")

    def test_displacement(self):
        model = beam()
        q = model.start(0, 0.1)
        moved = model.displacement(q)
        self.assertAlmostEqual(np.linalg.norm(moved, axis=1).max(), 0.1, 12)
        np.testing.assert_allclose(moved.ravel(), model.basis @ q, atol=1e-15)
        np.testing.assert_array_equal(model.displacement(q, slice(10, 20)), moved[10:20])
        np.testing.assert_array_equal(model.positions(q), model.vertices + moved)
        with self.assertRaises(ValueError):
            model.displacement(q, slice(0, 10, 2))
        for mode in (-1, 12):
            with self.assertRaisesRegex(ValueError, f"mode: {mode} is not within 0 to 11"):
                model.start(mode, 0.1)

    def test_scaling_is_exact(self):
        """A body twice as long vibrates at half the frequency (Langhaar 1951)."""
        model = beam()
        np.testing.assert_allclose(model.scale(length=2.0).frequencies * 2.0, model.frequencies, rtol=1e-14)
        np.testing.assert_allclose(model.scale(stiffness=4.0).frequencies, model.frequencies * 2.0, rtol=1e-14)

    def test_condensed(self):
        model = beam()
        condensed = model.condense(4)
        self.assertEqual((condensed.rank, condensed.shown), (4, 12))
        x = model.start(0, 0.05)[:4]
        shown = condensed.shape(x)
        np.testing.assert_array_equal(shown[:4], x)
        # the slaves are at rest up to terms of higher order: they lower the energy
        straight = np.concatenate([x, np.zeros(8)])
        self.assertLess(model.strain_energy(shown), model.strain_energy(straight))
        load = model.external_load(gravity=(0, 0, -9.81))
        self.assertEqual(condensed.condensed_load(x, load).shape, (4,))
        self.assertEqual(condensed.displacement(shown).shape, (81, 3))

    def test_a_file_that_was_condensed_has_no_energy_of_all_coordinates(self):
        file = model_file("condensed", "beam:8x2x2@1x0.15x0.15", fix="x<0.001", modes=6, rank=12, condense=True)
        model = thrum.Model.load(file)
        q = np.zeros(model.rank)
        for call in (model.strain_energy, model.internal_force, model.tangent_stiffness):
            with self.assertRaisesRegex(thrum.Missing, r"condense\(6\)"):
                call(q)
        stepped = model.condense(model.masters)
        rest = np.zeros(stepped.rank)
        self.assertEqual(stepped.strain_energy(rest), 0.0)
        self.assertEqual(np.abs(stepped.internal_force(rest)).max(), 0.0)

    def test_equilibrium_that_is_compressed_warns(self):
        model = beam()
        load = model.external_load(force=(0, 0, -1), group="tip")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            model.equilibrium(load)
        with self.assertWarnsRegex(RuntimeWarning, "is compressed to") as said:
            found = model.equilibrium(100000 * load)
        self.assertEqual(said.filename, __file__)
        self.assertTrue({"compressed", "inverted"} & set(model.monitor().look(found.q).warnings))

    def test_equilibrium(self):
        model = beam()
        load = model.external_load(gravity=(0, 0, -9.81))
        found = model.equilibrium(load)
        np.testing.assert_allclose(model.internal_force(found.q), load, atol=1e-8 * np.abs(load).max())
        self.assertTrue(found.stable)
        again = model.equilibrium(load, q=found.q)
        np.testing.assert_allclose(again.q, found.q, rtol=1e-7, atol=1e-12)
        with self.assertRaises(TypeError):
            model.equilibrium(load, steps=3)
        with self.assertRaises(ValueError):
            model.equilibrium(load * np.nan)

    def test_surface_and_stress(self):
        model = beam()
        triangles = model.outer_triangles()
        # a closed surface: Euler's formula for a sphere, and every edge has two triangles
        corners = np.unique(triangles)
        self.assertEqual(len(corners) - len(triangles) * 3 // 2 + len(triangles), 2)
        surface = model.surface(triangles=triangles)
        q = model.start(0, 0.1)
        out = np.empty((81, 3), np.float32)
        self.assertIs(surface.positions(q, out), out)
        np.testing.assert_allclose(out, model.positions(q), atol=1e-6)
        normals = surface.normals(out)
        # outside: the end of the beam looks along x
        self.assertGreater(normals[model.group("tip"), 0].min(), 0.5)
        np.testing.assert_allclose(surface.displacements(q), model.displacement(q), atol=1e-6)
        with self.assertRaises(TypeError):
            surface.positions(q, np.empty((81, 3)))

        points = model.stress_points()
        self.assertEqual(len(points), model.tet_count)
        at_rest = points.read(np.zeros(12))
        self.assertEqual(at_rest.von_mises.max(), 0.0)
        np.testing.assert_array_equal(at_rest.stretch, 1.0)
        some = model.stress_points([5, 3])
        self.assertEqual(some.tets.tolist(), [5, 3])
        np.testing.assert_array_equal(some.read(q).cauchy, points.read(q).cauchy[[5, 3]])

        # one region: a node a vertex, and in linear tetrahedra the average of a patch
        nodes = model.stress_nodes()
        self.assertEqual(nodes.vertices.tolist(), list(range(model.vertex_count)))
        self.assertEqual(set(nodes.regions.tolist()), {0})
        self.assertFalse(nodes.extrapolated)
        self.assertEqual(nodes.read(np.zeros(12)).von_mises.max(), 0.0)
        found = nodes.read(q)
        centres = points.read(q).cauchy
        self.assertTrue((found.cauchy.max(0) <= centres.max(0) * (1 + 1e-12)).all())
        self.assertEqual(found.von_mises.shape, (len(nodes),))

    def test_monitor(self):
        model = beam()
        monitor = model.monitor()
        self.assertEqual(monitor.look(np.zeros(12)).warnings, ())
        far = monitor.look(model.start(0, 0.9))
        self.assertIn("reach", far.warnings)
        monitor.clear()
        self.assertEqual(monitor.record.looks, 0)
        self.assertGreater(monitor.look_at_load(np.ones((81, 3))).load_share, 0.0)
        with self.assertRaises(TypeError):
            model.monitor(reach=1)


class Precompute(unittest.TestCase):
    def test_arrays(self):
        """The same mesh as arrays, as a meshio mesh and as a file gives the same model."""
        source = beam()
        vertices, tets = source.vertices, source.tets
        options = {"fix": "x<0.001", "modes": 3, "rank": 4, "young": 5e6, "poisson": 0.4, "density": 1000,
                   "order": 1}
        made = thrum.Model.precompute((vertices, tets), **options)
        np.testing.assert_allclose(made.frequencies[:2], source.frequencies[:2], rtol=1e-3)
        cells = types.SimpleNamespace(type="tetra", data=np.array(tets))
        mesh = types.SimpleNamespace(points=np.array(vertices), cells=[cells])
        self.assertEqual(thrum.Model.precompute(mesh, **options).frequencies.tolist(), made.frequencies.tolist())

    def test_refusals(self):
        with self.assertRaisesRegex(thrum.ProgramFailed, "nosuch.msh"):
            thrum.Model.precompute("nosuch.msh")
        for wrong in (3, (np.zeros((4, 2)), np.zeros((1, 4), int)), (np.zeros((4, 3)), np.array([[0, 1, 2, 4]])),
                      types.SimpleNamespace(points=np.zeros((3, 3)), cells=[])):
            with self.assertRaises((ValueError, TypeError)):
                thrum.Model.precompute(wrong)

    def test_free_body(self):
        self.assertEqual(block().rank, 6)


if __name__ == "__main__":
    unittest.main()
