"""The program from Python: runs, statics, refusals. SPDX-License-Identifier: Apache-2.0"""
import os
import pickle
import unittest
import warnings
from unittest import mock

import numpy as np
from support import FOLDER, beam, beam_file

import thrum


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
