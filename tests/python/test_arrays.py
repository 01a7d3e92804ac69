"""`thrum export --numpy, --torch, --jax`: the array code against the library. SPDX-License-Identifier: Apache-2.0"""
import importlib.util
import os
import subprocess
import sys
import types
import unittest
from pathlib import Path

import numpy as np
from support import FOLDER, beam, beam_file

import thrum

PROGRAM = os.environ["THRUM_PROGRAM"]
STEP = 0.002


def exported(library, name=None):
    """The module that the program writes for the test beam."""
    path = Path(FOLDER, f"{name or library}_code.py")
    subprocess.run([PROGRAM, "export", beam_file(), f"--{library}", path], check=True, stdout=subprocess.DEVNULL)
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def states(count, rank):
    random = np.random.default_rng(3)
    return 0.02 * random.standard_normal((count, rank)), 0.5 * random.standard_normal((count, rank))


class Arrays(unittest.TestCase):
    def near(self, one, other, share):
        one, other = np.asarray(one), np.asarray(other)
        self.assertEqual(one.shape, other.shape)
        self.assertLessEqual(abs(one - other).max(), share * abs(other).max())

    def test_what_cannot_be_written_leaves_nothing(self):
        folder = Path(FOLDER, "taken.py")
        folder.mkdir()
        run = subprocess.run([PROGRAM, "export", beam_file(), "--numpy", folder], capture_output=True)
        self.assertEqual(run.returncode, 1)
        self.assertFalse(Path(FOLDER, "taken_coefficients.npz").exists())

    def test_energy_force_and_tangent_are_those_of_the_library(self):
        model, code = beam(), exported("numpy")
        q, _ = states(3, code.RANK)
        self.near(code.energy(q), [model.strain_energy(one) for one in q], 1e-12)
        self.near(code.force(q), [model.internal_force(one) for one in q], 1e-12)
        self.near(code.tangent(q), [model.tangent_stiffness(one) for one in q], 1e-12)

    def test_named_places_move_and_are_pulled_alike(self):
        model, code = beam(), exported("numpy")
        q, _ = states(2, code.RANK)
        self.near(code.displacement(q[0], "tip"), model.displacement(q[0])[model.group("tip")], 1e-12)
        self.near(code.point_force("tip", (1, 2, -3)), model.external_load((1, 2, -3), group="tip"), 1e-12)
        self.near(code.gravity((0, 0, -9.81)), model.external_load(gravity=(0, 0, -9.81)), 1e-12)

    def test_steps_are_those_of_the_library(self):
        model, code = beam(), exported("numpy")
        load = model.external_load((0, 0, -10), group="tip")
        for integrator, step, matched in (("midpoint", code.step_midpoint, None), ("energy", code.step_energy, True),
                                          ("energy", code.step_energy, False)):
            how = {} if matched is None else {"matched": matched}
            options = {} if matched is None else {"frequency_matched": matched}
            for alpha, beta in ((0.0, 0.0), (1.0, 1e-4)):
                with model.state(integrator=integrator, dt=STEP, tolerance=1e-13, damping_alpha=alpha,
                                 damping_beta=beta, **options) as state:
                    state.force = load
                    q = p = np.zeros(code.RANK)
                    for _ in range(50):
                        q, p = step(q, p, load, STEP, alpha, beta, **how)
                    state.step(50)
                    self.near(q, state.q, 1e-10)
                    self.near(p, state.p, 1e-8)

    def test_the_energy_step_keeps_the_energy_of_large_swings(self):
        code = exported("numpy")
        q, p = states(4, code.RANK)
        before = code.total_energy(q, p)
        for _ in range(100):
            q, p = code.step_energy(q, p, 0.0, STEP, iterations=12)
        self.near(code.total_energy(q, p), before, 1e-11)

    def test_a_stand_in_for_jax_gives_the_same(self):
        # the file for JAX, with numpy behind exactly the names of jax.numpy that it may use
        allowed = ("asarray", "eye", "linalg", "ones_like", "sin", "sqrt", "tan", "where")
        jax = types.ModuleType("jax")
        jax.numpy = types.ModuleType("jax.numpy")
        for name in allowed:
            setattr(jax.numpy, name, getattr(np, name))
        jax.config = types.SimpleNamespace(update=lambda key, value: self.assertEqual((key, value),
                                                                                     ("jax_enable_x64", True)))
        sys.modules.update({"jax": jax, "jax.numpy": jax.numpy})
        try:
            code, plain = exported("jax"), exported("numpy")
        finally:
            del sys.modules["jax"], sys.modules["jax.numpy"]
        q, p = states(2, code.RANK)
        for step, same in ((code.step_energy, plain.step_energy), (code.step_midpoint, plain.step_midpoint)):
            np.testing.assert_array_equal(step(q, p, 0.0, STEP)[0], same(q, p, 0.0, STEP)[0])

    def test_torch_derives_what_the_code_says(self):
        try:
            import torch
        except ImportError:
            self.skipTest("python3-torch is not installed")
        torch.set_num_threads(1)
        code, plain = exported("torch"), exported("numpy")
        q, p = states(2, code.RANK)
        at = torch.asarray(q).requires_grad_(True)
        code.energy(at).sum().backward()
        self.near(at.grad, plain.force(q), 1e-12)

        # a step, and its derivative by the start against differences
        start, pace = torch.asarray(0.1 * q[0]).requires_grad_(True), torch.asarray(0.1 * p[0])
        ahead = code.step_energy(start, pace, 0.0, STEP)[0]
        self.near(ahead.detach(), plain.step_energy(0.1 * q[0], 0.1 * p[0], 0.0, STEP)[0], 1e-12)
        self.assertTrue(torch.autograd.gradcheck(lambda one: code.step_energy(one, pace, 0.0, STEP)[0], (start,),
                                                 eps=1e-7, atol=1e-5, rtol=1e-4))

        # at rest too, where the mean force is 0/0
        rest = torch.zeros(code.RANK, dtype=torch.float64, requires_grad=True)
        code.step_energy(rest, torch.zeros_like(rest), 0.0, STEP)[0].sum().backward()
        self.assertTrue(bool(torch.isfinite(rest.grad).all()))

    def test_what_is_no_polynomial_is_refused(self):
        code = Path(FOLDER, "none.py")
        condensed = Path(FOLDER, "condensed.npz")
        make = [PROGRAM, "precompute", "beam:4x1x1@1x0.1x0.1", "--fix", "x<0.001", "--modes", "4", "--rank", "8"]
        subprocess.run([*make, "--condense", "-o", condensed], check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
        for arguments, said in (([condensed, "--numpy", code], "follow the others at rest"),
                                ([beam_file(), "--numpy", Path(FOLDER, "none.txt")], "end with .py"),
                                ([beam_file(), "--numpy", code, "--torch", code], "one file")):
            run = subprocess.run([PROGRAM, "export", *arguments], stderr=subprocess.PIPE, text=True)
            self.assertNotEqual(run.returncode, 0)
            self.assertIn(said, run.stderr)
            self.assertFalse(code.exists())


if __name__ == "__main__":
    unittest.main()
